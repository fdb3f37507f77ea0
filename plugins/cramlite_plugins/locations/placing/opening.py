"""Turn about the vertical at which a payload fits best into an opening, and advice where it fits at none."""

from __future__ import annotations

from typing import Any

import numpy as np
import shapely

from cramlite.model import Floats, Remedy

from .query import Query

TURNS = np.arange(0.0, 180.0)
"""Turns about the vertical in which a payload may go into an opening [deg]."""
PLAY = 0.002
"""Extra width that an opening needs beyond the payload's width [m], since positions are tried in steps."""


def lacking(outline: Any, query: Query) -> tuple[Floats, Floats]:
    """Return the sides that an opening needs for a payload's outline at each of ``TURNS`` (n, 2) [m], and by
    how much it is too small (n,) [m]."""
    ends, hull = np.reshape(query.target.area.bounds, (2, 2)), shapely.get_coordinates(outline.convex_hull)
    cos, sin = np.cos(np.radians(TURNS)), np.sin(np.radians(TURNS))
    need: Floats = np.ptp(hull @ np.array([[cos, sin], [-sin, cos]]).transpose(2, 0, 1), axis=1) + PLAY
    return need, (need - (ends[1] - ends[0])).max(axis=1)


def wider(outline: Any, query: Query) -> Remedy | None:
    """Return the advice for an opening that is too small for a payload, however this is turned about the
    vertical; None if a turn fits."""
    (need, lacks), ends = lacking(outline, query), np.reshape(query.target.area.bounds, (2, 2))
    best = int(lacks.argmin())
    if lacks[best] < 1e-6:
        return None
    needed, there = (
        " x ".join(f"{1000 * float(side):.0f}" for side in sides) for sides in (need[best], ends[1] - ends[0])
    )
    thing, entity = query.thing.name, query.entity
    said = f"'{thing}' needs {needed} mm at its best turn, the opening of '{entity}' is {there} mm"
    cure = "take a smaller thing, have it put down otherwise, or name another container"
    return Remedy(f"opening {query.entity}", f"{said}: {cure}", float(lacks[best]))
