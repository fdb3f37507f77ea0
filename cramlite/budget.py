"""The budget of a search: counted work, never seconds, so that a seed gives the same program on any machine."""

from __future__ import annotations

from .value import Value


class Budget(Value):
    """Counted work: the same seed gives the same program on any machine.

    Args:
        asks: designators that plugins may be asked about, over one task sequence.
        proofs: fully grounded candidates that may be executed, over one task sequence.
        samples: of a sampling planner, per query.
        sequences: candidate task sequences that are tried.
    """

    asks: int = 3000
    proofs: int = 8
    samples: int = 4000
    sequences: int = 12


STOPPED = "stopped by the caller"


class BudgetSpent(Exception):
    """The counted budget of a search is used up."""
