"""Kitchens that are drawn by a seed: furniture, vessels, blocks, a drawer, a shelf, a box, and a goal of one to three parts.

A problem is a scenario as data. Goals are left out by the rules of ``experiments/drawn_goals.py``, and where our validators' predicates do
not hold once things and joints were put so by hand and left alone. No planner is asked.
"""

from __future__ import annotations

import math
import sys
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from itertools import count, product
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
from msgspec.structs import replace

from cramlite import Engine, Setting, UserError, data_folder, read_scenario
from cramlite.model import Pose, Thing, World
from cramlite.planning.symbolic.planning_problem import planning_problem
from cramlite.planning.task_goals import Goal
from cramlite_plugins.simulation.model.compile import Compiled, compile_world

sys.path.insert(0, str(data_folder("experiments")))
from drawn_goals import PART, PLACES, Literal, Offers, contradiction, drawn_goal, fits, in_order, most_parts, offered

GOALS = 200
"""Goals that are drawn in a kitchen before another kitchen is."""
SIX = Path(__file__).parents[1] / "plugins" / "imports" / "robots_data" / "six.urdf"
ROBOTS: Mapping[str, dict[str, Any]] = {
    "ur5e": {"type": "ur5e"},
    "file": {"file": str(SIX), "payload": 4.0, "sensor": "flange", "home": [0, 0.3, 1.6, 0, 1.24, 0]},
}
NEAR, FAR = 0.32, 0.68
"""How far from the base things stand [m]."""
APART = 0.02
"""Between what stands beside each other at first [m]."""
SENTENCE = {
    "on": "{} on {}", "in": "{} in {}", "open": "{} open", "close": "{} closed", "upright": "{} upright", "upside_down": "{} upside down",
}  # fmt: skip
VESSELS = ("bowl", "mug")
LYING = 0.3
"""How often a can or a bottle lies at first."""
DEEP = 0.001
"""Depth of contact that a pose may have which is free of it [m]."""
FREE, SETTLE = 6, 1.0
"""Poses that physics is asked about, and what things are left alone [s]."""
OPENED = 0.18
"""How far a drawer is open that is opened by hand [m]; it can be opened by 0.2 m."""
SHUT = 0.0005
"""And one that is shut by hand [m]."""
LIFTS = (0.002, 0.006, 0.012, 0.02, 0.04, 0.08)
"""Above a target's floor things are let go [m]."""
Spec = dict[str, Any]


class Kitchen:
    """Kitchen that was drawn.

    Args:
        robot: the scenario's key.
        things: of the scenario.
        extents: of what can be moved, upright [m].
        tops: what things can be put on or in -> "on" or "in", and its horizontal extents [m].
    """

    def __init__(self, robot: Spec) -> None:
        self.robot = robot
        self.things: list[Spec] = []
        self.extents: dict[str, tuple[float, float, float]] = {}
        self.tops: dict[str, tuple[str, tuple[float, float]]] = {}
        self.taken: list[tuple[float, float, float]] = []

    def add(self, name: str, model: str, position: Sequence[float], yaw: float = 0.0, pitch: float = 0.0, **sizes: Any) -> None:
        """Add a thing."""
        at = {"position": [round(float(v), 5) for v in position], "yaw": round(float(yaw), 5)} | ({"pitch": pitch} if pitch else {})
        self.things.append({"name": name, "model": model, "at": at, "with": sizes})

    def spec(self, goal: Sequence[Literal] = ()) -> Spec:
        """Return the scenario."""
        start = {"goal": [sentence(p) for p in goal]} if goal else {"tasks": []}
        return {"scenario": "drawn", "title": "A kitchen that was drawn", **start, "robot": self.robot, "things": self.things}


def sentence(literal: Literal) -> str:
    """Return a part of a goal as scenarios write it."""
    return SENTENCE[literal[0]].format(*literal[1:])


def kitchen_of(rng: Any) -> Kitchen:
    """Draw a kitchen."""
    found = Kitchen(ROBOTS[str(rng.choice(list(ROBOTS)))])
    found.add("floor", "table", (0.2, 0.0, -0.005), size=[2.0, 2.0, 0.02])
    found.tops["floor"] = ("on", (math.inf, math.inf))
    bearings = [float(math.radians(b)) for b in rng.permutation([-100, -50, 0, 50, 100])]
    for furniture in (_cabinet, _shelf, _tray, _basket):
        if rng.random() < 0.7:
            furniture(found, rng, bearings.pop() + float(rng.uniform(-0.15, 0.15)))
    for k in range(int(rng.integers(2, 6))):
        _movable(found, rng, k)
    return found


def _at(bearing: float, away: float) -> tuple[float, float]:
    return away * math.cos(bearing), away * math.sin(bearing)


