"""Meanings of the goals of a sentence: which of them hold already, replace others, or contradict each other."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations
from typing import TYPE_CHECKING, NamedTuple

from msgspec.structs import replace

from ..base.errors import UserError
from ..base.value import Value
from ..model.entity_name import thing_of
from .reference import Resolver
from .refusal import ABSENT, FALSE, UNREAD, Refusal, listed
from .tree import Clause

if TYPE_CHECKING:
    from ..interpretation.fluents import Fluents, GoalCondition, GoalPhrase

OR = " or "
ASIDES = ("aside", "ahead", "same", "going")
"""Relations of clauses that ask for no goal: asides, announcements, repeated names, and places to which the robot should go."""


class Literal(Value):
    """Goal of a sentence, with the words from which it was understood.

    Args:
        goal: in the words of goals.
        origins: words of the sentence, each with what it was taken for.
    """

    goal: str
    origins: tuple[tuple[str, str], ...] = ()

    def __str__(self) -> str:
        said = ", ".join(f"'{words}' = {meant}" for words, meant in self.origins)
        return f"{self.goal}" + (f"  ({said})" if said else "")


class Row(NamedTuple):
    """Goal for which one clause of a sentence asks, with the things that it is about."""

    clause: Clause
    phrase: GoalPhrase
    themes: tuple[str, ...]
    literal: Literal


class Meanings:
    """Meanings of a sentence's goals in a scene."""

    def __init__(self, resolver: Resolver, fluents: Fluents) -> None:
        self._its, self._fluents = resolver, fluents

    def without_told(self, found: Sequence[Row]) -> list[Row]:
        """Return the goals without the statements that come earlier in the sentence than a request and are
        already true in the scene."""
        asked = max((k for k, row in enumerate(found) if not row.clause.told), default=-1)
        return [row for k, row in enumerate(found) if not (row.clause.told and k < asked and self._so(row))]

    def without_left(self, found: Sequence[Row]) -> list[Row]:
        """Return the goals without those that a thing shall leave a place, if another goal takes it elsewhere."""
        meant = [(row, self._meaning(row)) for row in found]
        gone = {row.themes for row, one in meant if one is not None and one.needs and row.clause.place is not None}
        leaves = [row for row, one in meant if one is not None and one.without and not (one.needs or one.shown)]
        return [row for row in found if not (row.themes in gone and any(row is other for other in leaves))]

    def superseded(self, before: Row, row: Row, clauses: Sequence[Clause], number: int) -> bool:
        """Check whether a later goal makes an earlier one superfluous: the earlier one is only a step
        towards the later one, or contradicts it."""
        if before.themes != row.themes or before.clause is row.clause:
            return False
        one, other = (self._meaning(r) for r in (before, row))
        if one is None or other is None:
            return False
        if before.clause.told and self._its.true(one):
            return True  # "the tin is on the tray: pick it up" says where it is
        placed = all(r.clause.place is not None and r.clause.relation == "phrase" for r in (before, row))
        if placed and row.clause.theme.pronoun and not row.clause.theme.several and self._its.true(one):
            return True  # "pick the bowl on the ramekin and place it on the plate"
        if before.clause.told and not row.clause.told and row.clause.theme.pronoun and self._fluents.clash(self._its.scene, one, other):
            raise Refusal(ABSENT, f"the sentence says that '{before.literal.goal}' holds already, and it does not")
        means = not (one.needs or one.shown) or any(self._fluents[f[0]].in_hand for f in one.needs)
        if means and (other.needs or other.shown):
            return True
        apart = clauses.index(before.clause) < number - 1 or row.clause.later
        if not apart or not self._fluents.clash(self._its.scene, one, other):
            return False
        if not self._fluents.clash(self._its.scene, replace(one, without=frozenset()), replace(other, without=frozenset())):
            raise Refusal(FALSE, f"'{before.literal.goal}' and '{row.literal.goal}' cannot both hold in the end")
        return True

    def check_given(self, rows: Sequence[Row]) -> None:
        """Refuse a conditional request ("if ...") whose condition does not hold."""
        for row in rows:
            meaning = self._meaning(row._replace(clause=replace(row.clause, denied=False)))
            if OR in row.literal.goal or meaning is None or self._its.true(meaning) == row.clause.denied:
                raise Refusal(ABSENT, f"the condition '{row.literal.goal}' does not hold, so nothing is asked for")

    def check(self, clauses: Sequence[Clause], found: Sequence[Row]) -> None:
        """Refuse parts of a sentence that name a thing but ask for nothing, and goals that contradict each
        other."""
        clauses = [c for c in clauses if c.relation not in ASIDES]
        for clause, after in zip(clauses, (*clauses[1:], None), strict=True):
            nouns = [n for n in (after.theme, after.place, after.beside and after.beside.nouns[0]) if n] if after is not None else []
            if not (clause.phrases or clause.told or clause.relation == "swap") and not any(n.pronoun or n.elided for n in nouns):
                raise Refusal(UNREAD, f"the sentence names '{clause.theme.said}', and states no goal for it")
        goals = {row.literal.goal for row in found}
        for low, high in ((g.split(), h.split()) for g, h in combinations(sorted(goals), 2)):
            if low[1:2] == high[1:2] == ["on"] and low[2:] == high[:1] and high[2:] == low[:1]:
                raise Refusal(FALSE, f"{low[0]} and {high[0]} cannot be on each other")
        for goal in sorted(g for g in goals if f"not {g}" in goals):
            raise Refusal(FALSE, f"the sentence asks for '{goal}' and also for its opposite")
        meant = [(row, self._meaning(row)) for row in found]
        held = {row.themes for row, one in meant if one is not None and any(self._fluents[f[0]].in_hand for f in one.needs)}
        if len(held) > 1:
            names = listed(sorted(n for group in held for n in group), "and")
            raise Refusal(FALSE, f"{names} cannot all be held in one hand; say where they shall go")
        for (row, one), (other, two) in combinations(meant, 2):
            if one is not None and two is not None and row.themes == other.themes and self._fluents.clash(self._its.scene, one, two):
                raise Refusal(FALSE, f"'{row.literal.goal}' and '{other.literal.goal}' cannot both hold in the end")

    def _so(self, row: Row) -> bool:
        """Check whether a statement in the sentence is true in the present scene; a denial is true if what it denies is not."""
        meaning = self._meaning(row._replace(clause=replace(row.clause, denied=False)))
        return meaning is not None and self._its.true(meaning) != row.clause.denied

    def _meaning(self, row: Row) -> GoalCondition | None:
        """Return the facts that a part of a goal requires; None for a denial, an alternative ("or"), or a
        free choice of things."""
        if row.clause.denied or row.clause.either:
            return None
        goal = row.literal.goal.split()
        goal = [row.themes[0], *goal[3:]] if goal[1] == "of" else goal  # "2 of Tin on tray"
        names = [w for w in goal if thing_of(w) in self._its.scene.types]
        slots = len([w for w in row.phrase.form.split() if w.isupper()])
        slots -= bool(row.clause.amount)
        things = [*names[:slots], *([row.clause.amount] if row.clause.amount else [])]
        try:
            return row.phrase.meaning(self._its.scene, *things)
        except (UserError, KeyError, TypeError):
            return None
