"""Rates of counted successes with their 95 % intervals: Wilson's of a rate (JASA 22, 1927), Newcombe's of the difference of two."""

from __future__ import annotations

from typing import ClassVar

from .value import Value

Z = 1.959964  # 95 % of a normal distribution


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


def wilson_interval(hits: int, total: int) -> tuple[float, float]:
    """Compute the 95 % interval of a rate from numbers of successes and trials; (0, 1) where nothing was tried."""
    if not total:
        return (0.0, 1.0)
    rate = hits / total
    middle = rate + Z * Z / (2 * total)
    spread = Z * (rate * (1 - rate) / total + Z * Z / (4 * total**2)) ** 0.5
    scale = 1 + Z * Z / total
    return (max((middle - spread) / scale, 0.0), min((middle + spread) / scale, 1.0))


def newcombe_interval(hits: int, total: int, other_hits: int, other_total: int) -> tuple[float, float]:
    """Compute the 95 % interval of the difference of two independent rates, the first less the other; (-1, 1) where one was not tried.

    Source: Newcombe, Interval estimation for the difference between independent proportions, Statistics in Medicine 17, 1998, method 10.
    """
    if not (total and other_total):
        return (-1.0, 1.0)
    p, q = hits / total, other_hits / other_total
    (low, high), (other_low, other_high) = wilson_interval(hits, total), wilson_interval(other_hits, other_total)
    down, up = ((p - low) ** 2 + (other_high - q) ** 2) ** 0.5, ((high - p) ** 2 + (q - other_low) ** 2) ** 0.5
    return (p - q - down, p - q + up)
