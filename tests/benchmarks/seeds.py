"""Record and resolve a scenario for many seeds; the share that is solved, with its interval.

Each seed varies the person, their world and the robot's world. No solution counts as a failure.
"""

from __future__ import annotations

import argparse
import json
import resource
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from figure import add_figure, rate, value, write

from cramlite.base.rate import wilson_interval
from cramlite.experiment.figure import Number

Row = dict[str, object]


def one(scenario: str, seed: int, out: Path) -> Row:
    """Record, then resolve, as a user would: two processes; finished seeds are not run again."""
    folder = out / str(seed)
    result = folder / "result.json"
    if result.is_file():
        return json.loads(result.read_text())  # type: ignore[no-any-return]
    folder.mkdir(parents=True, exist_ok=True)
    recorded = _run("record", scenario, "--seed", str(seed), "--out", str(folder / "demonstration"))
    begin = time.monotonic()
    resolved = _run(
        "resolve", scenario, "--seed", str(seed), "--demonstration", str(folder / "demonstration"),
        "--out", str(folder / "run"), "--no-report", "--json",
    )  # fmt: skip
    row: Row = {
        "seed": seed,
        "solved": resolved.returncode == 0,
        "seconds": round(time.monotonic() - begin, 1),
    }
    if recorded.returncode or resolved.returncode:
        row["reason"] = (recorded.stderr if recorded.returncode else resolved.stderr).strip()
    else:
        summary = json.loads(resolved.stdout)
        row["candidate"] = summary["candidate"]
        row["findings"] = {f["validator"]: f["reason"] for f in summary["findings"]}
    result.write_text(json.dumps(row, indent=1))
    return row


def _run(*arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "cramlite", *arguments], capture_output=True, text=True, check=False
    )


def main(scenario: str, description: str | None, also: Callable[[Sequence[Row], Path], list[Number]] | None = None) -> None:
    """The command line of a benchmark over seeds.

    Args:
        also: prints and returns further numbers, given the rows and the folder with a folder for each seed.
    """
    parser = argparse.ArgumentParser(description=description, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--first", type=int, default=1000)
    parser.add_argument("--count", type=int, default=100)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--out", type=Path, required=True)
    add_figure(parser)
    arguments = parser.parse_args()
    seeds = range(arguments.first, arguments.first + arguments.count)
    rows = []
    with ThreadPoolExecutor(arguments.workers) as pool:
        for row in pool.map(lambda s: one(scenario, s, arguments.out), seeds):
            rows.append(row)
            said = "ok" if row["solved"] else f"FAILED {str(row['reason'])[-400:]}"
            print(f"{row['seed']}: {said} in {row['seconds']} s", flush=True)
    solved = sum(bool(r["solved"]) for r in rows)
    low, high = wilson_interval(solved, len(rows))
    times = sorted(float(str(r["seconds"])) for r in rows)
    memory = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024
    print(f"{solved} of {len(rows)} solved, 95 % interval {low:.3f} to {high:.3f}")
    print(f"resolve: median {times[len(times) // 2]:.1f} s, worst {times[-1]:.1f} s; largest process {memory:.0f} MB")
    half, most = times[len(times) // 2], times[-1]
    numbers = [rate("solved", solved, len(rows)), value("wall time", half, "s", "median"), value("wall time", most, "s", "most")]
    write(arguments, [*numbers, *(also(rows, arguments.out) if also else ())], seeds)
