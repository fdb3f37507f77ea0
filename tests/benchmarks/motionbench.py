"""MotionBenchMaker's UR5 problems: how many, how fast, how long, and whether Coal agrees.

    python tests/benchmarks/motionbench.py ARCHIVE --each 25 [--file] [--peer DIR]

ARCHIVE is ``ur5.tar.bz2`` of the problems as VAMP ships them: seven families of 100 scenes, a request each. The UR5's base is
0.9144 m high, ROS's base link is turned by 1.57 rad about z, and UR's base frame by pi more; the hand of the set is turned by
90 deg about the tool. Clearance is 0, and the goal is the one joint position of the request. A problem is valid whose start
and goal are free here. Times are CPU time: to the first path, and of the trajectory (planned, shortened, corners rounded and
checked); Coal then looks at it as it is executed, every 0.01 rad. ``--file`` solves them with an arm from a file, too: the same
links in MJCF, read as a user's are, with the hand on its flange, and no sensor between. ``--peer DIR`` lets sscbirrt solve the same
problems.

Source: Chamzas et al., MotionBenchMaker, IEEE RA-L 7(2), 2022.
"""

from __future__ import annotations

import argparse
import math
import tarfile
import tempfile
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path as File
from typing import Any

import numpy as np
import yaml
from figure import add_figure, rate, value, write
from planning import ACCELERATION, SPEED, Peer, executed, peer, smallest

from cramlite.experiment.figure import Number
from cramlite.model import Geom, Pose, Robot, RobotMount, Stated, Thing, World
from cramlite_plugins.imports.robots.robot_file import read_robot
from cramlite_plugins.motion_planning.planner import Path, plan
from cramlite_plugins.motion_planning.planning_scene import PlanningScene
from cramlite_plugins.motion_planning.scene_of_world import scene
from cramlite_plugins.robots import ur5
from cramlite_plugins.robots.dh_arm import arm_mjcf
from cramlite_plugins.robots.ur5 import UR5

HEIGHT, TURN, HAND = 0.9144, 1.57 + math.pi, math.pi / 2
SAMPLES = 20_000
Joints = tuple[float, ...]


@dataclass(frozen=True)
class Query:
    """A scene with start and goal; ``blocked`` says why it is not valid here."""

    name: str
    scene: PlanningScene
    start: Joints
    goal: Joints
    blocked: str


@dataclass(frozen=True)
class Result:
    """Answer of a planner: the path, its CPU seconds, and the smallest distance along it by Coal [m]."""

    path: Path | None
    seconds: float
    distance: float = 0.0
    reason: str = ""


def queries(archive: File, each: int, robots: Sequence[Robot], only: str | None = None) -> Iterator[tuple[Query, ...]]:
    """Read the first problems of each family, or of one; each for some robots."""
    with tarfile.open(archive) as packed:
        names = [n for n in packed.getnames() if "/scene" in n]
        for family in sorted({n.split("/")[-2] for n in names}):
            if only not in (None, family.removesuffix("_ur5")):
                continue
            of = sorted(n for n in names if n.split("/")[-2] == family)[:each]
            for name in of:
                texts = [packed.extractfile(n) for n in (name, name.replace("scene", "request"))]
                read = [yaml.load(t, yaml.CSafeLoader) for t in texts if t is not None]
                yield tuple(query(f"{family.removesuffix('_ur5')}/{name[-9:-5]}", *read, robot) for robot in robots)


def query(name: str, scene_: Mapping[str, Any], request: Mapping[str, Any], robot: Robot) -> Query:
    """Make one problem for a robot."""
    things = tuple(thing(o) for o in scene_["world"]["collision_objects"])
    mount = RobotMount("arm", robot.type, Pose((0, 0, HEIGHT), (math.cos(TURN / 2), 0, 0, math.sin(TURN / 2))))
    made = scene(World(things, (mount,)), {robot.type: robot}, "arm", clearance=0.0)
    state = request["start_state"]["joint_state"]
    at = dict(zip(state["name"], state["position"], strict=True))
    (goal,) = request["goal_constraints"]
    to = {c["joint_name"]: c["position"] for c in goal["joint_constraints"]}
    start, end = joints(at, robot), joints(to, robot)
    blocked = "; ".join(f"{w}: {made.why(q)}" for w, q in (("start", start), ("goal", end)) if made.why(q))
    return Query(name, made, start, end, blocked)


def joints(named: Mapping[str, float], robot: Robot) -> Joints:
    """Return a joint position of the problem set as one of the robot, the hand turned; joint positions of files may count
    from other zeros."""
    *first, last = (float(named[f"{j}_joint"]) for j in robot.joints)
    return tuple(q + h - ours for q, h, ours in zip((*first, last - HAND), robot.home, UR5.home, strict=True))


def from_file() -> Robot:
    """The UR5 with its links from an MJCF file."""
    with tempfile.TemporaryDirectory() as folder:
        path = File(folder) / "ur5.xml"
        path.write_text(arm_mjcf("ur5", ur5.DH, ur5.LINKS, UR5.joints, UR5.limits, ur5.BASE, ("", "")))
        return read_robot(path, "ur5_from_file", Stated(5.0, sensor="flange", home=UR5.home)).robot


