"""Time until work ends after somebody cancels it: at seeded random moments of three scenarios, in the terminal, Python,
``serve`` and MCP.

    CRAMLITE_TWINS=2 python tests/benchmarks/cancelling.py [--moments 50 --seed 0 --faces terminal,python,serve,mcp]

Each scenario is first resolved to its end in Python. How long that takes says from which moments is drawn; and the times at which
it asks whether to go on say how long a cancel at any moment would wait. Then moments are drawn, each is given to the next face, and
work that lasts is cancelled there: by Ctrl+C and SIGTERM in turn, ``stop``, ``cancel``, a cancelled call. What is measured is the time
until the answer; of ``serve`` and MCP also until a later request is answered.
"""

from __future__ import annotations

import argparse
import json
import os
import random
import signal
import subprocess
import sys
import tempfile
import threading
import time
from bisect import bisect_left
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from statistics import median
from typing import Any

from figure import add_figure, value, write

from cramlite import Engine, find_scenario, read_scenario
from cramlite.experiment.figure import Number

SCENARIOS = ("place_on_shelf", "tasks/pouring", "kitchen/into_drawer")
COMMAND = [sys.executable, "-m", "cramlite"]
LAGS = 10_000
"""Moments of a whole run for which the wait is computed."""
Face = Callable[[str, float], dict[str, float]]
"""Begins a scenario, cancels it so many seconds after its first line of progress, and returns what was waited for [s]; nothing where it
had ended before."""


def asked_times(name: str) -> list[float]:
    """Times at which a search that nobody cancels asks whether to go on [s from its first line]."""
    times: list[float] = []

    def stop() -> bool:
        times.append(time.monotonic())
        return False

    solutions = Engine().resolve(read_scenario(find_scenario(name)), stop=stop)
    next(solutions, None)
    return [t - times[0] for t in times]


def waits(times: list[float], seed: int) -> list[float]:
    """How long cancels at random moments would wait until they are heard [s]."""
    drawn = random.Random(seed)
    moments = (drawn.uniform(0.0, times[-1]) for _ in range(LAGS))
    return [times[min(bisect_left(times, m), len(times) - 1)] - m for m in moments]


def in_python(name: str, moment: float) -> dict[str, float]:
    asked, began, ended = threading.Event(), threading.Event(), threading.Event()

    def work() -> None:
        scenario = read_scenario(find_scenario(name))
        next(Engine().resolve(scenario, progress=lambda _: began.set(), stop=asked.is_set), None)
        ended.set()

    threading.Thread(target=work, daemon=True).start()
    began.wait()
    if ended.wait(moment):
        return {}
    at = time.monotonic()
    asked.set()
    ended.wait()
    return {"answer": time.monotonic() - at}


class Terminal:
    """The command line as a process; Ctrl+C and SIGTERM in turn."""

    def __init__(self) -> None:
        self._count = 0

    def __call__(self, name: str, moment: float) -> dict[str, float]:
        self._count += 1
        with tempfile.TemporaryDirectory() as folder, subprocess.Popen(
            [*COMMAND, "resolve", name, "--out", f"{folder}/run"], stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True
        ) as process:
            assert process.stderr is not None
            process.stderr.readline()
            time.sleep(moment)
            if process.poll() is not None:
                return {}
            at = time.monotonic()
            process.send_signal((signal.SIGINT, signal.SIGTERM)[self._count % 2])
            answer = next((time.monotonic() - at for line in process.stderr if "interrupted" in line), float("nan"))
            if process.wait() not in (130, 143):
                return {}
            there = {f.name for f in Path(folder, "run").iterdir()}
            assert {"trace.json", "report.html"} <= there, there
            return {"answer": answer, "end": time.monotonic() - at}


