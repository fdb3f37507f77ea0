"""Change of a program: an empty hand opens and closes while the arm moves, not before or after the motion."""

from __future__ import annotations

from msgspec.structs import replace

from cramlite.model import AnyStep, MoveJoints, Parallel, Program, SetGripper, enclosing_names


def opened_on_the_way(program: Program) -> Program:
    """Return a program whose empty fingers open and close while the arm moves, not before or after the motion.

    They open during the transfer after the gripper step, and close during the transfer before it.

    The transfer was planned with fingers as they are after it: wider than those that still open. Those that still close, or that a program
    begins with, may be wider than planned: whether they have room is seen when the text runs in the proof, where the arm is as fast as it
    can be. Empty fingers that close on nothing where a transfer ends do so during that one, which was planned with open fingers. Fingers
    that close on something, or that may let go of it, are waited for.
    """
    steps: list[AnyStep] = []
    places, order, empty = list[int](), None, False
    for step in program.steps:
        if isinstance(step, MoveJoints) and empty and order is steps[-1]:
            steps[-1] = Parallel(((order,), (step,)), origin=step.origin, comment=f"{order.comment}; {step.comment}")
            places.append(len(steps) - 1)
            continue
        if isinstance(step, SetGripper) and steps and isinstance(go := steps[-1], MoveJoints) and _shuts(order, step) and _of_one(go, step):
            steps[-1] = Parallel(((step,), (go,)), origin=go.origin, comment=f"{go.comment}; {step.comment}")
            places.append(len(steps) - 1)
            order, empty = step, False
            continue
        if isinstance(step, SetGripper):
            order, empty = step, _empty(order, step)
        places.append(len(steps))
        steps.append(step)
    places.append(len(steps))
    sections = tuple(replace(s, first=places[s.first], last=places[s.last]) for s in program.sections)
    return replace(program, steps=tuple(steps), sections=sections)


def _empty(before: SetGripper | None, order: SetGripper) -> bool:
    """Whether the fingers are empty when a gripper step moves them, by what this step and the one before
    expect them to hold."""
    if before is None:
        return order.opening > 0.0 if order.expect == "any" else _shuts(before, order)
    return before.expect == "none" and (order.expect == "none" or (order.expect == "any" and order.opening > 0.0))


def _shuts(before: SetGripper | None, order: SetGripper) -> bool:
    """Whether a gripper step closes the fingers fully on nothing: neither it nor the step before expects a thing between them."""
    return order.expect == "none" and order.opening == 0.0 and (before is None or before.expect == "none")


def _of_one(one: AnyStep, other: AnyStep) -> bool:
    """Whether two steps are of the same task."""
    return [*enclosing_names(one.origin)][1:] == [*enclosing_names(other.origin)][1:]