def _cabinet(kitchen: Kitchen, rng: Any, bearing: float) -> None:
    x, y = _at(bearing, rng.uniform(0.72, 0.8))
    where, yaw = (x, y, rng.uniform(0.12, 0.4)), bearing + math.pi
    kitchen.add("cabinet", "cabinet", where, yaw)
    kitchen.add("drawer", "drawer", where, yaw, parent="cabinet", opened=float(rng.choice([0.0, 0.15])))
    kitchen.tops |= {"cabinet": ("on", (0.3, 0.3)), "drawer": ("in", (0.25, 0.264))}
    kitchen.taken += [(*_at(bearing, 0.92), 0.25), (*_at(bearing, 0.68), 0.15)]


def _plate(kitchen: Kitchen, rng: Any, bearing: float, name: str, high: float) -> None:
    x, y = _at(bearing, rng.uniform(0.45, 0.6))
    size = [float(v) for v in rng.uniform(0.2, 0.34, 2)]
    kitchen.add(name, "table", (x, y, high), size=[*size, 0.02])
    kitchen.tops[name] = ("on", (size[0], size[1]))
    kitchen.taken.append((x, y, math.hypot(*size) / 2))


def _shelf(kitchen: Kitchen, rng: Any, bearing: float) -> None:
    _plate(kitchen, rng, bearing, "shelf", rng.uniform(0.1, 0.3))


def _tray(kitchen: Kitchen, rng: Any, bearing: float) -> None:
    _plate(kitchen, rng, bearing, "tray", 0.02)


def _basket(kitchen: Kitchen, rng: Any, bearing: float) -> None:
    x, y = _at(bearing, rng.uniform(0.45, 0.6))
    size = [float(v) for v in rng.uniform((0.18, 0.18, 0.08), (0.32, 0.32, 0.15))]
    kitchen.add("basket", "basket", (x, y, 0.0), size=size)
    kitchen.tops["basket"] = ("in", (size[0] - 0.02, size[1] - 0.02))
    kitchen.taken.append((x, y, math.hypot(*size[:2]) / 2))


def _movable(kitchen: Kitchen, rng: Any, number: int) -> None:
    """Something that can be moved, where there is room on the floor or on furniture; nothing where none was found."""
    model = str(rng.choice(["block", "block", "can", "bottle", "bowl", "mug"]))
    sizes, extents, foot = _sizes(model, rng)
    lies = model in ("can", "bottle") and bool(rng.random() < LYING)
    name, round_about = f"{model}_{number}", (max(extents) if lies else math.hypot(*extents[:2])) / 2
    bearers = ["floor", "floor", *(n for n in ("shelf", "tray") if n in kitchen.tops)]
    bearer = str(rng.choice(bearers))
    for _ in range(100):
        x, y, high = _spot(kitchen, rng, bearer, round_about)
        if all(math.hypot(x - u, y - v) > r + round_about + APART for u, v, r in kitchen.taken if bearer == "floor" or r < 0.1):
            pitch, foot = (math.pi / 2, extents[0] / 2) if lies else (0.0, foot)
            kitchen.add(name, model, (x, y, high + foot + 0.001), rng.uniform(-math.pi, math.pi), pitch, **sizes)
            kitchen.extents[name] = extents
            kitchen.taken.append((x, y, min(round_about, 0.099)))
            return


def _sizes(model: str, rng: Any) -> tuple[Spec, tuple[float, float, float], float]:
    """Parameters of a model, its extents and the height of its origin [m]."""
    u = [float(v) for v in rng.random(3)]
    if model == "block":
        size = (0.025 + 0.05 * u[0], 0.025 + 0.05 * u[1], 0.025 + 0.1 * u[2])
        return {"size": list(size)}, size, size[2] / 2
    if model == "bowl":
        radius, height = 0.055 + 0.025 * u[0], 0.04 + 0.02 * u[1]
        return {"radius": radius, "height": height}, (2 * radius, 2 * radius, height), height / 2
    if model == "mug":
        radius, height = 0.035 + 0.007 * u[0], 0.08 + 0.02 * u[1]
        return {"radius": radius, "height": height}, (2 * radius + 0.032, 2 * radius, height), height / 2
    radius, height = 0.025 + 0.01 * u[0], 0.06 + 0.06 * u[1]
    neck = 0.04 if model == "bottle" else 0.0
    sizes = {"radius": radius, "height": height} | ({"neck_height": neck} if neck else {})
    return sizes, (2 * radius, 2 * radius, height + neck), height / 2


def _spot(kitchen: Kitchen, rng: Any, bearer: str, room: float) -> tuple[float, float, float]:
    if bearer == "floor":
        return *_at(rng.uniform(-2.2, 2.2), rng.uniform(NEAR, FAR)), 0.005
    at = next(t["at"]["position"] for t in kitchen.things if t["name"] == bearer)
    half = [max(0.0, side / 2 - room) for side in kitchen.tops[bearer][1]]
    return at[0] + rng.uniform(-half[0], half[0]), at[1] + rng.uniform(-half[1], half[1]), at[2]


