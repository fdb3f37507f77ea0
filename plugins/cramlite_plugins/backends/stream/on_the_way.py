"""Programs whose fingers open while the arm is under way."""

from __future__ import annotations

from msgspec.structs import replace

from cramlite.model import AnyStep, MoveJoints, Parallel, Program, SetGripper


def opened_on_the_way(program: Program) -> Program:
    """Return a program in which empty fingers open during the transfer that follows, instead of before it.

    The transfer was planned with open fingers, which are wider than those that still open; whether those that a program begins with are
    wider than its first order says is seen when the text runs in the proof. Fingers that close later, or that may let go of something, are
    waited for.
    """
    steps: list[AnyStep] = []
    places, order, opens = list[int](), None, False
    for step in program.steps:
        if isinstance(step, MoveJoints) and opens and order is steps[-1]:
            steps[-1] = Parallel(((order,), (step,)), origin=step.origin, comment=f"{order.comment}; {step.comment}")
            places.append(len(steps) - 1)
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
