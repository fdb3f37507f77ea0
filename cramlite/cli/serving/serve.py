"""``cramlite serve``: the engine for other software, in any language: one JSON object a line on standard input and output.

A request is ``{"id": 1, "method": "resolve", "params": {...}}``; its answer ``{"id": 1, "result": ...}`` or
``{"id": 1, "error": {"code": ..., "message": ...}}``; between them lines of progress ``{"id": 1, "progress": "..."}``.
Codes: those of JSON-RPC 2.0, and 1 to 3 with the meaning of the command line's exit codes. Requests are worked off one
after another; ``cancel`` is heard at once. When standard input ends, what was asked is answered and the process ends; when
nobody reads the answers any more, the work is stopped and the process ends.
"""

from __future__ import annotations

import argparse
import json
import math
import queue
import sys
import threading
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any

from ...base.errors import DEFECTS, CramliteError, NoSolution, nearest
from ...base.pulse import Stopped, pulse
from ...base.value import Value, replace
from ...engine.engine import Engine
from ...engine.solution import Solution
from ...planning.trace import Trace
from ..arguments import Add, plugin_choice
from .answers import check_answer, interpret_answer, solution_answer, tasks_answer

if TYPE_CHECKING:
    from ...scenario.scenario import Scenario

CANCELLED = "cancelled"
LONGEST_LINE = 1_000_000
"""Largest number of characters in the line of a request: a scenario takes a few thousand."""
Id = int | float | str | None
PARSE_ERROR, NO_REQUEST, NO_METHOD, WRONG_PARAMS, INTERNAL = -32700, -32600, -32601, -32602, -32603
PARAMS: Mapping[str, tuple[str, ...]] = {
    "cancel": ("id",),
    "check": ("scenario", "goal", "say", "seed"),
    "interpret": ("episode",),
    "next": ("of",),
    "resolve": ("scenario", "goal", "say", "seed"),
    "run": ("of",),
    "tasks": (),
}
"""Method -> the names of its params."""


class Refused(Exception):
    """Rejected request: its JSON-RPC code, its id if it has one, and data beside the message."""

    def __init__(self, code: int, message: str, id_: Id = None, data: Any = None) -> None:
        super().__init__(message)
        self.code, self.id, self.data = code, id_, data


class OpenSearch(Value):
    """Search that a ``resolve`` request began, and that a ``next`` request continues until the next proven
    program."""

    solutions: Iterator[Solution]
    engine: Engine
    trace: Trace
    scenario: Scenario
    seed: int
    last: Solution | None = None


