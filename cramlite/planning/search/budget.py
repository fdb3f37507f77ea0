"""Budget of a search: counted work, so that a seed gives the same program on any machine; seconds if asked
for."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

from ...base.errors import UserError, nearest
from ...base.pulse import Stop
from ...base.value import Value

if TYPE_CHECKING:
    from ...scenario.scenario import Scenario
    from ..trace import Trace


RENAMED = {"asks": "expansions"}
"""Former names of budgets in files, with the present names."""


MOST = 1_000_000
"""Largest permitted value of a budget. On shipped scenarios an expansion took 8 to 35 ms of CPU and a proof 0.4 to 1.6 s (``Trace.seconds``
of four, seed 0, without twins), and a million seconds are 12 days. More is a slip, or means "for ever"."""
WHY_NOT_MORE = "a million expansions take hours, a million proofs or seconds days"


PROOF = 40
"""Work of a proof, in expansions: the ratio of their costs (``MOST``)."""
OPEN = ("seconds", "work")
"""Budgets that are unlimited where they are 0."""


class Budget(Value):
    """Limits on the work of a search, counted rather than timed: the same seed gives the same program on any machine.

    Args:
        expansions: nodes of the search that may be expanded (designators that plugins are asked about), over one task
            sequence.
        proofs: fully grounded candidates that may be executed, over one task sequence.
        samples: of a sampling planner, per query.
        sequences: candidate task sequences that are tried.
        seconds: of the whole search, which ends it wherever it then is; 0 for no limit. A slower machine may find less.
        work: of the whole search, over all task sequences: expansions, a proof counted as ``PROOF`` of them; 0 for no limit.

    Raises:
        UserError: one is no whole number from 1 to ``MOST``.
    """

    expansions: int = 3000
    proofs: int = 8
    samples: int = 4000
    sequences: int = 12
    seconds: int = 0
    work: int = 0

    def __post_init__(self) -> None:
        for name in self.__struct_fields__:
            value = getattr(self, name)
            if name in OPEN and value == 0 and not isinstance(value, bool):
                continue
            if not isinstance(value, int) or isinstance(value, bool) or not 1 <= value <= MOST:
                raise UserError(
                    f"Budget({name}={value!r:.40}): a budget is a whole number of at least 1 and at most {MOST}: {WHY_NOT_MORE}."
                )


def budget_of(scenario: Scenario) -> Budget:
    """Return the budget that a scenario asks for.

    Raises:
        UserError: there is no such budget, or it is not from 1 to ``MOST``; with file and line.
    """
    return budget_from(scenario.spec.budget, lambda key: scenario.where("budget", key))


def budget_from(asked: Mapping[str, int], where: Callable[[str], str]) -> Budget:
    """Return the budget that a file asks for.

    Args:
        where: "file:line" of a key.

    Raises:
        UserError: there is no such budget, or it is not from 1 to ``MOST``; with file and line.
    """
    valid = Budget.__struct_fields__
    for key, value in asked.items():
        if key not in valid:
            right = f"it is called '{RENAMED[key]}' now" if key in RENAMED else nearest(key, valid)
            raise UserError(f"{where(key)}: no budget '{key}'; {right}.")
        if value < 1 and not (key in OPEN and value == 0):  # no limit, as in Python
            raise UserError(f"{where(key)}: a budget is at least 1, not {value}.")
        if value > MOST:
            raise UserError(f"{where(key)}: a budget is at most {MOST}, not {value!s:.40}: {WHY_NOT_MORE}.")
    return Budget(**asked)


def until_late(budget: Budget, trace: Trace, stop: Stop) -> Stop:
    """Return the function ``stop``, extended to stop once the budget of seconds is spent, if there is one.

    That is recorded in the trace.
    """
    if not budget.seconds:
        return stop
    end, told = time.monotonic() + budget.seconds, list[bool]()

    def late() -> bool:
        over = time.monotonic() > end
        if over and not told:
            told.append(True)
            trace.spent("seconds", budget.seconds, f"{budget.seconds} s have passed, the budget of the search")
        return over or stop()

    return late


def is_late(trace: Trace) -> bool:
    """Check whether a search ended because its seconds were spent."""
    return any(e.kind == "budget" and "seconds" in e.numbers for e in trace.entries)


class BudgetSpent(Exception):
    """Signal that a search ends because a counted budget is used up.

    Args:
        budget: its name in ``Budget``.
        reason: what was counted, for people.
    """

    def __init__(self, budget: str, reason: str) -> None:
        super().__init__(reason)
        self.budget = budget
