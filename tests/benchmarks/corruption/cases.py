"""Cases of the corpus: each rule on each base that it takes, some times, with numbers drawn from one seed."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from random import Random

from cramlite.base.value import Value

from . import deletions, forces, further, harmless, meanings, order, sealed, strangers, typed
from .bases import BASES, Ready
from .rule import Rule

OPEN = (
    *strangers.RULES, *order.RULES, *deletions.RULES, *forces.RULES, *meanings.RULES, *further.RULES, *typed.RULES, *harmless.RULES,
)  # fmt: skip
"""Rules that may be looked at while judges are mended."""

RULES: Mapping[str, tuple[Rule, ...]] = {"open": OPEN, "sealed": sealed.RULES, "all": (*OPEN, *sealed.RULES)}
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


FIXED = {"bad": 30, "harmless": 10}
"""How many programs the test of every run has."""


def fixed(seed: int) -> tuple[Case, ...]:
    """Choose those: of each open rule the first program of one base, base after base in turn; quick ones, so nothing is poured.

    Further ones, until there are enough, are the same rules' programs of the next base.
    """
    return *_chosen([r for r in OPEN if r.group != "H"], FIXED["bad"], seed), *_chosen(harmless.RULES, FIXED["harmless"], seed)


def _chosen(rules: tuple[Rule, ...] | list[Rule], count: int, seed: int) -> list[Case]:
    found: list[Case] = []
    for turn in range(count):
        for k, rule in enumerate(rules):
            bases = [b.name for b in BASES if rule.takes(b) and b.name != "pour"]
            if turn < len(bases) and len(found) < count:
                found.append(Case(rule, bases[(k + turn) % len(bases)], 0, seed))
    return found


def rules_named(name: str) -> tuple[Rule, ...]:
    """Return a set of rules: "open", "sealed" or "all"."""
    return RULES[name]
