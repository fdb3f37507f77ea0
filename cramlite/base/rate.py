"""Rates of counted successes with their 95 % intervals."""

from __future__ import annotations

from typing import ClassVar

from .value import Value
from .wilson import wilson_interval


class Rate(Value):
    """Rate: a number of successes in a number of trials, with the 95 % Wilson score interval (Wilson, JASA 22, 1927)."""

    TOLD: ClassVar[tuple[str, ...]] = ("rate", "interval")
    """Names of the properties that the JSON text of a rate contains besides its fields (``json_text``)."""

    hits: int
    total: int

    @property
    def rate(self) -> float:
        """Observed rate, 0 to 1; 0 where nothing was tried."""
        return self.hits / self.total if self.total else 0.0

    @property
    def interval(self) -> tuple[float, float]:
        """Bounds of the rate's 95 % interval; (0, 1) where nothing was tried."""
        return wilson_interval(self.hits, self.total)

    @property
    def text(self) -> str:
        """Rate as text for people: "27 of 29 (.93, .78 to .98)"."""
        if not self.total:
            return "none tried"
        low, high = self.interval
        return f"{self.hits} of {self.total} ({digits(self.rate)}, {digits(low)} to {digits(high)})"


def digits(rate: float) -> str:
    """Return a rate with two digits, ".93"; "1.00" if every trial succeeded."""
    return f"{rate:.2f}".removeprefix("0")
