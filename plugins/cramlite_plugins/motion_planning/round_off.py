"""Blend radii of a joint path: at each corner the largest with which the rounded path keeps its clearance."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from cramlite.model import Floats

from ..kinematics.blends import LARGEST, rounded, zone

if TYPE_CHECKING:
    from .space import FreeBlends

Joints = tuple[float, ...]
SHARES = (LARGEST, 0.25, 0.12, 0.05)  # of the lines at a corner, what its blend may take; tried in this order
DIGIT = 1e-4  # blend radii are whole multiples of this [m], as they are written
SMALL = 0.002  # below this radius a corner is a stop [m]
# How far from where a path begins the tcp may really be [m]: motions by touch before it end where they find
# something, an unknown error of 5 mm and a search of 8 mm away; with a radius that takes half of the planned
# line, a blend would then take more than half of the real one, which the controller refuses.
ELSEWHERE = 0.015


def blend_radii(
    scene: FreeBlends, points: Sequence[Joints], speed: float, acceleration: float
) -> tuple[tuple[float, ...], float]:
    """Return the blend radius at each inner point, 0 for a stop [m], and the duration of the path [s].

    Args:
        scene: in which the lines between the points are free.
        speed, acceleration: of the leading axis [rad/s, rad/s2].
    """
    q = [np.asarray(p, dtype=float) for p in points]
    lines = zip(q, q[1:], q[2:], strict=False)
    found = [_largest(scene, a, b, c, 0.0 if k else ELSEWHERE) for k, (a, b, c) in enumerate(lines)]
    sections = rounded(q, [zones for _, zones in found], [(speed, acceleration)] * (len(q) - 1))
    return tuple(radius for radius, _ in found), sum(s.length for s in sections)


def _largest(
    scene: FreeBlends, before: Floats, corner: Floats, after: Floats, slack: float
) -> tuple[float, tuple[float, float]]:
    """Largest free blend radius at a corner of a joint path [m], and the fractions of both lines that the
    curve replaces.

    Args:
        slack: by how much less than half of the line before it must do [m].
    """
    centre = scene.tip(corner)
    for share in SHARES:
        ends = [scene.tip(corner + share * (other - corner)) for other in (before, after)]
        room = min(math.dist(centre, ends[0]) - slack, math.dist(centre, ends[1]))
        radius = math.floor(room / DIGIT - 1e-6) * DIGIT
        zones = (
            [zone(scene.tip, corner, other, radius) for other in (before, after)]
            if radius >= SMALL
            else [None]
        )
        if None in zones:
            continue
        into, out = float(zones[0] or 0.0), float(zones[1] or 0.0)
        if scene.blend_free(corner + into * (before - corner), corner, corner + out * (after - corner)):
            return round(radius, 4), (into, out)
    return 0.0, (0.0, 0.0)