def in_serve(name: str, moment: float) -> dict[str, float]:
    with subprocess.Popen([*COMMAND, "serve"], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdin is not None and process.stdout is not None

        def ask(number: int, method: str, **params: Any) -> None:
            assert process.stdin is not None
            process.stdin.write(json.dumps({"id": number, "method": method, "params": params}) + "\n")
            process.stdin.flush()

        def hear(number: int) -> dict[str, Any]:
            assert process.stdout is not None
            said = (json.loads(line) for line in process.stdout)
            return next(s for s in said if s["id"] == number and "progress" not in s)

        ask(1, "resolve", scenario=name)
        process.stdout.readline()
        time.sleep(moment)
        at = time.monotonic()
        ask(2, "cancel", id=1)
        ask(3, "interpret", episode="nothing")
        ended = "result" in hear(1)
        answer = time.monotonic() - at
        hear(3)
        later = time.monotonic() - at
        process.kill()
        return {} if ended else {"answer": answer, "later request": later}


def in_mcp(name: str, moment: float) -> dict[str, float]:
    import anyio
    from mcp import Client, StdioServerParameters

    async def use(folder: str) -> dict[str, float]:
        parameters = StdioServerParameters(command=COMMAND[0], args=[*COMMAND[1:], "mcp", "--folder", folder], env=dict(os.environ))
        async with Client(parameters) as client:
            began, found = anyio.Event(), list[Any]()

            async def progress(number: float, total: float | None, message: str | None) -> None:
                began.set()

            async def resolve() -> None:
                found.append(await client.call_tool("resolve", {"scenario": name}, progress_callback=progress))

            async with anyio.create_task_group() as group:
                group.start_soon(resolve)
                await began.wait()
                await anyio.sleep(moment)
                at = time.monotonic()
                group.cancel_scope.cancel()
            if found:
                return {}
            await client.call_tool("interpret", {"episode": "nothing"})
            return {"later request": time.monotonic() - at}

    with tempfile.TemporaryDirectory() as folder:
        return anyio.run(use, folder)


def told(values: list[float]) -> str:
    """Median, 95 % and the largest of some times [s]."""
    ordered = sorted(values)
    return " | ".join(f"{ordered[min(len(ordered) - 1, int(share * len(ordered)))]:.2f}" for share in (0.5, 0.95, 1.0))


def numbers(who: str, what: str, values: list[float]) -> list[Number]:
    """A row of the figure."""
    row, ordered = f"{who}: {what}", sorted(values)
    return [value(row, len(values), part="moments"), value(row, median(ordered), "s", "median"), value(row, ordered[-1], "s", "most")]


@contextmanager
def load_told() -> Iterator[None]:
    before = os.getloadavg()[0]
    yield
    print(f"\nLoad of the machine: {before:.1f} before, {os.getloadavg()[0]:.1f} after; {os.cpu_count()} processors.")


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    options.add_argument("--moments", type=int, default=50)
    options.add_argument("--seed", type=int, default=0)
    options.add_argument("--faces", default="terminal,python,serve,mcp")
    add_figure(options)
    asked = options.parse_args()
    faces: dict[str, Face] = {"terminal": Terminal(), "python": in_python, "serve": in_serve, "mcp": in_mcp}
    chosen = [faces[name] for name in asked.faces.split(",")]
    print("| scenario | whole run [s] | a cancel waits [s]: median | 95 % | most |\n|---|---|---|---|---|")
    with load_told():
        length: dict[str, float] = {}
        for name in SCENARIOS:
            times = asked_times(name)
            length[name] = times[-1]
            print(f"| {name} | {times[-1]:.0f} | {told(waits(times, asked.seed))} |", flush=True)
    measured: dict[tuple[str, str], list[float]] = {}
    drawn = random.Random(asked.seed)
    with load_told():
        for number in range(asked.moments):
            name, face = drawn.choice(SCENARIOS), number % len(chosen)
            for what, seconds in chosen[face](name, drawn.uniform(0.0, length[name])).items():
                measured.setdefault((asked.faces.split(",")[face], what), []).append(seconds)
                print(f"{number} {asked.faces.split(',')[face]} {name} {what}: {seconds:.2f} s", file=sys.stderr, flush=True)
        print("\n| face | until | moments | median [s] | 95 % | most |\n|---|---|---|---|---|---|")
        for (who, what), values in measured.items():
            print(f"| {who} | {what} | {len(values)} | {told(values)} |")
        answers = [v for (_, what), values in measured.items() if what in ("answer", "later request") for v in values]
        print(f"| all | answer, later request | {len(answers)} | {told(answers)} |")
    write(asked, (n for key, values in measured.items() for n in numbers(*key, values)), f"seed {asked.seed} draws the moments")


if __name__ == "__main__":
    main()
