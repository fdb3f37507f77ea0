"""``cramlite serve``: the engine for programs in other languages, one JSON object a line on standard input and output.

A request is ``{"id": 1, "method": "resolve", "params": {...}}``; its answer ``{"id": 1, "result": ...}`` or
``{"id": 1, "error": {"code": ..., "message": ...}}``; between them lines of progress ``{"id": 1, "progress": "..."}``.
Codes: those of JSON-RPC 2.0, and 1 to 3 with the meaning of the command line's exit codes. Requests are worked off one
after another; ``cancel`` is heard at once. When standard input ends, what was asked is answered and the process ends; when
nobody reads the answers any more, the work is stopped.
"""

from __future__ import annotations

import json
import queue
import sys
import threading
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import IO, Any

from .engine import Engine
from .errors import CramliteError, NoSolution, nearest
from .solution import Solution

LONGEST_LINE = 1_000_000
"""Characters: a scenario takes a few thousand."""

PARSE_ERROR, NO_REQUEST, NO_METHOD, WRONG_PARAMS, INTERNAL = -32700, -32600, -32601, -32602, -32603


class Refused(Exception):
    """A request that is none, with its JSON-RPC code."""

    def __init__(self, code: int, message: str) -> None:
        super().__init__(message)
        self.code = code


class Service:
    """One engine behind two streams.

    Args:
        engine: whose plugins answer.
        lines: requests.
        out: answers; nothing else is written to it.
    """

    def __init__(self, engine: Engine, lines: IO[str], out: IO[str]) -> None:
        self.engine, self._lines, self._out = engine, lines, out
        self._writing, self._todo = threading.Lock(), queue.SimpleQueue[Any]()
        self._cancelled: set[Any] = set()
        self._ended = False
        self._found: dict[Any, Iterator[Solution]] = {}
        self.methods: Mapping[str, Callable[[Any, dict[str, Any]], Any]] = {
            "check": self._check, "interpret": self._interpret, "next": self._next, "resolve": self._resolve,
            "tasks": self._tasks,
        }  # fmt: skip

    def run(self) -> int:
        """Answer until the requests end, or nobody reads the answers any more."""
        worker = threading.Thread(target=self._work, daemon=True)
        worker.start()
        while not self._ended and (line := self._lines.readline(LONGEST_LINE + 1)):
            if line.strip():
                self._hear(line)
        self._todo.put(None)
        worker.join()
        return 0

    def _hear(self, line: str) -> None:
        """Queue a request; what cannot be one, and ``cancel``, is answered at once."""
        try:
            request = _request(line)
        except Refused as refused:
            while len(line) > LONGEST_LINE and not line.endswith("\n"):  # the rest of a line that is too long
                line = self._lines.readline(LONGEST_LINE + 1)
            self._say({"id": None, "error": {"code": refused.code, "message": str(refused)}})
            return
        if request["method"] == "cancel":
            self._say({"id": request["id"], "result": {"cancelled": request["params"].get("id")}})
            self._cancelled.add(request["params"].get("id"))
        else:
            self._todo.put(request)

    def _work(self) -> None:
        while (request := self._todo.get()) is not None and not self._ended:
            self._say({"id": request["id"], **self._answer(request)})

    def _answer(self, request: dict[str, Any]) -> dict[str, Any]:
        try:
            if request["method"] not in self.methods:
                raise Refused(
                    NO_METHOD,
                    f"no method '{request['method']}'; {nearest(request['method'], (*self.methods, 'cancel'))}",
                )
            return {"result": self.methods[request["method"]](request["id"], request["params"])}
        except Refused as refused:
            return {"error": {"code": refused.code, "message": str(refused)}}
        except CramliteError as error:
            return {"error": {"code": error.exit_code, "message": str(error)}}
        except Exception as error:
            return {"error": {"code": INTERNAL, "message": f"a defect: {type(error).__name__}: {error}"}}

    def _say(self, answer: dict[str, Any]) -> None:
        from .explain import plain_json

        with self._writing:
            try:
                self._out.write(plain_json(answer) + "\n")
                self._out.flush()
            except (BrokenPipeError, ValueError):  # ValueError: the stream is closed
                self._ended = True

    # Methods

    def _tasks(self, id_: Any, params: dict[str, Any]) -> Any:
        from .explain import tasks_json

        return tasks_json(self.engine.knowledge.tasks.values())

    def _check(self, id_: Any, params: dict[str, Any]) -> Any:
        """Whether a scenario can be used; an error says why not."""
        scenario = _scenario(params)
        setting = self.engine.setting(scenario, seed=_seed(params))
        return {
            "scenario": scenario.name,
            "robot": setting.robot.type,
            "things": [t.name for t in setting.world.things],
        }

    def _interpret(self, id_: Any, params: dict[str, Any]) -> Any:
        found = self.engine.interpret(self.engine.read_episode(Path(_text(params, "episode"))))
        return found.to_json()

    def _resolve(self, id_: Any, params: dict[str, Any]) -> Any:
        """The first proven program; ``next`` with this request's id gives the following ones."""
        from .trace import Trace

        def stop() -> bool:
            return self._ended or id_ in self._cancelled

        def progress(text: str) -> None:
            self._say({"id": id_, "progress": text})

        trace, scenario = Trace(), _scenario(params)
        solutions = self.engine.resolve(scenario, seed=_seed(params), trace=trace, progress=progress, stop=stop)
        self._found[id_] = solutions
        return self._one(solutions, trace, stop)

    def _next(self, id_: Any, params: dict[str, Any]) -> Any:
        asked = params.get("of")
        if asked not in self._found:
            raise Refused(WRONG_PARAMS, f"'of' is the id of a 'resolve' before, not {asked!r}")
        return self._one(self._found[asked], None, lambda: asked in self._cancelled)

    def _one(self, solutions: Iterator[Solution], trace: Any, stop: Callable[[], bool]) -> Any:
        from .explain import failure_text

        solution = next(solutions, None)
        if solution is None:
            said = (
                "cancelled"
                if stop()
                else failure_text(trace, self.engine.registry.faults)
                if trace
                else "no further solution"
            )
            raise NoSolution(said)
        bound = solution.candidate.bindings
        return {
            "plan": str(solution.plan), "code": solution.code, "findings": solution.verdict.findings,
            "objects": {o.name: bound.get(o.name) for o in solution.plan.objects},
        }  # fmt: skip


