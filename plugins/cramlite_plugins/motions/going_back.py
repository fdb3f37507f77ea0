"""Motion "back": leads the arm back to where an attempt or a loop began, from wherever its steps may have ended.

The plan language asks for it: before an attempt is made again, at the end of a round, after the first of several has
succeeded. Steps that cannot fail come first in most attempts (a transfer); from all later ones the arm goes straight back
to where those ended, and from there the same way as it came.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from msgspec.structs import replace

from cramlite.model import (
    AnyStep,
    Belief,
    Joints,
    Motion,
    MoveJoints,
    MoveLinear,
    SetGripper,
    SetPayload,
    Wait,
    ZeroSensor,
    walk,
)
from cramlite.plugin import Answers, Context, Grounding, Refused, Unresolvable, hookimpl

from ..kinematics.forward import forward
from ..motion_planning.cartesian import plan_straight_line
from .gripping import PADS_SPEED

SURE = (MoveJoints, MoveLinear, SetPayload, ZeroSensor, Wait)
"""Types of steps that cannot fail. A gripper step that expects nothing cannot fail either, unless the gripper does not answer."""
SPEED, ACCELERATION = 0.05, 0.5  # straight back [m/s, m/s2]: half as fast as other straight motions, out of contact


@hookimpl
def resolve_motion(motion: Motion, belief: Belief, context: Context) -> Answers:
    """Resolve motion "back"; None for other kinds."""
    return _back(motion, belief, context) if motion.kind == "back" else None


def _back(motion: Motion, belief: Belief, context: Context) -> Iterator[Grounding]:
    start: Belief = motion.parameters["to"]
    after = list(walk(motion.parameters["after"]))
    _check_hand(motion, start, after)
    lead, rest = _split(after)
    pivot = _ends(lead)[-1] if _ends(lead) else start.joints
    _check_lines(motion, start, context, pivot, _ends(rest))
    steps = [*_open(motion, start, after), *_straight(motion, context, pivot, rest), *_retraced(motion, start, context, lead)]
    kept = replace(start, poses=belief.poses) if belief.poses.keys() == start.poses.keys() else start
    reason = f"straight to where the last {len(rest)} steps began, then back along the path of the first {len(lead)}"
    yield Grounding(tuple(steps), reason, 0.0, kept, key="back")


def _check_hand(motion: Motion, start: Belief, after: list[AnyStep]) -> None:
    """Refuse to go back after steps that may have released or taken a thing, since it may be anywhere then."""
    grips = [k for k, s in enumerate(after) if isinstance(s, SetGripper)]
    if start.held and grips:
        raise Unresolvable(f"'{motion.name}': the gripper moves while it holds '{start.held.thing}', so the steps cannot be tried again")
    taken = next((k for k in grips if after[k].expect == "object"), None)  # type: ignore[union-attr]
    if taken is not None and any(not _sure(s) for s in after[taken + 1 :]):
        raise Unresolvable(f"'{motion.name}': after a failure the grasped thing may be anywhere, so the steps cannot be tried again")


def _sure(step: AnyStep) -> bool:
    return isinstance(step, SURE) or (isinstance(step, SetGripper) and step.expect == "any")


def _split(after: list[AnyStep]) -> tuple[list[AnyStep], list[AnyStep]]:
    """Split program steps in two: those before the first step that can fail, and all from that step on."""
    count = next((k for k, s in enumerate(after) if not _sure(s)), len(after))
    return after[:count], after[count:]


def _ends(steps: Iterable[AnyStep]) -> list[Joints]:
    """Joint positions at which program steps end."""
    found: list[Joints] = []
    for step in steps:
        found += step.path if isinstance(step, MoveJoints) else [q for q in (getattr(step, "joints", ()),) if q]
    return found


def _check_lines(motion: Motion, start: Belief, context: Context, pivot: Joints, ends: list[Joints]) -> None:
    from ..motion_planning.reach import make_scene, touched

    scene = make_scene(start, context, touched(motion.may_touch, context), clearance=0.0)
    target = forward(context.robot, pivot)
    for q in ends:
        found = plan_straight_line(scene, context.robot, q, [target])
        if isinstance(found, Refused):
            said = f"'{motion.name}': no way back to where it began: {found.reason}"
            raise Unresolvable(said, blocking=found.blocking, collision=found.collision)


def _open(motion: Motion, start: Belief, after: list[AnyStep]) -> Iterator[AnyStep]:
    last = next((s for s in reversed(after) if isinstance(s, SetGripper)), None)
    if last is not None and start.held is None:
        yield SetGripper(start.opening, PADS_SPEED, last.force, origin=motion.name, comment="as wide as before")


def _straight(motion: Motion, context: Context, pivot: Joints, rest: list[AnyStep]) -> Iterator[AnyStep]:
    """Yield a straight TCP motion back to the joint position ``pivot``, if the steps after it moved the arm.

    So a thing that is touched is left in a straight line.
    """
    if _ends(rest):
        target = forward(context.robot, pivot)
        yield MoveLinear(target, SPEED, ACCELERATION, pivot, origin=motion.name, comment=motion.reason)


def _retraced(motion: Motion, start: Belief, context: Context, lead: list[AnyStep]) -> Iterator[AnyStep]:
    """Yield motions that undo, in reverse order, those first steps of a control structure that cannot
    fail."""
    here = start.joints
    back: list[AnyStep] = []
    for step in lead:
        if isinstance(step, MoveJoints):
            path = (*reversed(step.path[:-1]), here)
            back.append(replace(step, path=path, origin=motion.name, comment=motion.reason))
        elif isinstance(step, MoveLinear):
            target = forward(context.robot, here)
            back.append(replace(step, target=target, joints=here, origin=motion.name, comment=motion.reason))
        here = (_ends([step]) or [here])[-1]
    yield from reversed(back)