class Service:
    """Service that reads requests, one JSON object in each line, and answers all of them with one engine.

    Args:
        engine: whose plugins answer.
        lines: requests.
        out: answers; nothing else is written to it.
    """

    def __init__(self, engine: Engine, lines: IO[str], out: IO[str]) -> None:
        self.engine, self._lines, self._out = engine, lines, out
        self._writing, self._todo = threading.Lock(), queue.SimpleQueue[Any]()
        self._open: set[Id] = set()
        self._cancelled: set[Id] = set()
        self._ended = False
        self._found: dict[Id, OpenSearch] = {}
        self.methods: Mapping[str, Callable[[Id, dict[str, Any]], Any]] = {
            "check": self._check, "interpret": self._interpret, "next": self._next, "resolve": self._resolve,
            "run": self._run, "tasks": self._tasks,
        }  # fmt: skip

    def run(self) -> int:
        """Answer requests until the input ends, or nobody reads the answers any more; return the exit code."""
        threading.Thread(target=self._listen, daemon=True).start()
        while not self._ended and (request := self._todo.get()) is not None:
            answer = self._answer(request)
            self._open.discard(request["id"])
            self._say({"id": request["id"], **answer})
        return 0

    def hang_up(self) -> None:
        """Stop all work, since nobody reads the answers any more."""
        self._ended = True
        self._todo.put(None)

    def _listen(self) -> None:
        while line := self._lines.readline(LONGEST_LINE + 1):
            if line.strip():
                self._hear(line)
        self._todo.put(None)

    def _hear(self, line: str) -> None:
        """Queue a request; ``cancel``, and text that is no request, are answered at once."""
        try:
            request = _request(line)
            if request["method"] == "cancel":
                cancelled = self._to_cancel(request["params"], request["id"])
                self._say({"id": request["id"], "result": {"cancelled": cancelled}})
                self._cancelled.add(cancelled)  # after its answer, which comes before that of the request
            elif request["id"] in self._open:
                said = f"a request with the id {request['id']!r} is not answered yet; give another one"
                raise Refused(NO_REQUEST, said, request["id"])
            else:
                self._open |= {request["id"]} - {None}
                self._cancelled.discard(request["id"])
                self._todo.put(request)
        except DEFECTS as error:
            refused = error if isinstance(error, Refused) else Refused(INTERNAL, _defect(error))
            while len(line) > LONGEST_LINE and not line.endswith("\n"):  # the rest of a line that is too long
                line = self._lines.readline(LONGEST_LINE + 1)
            self._say({"id": refused.id, "error": {"code": refused.code, "message": str(refused)}})

    def _to_cancel(self, params: dict[str, Any], asked: Id) -> Id:
        """Return the id of the request to cancel: one that is not answered yet, or a ``resolve`` that could
        still give further programs."""
        id_: Id = params.get("id")
        if not _is_id(id_) or id_ is None or id_ not in self._open | set(self._found):
            waiting = ", ".join(repr(i) for i in [*self._open, *self._found]) or "none"
            said = f"'id' must be that of a request whose search goes on, not {id_!r}; there are: {waiting}"
            raise Refused(WRONG_PARAMS, said, asked)
        return id_

    def _answer(self, request: dict[str, Any]) -> dict[str, Any]:
        id_ = request["id"]
        try:
            with pulse(lambda: self._stopped(id_)):
                return {"result": self.methods[request["method"]](id_, request["params"])}
        except Stopped:
            return {"error": {"code": NoSolution.exit_code, "message": CANCELLED}}
        except Refused as refused:
            more = {"data": refused.data} if refused.data is not None else {}
            return {"error": {"code": refused.code, "message": str(refused), **more}}
        except CramliteError as error:
            return {"error": {"code": error.exit_code, "message": str(error)}}
        except DEFECTS as error:
            return {"error": {"code": INTERNAL, "message": _defect(error)}}

    def _say(self, answer: dict[str, Any]) -> None:
        from ...base.json_text import plain_json

        with self._writing:
            try:
                self._out.write(plain_json(answer) + "\n")
                self._out.flush()
            except (BrokenPipeError, ValueError):  # ValueError: the stream is closed
                self.hang_up()

    # Methods

    def _tasks(self, id_: Any, params: dict[str, Any]) -> Any:
        return tasks_answer(self.engine)

    def _check(self, id_: Any, params: dict[str, Any]) -> Any:
        """Check whether a scenario can be used; an error says why not."""
        return check_answer(self.engine, _scenario(params), _seed(params))

    def _interpret(self, id_: Any, params: dict[str, Any]) -> Any:
        return interpret_answer(self.engine, Path(_text(params, "episode")))

    def _resolve(self, id_: Any, params: dict[str, Any]) -> Any:
        """Return the first proven program of a search; ``next`` with this request's id gives the following ones."""

        def progress(text: str) -> None:
            self._say({"id": id_, "progress": text})

        trace, scenario = Trace(), _scenario(params)
        engine = self.engine.suited(scenario)
        solutions = engine.resolve(
            scenario, seed=_seed(params), trace=trace, progress=progress, stop=lambda: self._stopped(id_)
        )
        self._found[id_] = OpenSearch(solutions, engine, trace, scenario, _seed(params))
        return self._one(id_)

    def _next(self, id_: Any, params: dict[str, Any]) -> Any:
        return self._one(self._of(params))

    def _of(self, params: dict[str, Any]) -> Id:
        """Return the id of the ``resolve`` request that a request names by 'of'; that search must not have
        ended."""
        asked: Id = params.get("of")
        if not _is_id(asked) or asked not in self._found:
            raise Refused(WRONG_PARAMS, f"'of' is the id of a 'resolve' whose search can go on, not {asked!r}")
        return asked

    def _run(self, id_: Any, params: dict[str, Any]) -> Any:
        """Run the latest program of a search in simulation; where the world changes, prove the rest from
        there and run it, too.

        Each notice is sent to the client at once.
        """
        from msgspec import to_builtins

        from ...engine.recovery.going_on import GoingOn, Stretch
        from ...engine.recovery.time_line import gone_on

        found = self._found[self._of(params)]
        assert found.last is not None  # a search that can go on has found one

        def told(stretch: Stretch) -> None:
            if stretch.notice is not None:
                self._say({"id": id_, "notice": {**to_builtins(stretch.notice), "decision": stretch.decision, "to_do": stretch.to_do}})

        going = GoingOn(found.scenario, found.engine, found.seed, lambda text: self._say({"id": id_, "progress": text}))
        moments, why = gone_on(going, found.last, told)
        succeeded = not why and moments[-1].what == "end"
        return {"succeeded": succeeded, "reason": why, "time_line": to_builtins(moments)}

    def _stopped(self, id_: Id) -> bool:
        return self._ended or id_ in self._cancelled

    def _one(self, id_: Id) -> Any:
        from ...planning.diagnosis import how_it_ended
        from ...planning.failure import failure_text
        from ...planning.goal_parts import goal_answers
        from ...planning.what_to_try import what_to_try

        found = self._found.pop(id_)  # put back if it can go on
        solution = next(found.solutions, None)
        if solution is None:
            if self._stopped(id_):
                raise NoSolution(CANCELLED)
            if any(e.outcome == "proven" for e in found.trace.entries):
                raise NoSolution(f"No further solution: {how_it_ended(found.trace.entries)}.")
            said, answers = failure_text(found.trace, found.engine.registry.faults), goal_answers(found.trace)
            raise Refused(NoSolution.exit_code, said, data={"goal": answers, "try": what_to_try(found.trace.entries)})
        self._found[id_] = replace(found, last=solution)
        return solution_answer(solution)


