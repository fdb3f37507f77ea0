"""Grasps of all loose things of scenes: their number, the time of the search, and whether a thing stays in the hand after
the first one.

    python tests/benchmarks/scene_grasps.py --plugin experiments/libero/panda.py libero/*/scenario.yaml

For each kind of thing in the scenes of scenarios (things whose names differ in numbers alone are one kind, the first is taken): grips
found and seconds to find them; seconds until the first grasps are found that the arm reaches, and how many were refused before the first.
The arm of the scenario then follows a straight line to the first of these, closes, lifts by 0.2 m and stands still for half a second, in
the scene's physics. Held is what was lifted by 0.15 m at least, and moved less than 20 mm and 20 degrees in the hand. "in the way" names
what it met above 30 mm: that is no matter of the grasp.

Siblings that must be refused, with their numbers: a thing as heavy as 20 times what the hand bears, and one on pads without friction.
"""

from __future__ import annotations

import argparse
import itertools
import math
import re
import time
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
from figure import add_figure, rate, value, write
from msgspec.structs import replace

from cramlite import Engine, Setting, read_scenario
from cramlite.experiment.figure import Number
from cramlite.model import GRAVITY, Held, Location, Place, Pose, RobotMount, Thing, Value, initial_belief, pair_friction
from cramlite.plugin import Context, Grounding, Refused, Unresolvable
from cramlite_plugins.kinematics.inverse import inverse
from cramlite_plugins.locations.kinds import ground
from cramlite_plugins.locations.pinching import grips
from cramlite_plugins.motions.grip_force import MARGIN, grip_force, grip_of
from cramlite_plugins.simulation.model.compile import Compiled, compile_world

LIFT, HELD, TURNED = 0.20, 0.020, math.radians(20)
LOOKED = 100  # answers of one query


class Row(Value):
    """Findings for one thing."""

    name: str
    parts: int
    grips: int
    ranking: float
    asking: float
    refused: int
    first: str
    outcome: str

    def __str__(self) -> str:
        figures = f"{self.parts} | {self.grips} | {self.ranking:.2f} | {self.asking:.2f} | {self.refused}"
        return f"| {self.name} | {figures} | {self.outcome}: {self.first} |"


def ask(setting: Setting, engine: Engine, thing: Thing) -> tuple[Grounding | None, list[Refused]]:
    """The first grasp that the arm reaches, and what was refused before it."""
    mount = setting.world.robots[0]
    belief = initial_belief(setting.world, mount.name, *setting.robot.start(mount))
    context = Context(setting.robot, mount, {"it": thing.name}, engine.knowledge.taxonomy)
    refused: list[Refused] = []
    try:
        for answer in itertools.islice(ground(Location("g", "grasp", "it"), belief, context), LOOKED):
            if isinstance(answer, Grounding):
                return answer, refused
            refused.append(answer)
    except Unresolvable as no:
        refused.append(Refused("every grasp", no.reason))
    return None, refused


def row(setting: Setting, engine: Engine, thing: Thing) -> Row:
    """Look at one thing."""
    friction = pair_friction(setting.world.physics.pad_friction, thing.least_friction)
    begun = time.process_time()
    found = len(grips.ranked(thing, setting.robot.gripper, friction))
    ranking = time.process_time() - begun
    begun = time.process_time()
    first, refused = ask(setting, engine, thing)
    asking = time.process_time() - begun
    said = first.reason if first else refused[0].reason if refused else "nothing"
    outcome = lifted(setting, thing, first.value) if first else "no grasp"
    return Row(thing.name, len(thing.geoms), found, ranking, asking, len(refused), said, outcome)


def lifted(setting: Setting, thing: Thing, place: Place) -> str:
    """What comes of a grasp in physics."""
    robot, mount = setting.robot, setting.world.robots[0]
    way = [place.before, *_line(place.before, place.pose)]
    up = Pose(tuple(np.add(place.pose.position, mount.base.inverse().rotate((0, 0, LIFT)))), place.pose.quaternion)
    joints = [inverse(robot, place.pose, seed=robot.start(mount)[0])[0]]
    for pose in reversed(way[:-1]):
        joints.insert(0, inverse(robot, pose, seed=joints[0])[0])
    rise = [joints[-1]]
    for pose in _line(place.pose, up):
        rise.append((inverse(robot, pose, seed=rise[-1]) or (rise[-1],))[0])
    world = replace(setting.world, robots=(RobotMount(mount.name, mount.type, mount.base, joints[0], place.opening),))
    run = _Run(compile_world(world, {robot.type: robot}), mount.name, thing)
    run.follow(joints)
    run.close(joints[-1])
    before = run.in_hand()
    run.follow(rise)
    run.follow([rise[-1]] * 10)
    moved, turned = before.distance(run.in_hand())
    height = run.height() - thing.pose.position[2]
    held = height > 0.75 * LIFT and moved < HELD and turned < TURNED
    met = f", in the way: {', '.join(sorted(run.met))}" if run.met else ""
    return f"{'held' if held else 'LOST'} ({1000 * height:.0f} mm up, {1000 * moved:.0f} mm, {math.degrees(turned):.0f} deg{met})"


