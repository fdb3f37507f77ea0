"""Roles of a learned task: the things that change in one example, and which things of the other examples correspond to them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import combinations

import numpy as np

from ..base.value import Value
from .literal import ANY, HAND, Language, Literal
from .span import Truths
from .tables import Tables

MOST_ROLES = 3
"""Largest number of roles of a learned task: no shipped task has more."""
WHO = 4
"""Number of things that are tried in the roles: those that change most in the first demonstration."""
TRIED = 2
"""Number of choices of things that are tried for each number of roles: those with most conditions that all examples share."""


class Cast(Value, eq=False):
    """Assignment of things to roles in each example, with the conditions on these things that hold in all examples.

    Args:
        fillers: for each example the things in the roles.
        places: for each example the same as one index into the fillings of the roles.
        common: conditions that hold in all examples.
        changes: those of them that say that a recorded state begins or ends, with nothing left open, and that follow from no other.
        measured: where no recorded state begins or ends, the changes that must be measured: those of each thing that moves, else all.
        movers: how many roles are filled by things that are elsewhere in the end in all examples.
        agreement: how much the examples agree upon.
    """

    fillers: tuple[tuple[str, ...], ...]
    places: tuple[int, ...]
    common: tuple[Literal, ...]
    changes: tuple[Literal, ...]
    measured: tuple[tuple[Literal, ...], ...]
    movers: int
    agreement: float

    @property
    def roles(self) -> int:
        """Number of roles."""
        return len(self.fillers[0])

    @property
    def told(self) -> int:
        """Number of changes that a rule should explain.

        They are all recorded ones, one of each set of measured ones, and one for each moved thing.
        """
        return len(self.changes) + len(self.measured) + self.movers


def casts(tables: Tables, roles: int) -> list[Cast]:
    """Return the best assignments of things to a number of roles, for all examples together.

    Those with the most conditions in common come first; there are none if an example has too few things.

    Args:
        tables: of the examples.
    """
    literals = list(tables.language.literals(roles))
    weights = np.array([_weight(tables.language, one) for one in literals])
    holds = tables.truths(literals, roles)
    usable = tables.valid(roles)
    found = []
    for chosen in combinations(_who_changes(tables), roles):
        cast = _cast(tables, literals, weights, holds, usable, chosen)
        if cast is not None:
            found.append(cast)
    return sorted(found, key=lambda c: -c.agreement)[:TRIED]


def _who_changes(tables: Tables) -> list[int]:
    """Return the indices of the things that change, or that the agent acts on, in the first demonstration.

    The most changed come first.
    """
    language = tables.language
    literals = [one for one in language.literals(1) if one.roles and (_moving(language, one) or _with_hand(language, one))]
    weights = np.array([_weight(tables.language, one) for one in literals])
    score = weights @ tables.truths(literals, 1)[:, 0] if tables.size else np.zeros(0)
    score = np.where(tables.valid(1)[0], score, 0.0) if tables.size else score
    return [k for k in sorted(range(tables.size), key=lambda k: (-score[k], k)) if score[k] > 0][:WHO]


def _with_hand(language: Language, literal: Literal) -> bool:
    """Check whether a condition says that a recorded state of agent and role lasts throughout the task."""
    return literal.phase == "run" and HAND in literal.slots and not literal.denied and recorded(language, literal)


def _moving(language: Language, literal: Literal) -> bool:
    """Check whether a condition requires a change, or something that happens during the task."""
    return literal.kind in ("begins", "ends") or (not literal.denied and language.predicates[literal.predicate].phases == {"run"})


def _weight(language: Language, literal: Literal) -> float:
    """Return the weight, in choosing the roles of a learned task, of a condition that holds in all examples;
    changes weigh more than lasting states."""
    if not literal.roles:
        return 0.0
    if literal.kind in ("begins", "ends"):
        return 8.0 if recorded(language, literal) else 2.0
    return 0.05 if literal.denied else 2.0 if _moving(language, literal) else 1.0


def recorded(language: Language, literal: Literal) -> bool:
    """Check whether a condition is about a recorded state, which tasks change, and not about a measurement."""
    predicate = language.predicates[literal.predicate]
    return predicate.steady and (predicate.fluent.initial is not None or predicate.fluent.in_hand)


def _cast(
    tables: Tables, literals: Sequence[Literal], weights: np.ndarray, holds: Truths, usable: Truths, chosen: tuple[int, ...]
) -> Cast | None:
    roles = len(chosen)
    places = [int(np.ravel_multi_index(chosen, (tables.size,) * roles)) if roles else 0]
    common = holds[:, 0, places[0]]
    for k in range(1, len(tables.spans)):
        agreed = np.where(usable[k], (weights * common) @ holds[:, k], -1.0)
        if not len(agreed) or agreed.max() < 0:
            return None
        places.append(int(np.argmax(agreed)))
        common = common & holds[:, k, places[-1]]
    kept = tuple(one for one, true in zip(literals, common, strict=True) if true)
    names = tuple(tables.names(k, p, roles) for k, p in enumerate(places))
    movers = sum(all(s.elsewhere(f[role]) for s, f in zip(tables.spans, names, strict=True)) for role in range(roles))
    changes = tuple(_changes(tables.language, kept))
    measured = () if changes else _measured(tables.language, kept, roles)
    return Cast(names, tuple(places), kept, changes, measured, movers, float(weights @ common))


def _changes(language: Language, common: Sequence[Literal]) -> Iterator[Literal]:
    """Yield the changes that all examples share: recorded states of agent and roles that begin or end.

    A change that another one implies is left out.
    """
    changes = [one for one in common if one.kind in ("begins", "ends") and _whole(language, one) and recorded(language, one)]
    for one in changes:
        if not any(follows(language, one, other) for other in changes if other != one):
            yield one


def _whole(language: Language, literal: Literal) -> bool:
    """Check whether a condition leaves no argument open ("_"), except the contents of a vessel, which have no name."""
    contents = language.predicates[literal.predicate].fluent.of_contents
    return ANY not in (literal.slots[:-1] if contents else literal.slots)


def own_changes(tables: Tables, span: int) -> tuple[Literal, ...]:
    """Return the changes of recorded states between the agent and up to two things in a span, in terms of
    roles instead of things."""
    asked = [one for one in tables.language.literals(2) if one.kind in ("begins", "ends") and _whole(tables.language, one)]
    literals = [one for one in asked if recorded(tables.language, one)]
    if not literals or not tables.size:
        return ()
    true = (tables.truths(literals, 2)[:, span] & tables.valid(2)[span]).any(axis=1)
    return tuple(one for one, holds in zip(literals, true, strict=True) if holds)


def _measured(language: Language, common: Sequence[Literal], roles: int) -> tuple[tuple[Literal, ...], ...]:
    """Return sets of measured changes that all examples have in common.

    A rule should explain one change of each set.

    There is a set for each role that moves, else a single set of all changes.
    """
    changes = [one for one in common if one.kind in ("begins", "ends") and ANY not in one.slots]
    moving = {one.slots for one in common if one.kind == "holds" and _moving(language, one)}
    alone = [tuple(one for one in changes if one.slots == (role,) and one.slots in moving) for role in range(1, roles + 1)]
    return tuple(found for found in (alone if any(alone) else [tuple(changes)]) if found)


def follows(language: Language, literal: Literal, other: Literal) -> bool:
    """Check whether one change follows from another, as the predicate of the other declares (``implies``,
    ``undoes``)."""
    fluent = language.predicates[other.predicate].fluent
    if set(literal.slots) != set(other.slots) or literal.kind != other.kind:
        return False
    if other.kind == "begins":
        return literal.predicate in fluent.implies
    return literal.predicate in fluent.undoes
