"""Conditions that a learned rule may have.

A condition has a text and a description length in bits; a language says which conditions are possible.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import product
from typing import Literal as OneOf

from ..base.value import Value
from ..interpretation.timeline import PhaseName, Predicate

Kind = OneOf["holds", "begins", "ends", "at_least", "at_most", "class"]
"""Kind of a condition, which says how it asks its predicate: a state, a change over the span, a bound of a value, or a class of a thing."""

ANY, HAND = -1, 0
"""Values of a condition's argument slots: any thing (ANY), and the hand that acts (HAND); roles are counted from 1."""
PHASES: tuple[PhaseName, ...] = ("pre", "run", "post")
CHANGED, NUMBER, NEGATED, LOOK, OPEN = 1.0, 4.0, 1.0, 1.0, 3.0
"""Description lengths of parts of a condition [bits]: a change's direction (CHANGED), a threshold as one of 16 places between two values
(NUMBER), a negation (NEGATED), each unit of a predicate's cost, so that recorded states are preferred to measurements (LOOK), and an
argument that is left open where a role could be named (OPEN). In a negation an open argument costs nothing: "nothing supports a thing" is
about the thing."""


class Literal(Value, order=True):
    """Condition of a learned rule on the roles of a task.

    Args:
        predicate: its name.
        kind: how it is asked.
        phase: in which; "" of a change, which has two.
        slots: of its arguments.
        denied: whether it must not hold.
        bound: of a value, in the predicate's unit.
        class_: that a thing is of; "" of other kinds.
    """

    predicate: str
    kind: Kind
    phase: str
    slots: tuple[int, ...]
    denied: bool = False
    bound: float = 0.0
    class_: str = ""

    @property
    def roles(self) -> frozenset[int]:
        """Roles that the condition mentions."""
        return frozenset(s for s in self.slots if s > 0)

    @property
    def binds(self) -> frozenset[int]:
        """Roles for which the condition proposes things; none for a negated or numeric condition, which only
        tests things."""
        return frozenset() if self.denied or self.kind in ("at_least", "at_most") else self.roles

    def texts(self, names: Sequence[str]) -> Iterator[tuple[PhaseName, str]]:
        """Yield the texts of the condition in a rule file, each with its phase: before, during or after the task.

        ``names`` are the variables of the agent and of the roles.
        """
        arguments = ["_" if s == ANY else names[s] for s in self.slots]
        if self.kind == "class":
            arguments.append(self.class_)
        atom = f"{self.predicate}({', '.join(arguments)})"
        if self.kind in ("begins", "ends"):
            before, after = ("not ", "") if self.kind == "begins" else ("", "not ")
            yield "pre", before + atom
            yield "post", after + atom
        else:
            compared = {"at_least": f" >= {self.bound:g}", "at_most": f" <= {self.bound:g}"}.get(self.kind, "")
            yield self.phase, ("not " if self.denied else "") + atom + compared  # type: ignore[misc]


class Language(Value):
    """Language of a learned rule's conditions: the predicates that they may use, and how many classes they may name.

    Args:
        predicates: by name; those that hold of classes among them.
        hand: the predicate by which a rule names who acts; None where no plugin declares one.
        thing: the predicate by which a rule says that something is a thing of its own, and no part; None likewise.
        classes: how many classes an ontology offers.
        motion: the predicate of the motion that all examples show; None where they show none.
    """

    predicates: dict[str, Predicate]
    hand: str | None
    thing: str | None
    classes: int
    motion: str | None = None

    def bits(self, literal: Literal, roles: int) -> float:
        """Return the description length [bits] of a condition in a rule that has ``roles`` roles."""
        predicate = self.predicates[literal.predicate]
        bits = math.log2(len(self.predicates)) + math.log2(roles + 2) * len(literal.slots) + LOOK * predicate.cost
        bits += OPEN * max(literal.slots.count(ANY) - literal.denied, 0)
        if literal.kind in ("begins", "ends"):
            return bits + CHANGED
        bits += 0.0 if predicate.timeless else math.log2(len(PHASES))
        bits += {"at_least": NUMBER, "at_most": NUMBER, "class": math.log2(max(self.classes, 2))}.get(literal.kind, 0.0)
        return bits + (NEGATED if literal.denied else 0.0)

    def literals(self, roles: int) -> Iterator[Literal]:
        """Yield all conditions that a rule with ``roles`` roles may have, except those with a number or a class."""
        slots = (ANY, *([HAND] if self.hand else []), *range(1, roles + 1))
        for predicate in self.predicates.values():
            if predicate.value or predicate.classes or predicate.name == self.hand:
                continue
            for arguments in product(slots, repeat=predicate.arity):
                if _sensible(predicate, arguments):
                    yield from _asked(predicate, arguments)


def _sensible(predicate: Predicate, slots: tuple[int, ...]) -> bool:
    """Check whether the learner should consider a condition: it names the agent or a role, and none of them twice.

    The contents of a vessel must not be named, and the arguments of a symmetric predicate have one order.
    """
    named = [s for s in slots if s != ANY]
    if len(set(named)) < len(named) or (slots and not named) or (predicate.fluent.of_contents and slots[-1] != ANY):
        return False
    return not (predicate.fluent.symmetric and slots != tuple(sorted(slots)))


def _asked(predicate: Predicate, slots: tuple[int, ...]) -> Iterator[Literal]:
    if predicate.timeless:
        phases: tuple[PhaseName, ...] = ("pre",)
    else:
        phases = tuple(p for p in PHASES if p in predicate.phases)
        if {"pre", "post"} <= set(phases):
            yield Literal(predicate.name, "begins", "", slots)
            yield Literal(predicate.name, "ends", "", slots)
    for phase in phases:
        yield Literal(predicate.name, "holds", phase, slots)
        yield Literal(predicate.name, "holds", phase, slots, denied=True)
