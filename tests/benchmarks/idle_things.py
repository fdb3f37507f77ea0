"""What idle things cost: CPU time of a whole ``cramlite resolve`` of a small task, with and without vessels that stand about.

    python tests/benchmarks/idle_things.py                   # 0, 4, 8 and 16 of them, far from the arm
    python tests/benchmarks/idle_things.py --near            # within its reach
    python tests/benchmarks/idle_things.py --counts 0 16 --times 3

The task is to put a block onto a shelf; planning, the nominal proof, eight twins, judging and the report are in the figures. Each ratio is
to the run without idle things of the same round, since other work on the machine changes all of them; the least of all rounds is told.
"""

from __future__ import annotations

import argparse
import math
import os
import resource
import subprocess
import sys
import tempfile
from pathlib import Path

from figure import add_figure, value, write

TASK = """
scenario: block_among_{count}
title: A block onto a shelf
goal: [block on shelf]
robot: {{type: ur5e}}
things:
  - {{name: floor, model: table, at: {{position: [0, 0, -5 mm]}}, with: {{size: [6 m, 6 m, 20 mm]}}}}
  - {{name: shelf, model: table, at: {{position: [0.1, -0.5, 0.1]}}, with: {{size: [0.3 m, 0.3 m, 0.2 m]}}}}
  - {{name: block, model: block, at: {{position: [0.45, 0.1, 31 mm]}}, with: {{size: [50 mm, 50 mm, 50 mm]}}}}
"""
KINDS = (("jug", 56), ("bowl", 31), ("mug", 54), ("bottle", 81))
"""Models, and how high the origin of each is over the floor [mm]."""
FAR, NEAR = (1.7, 0.0, math.tau), (0.75, 0.8, 3.5)
"""Radius of the circle that they stand on [m], and where on it [rad]: all around, or where the arm does not pass."""


def scenario(count: int, circle: tuple[float, float, float]) -> str:
    """The text of a scenario with so many idle things."""
    radius, first, last = circle
    lines = []
    for k in range(count):
        (model, height), angle = KINDS[k % len(KINDS)], first + (last - first) * k / count
        row = radius + (0.2 if k % 2 else 0.0)
        at = f"[{row * math.cos(angle):.3f}, {row * math.sin(angle):.3f}, {height} mm]"
        lines.append(f"  - {{name: {model}_{k}, model: {model}, at: {{position: {at}}}}}\n")
    return TASK.format(count=count).lstrip() + "".join(lines)


def cpu_seconds(text: str) -> float:
    """CPU time of resolving a scenario, with all processes that it starts [s].

    Raises:
        SystemExit: nothing was proven.
    """
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "scenario.yaml"
        file.write_text(text, encoding="utf-8")
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        words = [sys.executable, "-m", "cramlite", "resolve", str(file), "--out", str(Path(folder) / "run")]
        done = subprocess.run(words, capture_output=True, text=True, check=False, env={**os.environ, "OMP_NUM_THREADS": "1"})
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
    if done.returncode:
        raise SystemExit(done.stderr)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def main() -> None:
    """Print a row for each count."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--counts", type=int, nargs="+", default=[0, 4, 8, 16])
    parser.add_argument("--times", type=int, default=1, help="rounds; the least ratio of all is told")
    parser.add_argument("--near", action="store_true", help="within the arm's reach, where it does not pass")
    add_figure(parser)
    options = parser.parse_args()
    circle = NEAR if options.near else FAR
    rounds = [{n: cpu_seconds(scenario(n, circle)) for n in {0, *options.counts}} for _ in range(options.times)]
    numbers = []
    print("| idle things | CPU time [s] | times as much as without |\n|---|---|---|")
    for count in options.counts:
        seconds, ratio = min(r[count] for r in rounds), min(r[count] / r[0] for r in rounds)
        numbers.append(value("CPU time", ratio, "times", f"{count} idle things", x=count))
        print(f"| {count} | {seconds:.1f} | {ratio:.2f} |")
    write(options, numbers)


if __name__ == "__main__":
    main()
