"""Friction of a pair of surfaces, from a coefficient of each."""

from __future__ import annotations


def pair_friction(a: float, b: float) -> float:
    """Return the sliding friction coefficient of two surfaces in contact: 2ab/(a + b).

    Friction belongs to a pair. A surface's own coefficient is that of a pair of two such surfaces; for two different ones the
    smaller counts most, and one without friction makes the pair slide. The law is Drake's
    (``CalcContactFrictionFromSurfaceProperties``); it is ad hoc, as they say there: it stands in for a measurement.

    Args:
        a, b: coefficients of the two surfaces, not negative.
    """
    return 2.0 * a * b / (a + b) if a + b > 0.0 else 0.0
