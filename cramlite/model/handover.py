"""Handovers: the moments of a plan at which a thing passes into the hand, or out of it."""

from __future__ import annotations

from ..base.value import Value
from .belief import Belief, Estimate


class Handover(Value):
    """One thing that passes into the hand, or out of it.

    Args:
        thing: its name.
        by: designator whose code does it, e.g. "1.Grasping/close"; "" for what is in the hand when the program begins.
        taken: True into the hand, False out of it.
        rest: where the thing is expected to come to rest after it left the hand, world frame; None where it is taken.
        optional: True where the run decides whether it happens, as in a branch of a fallback.
    """

    thing: str
    by: str
    taken: bool
    rest: Estimate | None = None
    optional: bool = False


def handovers(before: Belief, after: Belief, by: str, *, optional: bool) -> tuple[Handover, ...]:
    """Return which things passed into the hand, or out of it, between two beliefs."""
    was, now = before.held, after.held
    if (was.thing if was else "") == (now.thing if now else ""):
        return ()
    found = []
    if was is not None:
        found.append(_left(was.thing, after, by, optional))
    if now is not None:
        found.append(Handover(now.thing, by, taken=True, optional=optional))
    return tuple(found)


def _left(thing: str, after: Belief, by: str, optional: bool) -> Handover:
    return Handover(thing, by, False, after.poses.get(thing), optional=optional)
