"""No-goods: combinations of choices that failed, so that none is tried twice."""

from __future__ import annotations

from msgspec import Struct, field

from .choice_point import Choice

Conflict = frozenset[str]
"""Names of the choices that a failure depends on."""


class Nogoods(Struct):
    """What failed so far.

    Args:
        known: combinations by each of their choices.
    """

    known: dict[Choice, list[frozenset[Choice]]] = field(default_factory=dict)

    def made_again(self, choices: tuple[Choice, ...]) -> Conflict | None:
        """The names of the choices in a combination that failed before and is made again with the last choice."""
        made = set(choices)
        found = next((nogood for nogood in self.known.get(choices[-1], ()) if nogood <= made), None)
        return frozenset(name for name, _ in found) if found is not None else None

    def remember(self, conflict: Conflict, choices: tuple[Choice, ...]) -> None:
        """That those of the choices which a failure depends on do not go together."""
        nogood = frozenset(c for c in choices if c[0] in conflict)
        for choice in nogood:
            self.known.setdefault(choice, []).append(nogood)
