"""Tables of facts of many spans at once, one for each predicate and phase.

Spans have few things each, so all are padded to the same number; who acts has the last place.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from .literal import ANY, HAND, Language, Literal
from .span import Span, Truths


class Tables:
    """Arrays that say which facts hold in each of several spans; each array is computed when it is first used.

    Args:
        language: whose predicates are asked.
        spans: at least one.
    """

    def __init__(self, language: Language, spans: Sequence[Span]) -> None:
        self.language, self.spans = language, tuple(spans)
        self.size = max((len(s.things) for s in spans), default=0)
        self._known: dict[tuple[str, str], npt.NDArray] = {}  # type: ignore[type-arg]

    def valid(self, roles: int) -> Truths:
        """Return for each span the role assignments that give each role another thing of this span, as a mask (spans, assignments).

        The rest contain the padding of the tables, or one thing twice.
        """
        one = np.arange(self.size)[None, :] < np.array([len(s.things) for s in self.spans])[:, None]
        found = np.ones((len(self.spans), *(1,) * roles), dtype=np.bool_)
        for role in range(roles):
            found = found & one.reshape(-1, *(self.size if k == role else 1 for k in range(roles)))
        several = [len(set(k)) == roles for k in np.ndindex(*(self.size,) * roles)]
        return np.asarray(found.reshape(len(self.spans), -1) & np.array(several, dtype=np.bool_))

    def truths(self, literals: Sequence[Literal], roles: int) -> Truths:
        """Return for each condition the spans and role assignments in which it holds, as a mask (conditions,
        spans, assignments)."""
        shape = (len(self.spans), *(self.size,) * roles)
        found = np.empty((len(literals), *shape), dtype=np.bool_)
        for k, literal in enumerate(literals):
            found[k] = self.truth(literal, roles)
        return found.reshape(len(literals), len(self.spans), self.size**roles)

    def truth(self, literal: Literal, roles: int) -> Truths:
        """Return a boolean array that says for which spans and role assignments a condition holds.

        Axes of roles that the condition does not mention have length 1.
        """
        if literal.kind in ("begins", "ends"):
            before, after = (self._of_slots(self._holds(literal, p), literal.slots, roles) for p in ("pre", "post"))
            return ~before & after if literal.kind == "begins" else before & ~after
        if literal.kind in ("at_least", "at_most"):
            values = self._holds(literal, literal.phase)
            with np.errstate(invalid="ignore"):
                found = values >= literal.bound if literal.kind == "at_least" else values <= literal.bound
        else:
            found = self._holds(literal, literal.phase)
        found = self._of_slots(found, literal.slots, roles)
        return ~found if literal.denied else found

    def _holds(self, literal: Literal, phase: str) -> npt.NDArray:  # type: ignore[type-arg]
        key = (literal.predicate, literal.class_ or phase)
        if key not in self._known:
            tables = [self._of_span(s, literal, phase) for s in self.spans]
            padded = np.zeros((len(tables), *(self.size + 1,) * tables[0].ndim), dtype=tables[0].dtype)
            for k, (span, one) in enumerate(zip(self.spans, tables, strict=True)):
                places = [*range(len(span.things)), self.size]
                padded[(k, *np.ix_(*[places] * one.ndim))] = one
            self._known[key] = padded
        return self._known[key]

    def _of_span(self, span: Span, literal: Literal, phase: str) -> npt.NDArray:  # type: ignore[type-arg]
        predicate = self.language.predicates[literal.predicate]
        if literal.class_:
            return span.of_class(predicate, literal.class_)
        return span.values(predicate, phase) if predicate.value else span.holds(predicate, phase)  # type: ignore[arg-type]

    def _of_slots(self, table: Truths, slots: tuple[int, ...], roles: int) -> Truths:
        """Convert a predicate's table over things to a table over roles, with one axis for each role.

        An argument "_" stands for any thing; that of the agent is fixed.
        """
        places = (self.size if s == HAND else slice(None) if s == ANY else slice(self.size) for s in slots)
        picked = table[(slice(None), *places)]
        left = [s for s in slots if s != HAND]
        picked = np.asarray(picked.any(axis=tuple(k + 1 for k, s in enumerate(left) if s == ANY))) if ANY in left else picked
        named = [s for s in left if s > 0]
        picked = np.transpose(picked, (0, *(np.argsort(named) + 1))) if len(named) > 1 else picked
        return np.asarray(picked).reshape([len(self.spans), *(self.size if r in named else 1 for r in range(1, roles + 1))])

    def place(self, span: int, fillers: Sequence[str]) -> int:
        """Return the index of the role assignment in which things with these names fill the roles."""
        things = self.spans[span].things
        return int(np.ravel_multi_index([things.index(f) for f in fillers], (self.size,) * len(fillers))) if fillers else 0

    def names(self, span: int, place: int, roles: int) -> tuple[str, ...]:
        """Return the names of the things in a role assignment that is given by its index."""
        things = self.spans[span].things
        return tuple(things[int(k)] for k in np.unravel_index(place, (self.size,) * roles)) if roles else ()
