"""Refutations: why a whole task sequence failed, in terms of its tasks and of the state of things at that
time."""

from __future__ import annotations

from collections.abc import Iterable

from ..base.errors import InTheWay
from ..base.value import Value

ANY = ""
"""Wildcard among the things in the way: any thing of the world."""


Part = tuple[str, tuple[tuple[str, str], ...]]
"""Subtask: its class, and the entity in each of its roles."""

WHOLE: Part = ("", ())
"""Subtask that represents the whole task."""


class InTask(Value):
    """Member of a conflict set: a task of the plan in which an alternative was refused.

    Args:
        number: of the task, counted from 1.
        part: in which of the tasks that it is made of; None where that is said of each refusal below.
    """

    number: int
    part: Part | None = WHOLE


class AsItIs(Value):
    """Part of a conflict set: a refusal that holds while at least one of its things is unmoved and unchanged.

    ``ANY`` among the things stands for any thing of the world.
    """

    things: frozenset[str]


class Unfit(Value):
    """Part of a conflict set: a thing named by the goal or plan can fill no role, in whatever task sequence."""

    entity: str


class Capped(Value):
    """Member of a conflict set: the search left alternatives of a choice untried, and may succeed once it
    tries more."""


class Later(Value):
    """Member of a conflict set: another alternative of this choice may avoid the failure, but alternatives of
    other choices are tried first."""

    choice: str


class Refutation(Value):
    """Refutation of a task sequence: all its groundings failed, as far as the budget and limits on
    alternatives let them be tried.

    Args:
        tasks: in which something was refused, counted from 1, in order.
        things: sets of things that were in the way: it fails while of each set at least one is as it then was; None where it was
            not said of all refusals what they depend on.
        reason: the refusal that came after the most choices.
        part: of the last of these tasks, in which alone all of it was refused; None where it was in several, or in no part.
        unfit: things that can play no role in any task sequence.
    """

    tasks: tuple[int, ...]
    things: tuple[tuple[str, ...], ...] | None
    reason: str = ""
    part: Part | None = None
    unfit: tuple[str, ...] = ()


def as_they_are(things: InTheWay) -> frozenset[AsItIs]:
    """Convert the blocking things of a refusal (``Refused.blocking``) to causes for a conflict set."""
    sets = [ANY] if things is None else things
    return frozenset(AsItIs(frozenset([one] if isinstance(one, str) else one)) for one in sets)


def refutation(conflict: Iterable[object], reason: str = "") -> Refutation:
    """Return why a task sequence failed, from the causes that the search collected (a conflict set).

    Of sets of things in the way only those that contain no other set are kept.
    """
    found = tuple(conflict)
    sets = {c.things for c in found if isinstance(c, AsItIs)}
    least = sorted(tuple(sorted(s)) for s in sets if not any(other < s for other in sets))
    tasks = sorted({c.number for c in found if isinstance(c, InTask)})
    parts = {c.part for c in found if isinstance(c, InTask) and c.number == tasks[-1] and c.part is not None}
    part = next(iter(parts)) if len(parts) == 1 and WHOLE not in parts else None
    unfit = tuple(sorted(c.entity for c in found if isinstance(c, Unfit)))
    return Refutation(tuple(tasks), None if any(ANY in s for s in sets) else tuple(least), reason, part, unfit)
