"""Reachability filter of candidate places: it refuses those for which the arm has no collision-free joint
position at a TCP pose on the way.

As ``ComputeIK`` of MoveIt Task Constructor wraps a generator of poses. A generator yields candidates, best
first, and names no inverse kinematics and no planning scene.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import lru_cache
from typing import Any

from msgspec.structs import replace

from cramlite.model import Belief, Joints, Pose, Stage, Value
from cramlite.plugin import Answer, Context, Grounding, Refused

from ..kinematics.reach import reach_shortfall
from ..motion_planning.cartesian import plan_straight_line
from ..motion_planning.planning_scene import PlanningScene
from ..motion_planning.reach import collision_free_ik, make_scene, shift

SCENES = 24
"""Number of an arm's planning scenes that are cached: consecutive grasps are of about the same width."""
IN_ORDER = 0.1
"""Cost added for each earlier candidate, where a candidate states no cost of its own."""


class Leg(Value):
    """TCP pose at which the arm has to be free of collision, with joint positions near those of the previous
    leg.

    Args:
        pose: in the base frame.
        touching: entities that hand and payload may touch there.
        opening: of the fingers [m]; the believed one by default.
        clearance: to everything else [m]; the planner's own by default.
        hand: whether the hand may touch these entities, and not the payload alone.
        along: poses through which the arm has to lead the hand straight on from there, checked all the way.
        said: clause before a refusal there, such as "at the grasp".
        where: stage of the way that a refusal there is about.
    """

    pose: Pose
    touching: tuple[str, ...] = ()
    opening: float | None = None
    clearance: float | None = None
    hand: bool = True
    along: tuple[Pose, ...] = ()
    said: str = ""
    where: Stage | None = None

    def refused(self, no: Refused) -> Refused:
        """Return a refusal with the stage of the motion, such as "at the grasp", put before its reason."""
        said = f"{self.said}: {no.reason}" if self.said else no.reason
        return replace(no, reason=said, where=self.where or no.where)


class Candidate(Value):
    """Candidate for the grounding of a location, before it is checked whether the arm reaches it.

    Args:
        name: for people; it also identifies the alternative.
        place: what the location is grounded to.
        legs: the TCP poses on the way, in the order in which the arm is asked.
        reason: why this one; the name by default.
        cost: ``IN_ORDER`` times the number of those before it by default.
        key: identifies the alternative among its siblings; the name by default.
        group: of alternatives one of which is enough; "" for none.
        anew: whether the place is where it is wherever the arm comes from.
        passed: number of checks that it passed before.
        check: further objection, given the joint positions of all legs.
    """

    name: str
    place: Any
    legs: tuple[Leg, ...]
    reason: str = ""
    cost: float | None = None
    key: str = ""
    group: str = ""
    anew: bool = False
    passed: int = 0
    check: Callable[[Sequence[Joints]], Refused | None] | None = None


class Arm:
    """Reachability checks of an arm in a belief: free joint positions at TCP poses, with planning scenes
    that are kept."""

    def __init__(self, belief: Belief, context: Context) -> None:
        self.belief, self.context = belief, context
        self._scene = lru_cache(SCENES)(self._made)
        self._kept = lru_cache(SCENES)(self._built)

    def scene(
        self,
        touching: tuple[str, ...] = (),
        opening: float | None = None,
        clearance: float | None = None,
        hand: bool = True,
    ) -> PlanningScene:
        """Return the planning scene in which hand and payload may touch some entities; it is made once and
        reused."""
        return self._scene(touching, opening, clearance, hand)

    def _made(
        self, touching: tuple[str, ...], opening: float | None, clearance: float | None, hand: bool
    ) -> PlanningScene:
        closed = self._kept(touching, clearance, hand)
        return closed if opening is None else closed.opened(opening)

    def _built(self, touching: tuple[str, ...], clearance: float | None, hand: bool) -> PlanningScene:
        return make_scene(self.belief, self.context, touching, None, clearance, hand)

    def of(self, leg: Leg) -> PlanningScene:
        """Return the planning scene for a TCP pose that the arm has to reach."""
        return self.scene(leg.touching, leg.opening, leg.clearance, leg.hand)

    def at(self, leg: Leg, seed: Joints | None = None) -> Joints | Refused:
        """Return, of the collision-free joint positions at a TCP pose, the one nearest to joint position
        ``seed``; or why there is none.

        The default seed is the believed joint position.
        """
        if (no := self._hand_met(leg)) is not None:
            return leg.refused(no)
        begin = self.belief.joints if seed is None else seed
        there = collision_free_ik(self.of(leg), self.context, leg.pose, begin)
        if not isinstance(there, Refused) and leg.along:
            line = plan_straight_line(self.of(leg), self.context.robot, there, leg.along)
            there = line if isinstance(line, Refused) else there
        return leg.refused(there) if isinstance(there, Refused) else there

    def _hand_met(self, leg: Leg) -> Refused | None:
        """Return the refusal with what the hand meets at a TCP pose, whatever the arm's posture; None if
        nothing.

        It saves inverse kinematics, which takes a hundred times as long for seven axes; arms with fewer are
        not checked.
        """
        robot = self.context.robot
        if len(robot.joints) < 7 or reach_shortfall(robot, leg.pose):
            return None
        return self.of(leg).met(self.belief.base() * leg.pose)

    def led(self, legs: Iterable[Leg]) -> tuple[Joints, ...] | Refused:
        """Return the joint positions at TCP poses in turn, each the nearest to the one before; or why one
        pose has none."""
        found = list[Joints]()
        for leg in legs:
            there = self.at(leg, found[-1] if found else None)
            if isinstance(there, Refused):
                return there
            found.append(there)
        return tuple(found)

    def free_along(self, leg: Leg, way: Any, parts: Iterable[float], seed: Joints | None = None) -> bool:
        """Check whether the arm is free of collision at points of a straight way (3,) [m] from a TCP pose."""
        legs = (replace(leg, pose=shift(leg.pose, part * way)) for part in parts)
        return not any(isinstance(self.at(one, seed), Refused) for one in legs)


def reached(
    candidates: Iterable[Candidate | Refused], arm: Arm, because: tuple[str, ...] | None = None
) -> Iterator[Answer]:
    """Yield the places that an arm reaches, and why it does not reach the others.

    Args:
        candidates: best first; refusals among them are passed on.
        because: choices that refusals of candidates depend on, in place of their own.
    """
    done = set[str]()
    for k, candidate in enumerate(candidates):
        if isinstance(candidate, Refused):
            yield candidate
        elif candidate.group not in done:
            no = objection(candidate, arm)
            if no is not None:
                no = no if because is None else replace(no, because=because)
                yield no.of(candidate.name, max(candidate.passed, no.passed))
                continue
            done |= {candidate.group} - {""}
            cost = IN_ORDER * k if candidate.cost is None else candidate.cost
            reason, key = candidate.reason or candidate.name, candidate.key or candidate.name
            yield Grounding(candidate.place, reason, cost, key=key, anew=candidate.anew)


def objection(candidate: Candidate, arm: Arm) -> Refused | None:
    """Return why the arm cannot go to a proposed place, or why the place fails a check of its own; None if
    neither applies."""
    led = arm.led(candidate.legs)
    if isinstance(led, Refused):
        return led
    return candidate.check(led) if candidate.check else None