def _request(line: str) -> dict[str, Any]:
    if len(line) > LONGEST_LINE:
        raise Refused(NO_REQUEST, f"a line has at most {LONGEST_LINE} characters")
    try:
        data = json.loads(line)
    except (ValueError, RecursionError) as error:
        raise Refused(PARSE_ERROR, f"no JSON: {error}") from error
    if not isinstance(data, dict) or not isinstance(data.get("method"), str):
        raise Refused(NO_REQUEST, 'a request is an object such as {"id": 1, "method": "tasks"}')
    params = data.get("params", {})
    if not isinstance(params, dict) or isinstance(data.get("id"), dict | list):
        raise Refused(NO_REQUEST, "'params' is an object, 'id' a number or text")
    return {"id": data.get("id"), "method": data["method"], "params": params}


def _scenario(params: dict[str, Any]) -> Any:
    from .resources import find_scenario
    from .scenario import read_scenario

    return read_scenario(find_scenario(_text(params, "scenario")))


def _text(params: dict[str, Any], name: str) -> str:
    if not isinstance(params.get(name), str):
        raise Refused(WRONG_PARAMS, f"'{name}' is missing; it is a file, or the name of a shipped one")
    return str(params[name])


def _seed(params: dict[str, Any]) -> int:
    seed = params.get("seed", 0)
    if not isinstance(seed, int) or isinstance(seed, bool):
        raise Refused(WRONG_PARAMS, f"'seed' is a whole number, not {seed!r}")
    return seed


def serve(engine: Engine) -> int:
    """Serve on this process's standard streams; what plugins print goes to standard error."""
    out, sys.stdout = sys.stdout, sys.stderr
    try:
        return Service(engine, sys.stdin, out).run()
    finally:
        sys.stdout = out
        _close_quietly(out)


def _close_quietly(out: IO[str]) -> None:
    """Where nobody reads any more, Python would complain at its end about what it could not write."""
    import os

    try:
        out.flush()
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), out.fileno())


__all__ = ["Service", "serve"]
