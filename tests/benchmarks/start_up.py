"""Cost of a command's start: CPU time of whole processes, against ``python -c pass`` in the same run.

    python tests/benchmarks/start_up.py [--runs 5]

Each command runs once to fill the caches (byte code, taxonomy), and then ``--runs`` times in turn with the others, so that
a machine that becomes slower meanwhile is slower for all of them. The ratio says more than the seconds where a machine
is busy: its processors are shared then, and the same work takes up to twice the time.
"""

from __future__ import annotations

import argparse
import os
import resource
import subprocess
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from statistics import median

from figure import add_figure, value, write

from cramlite.experiment.figure import Number

ROOT = Path(__file__).resolve().parents[2]
EMPTY = "python -c pass"
OTHERS = """
from cramlite_plugins.simulation.model.no_window import import_mujoco
import_mujoco()
import argparse, importlib.metadata, msgspec, pluggy, pydantic, rdflib, yaml
pydantic.BaseModel, pydantic.Field
"""
COMMANDS = {
    EMPTY: ["-c", "pass"],
    "import numpy": ["-c", "import numpy"],
    "what check imports of others": ["-c", OTHERS],
    "import cramlite": ["-c", "import cramlite"],
    "cramlite --help": ["-m", "cramlite", "--help"],
    "cramlite tasks": ["-m", "cramlite", "tasks"],
    "cramlite check fetch_from_hanger": ["-m", "cramlite", "check", "scenarios/fetch_from_hanger.yaml"],
    "cramlite interpret, shipped episode": ["-m", "cramlite", "interpret", "scenarios/fetch_from_hanger/demonstration"],
}


def cpu_time(arguments: Sequence[str]) -> float:
    """User and system time of a Python process and its child processes [s]."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run([sys.executable, *arguments], cwd=ROOT, stdout=subprocess.DEVNULL, check=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def numbers(name: str, times: Sequence[float], empty: float) -> Iterator[Number]:
    """Yield least and median time of a command [s], and how many times that of Python alone, ``empty``, the median is."""
    yield value(name, round(min(times), 3), "s", "least")
    yield value(name, round(median(times), 3), "s", "median")
    yield value(name, round(median(times) / empty, 1), part=f"times {EMPTY}")


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    options.add_argument("--runs", type=int, default=5)
    add_figure(options)
    asked = options.parse_args()
    runs = asked.runs
    for arguments in COMMANDS.values():
        cpu_time(arguments)
    took: dict[str, list[float]] = {name: [] for name in COMMANDS}
    for _ in range(runs):
        for name, arguments in COMMANDS.items():
            took[name].append(cpu_time(arguments))
    print(f"| what | least | median of {runs} | median, times '{EMPTY}' |\n|---|---|---|---|")
    for name, times in took.items():
        print(f"| `{name}` | {min(times):.3f} s | {median(times):.3f} s | {median(times) / median(took[EMPTY]):.1f} |")
    write(asked, (n for name, times in took.items() for n in numbers(name, times, median(took[EMPTY]))))
    print(f"load {os.getloadavg()[0]:.1f}")


if __name__ == "__main__":
    main()
