"""Wilson's score interval of a rate (Wilson, JASA 22, 1927), and Newcombe's interval of the difference of two rates."""

from __future__ import annotations

Z = 1.959964  # 95 % of a normal distribution


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
