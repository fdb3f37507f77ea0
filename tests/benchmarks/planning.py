"""Pick and place in a cluttered shelf: how many, how fast, how long, and whether Coal agrees.

    python tests/benchmarks/planning.py --problems 100 --peer DIR

A problem goes from one free tool pose in the shelf to another; each has a known true goal. Times are CPU time of the
complete trajectory (inverse kinematics, planned, shortened, corners rounded and checked, timed); Coal then looks at it
as it is executed, every 0.01 rad. ``--peer DIR`` lets sscbirrt solve the same problems, in an environment of its own
that is made in DIR (planning_peer.py).
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path as File
from typing import Any

import mujoco
import numpy as np
from figure import add_figure, rate, value, write
from planning_problems import Problem, mjcf, problem

from cramlite.experiment.figure import Number

sys.path.insert(0, str(File(__file__).parents[1]))

from helpers import coal_check

from cramlite.model import Floats
from cramlite_plugins.kinematics.blends import rounded, zone
from cramlite_plugins.kinematics.inverse import inverse
from cramlite_plugins.motion_planning.planner import Path, plan, resampled
from cramlite_plugins.motion_planning.planning_scene import PlanningScene
from cramlite_plugins.motion_planning.postures import CLEARANCE

SPEED, ACCELERATION = 1.57, 3.0  # of the planners' comparison [rad/s, rad/s2]
PEER = ("sscbirrt==3.15.0", "mujoco==3.14.0")
STEP = 0.01  # of Coal's check [rad]


@dataclass(frozen=True)
class Result:
    """One problem: seconds, path or None, state checks, smallest distance on a fine grid by Coal [m]."""

    seconds: float
    path: Path | None
    checks: int
    distance: float
    reason: str = ""


def solve(task: Problem, seed: int) -> Result:
    """Solve one problem; Coal checks its path."""
    scene = task.scene
    scene.checks[0], before = 0, time.process_time()
    goals = inverse(scene.robot, task.goal, seed=task.start)
    found = plan(scene, task.start, goals, seed=seed, speed=SPEED, acceleration=ACCELERATION)
    seconds, checks = time.process_time() - before, scene.checks[0]
    if not isinstance(found, Path):
        return Result(seconds, None, checks, 0.0, found.reason)
    return Result(seconds, found, checks, smallest(scene, executed(scene, found)))


def executed(scene: PlanningScene, path: Path) -> Iterator[Floats]:
    """Joint positions of the path with its corners rounded."""
    zones = []
    for (a, corner, b), radius in zip(zip(path.points, path.points[1:], path.points[2:], strict=False), path.radii, strict=True):
        found = [zone(scene.tip, corner, other, radius) if radius > 0 else 0.0 for other in (a, b)]
        zones.append((float(found[0] or 0.0), float(found[1] or 0.0)))
    for section in rounded(path.points, zones, [(SPEED, ACCELERATION)] * (len(path.points) - 1)):
        count = max(1, int(SPEED * section.length / STEP))
        yield from (section.at(section.length * k / count) for k in range(count + 1))


def smallest(scene: PlanningScene, positions: Iterator[Floats] | Sequence[Floats]) -> float:
    """The smallest distance for Coal [m]."""
    solids, checked = coal_check.shapes(scene), coal_check.pairs(scene)
    return min(min(coal_check.distances(scene, q, solids, checked).values()) for q in positions)


def raw_check(scene: PlanningScene, count: int = 2000) -> float:
    """CPU seconds of one mj_kinematics and mj_collision."""
    model, data = scene.compiled.model, scene.data
    positions = np.random.default_rng(1).uniform(-3, 3, (count, 6))
    before = time.process_time()
    for q in positions:
        data.qpos[:6] = q
        mujoco.mj_kinematics(model, data)
        mujoco.mj_collision(model, data)
    return (time.process_time() - before) / count


@dataclass(frozen=True)
class Peer:
    """A problem for sscbirrt: scene, start, goals and clearance [m]."""

    scene: PlanningScene
    start: Sequence[float]
    goals: Sequence[Sequence[float]]
    clearance: float


def peer(tasks: Sequence[Peer], folder: File) -> list[dict[str, Any]]:
    """sscbirrt's answers, from a virtual environment that is made when there is none."""
    python = folder / "bin" / "python"
    if not python.exists():
        subprocess.run([sys.executable, "-m", "venv", str(folder)], check=True)
        subprocess.run([str(python), "-m", "pip", "install", "-q", *PEER], check=True)
    problems = [
        {
            "mjcf": mjcf(t.scene), "start": t.start, "goals": t.goals, "seed": k,
            "speed": SPEED, "acceleration": ACCELERATION, "clearance": t.clearance,
        }
        for k, t in enumerate(tasks)
    ]  # fmt: skip
    (folder / "problems.json").write_text(json.dumps(problems))
    script = File(__file__).with_name("planning_peer.py")
    subprocess.run([str(python), str(script), str(folder / "problems.json"), str(folder / "answers.json")], check=True)
    answers: list[dict[str, Any]] = json.loads((folder / "answers.json").read_text())
    return answers


