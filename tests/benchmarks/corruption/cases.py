"""Cases of the corpus: each rule on each base that it takes, some times, with numbers drawn from one seed."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from random import Random

from cramlite.base.value import Value

from . import deletions, forces, further, harmless, meanings, order, sealed, sealed_harmless, strangers, typed
from .bases import BASES, Ready
from .rule import Rule

OPEN = (
    *strangers.RULES, *order.RULES, *deletions.RULES, *forces.RULES, *meanings.RULES, *further.RULES, *typed.RULES, *harmless.RULES,
)  # fmt: skip
"""Rules that may be looked at while judges are mended."""

SEALED = (*sealed.RULES, *sealed_harmless.RULES)
"""Rules that are judged once, at the end."""

RULES: Mapping[str, tuple[Rule, ...]] = {"open": OPEN, "sealed": SEALED, "all": (*OPEN, *SEALED)}
"""Rules by the name of their set."""


class Case(Value):
    """Program to be edited.

    Args:
        rule: what is done to it.
        base: name of the base.
        number: which of the rule's programs of this base.
        seed: of all numbers.
    """

    rule: Rule
    base: str
    number: int
    seed: int

    @property
    def name(self) -> str:
        """Unique in the corpus."""
        return f"{self.rule.name}/{self.base}/{self.number}"

    def text(self, ready: Ready) -> str:
        """Write the edited program."""
        return self.rule.edit(ready, Random(f"{self.seed}/{self.name}"))


def cases(rules: tuple[Rule, ...], seed: int) -> Iterator[Case]:
    """List the cases of some rules, by base."""
    for base in BASES:
        for rule in rules:
            if rule.takes(base):
                yield from (Case(rule, base.name, k, seed) for k in range(rule.times))


FIXED = ()
"""Forty programs of open rules that the tests judge: of each kind one or none, and quick ones. They were chosen before any verdict."""


def fixed() -> tuple[Case, ...]:
    """Return the cases of the tests, with the numbers of seed 1."""
    return tuple(c for c in cases(OPEN, 1) if c.name in FIXED)


def rules_named(name: str) -> tuple[Rule, ...]:
    """Return a set of rules: "open", "sealed" or "all"."""
    return RULES[name]
