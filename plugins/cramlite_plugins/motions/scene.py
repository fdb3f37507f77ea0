"""What an arm may bump into: collision and clearance of joint positions and of the lines between them.

A planning model (``simulation.compile``) has no capsule that MuJoCo would miss across a plate, and
only what moves with the arm can touch anything. Its contact margin is ``HORIZON``, so that one check
gives the distance to everything nearby; which distance is needed is asked per pair of geoms.

A line between two joint positions is not sampled on a grid: each check says how far the arm may
go before it can touch anything. Joint i turning by dq_i moves no point of a geom by more than
r_i |dq_i|, where r_i is the largest distance of that geom from the joint's axis, so a pair at
distance d cannot meet before sum_i r_i |dq_i| reaches d; i runs over the joints between the two
geoms (conservative advancement: Schwarzer, Saha and Latombe, IEEE T-RO 21(3), 2005). With a
clearance c at every check, about c / 2 is left in between.

MuJoCo's distances are not taken as they are. Contacts of cylinders with boxes and with one another
overestimate a distance, measured on 20,000 pairs, by up to 0.6 mm below 6 mm and by at most a fifth above
(see ``_advance``); those between two boxes may be missing (``boxes``). Overlaps are always found.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import mujoco
import numpy as np

from cramlite.geometry import Floats, Pose
from cramlite.robots import Robot
from cramlite.world import RobotMount, World

from ..simulation.build import Carried
from ..simulation.compile import Compiled, compile_world
from ..simulation.index import Owner, RobotIndex
from .boxes import Boxes, boxes

Joints = tuple[float, ...]
Position = Sequence[float] | Floats
Pairs = frozenset[frozenset[str]]

HORIZON = 0.04  # distances above this are not told apart [m]
CLEARANCE = 0.005  # asked for on planned paths [m]: with none, 6 of 200 rechecked paths clip
TOUCH = 0.0003  # depth of a resting contact in MuJoCo that a start or goal may have [m]
NEAR = 0.35  # the neighbourhood of a start or goal that touches something, largest joint difference [rad]
SMALLEST = 0.002  # shortest advance along a line, largest joint difference [rad]: only counts near such contacts


@dataclass(frozen=True)
class Scene:
    """A robot among things; make one with ``scene``.

    Args:
        compiled: the planning model.
        index: the robot that moves.
        data: scratch state; every query overwrites the joints of the robot.
        need: distance (geoms, geoms) that each pair must keep; -inf where contact is allowed [m].
        moved: (geoms, joints) 1 where the joint moves the geom, else 0.
        still: 1 - moved.
        bound: (geoms, 1) bounding radius and horizon of each [m].
        first: id of the robot's first joint; its joints follow one another.
        anchors: joint positions with the pairs that are closer there than needed, and how close.
        boxes: measures the distances between boxes, which MuJoCo leaves out.
        checks: counts state checks; a list of one, shared by all scenes made from this one.
    """

    compiled: Compiled
    index: RobotIndex
    data: Any
    need: Floats
    moved: Floats
    still: Floats
    bound: Floats
    first: int
    boxes: Boxes
    anchors: tuple[tuple[Joints, Mapping[tuple[int, int], float]], ...] = ()
    checks: list[int] | None = None

    @property
    def robot(self) -> Robot:
        return self.index.robot

    @property
    def limits(self) -> tuple[tuple[float, float], ...]:
        """(lower, upper) of each joint [rad]."""
        return self.robot.limits

    def free(self, q: Sequence[float]) -> bool:
        """Whether the joints are inside their limits and every pair keeps the distance that it needs."""
        pairs, distances = self._look(q)
        return self._inside(q) and bool((distances >= self._needed(q, pairs)).all())

    def line_free(self, a: Sequence[float], b: Sequence[float]) -> bool:
        """Whether the straight joint-space line is free; its far end and middle are looked at first."""
        middle = [(x + y) / 2 for x, y in zip(a, b, strict=True)]
        return self.free(b) and self.free(middle) and self.blocked(a, b) is None

    def blocked(self, a: Sequence[float], b: Sequence[float]) -> float | None:
        """The fraction of the straight joint-space line where it is first blocked; None when it is free."""
        start, way = np.asarray(a, dtype=float), np.subtract(b, a)
        least = SMALLEST / max(float(np.abs(way).max()), SMALLEST)
        part = 0.0
        while True:
            q = start + part * way
            pairs, distances = self._look(q)
            if not self._inside(q) or (distances < self._needed(q, pairs)).any():
                return part
            if part >= 1.0:
                return None
            part = min(1.0, part + max(least, self._advance(pairs, distances, np.abs(way))))

    def collisions(self, q: Sequence[float]) -> tuple[tuple[str, str, float], ...]:
        """What is closer than it needs to be: (one, other, depth), deepest first.

        Depth is positive inside each other and negative for a distance that is too small [m]. Names are those of
        ``Owner.touch``: "thing", "thing/part", "effector/left", "mount/link".
        """
        pairs, distances = self._look(q)
        found: dict[tuple[str, str], float] = {}
        for (g, h), d, need in zip(pairs, distances, self._needed(q, pairs), strict=True):
            if d < need:
                names = self.compiled.owners[g].touch, self.compiled.owners[h].touch
                found[names] = max(found.get(names, -np.inf), -float(d))
        return tuple(sorted(((a, b, depth) for (a, b), depth in found.items()), key=lambda c: (-c[2], c)))

    def clearance(self, q: Sequence[float]) -> float:
        """The smallest distance of any pair that may not touch [m]; at most ``HORIZON``, negative inside each other."""
        pairs, distances = self._look(q)
        counted = distances[self.need[pairs[:, 0], pairs[:, 1]] > -np.inf]
        return min(HORIZON, float(counted.min(initial=HORIZON)))

    def why(self, q: Sequence[float]) -> str:
        """What is in the way, as a clause with numbers; empty when free."""
        for name, value, (low, high) in zip(self.robot.joints, q, self.limits, strict=True):
            if not low <= value <= high:
                return f"joint '{name}' at {value:.3f} rad is outside {low:.3f} .. {high:.3f} rad"
        clauses = [
            f"'{a}' is {depth * 1e3:.1f} mm inside '{b}'"
            if depth > 0
            else f"'{a}' is only {-depth * 1e3:.1f} mm from '{b}'"
            for a, b, depth in self.collisions(q)[:2]
        ]
        return ", ".join(clauses)

    def relaxed(self, anchors: Sequence[Sequence[float]]) -> Scene:
        """The same scene, asking near each of these positions for no more clearance than there is at it."""
        return replace(self, anchors=tuple(self._anchor(q) for q in anchors))

    def at(self, poses: Mapping[str, Pose]) -> Scene:
        """The same scene with movable things elsewhere; poses in the world. A held thing stays in the hand."""
        data = mujoco.MjData(self.compiled.model)
        data.qpos[:] = self.data.qpos
        for name, pose in poses.items():
            self.compiled.place(data, name, pose)
        mujoco.mj_kinematics(self.compiled.model, data)
        return replace(self, data=data, anchors=(), boxes=self.boxes.placed(data))

    def tcp(self, q: Sequence[float]) -> Pose:
        """The tcp in the world frame."""
        self.data.qpos[list(self.index.joints)] = q
        mujoco.mj_kinematics(self.compiled.model, self.data)
        return self.index.pose(self.data)

    def _inside(self, q: Position) -> bool:
        return all(low <= value <= high for value, (low, high) in zip(q, self.limits, strict=True))

    def _look(self, q: Position) -> tuple[Any, Floats]:
        """The pairs of geoms (n, 2) within the horizon and their distances (n,), of which some may be allowed."""
        model, data = self.compiled.model, self.data
        data.qpos[self.index.joints[0] : self.index.joints[0] + len(self.index.joints)] = q
        mujoco.mj_kinematics(model, data)
        mujoco.mj_collision(model, data)
        if self.checks is not None:
            self.checks[0] += 1
        pairs, distances = data.contact.geom, data.contact.dist
        more, further = self.boxes.near(model, data, HORIZON)
        return np.concatenate([pairs, more]), np.concatenate([distances, further])

    def _needed(self, q: Position, pairs: Any) -> Floats:
        need: Floats = self.need[pairs[:, 0], pairs[:, 1]]
        for position, closer in self.anchors:
            if closer and max(abs(x - y) for x, y in zip(q, position, strict=True)) < NEAR:
                known = [closer.get((g, h), np.inf) for g, h in pairs.tolist()]
                need = np.minimum(need, known)
        return need

    def _anchor(self, q: Sequence[float]) -> tuple[Joints, Mapping[tuple[int, int], float]]:
        pairs, distances = self._look(q)
        near: dict[tuple[int, int], float] = {}
        for (g, h), d in zip(pairs.tolist(), distances.tolist(), strict=True):
            if -TOUCH <= d < self.need[g, h]:
                near[g, h] = min(near.get((g, h), np.inf), d - 1e-5)
        return tuple(float(v) for v in q), near

    def _advance(self, pairs: Any, distances: Floats, way: Floats) -> float:
        """The fraction of the line that may be gone before any pair can meet.

        A distance d is at least 0.8 d - 0.6 mm in truth: see the head of this module.
        """
        rate = self._rates(way)
        part = HORIZON / max(float(rate.sum(axis=1).max()), HORIZON)
        if not len(pairs):
            return part
        g, h = pairs[:, 0], pairs[:, 1]
        still = self.still
        speed = np.einsum("pj,pj->p", rate[g], still[h]) + np.einsum("pj,pj->p", rate[h], still[g])
        speed[self.need[g, h] == -np.inf] = 0.0
        return min(part, 1.0 / max(float((speed / np.maximum(0.8 * distances - 0.0006, 1e-9)).max()), 1.0))

    def _rates(self, way: Floats) -> Floats:
        """How far each joint may move any point of each geom over the whole line: (geoms, joints) [m].

        The lever is the distance of the geom's centre p from the axis u through a, |p - a|^2 - ((p - a) u)^2 under
        a root, and its bounding radius; it may grow by ``HORIZON`` until the next check.
        """
        data, first = self.data, self.first
        u, a = data.xaxis[first : first + len(way)], data.xanchor[first : first + len(way)]
        p = data.geom_xpos
        along = p @ u.T - np.einsum("jk,jk->j", a, u)
        square = np.einsum("gk,gk->g", p, p)[:, None] - 2.0 * (p @ a.T) + np.einsum("jk,jk->j", a, a) - along * along
        np.maximum(square, 0.0, out=square)
        rates: Floats = (np.sqrt(square, out=square) + self.bound) * (self.moved * way)
        return rates


def scene(
    world: World,
    robots: Mapping[str, Robot],
    mount: str,
    *,
    poses: Mapping[str, Pose] | None = None,
    held: tuple[str, Pose] | None = None,
    opening: float | None = None,
    allowed: Pairs = frozenset(),
    clearance: float = CLEARANCE,
) -> Scene:
    """A scene for planning.

    Args:
        robots: descriptions by type name.
        mount: the name of the robot that moves; others stay at home.
        poses: where things are now, in the world frame; those not named are where the world has them.
        held: (thing, its pose in the tcp frame): moves with the tool and may touch the gripper.
        opening: distance between the pads [m]; None is fully open.
        allowed: unordered pairs of names that may touch: "thing", "thing/part", "effector", "effector/left", "arm" or
            "mount/link". A pair allows every part of what it names.
        clearance: distance that every other pair must keep [m], up to ``HORIZON``.

    Raises:
        UserError: the world does not compile.
        ValueError: the clearance is negative or above the horizon.
        KeyError: there is no such robot or thing.
    """
    if not 0 <= clearance <= HORIZON:
        raise ValueError(f"clearance {clearance} m; it must lie between 0 and {HORIZON} m")
    for name in [*(poses or {}), *([held[0]] if held else [])]:
        world.thing(name)
    placed = world.moved(dict(poses or {}))
    carried = {held[0]: Carried(mount, held[1])} if held else None
    compiled = compile_world(placed, robots, planning=True, carried=carried)
    compiled.model.geom_margin[:] = HORIZON / 2  # MuJoCo adds the margins of a pair
    compiled.model.body_margin[:] = HORIZON / 2  # what its first, coarse sweep uses
    index, data = compiled.robots[mount], compiled.data()
    index.set_opening(compiled.model, data, index.reach[1] if opening is None else opening)
    moved = _moved(compiled, index)
    bound = compiled.model.geom_rbound[:, None] + HORIZON
    first = int(np.flatnonzero(compiled.model.jnt_qposadr == index.joints[0])[0])
    need = _need(compiled, moved, allowed, clearance)
    mujoco.mj_kinematics(compiled.model, data)
    apart = boxes(compiled.model, data, need, np.flatnonzero(moved.any(axis=1)))
    return Scene(compiled, index, data, need, moved, 1.0 - moved, bound, first, apart, checks=[0])


def base(scene_: Scene) -> Pose:
    """The robot's base frame in the world."""
    mounts: Iterator[RobotMount] = (m for m in scene_.compiled.world.robots if m.name == scene_.index.name)
    return next(mounts).base


