"""CPU time of a proof, against another version in the same run: of `cramlite resolve` with its twins.

    python tests/benchmarks/proof_cost.py CHECKOUT [SCENARIO ...] [--runs 3] [--seed 0]

CHECKOUT is a work tree of the other version with an environment of its own in `.venv`. Each scenario runs in turn with
both versions, each time as a process of its own, the first of the two in every other round the other one, so that a machine that becomes
slower meanwhile is slower for both. A process that exits with something else than 0 has proven nothing: it ends the measurement.
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
from tempfile import TemporaryDirectory

from figure import add_figure, value, write

from cramlite.experiment.figure import Number

HERE = Path(__file__).resolve().parents[2]
SCENARIOS = ("place_on_shelf", "kitchen/into_drawer", "fetch_from_hanger", "tasks/pouring", "kitchen/stack_of_four")
Times = dict[tuple[str, Path], list[float]]


def cpu_time(checkout: Path, scenario: str, seed: int) -> float:
    """User and system time of one proof and its child processes [s]."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    with TemporaryDirectory() as out:
        command = [".venv/bin/cramlite", "resolve", scenario, "--seed", str(seed), "--no-report", "--out", out]
        ran = subprocess.run(command, cwd=checkout, capture_output=True, text=True)
    if ran.returncode:
        sys.exit(f"{checkout}: {scenario} is not proven with seed {seed}: {ran.stdout[-500:]}{ran.stderr[-500:]}")
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def measure(other: Path, scenarios: Sequence[str], runs: int, seed: int) -> Times:
    """Time every scenario with both versions, in turn."""
    took: Times = {(scenario, checkout): [] for scenario in scenarios for checkout in (HERE, other)}
    for k in range(runs):
        for scenario in scenarios:
            for checkout in (HERE, other) if k % 2 else (other, HERE):
                took[scenario, checkout].append(cpu_time(checkout, scenario, seed))
                print(f"{k + 1} {scenario} {checkout.name}: {took[scenario, checkout][-1]:.1f} s", file=sys.stderr, flush=True)
    return took


def ratios(took: Times, other: Path) -> Iterator[Number]:
    """Print a row for each scenario and one for all of them; yield their numbers."""
    print("| scenario | here | there | ratio of medians |\n|---|---|---|---|")
    rows = [(s, median(took[s, HERE]), median(took[s, other])) for s, checkout in took if checkout == HERE]
    for name, here, there in (*rows, ("all", sum(r[1] for r in rows), sum(r[2] for r in rows))):
        print(f"| `{name}` | {here:.2f} s | {there:.2f} s | {here / there:.2f} |")
        yield value(name, round(here / there, 3), "", "times the CPU time of the other version")
        yield value(name, round(here, 2), "s", "here")


def main() -> None:
    """Measure, print a table, and write the figure if one is asked for."""
    options = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    options.add_argument("checkout", type=Path, help="a work tree of the other version, with its .venv")
    options.add_argument("scenarios", nargs="*", help="all five without")
    options.add_argument("--runs", type=int, default=3)
    options.add_argument("--seed", type=int, default=0)
    add_figure(options)
    asked = options.parse_args()
    other = asked.checkout.resolve()
    took = measure(other, asked.scenarios or SCENARIOS, asked.runs, asked.seed)
    numbers = list(ratios(took, other))
    write(asked, numbers, seeds=str(asked.seed), cpu_s=sum(map(sum, took.values())))
    print(f"load {os.getloadavg()[0]:.1f}")


if __name__ == "__main__":
    main()