class Rules:
    """Rules that leave goals out of a kitchen.

    Raises:
        UserError: the kitchen is none: things stand in one another.
    """

    def __init__(self, engine: Engine, kitchen: Kitchen) -> None:
        self.engine, self.kitchen = engine, kitchen
        self.setting = engine.setting(read_scenario(kitchen.spec()), twins=0)

    def offers(self) -> Offers:
        """Return the literals that the kitchen offers."""
        movable = self.kitchen.extents
        targets = {name: (how, PART) for name, (how, _) in self.kitchen.tops.items()}
        states = {n: ("upside_down",) if n.startswith(VESSELS) else ("upright",) for n in movable if not n.startswith("block")}
        found = offered(movable, targets, states | {n: ("open", "close") for n in targets if n == "drawer"})
        into = tuple(("in", what, n) for n in sorted(movable) if n.startswith(VESSELS) for what in sorted(movable) if what != n)
        return {**found, "in": (*found.get("in", ()), into)} if into else found

    def left_out(self, goal: Sequence[Literal]) -> str:
        """Return the first rule that leaves a goal out; "" for none."""
        if contradiction(goal, {}):
            return "a contradiction"
        try:
            if any(self.holds(p, self.setting.world) for p in goal):
                return "a part holds already"
        except UserError:
            return "our predicates have no words for it"
        if any(p[0] in PLACES and not fits(self.kitchen.extents[p[1]], self._room(p[2])) for p in goal):
            return "a thing is larger than its target in every attitude"
        return "" if self.by_hand(goal) else "our predicates cannot hold it"

    def _room(self, name: str) -> tuple[float, float]:
        return self.kitchen.tops[name][1] if name in self.kitchen.tops else self.kitchen.extents[name][:2]

    def holds(self, literal: Literal, world: World) -> bool:
        """Return whether a part of a goal holds in a world, by the predicates that our validators ask."""
        knowledge = self.engine.knowledge
        setting: Setting = replace(self.setting, world=world)
        problem = planning_problem(Goal((sentence(literal),)), setting.symbolic(knowledge.taxonomy), knowledge)
        return bool(problem.wanted.met(problem.facts))

    def by_hand(self, goal: Sequence[Literal]) -> bool:
        """Return whether a goal holds once things and joints were set so and left alone; things that take no part are not
        there."""
        named = {n for p in goal for n in p[1:]}
        things = tuple(t for t in self.setting.world.things if t.name not in self.kitchen.extents or t.name in named)
        for opened in self._drawers(goal):
            world = _with_drawer(replace(self.setting.world, things=things, robots=()), opened)
            if self._all_put(goal, world):
                return True
        return False

    def _drawers(self, goal: Sequence[Literal]) -> list[float | None]:
        """Length by which the drawer is open: that of the goal, else the present one, or that of an open drawer."""
        said = [SHUT if p[0] == "close" else OPENED for p in goal if p[0] in ("open", "close")]
        return [said[0]] if said else [None, OPENED]

    def _all_put(self, goal: Sequence[Literal], world: World) -> bool:
        asked = {p[1]: p[0] for p in goal if p[0] in ("upright", "upside_down")}
        places = in_order(goal, {})
        placed = {p[1] for p in places}
        for literal in (*((how, what) for what, how in asked.items() if what not in placed), *places):
            put = self._put(literal, asked.get(literal[1]), world)
            if put is None:
                return False
            world = put
        world = _settled(world)
        return all(self.holds(p, world) for p in goal)

    def _put(self, literal: Literal, attitude: str | None, world: World) -> World | None:
        """The world with a thing at its goal; None where no pose was found in which it stays."""
        compiled, tried = compile_world(world, {}), 0
        data = compiled.data()
        for pose in self._poses(literal, attitude, world):
            compiled.place(data, literal[1], pose)
            if not _free(compiled, data, literal[1]):
                continue
            rested = _settled(_moved(world, literal[1], pose))
            if self.holds(literal, rested):
                return rested
            if (tried := tried + 1) == FREE:
                break
        return None

    def _poses(self, literal: Literal, attitude: str | None, world: World) -> Iterator[Pose]:
        """Poses of a thing at its target: upright, upside down and lying, from the middle outwards, from low to high."""
        size = self.kitchen.extents[literal[1]]
        middle, half = self._target(literal, world)
        turns = {"upright": [(0.0, 0.0)], "upside_down": [(math.pi, 0.0)]}
        allowed = turns[attitude] if attitude else [(0.0, 0.0), (math.pi / 2, 0.0), (0.0, math.pi / 2), (math.pi, 0.0)]
        steps = sorted(product((-0.6, -0.3, 0.0, 0.3, 0.6), repeat=2), key=lambda s: s[0] ** 2 + s[1] ** 2)
        for (roll, pitch), yaw, (u, v), lift in product(allowed, (0.0, math.pi / 2, math.pi / 4), steps, LIFTS):
            turn = Pose.from_rotvec((0.0, 0.0, 0.0), (0.0, 0.0, yaw)) * Pose.from_rotvec((0.0, 0.0, 0.0), (roll, pitch, 0.0))
            upwards = 0 if pitch else 1 if math.isclose(roll, math.pi / 2) else 2
            where = middle * Pose((u * half[0], v * half[1], lift + size[upwards] / 2))
            yield Pose(where.position) * Pose((0.0, 0.0, 0.0), middle.quaternion) * turn

    def _target(self, literal: Literal, world: World) -> tuple[Pose, tuple[float, float]]:
        """The middle of a target's floor, and how far from there a thing may be [m]."""
        if literal[0] not in PLACES:
            thing = world.thing(literal[1])
            x, y, z = thing.pose.position
            return Pose((x, y, z - self.kitchen.extents[literal[1]][2] / 2)), (0.01, 0.01)
        name = literal[2]
        pose, room = world.thing(name).pose, self._room(name)
        if name == "floor":
            return Pose((0.45, 0.0, 0.0)), (0.1, 0.4)
        below = {"drawer": (-0.125, 0.0, -0.082), "cabinet": (-0.15, 0.0, 0.1), "basket": (0.0, 0.0, 0.01)}
        if name in self.kitchen.extents:
            high = self.kitchen.extents[name][2] / 2
            return pose * Pose((0.0, 0.0, 0.007 - high if literal[0] == "in" else high)), (room[0] / 2, room[1] / 2)
        return pose * Pose(below.get(name, (0.0, 0.0, 0.0))), (room[0] / 2, room[1] / 2)


