"""Cases of the corpus: each rule on each base program that it takes, some times, with numbers drawn from one seed."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from random import Random

from cramlite.base.value import Value

from . import (
    deletions,
    forces,
    further,
    handling,
    handling_harmless,
    harmless,
    latest,
    letting_go,
    meanings,
    order,
    protections,
    sealed,
    sealed_harmless,
    strangers,
    typed,
)  # fmt: skip
from .bases import BASES, Ready
from .rule import Rule

OPEN = (
    *strangers.RULES, *order.RULES, *letting_go.RULES, *deletions.RULES, *forces.RULES, *meanings.RULES, *further.RULES,
    *typed.RULES, *harmless.RULES,
)  # fmt: skip
"""Rules that may be looked at while validators are mended."""

SEALED = (*sealed.RULES, *sealed_harmless.RULES)
"""Rules that are judged once, at the end."""

FRESH = (*protections.RULES, *handling.RULES, *handling_harmless.RULES)
"""Rules that were written later, again without a look at the validators."""

LATEST = latest.RULES
"""Rules that were written last, by an auditor who had not read the validators."""

RULES: Mapping[str, tuple[Rule, ...]] = {
    "open": OPEN,
    "fresh": FRESH,
    "latest": LATEST,
    "sealed": SEALED,
    "all": (*OPEN, *FRESH, *LATEST, *SEALED),
}
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


FIXED = frozenset(
    [
        "stranger_carried/shelf/0",
        "stranger_carried/door/0",
        "stranger_dropped/stack/0",
        "stranger_and_back/basket/0",
        "stranger_onto_place/fragile/0",
        "support_moved/stack/0",
        "wrong_thing/basket/0",
        "late_open/shelf/0",
        "early_open/stack/0",
        "let_go_leaning/fragile/0",
        "set_down_on_way/stack/0",
        "dragged_along/shelf/0",
        "retaken_after_placing/fragile/0",
        "pulled_along_peg/hang/0",
        "lift_behind_transfer/stack/0",
        "last_step_deleted/drawer/0",
        "token_retreat/push/0",
        "typed_step_deleted/typed/0",
        "grip_too_strong/fragile/0",
        "press_after_release/shelf/0",
        "hard_put_down/fragile/0",
        "typed_payload/typed/0",
        "lid_beside/lid/0",
        "pushed_and_back/push/0",
        "stack_at_edge/stack/0",
        "hung_at_tip/hang/0",
        "dropped_from_high/basket/0",
        "drop_and_retake/shake/0",
        "turned_back/door/0",
        "half_open/fetch/0",
        "comment_moved/shelf/0",
        "comment_reworded/basket/0",
        "trailing_removed/knob/0",
        "slower/stack/0",
        "waits/push/0",
        "logged/door/0",
        "renamed/fetch/0",
        "placed_aside/fragile/0",
        "gripped_more/stack/0",
        "typed_one_line/typed/0",
    ]
)
"""Forty quick programs of open rules that the tests judge, 30 bad ones of all classes and 10 harmless ones, by what the rules mean."""


def fixed() -> tuple[Case, ...]:
    """Return the cases of the tests, with the numbers of seed 1."""
    return tuple(c for c in cases(OPEN, 1) if c.name in FIXED)


def rules_named(name: str) -> tuple[Rule, ...]:
    """Return a set of rules: "open", "sealed" or "all"."""
    return RULES[name]
