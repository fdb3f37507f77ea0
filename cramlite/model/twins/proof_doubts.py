"""Requirements of a proof: in how many twins a program is tried, and what share of all runs must succeed."""

from __future__ import annotations

import math

from ...base.errors import UserError
from ...base.value import Value
from .error_model import ErrorModel

MOST_TWINS = 1000


class ProofDoubts(Value):
    """Number and errors of the twins in which a program runs beside its nominal run, and the share of all
    runs that must succeed.

    The runs are taken one after another and stop as soon as those that are left can no longer change the decision.

    Args:
        twins: how many worlds are drawn; 0 for the nominal run alone.
        at_least: share of all runs, the nominal one counted, that must succeed. 0.85 of 9 is 8 of 9.
        errors: from which twins are drawn.

    Raises:
        UserError: a number of twins that is not in 0 .. ``MOST_TWINS``, or a share that is not in 0 .. 1.
    """

    twins: int = 8
    at_least: float = 0.85
    errors: ErrorModel = ErrorModel()

    def __post_init__(self) -> None:
        if not isinstance(self.twins, int) or isinstance(self.twins, bool) or not 0 <= self.twins <= MOST_TWINS:
            raise UserError(f"The number of twins is {self.twins!r}; it is a whole number in 0 .. {MOST_TWINS}, 0 for none.")
        if not 0 <= self.at_least <= 1:
            raise UserError(f"at_least is {self.at_least!r}; it is the share of runs that must succeed, in 0 .. 1.")

    @property
    def runs(self) -> int:
        """Largest number of runs: the nominal one and one in each twin."""
        return 1 + self.twins

    @property
    def needed(self) -> int:
        """Number of a proof's runs that must succeed."""
        return math.ceil(self.at_least * self.runs - 1e-9)

    def decided(self, succeeded: int, ran: int) -> bool:
        """Check whether a program is certain to be accepted or refused, however its remaining runs in twins end."""
        return succeeded >= self.needed or succeeded + self.runs - ran < self.needed