def thing(entry: Mapping[str, Any]) -> Thing:
    """Return a collision object as a thing that cannot be moved."""
    at = pose(entry["pose"]) if "pose" in entry else Pose()
    geoms = tuple(
        geom(p, pose(q)) for p, q in zip(entry["primitives"], entry["primitive_poses"], strict=True)
    )  # fmt: skip
    return Thing(entry["id"], "mbm:Obstacle", at, geoms)


def geom(primitive: Mapping[str, Any], at: Pose) -> Geom:
    """Return a primitive: ROS gives extents of boxes, height and radius of cylinders, the radius of spheres."""
    size = [float(v) for v in primitive["dimensions"]]
    if primitive["type"] == "box":
        return Geom("box", tuple(v / 2 for v in size), at)
    return Geom("cylinder", (size[1], size[0] / 2), at) if primitive["type"] == "cylinder" else Geom("sphere", (size[0],), at)


def pose(entry: Mapping[str, Sequence[float]]) -> Pose:
    """Return a pose; quaternions of the set end with w."""
    x, y, z, w = (float(v) for v in entry["orientation"])
    return Pose(tuple(float(v) for v in entry["position"]), (w, x, y, z))


def solve(task: Query, seed: int) -> Result:
    """Solve one problem; Coal checks its path."""
    before = time.process_time()
    found = plan(task.scene, task.start, [task.goal], seed=seed, samples=SAMPLES, speed=SPEED, acceleration=ACCELERATION)
    seconds = time.process_time() - before
    if not isinstance(found, Path):
        return Result(None, seconds, reason=found.reason)
    return Result(found, seconds, smallest(task.scene, executed(task.scene, found)))


def told(family: str, tasks: Sequence[Query], results: Sequence[Result]) -> list[Number]:
    """Print the figures of a family; return them."""
    paths = [r.path for r in results if r.path is not None]
    right = sum(r.path is not None and r.distance > -1e-6 for r in results)
    ms = [1e3 * r.seconds for r in results]
    half, most = np.quantile(ms, (0.5, 0.95))
    mean = float(np.mean([p.duration for p in paths])) if paths else math.nan
    print(
        f"{family}: valid {len(results)} of {len(tasks)}; solved and rechecked {right} of {len(results)}; trajectory {half:.0f} ms "
        f"median, {most:.0f} ms p95; duration {mean:.2f} s; samples {np.median([p.samples for p in paths] or [0]):.0f} median",
        flush=True,
    )
    return [
        rate(family, right, len(results), "solved and rechecked"), value(family, half, "ms", "trajectory, median"),
        value(family, most, "ms", "95 %"), value(family, mean, "s", "duration, mean"),
    ]  # fmt: skip


def theirs(tasks: Sequence[Query], folder: File, families: Sequence[str]) -> list[Number]:
    """Let sscbirrt solve the problems; return its figures by family."""
    answers = peer([Peer(t.scene, t.start, [t.goal], 0.0) for t in tasks], folder)
    numbers: list[Number] = []
    for family in families:
        of = [a for t, a in zip(tasks, answers, strict=True) if t.name.startswith(f"{family}/") or family == "all"]
        half, most = np.quantile([a["ms"] for a in of], (0.5, 0.95))
        solved = [a["duration"] for a in of if "duration" in a]
        print(f"sscbirrt, {family}: solved {len(solved)} of {len(of)}; {half:.0f} ms median, {most:.0f} ms p95; {np.mean(solved):.2f} s")
        name = f"sscbirrt, {family}"
        numbers += [rate(name, len(solved), len(of), "solved"), value(name, half, "ms", "trajectory, median")]
        numbers += [value(name, most, "ms", "95 %"), value(name, float(np.mean(solved)), "s", "duration, mean")]
    return numbers


def main() -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("archive", type=File)
    parser.add_argument("--each", type=int, default=25, help="problems of each family")
    parser.add_argument("--only", help="one family")
    parser.add_argument("--file", action="store_true", help="an arm from a file, too")
    parser.add_argument("--peer", type=File, help="folder for sscbirrt's environment")
    add_figure(parser)
    options = parser.parse_args()
    robots = (UR5, from_file()) if options.file else (UR5,)
    tasks, *others = zip(*queries(options.archive, options.each, robots, options.only), strict=True)
    families = sorted({t.name.split("/")[0] for t in tasks})
    numbers, all_ = [], []
    for family in families:
        of = [t for t in tasks if t.name.startswith(f"{family}/")]
        for t in of if options.only else ():
            if t.blocked:
                print(f"  {t.name} is not valid: {t.blocked}")
        found = [(t.name, solve(t, k)) for k, t in enumerate(of) if not t.blocked]
        for name, r in found:
            if r.path is None or r.distance <= -1e-6:
                print(f"  {name}: {r.reason or f'{1e3 * r.distance:.2f} mm by Coal'}, {r.seconds:.1f} s")
        numbers += told(family, of, [r for _, r in found])
        all_ += [r for _, r in found]
    numbers += told("all", tasks, all_)
    for filed in others:
        numbers += told("all, arm from a file", filed, [solve(t, k) for k, t in enumerate(filed) if not t.blocked])
    if options.peer:
        numbers += theirs([t for t in tasks if not t.blocked], options.peer, [*families, "all"])
    write(options, numbers, f"the first {options.each} of each family")


if __name__ == "__main__":
    main()
