"""Typed program at a share of its speed: the same places, forces and decisions, at later times."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from msgspec.structs import replace

from .program import Program
from .steps import AnyStep, Fallback, Monitor, Parallel, Repeat, SetGripper, Wait

SPEEDS, ACCELERATIONS, TIMES = ("speed", "turn_speed"), ("acceleration", "turn_acceleration"), ("timeout", "time")


def slowed(program: Program, share: float) -> Program:
    """Return a program with every motion of the arm and its platform at a share of its speed.

    Accelerations shrink by the square of it, so that each motion keeps its shape, and time-outs grow. The fingers close as fast as
    before, since grips are judged by it; waits stay as long.

    Args:
        share: above 0 and up to 1.
    """
    return replace(program, steps=tuple(_steps(program.steps, share)))


def _steps(steps: Iterable[AnyStep], share: float) -> Iterable[AnyStep]:
    return (_step(step, share) for step in steps)


def _step(step: AnyStep, share: float) -> AnyStep:
    if isinstance(step, Fallback | Parallel):
        return replace(step, branches=tuple(tuple(_steps(b, share)) for b in step.branches))
    if isinstance(step, Repeat | Monitor):
        inner: dict[str, Any] = {"steps": tuple(_steps(step.steps, share))}
        return replace(step, **inner, **_changed(step, TIMES, 1 / share))
    if isinstance(step, SetGripper | Wait):
        return step
    changes = _changed(step, SPEEDS, share) | _changed(step, ACCELERATIONS, share**2) | _changed(step, TIMES, 1 / share)
    return replace(step, **changes)


def _changed(step: AnyStep, names: Iterable[str], factor: float) -> dict[str, float]:
    values = {name: getattr(step, name, None) for name in names}
    return {name: value * factor for name, value in values.items() if value is not None}