def _with_drawer(world: World, opened: float | None) -> World:
    """The world with its drawer open by a length; unchanged for None."""
    joint = next((t.joint for t in world.things if t.name == "drawer"), None)
    if opened is None or joint is None:
        return world
    out = next(t for t in world.things if t.name == "drawer").pose * Pose((opened - joint.value, 0.0, 0.0))
    return _moved(world, "drawer", out)


def _moved(world: World, name: str, pose: Pose) -> World:
    return replace(world, things=tuple(t.moved_to(pose) if t.name == name else t for t in world.things))


def _free(compiled: Compiled, data: Any, name: str) -> bool:
    """Whether a thing is in contact with nothing, but for a surface that it is about to rest on."""
    mujoco.mj_kinematics(compiled.model, data)
    mujoco.mj_collision(compiled.model, data)
    inside = (c for c in data.contact if c.dist < -DEEP)
    return not any(name in (compiled.owners[c.geom1].touch, compiled.owners[c.geom2].touch) for c in inside)


def _settled(world: World) -> World:
    """The world after things were left alone."""
    compiled = compile_world(world, {})
    data = compiled.data()
    for _ in range(round(SETTLE / compiled.model.opt.timestep)):
        mujoco.mj_step(compiled.model, data)
    mujoco.mj_forward(compiled.model, data)
    return replace(world, things=tuple(_seen(t, compiled.pose(data, t.name)) for t in world.things))


def _seen(thing: Thing, pose: Pose) -> Thing:
    """A thing as it was seen in the end; one whose joint went into its stop, as solvers let it, keeps its old position."""
    if thing.joint is None:
        return thing.moved_to(pose) if thing.mass else thing
    moved = thing.moved_to(pose)
    return moved if moved.joint is not None and moved.joint.lower <= moved.joint.value <= moved.joint.upper else thing


def drawn_kitchen(engine: Engine, seed: int, told: Counter[str]) -> tuple[Kitchen, tuple[Literal, ...]]:
    """Draw the kitchen and the goal of a seed; tell what was left out."""
    for attempt in count():
        rng = np.random.default_rng([seed, attempt])
        told["kitchens drawn"] += 1
        kitchen = kitchen_of(rng)
        parts = int(rng.integers(1, 4))
        try:
            rules = Rules(engine, kitchen)
        except UserError:
            told["kitchens left out: things stand in one another"] += 1
            continue
        offers = rules.offers()
        for _ in range(GOALS if parts <= most_parts(offers) else 0):
            goal = drawn_goal(rng, offers, parts)
            told["goals drawn"] += 1
            why = rules.left_out(goal)
            if not why:
                return kitchen, goal
            told[f"goals left out: {why}"] += 1
        told["kitchens left out: no goal of so many parts was found"] += 1
    raise AssertionError
