"""Paths into and between the compartments of a cluttered shelf: how many, how fast, how long, and whether Coal agrees.

Run: python tests/benchmarks/planning.py [--problems 50] [--seed 0]

A problem goes from one free tool pose in the shelf to another; both have a free inverse solution by construction,
so each has a true goal. Times are of the complete path (inverse kinematics, planned, shortened, checked, timed),
also in units of one raw collision check on the same machine, because other load changes milliseconds but hardly ratios.
"""

from __future__ import annotations

import argparse
import statistics
import sys
import time
from dataclasses import dataclass
from pathlib import Path as File

import mujoco
import numpy as np

sys.path.insert(0, str(File(__file__).parents[1] / "plugins" / "motions"))

import coal_check
from scenes import TABLE, box, make

from cramlite.geometry import Pose
from cramlite.world import Thing
from cramlite_plugins.motions.kinematics import inverse
from cramlite_plugins.motions.planner import Path, plan, resampled
from cramlite_plugins.motions.scene import Scene
from cramlite_plugins.robots.ur5e import UR5E

Joints = tuple[float, ...]
SPEED, ACCELERATION = 1.57, 3.0  # of the planners' comparison [rad/s, rad/s2]


@dataclass(frozen=True)
class Result:
    """One problem: seconds, path or None, state checks, smallest distance on a fine grid by Coal [m]."""

    seconds: float
    path: Path | None
    checks: int
    distance: float
    reason: str = ""


def shelf(rng: np.random.Generator) -> tuple[Thing, ...]:
    """Two boards, two sides, a back and a post, and six boxes standing on table and board."""
    walls = (
        TABLE,
        box("back", (0.4, 0.01, 0.35), (0.45, 0.72, 0.34)),
        box("board", (0.4, 0.14, 0.01), (0.45, 0.57, 0.34)),
        box("top", (0.4, 0.14, 0.01), (0.45, 0.57, 0.69)),
        box("left", (0.01, 0.14, 0.35), (0.05, 0.57, 0.34)),
        box("right", (0.01, 0.14, 0.35), (0.85, 0.57, 0.34)),
        box("post", (0.01, 0.14, 0.16), (0.45, 0.57, 0.17)),
    )
    clutter = []
    for k in range(6):
        half = rng.uniform((0.02, 0.02, 0.03), (0.04, 0.04, 0.07))
        floor = -0.01 if k % 2 else 0.35
        place = (float(rng.uniform(0.1, 0.8)), float(rng.uniform(0.5, 0.68)), floor + float(half[2]) + 0.001)
        clutter.append(box(f"box{k}", (float(half[0]), float(half[1]), float(half[2])), place, 0.2))
    return (*walls, *clutter)


def stand(scene: Scene, rng: np.random.Generator) -> tuple[Pose, Joints]:
    """A tool pose in the shelf or before it that has a free inverse solution, and that solution."""
    while True:
        inside = rng.random() < 0.75
        low, high = ((0.12, 0.42, 0.06), (0.78, 0.56, 0.6)) if inside else ((0.2, 0.1, 0.1), (0.6, 0.3, 0.5))
        position = rng.uniform(low, high)
        axis = np.array((0.0, 1.0, 0.0)) + rng.normal(0, 0.15, 3) if inside else np.array((0.1, 0.2, -1.0))
        pose = Pose.from_axes(position.tolist(), axis, rng.normal(0, 1, 3))
        free = [q for q in inverse(UR5E, pose)[:24] if scene.free(q)]
        if free:
            return pose, free[0]


def solve(number: int, seed: int) -> Result:
    """One problem, its path checked by Coal."""
    rng = np.random.default_rng((seed, number))
    scene = make(*shelf(rng))
    (_, start), (goal, _) = stand(scene, rng), stand(scene, rng)
    assert scene.checks is not None
    scene.checks[0], before = 0, time.process_time()
    goals = inverse(UR5E, goal, seed=start)
    found = plan(scene, start, goals, seed=number, speed=SPEED, acceleration=ACCELERATION)
    seconds = time.process_time() - before
    checks = scene.checks[0]
    if not isinstance(found, Path):
        return Result(seconds, None, checks, 0.0, found.reason)
    return Result(seconds, found, checks, smallest(scene, found))


def smallest(scene: Scene, path: Path) -> float:
    """The smallest distance along the path for Coal, every 0.01 rad [m]."""
    solids, checked = coal_check.shapes(scene), coal_check.pairs(scene)
    return min(min(coal_check.distances(scene, q, solids, checked).values()) for q in resampled(path.points, 0.01))


def raw_check(count: int = 2000) -> float:
    """Seconds of one mj_kinematics and mj_collision in such a shelf."""
    scene = make(*shelf(np.random.default_rng(0)))
    model, data = scene.compiled.model, scene.data
    positions = np.random.default_rng(1).uniform(-3, 3, (count, 6))
    before = time.process_time()
    for q in positions:
        data.qpos[:6] = q
        mujoco.mj_kinematics(model, data)
        mujoco.mj_collision(model, data)
    return (time.process_time() - before) / count


def main() -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("--problems", type=int, default=50)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    unit = raw_check()
    results = [solve(k, options.seed) for k in range(options.problems)]
    solved = [r for r in results if r.path is not None]
    times = np.array([r.seconds for r in results])
    paths = [r.path for r in results if r.path is not None]
    half, most = float(np.median(times)), float(np.quantile(times, 0.95))
    lasting = [p.duration for p in paths]
    print(f"solved {len(solved)} of {len(results)}")
    print(f"complete path {half * 1e3:.0f} ms median, {most * 1e3:.0f} ms p95")
    print(f"  = {half / unit:.0f} and {most / unit:.0f} raw checks of {unit * 1e6:.0f} us")
    print(f"state checks {statistics.median(r.checks for r in results):.0f} median; ", end="")
    print(f"{1e6 * times.sum() / sum(r.checks for r in results):.0f} us each, planner included")
    print(f"duration {statistics.mean(lasting):.2f} s mean, {statistics.median(lasting):.2f} s median; ", end="")
    print(f"first solutions {statistics.mean(p.first for p in paths):.2f} s")
    print(f"straight joint lines {sum(p.samples == 0 for p in paths)}")
    print(f"collisions by Coal {sum(r.distance <= 0 for r in solved)}; ", end="")
    print(f"smallest distance {min(r.distance for r in solved) * 1e3:.1f} mm")
    for number, r in enumerate(results):
        if r.path is None:
            print(f"problem {number}: {r.reason}")


if __name__ == "__main__":
    main()
