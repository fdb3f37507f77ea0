"""Programs whose fingers open or close while the arm is under way."""

from __future__ import annotations

from msgspec.structs import replace

from cramlite.model import AnyStep, MoveJoints, Parallel, Program, SetGripper, enclosing_names


def opened_on_the_way(program: Program) -> Program:
    """Return a program in which empty fingers open during the transfer that follows, instead of before it, and close during the one before.

    The transfer was planned with open fingers, which are wider than those that still open; whether those that a program begins with are
    wider than its first order says is seen when the text runs in the proof. Empty fingers that close on nothing where a transfer ends do so
    during that one: it was planned with open fingers, too. Fingers that close on something, or that may let go of it, are waited for.
    """
    steps: list[AnyStep] = []
    places, order, opens = list[int](), None, False
    for step in program.steps:
        if isinstance(step, MoveJoints) and opens and order is steps[-1]:
            steps[-1] = Parallel(((order,), (step,)), origin=step.origin, comment=f"{order.comment}; {step.comment}")
            places.append(len(steps) - 1)
            continue
        if isinstance(step, SetGripper) and steps and isinstance(go := steps[-1], MoveJoints) and _shuts(order, step) and _of_one(go, step):
            steps[-1] = Parallel(((step,), (go,)), origin=go.origin, comment=f"{go.comment}; {step.comment}")
            places.append(len(steps) - 1)
            order, opens = step, False
            continue
        if isinstance(step, SetGripper):
            order, opens = step, step.expect == "any" and _widens(order, step)
        places.append(len(steps))
        steps.append(step)
    places.append(len(steps))
    sections = tuple(replace(s, first=places[s.first], last=places[s.last]) for s in program.sections)
    return replace(program, steps=tuple(steps), sections=sections)


def _widens(before: SetGripper | None, order: SetGripper) -> bool:
    """Whether an order opens empty fingers: the first one of a program, or after one that found nothing between them."""
    if before is None:
        return order.opening > 0.0
    return before.expect == "none" and order.opening >= before.opening


def _shuts(before: SetGripper | None, order: SetGripper) -> bool:
    """Whether an order closes empty fingers on nothing: the first one of a program, or after one that found nothing between them."""
    return order.expect == "none" and order.opening == 0.0 and (before is None or before.expect == "none")


def _of_one(one: AnyStep, other: AnyStep) -> bool:
    """Whether two steps are of the same task."""
    return [*enclosing_names(one.origin)][1:] == [*enclosing_names(other.origin)][1:]
