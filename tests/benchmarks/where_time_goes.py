"""Where the time of a resolution goes: CPU time by stage, first and again in the same engine.

    python tests/benchmarks/where_time_goes.py [SCENARIO ...] [--seed 0] [--before PYTHON]

Each scenario runs in a process of its own. "start" is all until the engine is there, "world" the setting with what a camera sees; the
others are the stages of the search (``Trace.seconds``). Runs in twins are in other processes: their time is the sum of all.

``--before`` names the Python of an environment with an earlier version: its ``cramlite resolve`` is measured beside, with all that it
starts and writes.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Mapping

from figure import add_figure, value, write

from cramlite import Engine, Trace, find_scenario, read_scenario
from cramlite.experiment.figure import Number

SCENARIOS = ("place_on_shelf", "fetch_from_hanger", "kitchen/into_drawer", "tasks/pouring", "kitchen/stack_of_four")
Stages = Mapping[str, float]


def once(name: str, engine: Engine, seed: int) -> Stages:
    """Resolve a scenario; return CPU seconds by stage."""
    trace, began = Trace(), time.process_time()
    scenario = read_scenario(find_scenario(name))
    setting = engine.setting(scenario, seed=seed)
    world, solution = time.process_time() - began, next(engine.resolve(scenario, setting=setting, seed=seed, trace=trace), None)
    if solution is None:
        raise SystemExit(f"{name} is not proven with seed {seed}")
    return {"world": world, **trace.seconds}


def in_this_process(name: str, seed: int) -> dict[str, Stages]:
    """Resolve a scenario twice in one engine; return the times of stages of both."""
    engine = Engine()
    start = time.process_time()
    return {"first": {"start": start, **once(name, engine, seed)}, "again": once(name, engine, seed)}


def measured(name: str, seed: int) -> dict[str, Stages]:
    """Return the stages of a scenario in a process of its own."""
    ran = subprocess.run(
        [sys.executable, __file__, "--here", name, "--seed", str(seed)], stdout=subprocess.PIPE, text=True, check=True
    )  # fmt: skip
    found: dict[str, Stages] = json.loads(ran.stdout)
    return found


def earlier(name: str, seed: int, python: str) -> dict[str, Stages]:
    """Resolve a scenario by the command line of another environment; return CPU seconds of all its processes."""
    with tempfile.TemporaryDirectory() as folder:
        began = sum(os.times()[2:4])
        command = [os.path.abspath(python), "-m", "cramlite", "resolve", name, "--seed", str(seed), "--no-report", "--out", folder]
        subprocess.run(command, cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, check=True)
        return {"before": {"resolve": sum(os.times()[2:4]) - began}}


def rows(name: str, found: Mapping[str, Stages]) -> Iterator[Number]:
    """Print the stages of a scenario; yield them as numbers."""
    for which, stages in found.items():
        told = ", ".join(f"{stage} {seconds:.2f} s" for stage, seconds in stages.items())
        print(f"{name}, {which}: {told}; all {sum(stages.values()):.2f} s", flush=True)
        for stage, seconds in {**stages, "all": sum(stages.values())}.items():
            yield value(f"{name}, {which}", round(seconds, 2), "s", stage)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenarios", nargs="*", default=SCENARIOS)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--before", metavar="PYTHON", help="measure the version of this environment, too")
    parser.add_argument("--here", help=argparse.SUPPRESS)
    add_figure(parser)
    options = parser.parse_args()
    if options.here:
        print(json.dumps(in_this_process(options.here, options.seed)))
        return
    numbers = list[Number]()
    for name in options.scenarios:
        before = earlier(name, options.seed, options.before) if options.before else {}
        numbers += rows(name, before | measured(name, options.seed))
    write(options, numbers, f"seed {options.seed}")


if __name__ == "__main__":
    main()