def _line(a: Pose, b: Pose) -> list[Pose]:
    return [Pose(tuple(np.add(np.multiply(1 - s, a.position), np.multiply(s, b.position))), b.quaternion) for s in np.linspace(0.1, 1, 10)]


class _Run:
    """A simulation under way."""

    def __init__(self, compiled: Compiled, mount: str, thing: Thing) -> None:
        self.compiled, self.thing, self.met = compiled, thing, set[str]()
        self.index, self.data = compiled.robots[mount], compiled.data()
        mujoco.mj_forward(compiled.model, self.data)

    def follow(self, joints: list[Any]) -> None:
        """Bring the arm through joint positions, 0.1 s to each."""
        for a, b in itertools.pairwise(joints):
            self._steps(0.1, a, b)

    def close(self, at: Any) -> None:
        """Close the fingers, with all their force."""
        start = float(self.data.ctrl[self.index.gripper])
        for share in np.linspace(0.05, 1.0, 20):
            self.data.ctrl[self.index.gripper] = start + share * (255 - start)
            self._steps(0.05, at, at)

    def _steps(self, seconds: float, a: Any, b: Any) -> None:
        count = round(seconds / self.compiled.model.opt.timestep)
        for k in range(1, count + 1):
            self.data.ctrl[list(self.index.actuators)] = np.add(a, np.subtract(b, a) * (k / count))
            mujoco.mj_step(self.compiled.model, self.data)
        if self.height() > self.thing.pose.position[2] + 0.03:
            pairs = (p for p in self.compiled.collisions(self.data) if self.thing.name in p)
            self.met |= {n for p in pairs for n in p if n != self.thing.name and not n.startswith("effector")}

    def height(self) -> float:
        return float(self.compiled.pose(self.data, self.thing.name).position[2])

    def in_hand(self) -> Pose:
        return self.index.pose(self.data).inverse() * self.compiled.pose(self.data, self.thing.name)


def siblings(setting: Setting, engine: Engine, thing: Thing) -> list[str]:
    """The reason for a thing that is too heavy, and for one that is too slippery; "" where it is not refused."""
    gripper, mount = setting.robot.gripper, setting.world.robots[0]
    context = Context(setting.robot, mount, {}, engine.knowledge.taxonomy)
    heavy = replace(thing, mass=20 * 2 * gripper.force[1] / (MARGIN * GRAVITY))
    slippery = replace(setting.world, physics=replace(setting.world.physics, pad_friction=0.0))
    said = []
    for world, it in ((setting.world, heavy), (slippery, thing)):
        changed = replace(world, things=tuple(it if t.name == it.name else t for t in world.things))
        try:
            grip_force(grip_of(Held(it.name, Pose(), 0.0), changed, gripper), 0.0, context, (), ())
            said.append("")
        except Unresolvable as no:
            said.append(no.reason)
    return said


def loose(setting: Setting) -> list[Thing]:
    """The things of a scene that a hand may take away."""
    return [t for t in setting.world.things if not t.furniture]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenarios", nargs="+", type=Path)
    parser.add_argument("--plugin", type=Path, action="append", default=[])
    add_figure(parser)
    arguments = parser.parse_args()
    engine, seen, rows, wrong = Engine(files=arguments.plugin), set[str](), list[Row](), list[str]()
    print("| thing | parts | grips | s | s to the first | refused before | first |\n|---|---|---|---|---|---|---|")
    for path in arguments.scenarios:
        setting = engine.setting(read_scenario(path), twins=0)
        for thing in loose(setting):
            kind = re.sub(r"\d+", "", thing.name)
            if kind in seen:
                continue
            seen.add(kind)
            r = row(setting, engine, thing)
            rows.append(r)
            print(r, flush=True)
            wrong += [f"{thing.name}: a sibling was not refused" for said in siblings(setting, engine, thing) if not said]
    free = [r for r in rows if "in the way" not in r.outcome and r.outcome != "no grasp"]
    held = sum(r.outcome.startswith("held") for r in free)
    slowest = max((r.ranking for r in rows), default=0.0)
    taken = sum(r.outcome != "no grasp" for r in rows)
    print(f"\n{len(rows)} things; a grasp was found of {taken}; of {len(free)} with a free way up the first held {held};")
    print(f"slowest ranking {slowest:.2f} s; {2 * len(rows) - len(wrong)} of {2 * len(rows)} siblings refused")
    print(*wrong, sep="\n")
    write(arguments, numbers_of(taken, held, len(free), len(rows), 2 * len(rows) - len(wrong), slowest))


def numbers_of(taken: int, held: int, free: int, things: int, refused: int, slowest: float) -> list[Number]:
    """The numbers of the figure."""
    rows = (("a grasp was found", taken, things), ("held by the first, of those with a free way up", held, free),
            ("siblings refused", refused, 2 * things))  # fmt: skip
    return [*(rate(*row) for row in rows if row[2]), value("slowest ranking", slowest, "s")]


if __name__ == "__main__":
    main()
