"""Belief state at one point of a plan, with the source of each pose."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from msgspec import field
from msgspec.structs import replace

from ..base.value import Value
from .entity_name import EntityName, thing_of
from .geometry import Pose
from .program.swing import Swing
from .world.thing import Feature, Thing
from .world.world import World


class Estimate(Value):
    """Pose with its uncertainty and provenance.

    Args:
        pose: world frame.
        sigma: standard deviation of the position [m].
        source: who said so.
        fall: how far it may have fallen there after it was let go, at most [m]: in a container down to its floor.
    """

    pose: Pose
    sigma: float = 0.0
    source: str = "known from the scenario"
    fall: float = 0.0


class Held(Value):
    """Grasped thing, with its pose in the hand.

    Args:
        tcp_to_thing: its pose in the TCP frame.
        opening: finger distance [m].
        sigma: standard deviation of its position in the hand [m]; motions in contact widen it.
        joints: of the arm when it was grasped: where they still are, nothing has moved.
        carries: what is in it, on it or hung on it, directly or through others, and moves along: poses in its frame.
        swing: of a thing that turns between the pads when it is lifted, from as it lies to as it hangs; None for what is held fast.
    """

    thing: str
    tcp_to_thing: Pose
    opening: float
    sigma: float = 0.0
    joints: tuple[float, ...] = ()
    carries: Mapping[str, Estimate] = field(default_factory=dict)
    swing: Swing | None = None


Relation = tuple[str, str, str]
"""A believed fact: (predicate, thing, place), e.g. ("hangs_on", "tea", "hanger")."""


class Belief(Value):
    """Belief state: the world as the engine believes it to be; frozen.

    Args:
        world: shapes and features of the things; its poses are the initial ones.
        poses: thing -> estimate, for every thing that is not held, nor moves along with what is.
        robot: the mount that acts.
        joints: its joint position [rad].
        opening: of its gripper [m].
        held: what is grasped, and how.
        relations: facts such as ("hangs_on", "tea", "hanger").
        at: where the arm's base is in the world, for a robot that drives; None for one that is bolted down.
    """

    world: World
    poses: Mapping[str, Estimate]
    robot: str
    joints: tuple[float, ...]
    opening: float
    held: Held | None = None
    relations: frozenset[Relation] = field(default_factory=frozenset)
    at: Pose | None = None

    @property
    def payload(self) -> Held:
        """Payload of a belief in which something is grasped; an AssertionError where nothing is."""
        assert self.held is not None
        return self.held

    def thing(self, entity: str) -> Thing:
        """Return the thing that an entity name ("thing" or "thing/feature") belongs to."""
        return self.world.thing(thing_of(entity))

    def feature(self, entity: str, type_: str | None = None) -> Feature | None:
        """Return the feature that an entity names, or the thing's first feature of a class; None if there is none."""
        name = EntityName.parse(entity)
        owner = self.world.thing(name.thing)
        if name.part:
            return next((f for f in owner.features if f.name == name.part), None)
        return owner.feature(type_) if type_ else None

    def base(self) -> Pose:
        """Return the pose of the arm's base in the world frame."""
        return self.at or next(r.base for r in self.world.robots if r.name == self.robot)

    def pose(self, entity: str) -> Pose:
        """Return the pose of a thing or feature in the robot's base frame.

        Raises:
            KeyError: the thing is held or moves along (its pose depends on the arm), or is unknown.
        """
        name = EntityName.parse(entity)
        pose = self.base().inverse() * self.poses[name.thing].pose
        feature = self.feature(entity) if name.part else None
        return pose * feature.pose if feature else pose

    def moved(self, joints: tuple[float, ...]) -> Belief:
        """Return the belief with the arm at another joint position [rad]."""
        return replace(self, joints=joints)

    def driven(self, at: Pose) -> Belief:
        """Return the belief with the arm's base at another pose in the world; the payload moves along."""
        held = replace(self.held, joints=()) if self.held else None
        return replace(self, at=at, held=held)

    def grasped(self, held: Held) -> Belief:
        """Return the belief with a thing grasped: it, and all that it carries, moves with the hand from
        now on."""
        poses = {k: v for k, v in self.poses.items() if k != held.thing and k not in held.carries}
        return replace(self, poses=poses, held=replace(held, joints=self.joints), opening=held.opening)

    def released(self, estimate: Estimate, opening: float) -> Belief:
        """Return the belief after the payload is released: it is at the pose ``estimate``, with all things that it carries.

        Args:
            estimate: of the thing's pose, in the world frame.
            opening: distance between the pads then [m].
        """
        along = {n: replace(e, pose=estimate.pose * e.pose) for n, e in self.payload.carries.items()}
        return replace(self, poses={**self.poses, self.payload.thing: estimate, **along}, held=None, opening=opening)

    def in_hand(self) -> dict[str, Pose]:
        """Return the things that move with the hand, the payload first: poses in the TCP frame."""
        if self.held is None:
            return {}
        along = {n: self.held.tcp_to_thing * e.pose for n, e in self.held.carries.items()}
        return {self.held.thing: self.held.tcp_to_thing, **along}

    def related(self, *facts: Relation) -> Belief:
        """Return the belief with the given relations between things added."""
        return replace(self, relations=self.relations | set(facts))

    def unrelated(self, predicate: str, subject: str) -> Belief:
        """Return the belief without any relation ``predicate(subject, _)``."""
        return replace(self, relations=frozenset(r for r in self.relations if r[:2] != (predicate, subject)))

    def relates(self, predicate: str, subject: str) -> str | None:
        """Return the first thing for which ``predicate(subject, thing)`` holds, or None."""
        return next((o for p, s, o in sorted(self.relations) if (p, s) == (predicate, subject)), None)


def initial_belief(
    world: World,
    robot: str,
    joints: tuple[float, ...],
    opening: float,
    relations: Iterable[Relation] = (),
    at: Pose | None = None,
) -> Belief:
    """Return the belief that takes every pose of the world as known.

    Args:
        robot: name of the mount.
        joints: where its joints are, in the robot's order [rad].
        opening: distance between the pads [m].
        relations: that hold at the start, such as ("hangs_on", "coffee", "hook/peg").
        at: the pose of a base that drives, in the world frame; None where it stands as mounted.
    """
    poses = {t.name: Estimate(t.pose) for t in world.things}
    return Belief(world, poses, robot, joints, opening, relations=frozenset(relations), at=at)
