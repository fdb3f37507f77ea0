"""Wilson's score interval of a rate (Wilson, JASA 22, 1927)."""

from __future__ import annotations

Z = 1.959964  # 95 % of a normal distribution


def wilson_interval(hits: int, total: int) -> tuple[float, float]:
    """Compute the 95 % interval of a rate that was observed as so many of so many; (0, 1) where nothing was tried."""
    if not total:
        return (0.0, 1.0)
    rate = hits / total
    middle = rate + Z * Z / (2 * total)
    spread = Z * (rate * (1 - rate) / total + Z * Z / (4 * total**2)) ** 0.5
    scale = 1 + Z * Z / total
    return (max((middle - spread) / scale, 0.0), min((middle + spread) / scale, 1.0))