def _moved(compiled: Compiled, index: RobotIndex) -> Floats:
    """(geoms, joints): 1 where joint j of the arm is above geom g in the kinematic tree, else 0."""
    model = compiled.model
    bodies = [int(model.jnt_bodyid[np.flatnonzero(model.jnt_qposadr == a)[0]]) for a in index.joints]
    result = np.zeros((model.ngeom, len(bodies)))
    for g in range(model.ngeom):
        body = int(model.geom_bodyid[g])
        while body > 0:
            if body in bodies:
                result[g, bodies.index(body)] = 1.0
            body = int(model.body_parentid[body])
    return result


def _need(compiled: Compiled, moved: Floats, allowed: Pairs, clearance: float) -> Floats:
    """The distance that each pair of geoms must keep; two that no joint moves apart need none."""
    apart = (moved[:, None, :] != moved[None, :, :]).any(axis=2)
    need = np.where(apart, clearance, -np.inf)
    for pair in allowed:
        one, other = (tuple(pair) * 2)[:2]
        first = np.array([_is(o, one) for o in compiled.owners])
        second = np.array([_is(o, other) for o in compiled.owners])
        both = np.outer(first, second)
        need[both | both.T] = -np.inf
    return need


def _is(owner: Owner, name: str) -> bool:
    """Whether a geom's owner is what an allowed pair names."""
    return name in (owner.name, owner.touch, owner.kind) and name != "thing"
