"""Refutations: what the failure of a whole task sequence depends on, as tasks of it and things as they then were."""

from __future__ import annotations

from collections.abc import Iterable

from ..base.value import Value

ANY = ""
"""Stands for every thing of the world."""


class InTask(Value):
    """Part of a conflict set: something was refused in this task of the plan, counted from 1."""

    number: int


class AsItIs(Value):
    """Part of a conflict set: something was refused while this thing, or ``ANY``, was where it is, and as it is."""

    thing: str


class Refutation(Value):
    """Failure of every grounding of a task sequence, as far as the budget and the caps let them be tried.

    Args:
        tasks: in which something was refused, counted from 1, in order.
        things: that were in the way as they then were; None where it was not said of all refusals what they depend on.
        reason: the refusal that came after the most choices.
    """

    tasks: tuple[int, ...]
    things: tuple[str, ...] | None
    reason: str = ""


def as_they_are(things: Iterable[str] | None) -> frozenset[AsItIs]:
    """Return the part of a conflict set that blames things, by what a plugin says of them (``Refused.blocking``)."""
    return frozenset(map(AsItIs, [ANY] if things is None else things))


def refutation(conflict: Iterable[object], reason: str = "") -> Refutation:
    """Return what a conflict set says of tasks and things."""
    found = tuple(conflict)
    things = {c.thing for c in found if isinstance(c, AsItIs)}
    tasks = sorted({c.number for c in found if isinstance(c, InTask)})
    return Refutation(tuple(tasks), None if ANY in things else tuple(sorted(things)), reason)