def line(name: str, milliseconds: Sequence[float], durations: Sequence[float], distances: Sequence[float]) -> list[Number]:
    """Print one row of the comparison; return its numbers."""
    half, most = np.quantile(milliseconds, (0.5, 0.95))
    print(
        f"{name}: solved {len(durations)} of {len(milliseconds)}; complete {half:.0f} ms median, {most:.0f} ms p95; "
        f"duration {np.mean(durations):.2f} s mean, {np.median(durations):.2f} s median; collisions by Coal "
        f"{sum(d <= 0 for d in distances)}, smallest distance {1e3 * min(distances):.1f} mm"
    )
    times = [value(name, half, "ms", "complete trajectory, median"), value(name, most, "ms", "95 %")]
    return [rate(name, len(durations), len(milliseconds), "solved"), *times, value(name, float(np.mean(durations)), "s", "duration, mean")]


def main() -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--problems", type=int, default=100)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--peer", type=File, help="folder for sscbirrt's environment")
    add_figure(parser)
    options = parser.parse_args()
    tasks = [problem(k, options.seed) for k in range(options.problems)]
    results = [solve(t, k) for k, t in enumerate(tasks)]
    paths = [r.path for r in results if r.path is not None]
    numbers = line("cramlite", [1e3 * r.seconds for r in results], [p.duration for p in paths], [r.distance for r in results if r.path])
    checks = sum(r.checks for r in results)
    print(f"  straight joint lines {sum(p.samples == 0 for p in paths)}; first solutions {np.mean([p.first for p in paths]):.2f} s")
    corners = [r for p in paths for r in p.radii]
    print(f"  corners {len(corners)}, of them stops {sum(r == 0 for r in corners)}; {checks} state checks of ", end="")
    print(f"{1e6 * sum(r.seconds for r in results) / checks:.0f} us, planner included; raw {1e6 * raw_check(tasks[0].scene):.0f} us")
    for number, r in enumerate(results):
        if r.path is None:
            print(f"  problem {number}: {r.reason}")
    if options.peer:
        given = [Peer(t.scene, t.start, inverse(t.scene.robot, t.goal, seed=t.start), CLEARANCE) for t in tasks]
        answers = peer(given, options.peer)
        good = [(t, a) for t, a in zip(tasks, answers, strict=True) if "duration" in a]
        far = [smallest(t.scene, resampled([tuple(q) for q in a["path"]], STEP)) for t, a in good]
        numbers += line("sscbirrt", [a["ms"] for a in answers], [a["duration"] for _, a in good], far)
        both = [r.path.duration / a["duration"] for r, a in zip(results, answers, strict=True) if r.path and "duration" in a]
        print(f"  duration of ours / theirs on the same problem: {np.mean(both):.2f} mean, {np.median(both):.2f} median")
    write(options, numbers, f"seed {options.seed}")


if __name__ == "__main__":
    main()
