"""Fit of a hole on a peg: round ones by their radius, square ones by their width.

The size of a ``vrps:Peg`` is its ``radius`` and ``length``, that of a ``vrps:Hole`` its ``diameter`` (the
widest round rod that goes through) and ``depth``. Either is square if it has a ``width``, too; then the x and
y axes of its pose are along its sides.
"""

from __future__ import annotations

import math

from cramlite.model import Feature, Floats

PLAY = 0.0003  # least radial play of a hole on a peg that moves [m]: MuJoCo's resting contact depth
# Lean below which a peg stands: a threaded thing sinks to its root by itself
STANDING = math.cos(math.radians(20.0))


def play(hole: Feature, peg: Feature) -> float:
    """Return the radial play of a hole on a peg [m], side along side if both are square; negative if the
    hole does not go over the peg."""
    if aligned(hole, peg):
        return (hole.size["width"] - peg.size["width"]) / 2
    round_it = peg.size["width"] / math.sqrt(2) if "width" in peg.size else peg.size["radius"]
    return hole.size["diameter"] / 2 - round_it


def aligned(hole: Feature, peg: Feature) -> bool:
    """Return whether hole and peg are both square, so that their sides have to be parallel."""
    return "width" in hole.size and "width" in peg.size


def stands(axis: Floats) -> bool:
    """Return whether a peg is upright, its unit axis (3,) pointing to its tip: a thing threaded onto it is
    carried by what the peg stands on."""
    return float(axis[2]) > STANDING
