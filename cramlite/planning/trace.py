"""The trace of a resolution: who answered what, and why the others were refused."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, Literal

from msgspec import Struct, field, to_builtins

from ..base.value import Value

Outcome = Literal["asked", "chosen", "refused", "impossible", "failed", "nogood", "capped", "fault", "proven"]


class Entry(Value):
    """One line of the trace.

    Args:
        number: position in the trace.
        parent: number of the choice that this hangs under; 0 for the root.
        candidate: which task sequence this belongs to, from 1.
        designator: its name.
        text: the designator, or the alternative, in words.
        outcome: "asked" (a designator is up), "chosen" (an alternative is tried), "refused" (a plugin considered and
            dropped it), "impossible" (a plugin says so for the whole designator), "failed" (tried, and what followed
            failed), "nogood" (skipped: the same combination failed before), "capped", "fault" (a plugin's bug),
            "proven" (its text ran and was judged).
        plugin: who said it.
        reason: a clause with numbers and units.
        cost: of an alternative.
        passed: checks that a refused alternative passed before.
    """

    number: int
    parent: int
    candidate: int
    designator: str
    text: str
    outcome: Outcome
    plugin: str
    reason: str
    cost: float | None = None
    passed: int = 0


class Trace(Struct):
    """An append-only list of entries, filled while a search runs.

    Args:
        entries: in the order in which things were decided.
        candidate: which task sequence is being tried, from 1.
    """

    entries: list[Entry] = field(default_factory=list)
    candidate: int = 1

    def add(
        self, parent: int, designator: str, text: str, outcome: Outcome, plugin: str, reason: str,
        cost: float | None = None, passed: int = 0,
    ) -> int:  # fmt: skip
        number = len(self.entries) + 1
        self.entries.append(
            Entry(number, parent, self.candidate, designator, text, outcome, plugin, reason, cost, passed)
        )
        return number

    def about(self, designator: str) -> Iterator[Entry]:
        """Entries of designators whose name contains the text."""
        return (e for e in self.entries if designator.lower() in e.designator.lower())

    def to_json(self) -> list[dict[str, Any]]:
        return [to_builtins(e) for e in self.entries]

    @classmethod
    def from_json(cls, rows: list[dict[str, Any]]) -> Trace:
        return cls([Entry(**row) for row in rows])
