"""Postures of an arm among things: collisions and clearance of single joint positions.

A planning model (``simulation.compile``) has no capsule that MuJoCo would miss across a plate, and
only what moves with the arm can touch anything. ``inflated`` copies of it, in which every shape is bigger,
say in one collision check which pairs are near; only for those the exact distance is asked for. (A contact
margin in place of the bigger shapes misses boxes and overestimates the distances of cylinders.)
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from types import MappingProxyType
from typing import Any, Self

import mujoco
import numpy as np
from msgspec import field
from msgspec.structs import replace

from cramlite.model import Collision, Floats, Pose, Robot, Value
from cramlite.plugin import Refused

from ..simulation.model.compile import Compiled
from ..simulation.model.index import RobotIndex
from .approach import Chains
from .inflated import Inflated, inflated
from .pairs import Movers
from .space import refusal

Joints = tuple[float, ...]
Position = Sequence[float] | Floats

HORIZON = 0.05  # distances above this are not told apart [m]
CLEARANCE = 0.005  # asked for on planned paths [m]: with none, 6 of 200 rechecked paths clip
LEVELS = (0.012, 0.025)
"""Further distances by which collision models are inflated [m], so that one check shows that much room at
once."""
TOUCH = 0.0003  # depth of a resting contact in MuJoCo that a start or goal may have [m]
# The same of a start that a straight line leaves [m]: things lean on their neighbours by .3 mm and more
LEANS = 0.001
NEAR = 0.35  # the neighbourhood of a start or goal that touches something, largest joint difference [rad]
FAR = 0.1  # up to where distances of near pairs are measured [m]
KNOWN = 1024  # joint positions of which a scene remembers whether they are free
LATELY = 4
"""Number of pairs that were too close lately, which are measured first at a new joint position. Nearly half
of those that trees reach are blocked, and a collision check takes six times as long then as of free ones."""


class Postures(Value):
    """Joint positions of a robot among things, and what is too near to what in each.

    Args:
        compiled: the planning model.
        index: the robot that moves.
        data: scratch state; every query overwrites the joints of the robot.
        joints: of the robot, in that state (n,) [rad].
        need: distance (geoms, geoms) that each pair must keep; -inf where contact is allowed [m].
        movers: which joints move which geoms.
        chains: of joints between geoms.
        levels: what finds near pairs, from the clearance up.
        kept: distance that is left between two checks [m].
        checks: counts state checks; a list of one, shared by all scenes made from this one.
        opening: of the fingers [m].
        held: what moves with the tool -> its pose in the tcp frame.
        displaced: things that are not where the world had them -> pose in the world.
        anchors: joint positions with the pairs that are closer there than needed, and how close.
        known: joint positions that were looked at, and whether they are free: trees, shortcuts and checks end
            at the same ones.
        lately: pairs that were too close at joint positions, the last one first.
    """

    compiled: Compiled
    index: RobotIndex
    data: Any
    joints: Floats
    need: Floats
    movers: Movers
    chains: Chains
    levels: tuple[Inflated, ...]
    kept: float
    checks: list[int]
    opening: float = 0.0
    held: Mapping[str, Pose] = MappingProxyType({})
    displaced: Mapping[str, Pose] = MappingProxyType({})
    anchors: tuple[tuple[Joints, Mapping[tuple[int, int], float]], ...] = ()
    known: dict[Joints, bool] = field(default_factory=dict)
    lately: list[tuple[int, int]] = field(default_factory=list)

    @property
    def robot(self) -> Robot:
        """Return the robot for which motions are planned in this scene."""
        return self.index.robot

    @property
    def moved(self) -> Floats:
        """Return a table (geoms, joints): 1 where the joint moves the geom, else 0."""
        return self.movers.moved

    @property
    def limits(self) -> tuple[tuple[float, float], ...]:
        """Return the limits (lower, upper) of each joint [rad]."""
        return self.robot.limits

    def opened(self, opening: float) -> Self:
        """Return the same scene with the fingers open by some distance [m]."""
        data = self.compiled.places()
        self.index.set_opening(data, opening)
        return replace(self, data=data, joints=joint_view(data, self.index), opening=opening, known={})

    def free(self, q: Position) -> bool:
        """Check whether the joints are inside their limits and every pair keeps its required distance."""
        key = tuple(q)
        if key not in self.known:
            if len(self.known) == KNOWN:
                self.known.clear()
            self.known[key] = self._inside(q) and self._keeps(q, self.lately[:LATELY])
        return self.known[key]

    def met(self, tcp: Pose, hand: bool = True) -> Refused | None:
        """Return the obstacle too near to the hand or its payload, with the tcp at a pose in the world; None
        for none.

        Then no joint position for the pose is free, which is known without one: of the hand there is no state
        to draw.

        Args:
            hand: whether the hand is there; without it what it holds is, whoever may hold it.
        """
        data, model = self.data, self.compiled.model
        self.joints[:] = self.robot.home
        mujoco.mj_kinematics(model, data)
        rigid, still = self.moved[:, -1] > 0, self.moved.sum(axis=1) == 0
        if not hand:
            rigid = rigid & np.array([o.kind == "thing" for o in self.compiled.owners])
        way = (tcp * self.index.pose(data).inverse()).matrix
        data.geom_xpos[rigid] = data.geom_xpos[rigid] @ way[:3, :3].T + way[:3, 3]
        data.geom_xmat[rigid] = (way[:3, :3] @ data.geom_xmat[rigid].reshape(-1, 3, 3)).reshape(-1, 9)
        pairs = [
            (g, h)
            for g, h in self.levels[0].near_apart(data)
            if (rigid[g] and still[h]) or (rigid[h] and still[g])
        ]
        far = [
            (mujoco.mj_geomDistance(model, data, g, h, FAR, None), g, h)
            for g, h in pairs
            if self.need.item(g, h) > -math.inf
        ]
        close = sorted((d, g, h) for d, g, h in far if d < self.need.item(g, h))
        if not close:
            return None
        touch = [(self.compiled.owners[g].touch, self.compiled.owners[h].touch, -d) for d, g, h in close]
        loose = {self._loose(g, h) for _, g, h in close}
        deepest = {pair[:2]: pair for pair in reversed(touch)}  # of each pair
        named = list(dict.fromkeys(pair[:2] for pair in touch))[:2]
        reason = ", ".join(str(self._state(self.robot.home, *deepest[names])) for names in named)
        there = {name: tcp * pose for name, pose in self.held.items()}
        drawn = (
            None
            if hand
            else replace(self._state(self.robot.home, *touch[0]), held={}, moved={**self.displaced, **there})
        )
        return refusal(reason, blocking=() if "" in loose else (tuple(sorted(loose)),), collision=drawn)

    def collisions(self, q: Position) -> tuple[tuple[str, str, float], ...]:
        """Return the pairs that are closer than their required distance: (one, other, depth), deepest first.

        Depth is positive inside each other and negative for a distance that is too small [m]. Names are those
        of ``Owner.touch``: "thing", "thing/part", "effector/left", "mount/link".
        """
        found: dict[tuple[str, str], float] = {}
        for g, h, d in self._look(q, self.levels[0]):
            if d < self._needed(q, g, h):
                names = self.compiled.owners[g].touch, self.compiled.owners[h].touch
                found[names] = max(found.get(names, -np.inf), -d)
        return tuple(sorted(((a, b, depth) for (a, b), depth in found.items()), key=lambda c: (-c[2], c)))

    def clearance(self, q: Position) -> float:
        """Return the smallest distance of any two bodies that must not touch [m].

        At most ``HORIZON``, negative inside each other.
        """
        return min(
            (d for _, _, d in self._look(q, inflated(self.compiled.model, self.movers.apart(), HORIZON))),
            default=HORIZON,
        )

    def why(self, q: Position) -> str:
        """Explain in words and numbers why a joint position is not free; "" if it is free."""
        for name, value, (low, high) in zip(self.robot.joints, q, self.limits, strict=True):
            if not low <= value <= high:
                return f"joint '{name}' at {value:.3f} rad is outside {low:.3f} .. {high:.3f} rad"
        return ", ".join(str(self._state(q, *pair)) for pair in self.collisions(q)[:2])

    def collision(self, q: Position) -> Collision | None:
        """Return the deepest collision at a joint position; None without a collision, or outside the joint
        limits."""
        close = self.collisions(q) if self._inside(q) else ()
        return self._state(q, *close[0]) if close else None

    def _state(self, q: Position, one: str, other: str, depth: float) -> Collision:
        base = next(m.base for m in self.compiled.world.robots if m.name == self.index.name)
        joints = tuple(round(float(v), 6) for v in q)
        return Collision(
            one,
            other,
            depth,
            self.index.name,
            base,
            joints,
            self.opening,
            dict(self.held),
            dict(self.displaced),
        )

    def blocking(self, q: Position) -> tuple[str, ...]:
        """Return the things, sorted, all of which must be moved before a joint position can be free.

        None where it stays blocked whatever tasks move: by the robot, by what is fixed or held, or by a
        limit.
        """
        close = (p for p in self._look(q, self.levels[0]) if p[2] < self._needed(q, *p[:2]))
        loose = {self._loose(g, h) for g, h, _ in close} if self._inside(q) else set()
        return () if "" in loose else tuple(sorted(loose))

    def _loose(self, *pair: int) -> str:
        """Thing of a pair of geoms that is not in the hand and that a task could move; "" if there is
        none."""
        world, owners = self.compiled.world, self.compiled.owners
        still = (owners[g].name for g in pair if owners[g].kind == "thing" and not self.movers.carried[g])
        return next((n for n in still if world.thing(n).movable or world.thing(n).joint is not None), "")

    def relaxed(self, anchors: Sequence[Position], start: Position | None = None) -> Self:
        """Return this scene with less clearance required near some joint positions (``anchors``), where the
        arm has less.

        Args:
            start: anchor in which contacts may be as deep as those of things that lean on one another.
        """
        found = [self._anchor(q) for q in anchors] + ([] if start is None else [self._anchor(start, LEANS)])
        return replace(self, anchors=tuple((q, closer) for q, closer in found if closer), known={})

    def at(self, poses: Mapping[str, Pose]) -> Self:
        """Return the same scene with movable things elsewhere; poses in the world. A held thing stays in
        the hand."""
        data = mujoco.MjData(self.compiled.model)
        data.qpos[:] = self.data.qpos
        for name, pose in poses.items():
            self.compiled.place(data, name, pose)
        return replace(
            self,
            data=data,
            joints=joint_view(data, self.index),
            displaced={**self.displaced, **poses},
            anchors=(),
            known={},
        )

    def tcp(self, q: Position) -> Pose:
        """Return the pose of the tcp in the world frame."""
        self.joints[:] = q
        mujoco.mj_kinematics(self.compiled.model, self.data)
        return self.index.pose(self.data)

    def tip(self, q: Position) -> Floats:
        """Return the position (3,) of the tcp in the world frame [m]."""
        self.joints[:] = q
        mujoco.mj_kinematics(self.compiled.model, self.data)
        return np.array(self.data.site_xpos[self.index.tcp])

    def _inside(self, q: Position) -> bool:
        # A generator takes twice as long.
        for value, (low, high) in zip(q, self.limits, strict=True):  # noqa: SIM110
            if not low <= value <= high:
                return False
        return True

    def _keeps(self, q: Position, first: Sequence[tuple[int, int]] = ()) -> bool:
        """Whether at a joint position every pair of bodies keeps its required distance.

        Args:
            first: pairs that are looked at before all others.
        """
        self._place(q)
        if first and self._too_close(q, self._measured(first)):
            return False
        near = self.levels[0].near(self.data)
        return not (near and self._too_close(q, self._measured(near)))

    def _too_close(self, q: Position, measured: Iterable[tuple[int, int, float]]) -> bool:
        """Whether one of some pairs does not keep its distance at a joint position; it is remembered."""
        for g, h, d in measured:
            if d < self.need.item(g, h) and d < self._needed(q, g, h):
                if (g, h) in self.lately:
                    self.lately.remove((g, h))
                self.lately.insert(0, (g, h))
                del self.lately[LATELY:]
                return True
        return False

    def _look(self, q: Position, level: Inflated) -> Iterator[tuple[int, int, float]]:
        """Pairs (one, other, distance) that must not touch and whose shapes meet at a joint position when
        inflated by ``level``.

        A few are farther apart than the level's distance, since an inflated box grows most at its corners.
        """
        self._place(q)
        return self._near(level)

    def _place(self, q: Position) -> None:
        """Put the arm at a joint position in the model's data."""
        self.joints[:] = q
        mujoco.mj_kinematics(self.compiled.model, self.data)
        self.checks[0] += 1

    def _near(self, level: Inflated) -> Iterator[tuple[int, int, float]]:
        """Pairs (one, other, distance) that must not touch and whose shapes meet when inflated, with the arm
        at the joint position that is set in the simulation state."""
        return self._measured(level.near(self.data))

    def _measured(self, near: Iterable[tuple[int, int]]) -> Iterator[tuple[int, int, float]]:
        """Yield pairs (one, other, distance) of those geom pairs that must not touch, with the distance
        between their shapes [m].

        Each is measured when it is asked for: the first one that is too close ends most checks of blocked
        positions.
        """
        model, data, need = self.compiled.model, self.data, self.need
        for g, h in near:
            if need.item(g, h) > -math.inf:
                yield g, h, mujoco.mj_geomDistance(model, data, g, h, FAR, None)

    def _needed(self, q: Position, g: int, h: int) -> float:
        need: float = self.need.item(g, h)
        for position, closer in self.anchors:
            if (g, h) in closer and max(abs(x - y) for x, y in zip(q, position, strict=True)) < NEAR:
                need = min(need, closer[g, h])
        return need

    def _anchor(self, q: Position, deepest: float = TOUCH) -> tuple[Joints, Mapping[tuple[int, int], float]]:
        near = {
            (g, h): d - 1e-5 for g, h, d in self._look(q, self.levels[0]) if -deepest <= d < self.need[g, h]
        }
        return as_joints(q), near


def as_joints(q: Position) -> Joints:
    return tuple(float(v) for v in q)


def joint_view(data: Any, index: RobotIndex) -> Floats:
    """The joint positions (n,) of a robot in MuJoCo's state, as an array that shares its memory: writing to
    it moves the joints."""
    joints: Floats = data.qpos[index.joints[0] : index.joints[0] + len(index.joints)]
    return joints
