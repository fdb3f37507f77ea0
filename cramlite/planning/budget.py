"""The budget of a search: counted work, never seconds, so that a seed gives the same program on any machine."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

from ..base.errors import UserError, nearest
from ..base.value import Value

if TYPE_CHECKING:
    from ..scenario.scenario import Scenario


RENAMED = {"asks": "expansions"}
"""Budgets that older files have, and what they are called now."""


class Budget(Value):
    """Limits on the work of a search, counted rather than timed: the same seed gives the same program on any machine.

    Args:
        expansions: nodes of the search that may be expanded (designators that plugins are asked about), over one task
            sequence.
        proofs: fully grounded candidates that may be executed, over one task sequence.
        samples: of a sampling planner, per query.
        sequences: candidate task sequences that are tried.

    Raises:
        UserError: one is no whole number of at least 1.
    """

    expansions: int = 3000
    proofs: int = 8
    samples: int = 4000
    sequences: int = 12

    def __post_init__(self) -> None:
        for name in self.__struct_fields__:
            value = getattr(self, name)
            if not isinstance(value, int) or isinstance(value, bool) or value < 1:
                raise UserError(f"Budget({name}={value!r}): a budget is a whole number of at least 1.")


def budget_of(scenario: Scenario) -> Budget:
    """Return the budget that a scenario asks for.

    Raises:
        UserError: there is no such budget, or it is below 1; with file and line.
    """
    return budget_from(scenario.spec.budget, lambda key: scenario.where("budget", key))


def budget_from(asked: Mapping[str, int], where: Callable[[str], str]) -> Budget:
    """Return the budget that a file asks for.

    Args:
        where: "file:line" of a key.

    Raises:
        UserError: there is no such budget, or it is below 1; with file and line.
    """
    valid = Budget.__struct_fields__
    for key, value in asked.items():
        if key not in valid:
            right = f"it is called '{RENAMED[key]}' now" if key in RENAMED else nearest(key, valid)
            raise UserError(f"{where(key)}: no budget '{key}'; {right}.")
        if value < 1:
            raise UserError(f"{where(key)}: a budget is at least 1, not {value}.")
    return Budget(**asked)


class BudgetSpent(Exception):
    """End of a search because a counted budget is used up.

    Args:
        budget: its name in ``Budget``.
        reason: what was counted, for people.
    """

    def __init__(self, budget: str, reason: str) -> None:
        super().__init__(reason)
        self.budget = budget


class Stopped(Exception):
    """End of a search because the caller stopped it."""