def _request(line: str) -> dict[str, Any]:
    if len(line) > LONGEST_LINE:
        raise Refused(NO_REQUEST, f"a line has at most {LONGEST_LINE} characters")
    try:
        data = json.loads(line, parse_constant=_finite, parse_float=_finite)
    except (ValueError, RecursionError) as error:
        raise Refused(PARSE_ERROR, f"no JSON: {error}") from error
    id_ = data.get("id") if isinstance(data, dict) else None
    if not _is_id(id_):
        raise Refused(NO_REQUEST, "'id' is a number or text")
    if not isinstance(data, dict) or not isinstance(data.get("method"), str):
        raise Refused(NO_REQUEST, 'a request is an object such as {"id": 1, "method": "tasks"}', id_)
    method, params = data["method"], data.get("params", {})
    if method not in PARAMS:
        raise Refused(NO_METHOD, f"no method '{method}'; {nearest(method, PARAMS)}", id_)
    if not isinstance(params, dict):
        raise Refused(NO_REQUEST, "'params' is an object", id_)
    for name in params:
        if name not in PARAMS[method]:
            raise Refused(WRONG_PARAMS, f"'{method}' has no param '{name}'; {nearest(name, PARAMS[method])}", id_)
    return {"id": id_, "method": method, "params": params}


def _defect(error: BaseException) -> str:
    return f"a defect: {type(error).__name__}: {error}"


def _finite(text: str) -> float:
    number = float(text)
    if not math.isfinite(number):
        raise ValueError(f"{text} is no finite number")
    return number


def _is_id(id_: object) -> bool:
    """Check whether a value can be the id of a request; None stands for no id, and True is refused, though it
    equals 1."""
    return id_ is None or (isinstance(id_, int | float | str) and not isinstance(id_, bool))


def _scenario(params: dict[str, Any]) -> Any:
    from ...base.resources import find_scenario
    from ...scenario.scenario import read_scenario, started_by

    if "say" in params and "goal" in params:
        raise Refused(WRONG_PARAMS, "'say' is a sentence in the place of a 'goal'; leave one of them out")
    if "say" in params:
        params = {**params, "goal": {"say": _text(params, "say", "a sentence, such as 'put the tin on the tray'")}}
    said = started_by(params.get("scenario"), params.get("goal"))
    scenario = read_scenario(said if isinstance(said, dict) else find_scenario(_text(params, "scenario")))
    return scenario.with_goal(params["goal"]) if "goal" in params else scenario


def _text(params: dict[str, Any], name: str, what: str = "a file, or the name of a shipped one") -> str:
    or_data = ", or what such a file holds" if name == "scenario" else ""
    if not isinstance(params.get(name), str):
        raise Refused(WRONG_PARAMS, f"'{name}' is missing; it is {what}{or_data}")
    return str(params[name])


def _seed(params: dict[str, Any]) -> int:
    seed = params.get("seed", 0)
    if not isinstance(seed, int) or isinstance(seed, bool):
        raise Refused(WRONG_PARAMS, f"'seed' is a whole number, not {seed!r}")
    return seed


def serve(engine: Engine) -> int:
    """Serve on this process's standard streams; prints of plugins go to standard error."""
    out, sys.stdout = sys.stdout, sys.stderr
    number = sys.stdin.fileno()
    lines = open(number, encoding="utf-8", errors="replace", closefd=False)  # noqa: SIM115  Python's end waits for who reads stdin
    service = Service(engine, lines, out)
    threading.Thread(target=_watch, args=(out.fileno(), service.hang_up), daemon=True).start()
    try:
        return service.run()
    finally:
        sys.stdout = out
        _close_quietly(out)


def _watch(out: int, hang_up: Callable[[], None]) -> None:
    """Wait until the process that reads a pipe is gone, then call ``hang_up``.

    A write to the pipe would show that late, or never.
    """
    import select

    if hasattr(select, "poll"):
        poll = select.poll()
        poll.register(out, 0)  # errors and hang-ups come unasked
        poll.poll()
        hang_up()


def _close_quietly(out: IO[str]) -> None:
    """Close standard output without an error if the process that read it is gone.

    Python would complain about that when it ends.
    """
    import os

    try:
        out.flush()
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), out.fileno())


def _serve(arguments: argparse.Namespace) -> int:
    return serve(Engine.with_plugins(plugin_choice(arguments)))


def add_commands(add: Add) -> None:
    """Add the command ``serve``, with its arguments, to the command line."""
    add("serve", _serve)
