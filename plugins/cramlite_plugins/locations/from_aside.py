"""Oblique ways of the hand, at 45 deg or steeper, to and from a place under an overhang, such as under the
handle of an open drawer, or in a drawer that is half shut."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from cramlite.model import Floats

ANGLES = (180.0, 90.0, -90.0, 0.0)
"""Sideways directions of oblique ways in the base frame, the one towards the robot first [deg]."""


def slants(rise: float, share: float = 1.0) -> Iterator[tuple[str, Floats]]:
    """Generate named displacements (3,) of the hand [m]: up by ``rise``, and by ``share`` times ``rise`` to
    one of several sides."""
    for angle in ANGLES:
        way: Floats = rise * np.array(
            [share * math.cos(math.radians(angle)), share * math.sin(math.radians(angle)), 1.0]
        )
        yield f"aside at {angle:.0f} deg", way
