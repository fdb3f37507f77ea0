"""Visibility of a placement from a camera or a point: the share of the payload that occluders hide."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any

import numpy as np

from cramlite.model import Belief, Floats, Thing

from ...shapes import ray_casting as rays
from ...shapes.bounds import box_around
from .query import Placement, Query

SEEN = 0.5  # share of a thing that others may not hide


def visible(placement: Placement, query: Query) -> str:
    """Check that a placed payload is in a camera's field of view, and that other things hide at most half of
    it."""
    asked = query.where.visible_from
    if asked is None:
        return ""
    eye, axis, field = _eye(asked, query)
    if eye is None:
        return (
            "it cannot be said whether a camera sees it: none is fixed in the world; give 'visible_from' a "
            "point"
        )
    points = placement.thing.apply(_grid(query.thing))
    middle = points.mean(axis=0) - eye
    off = (
        math.acos(float(np.clip(middle @ axis / np.linalg.norm(middle), -1, 1))) if axis is not None else 0.0
    )
    if off > field:
        return (
            f"{math.degrees(off):.0f} deg off the camera's axis, it sees {math.degrees(field):.0f} deg to "
            "each side"
        )
    others = (t for t in query.belief.world.things if t.name != query.thing.name)
    hidden, by = hidden_by(points, eye, query.belief, others)
    share = 1.0 - float(hidden.mean())
    if share >= SEEN:
        return ""
    return f"{100 * share:.0f} % of it is seen, {100 * SEEN:.0f} % is needed; '{by}' hides most"


def _grid(thing: Thing) -> Floats:
    """Return a grid of 27 points in the box around a thing, at which its occlusion is sampled."""
    low, high = box_around(thing.geoms)
    shares = np.array([(x, y, z) for x in (0.1, 0.5, 0.9) for y in (0.1, 0.5, 0.9) for z in (0.1, 0.5, 0.9)])
    found: Floats = low + shares * (high - low)
    return found


def _eye(asked: Any, query: Query) -> tuple[Floats | None, Floats | None, float]:
    """Position and view direction of the camera or the stated point, None where unknown, and half the field
    of view [rad]."""
    base = query.belief.base().inverse()
    if asked != "camera":
        return base.apply(np.asarray(asked, dtype=float)), None, math.pi
    camera = query.context.camera
    if camera is None or camera.mount is not None:
        return None, None, 0.0
    pose = base * camera.pose
    return np.asarray(pose.position), pose.rotate((0.0, 0.0, 1.0)), camera.intrinsics.min_half_field_of_view


def hidden_by(points: Floats, eye: Floats, belief: Belief, others: Iterable[Thing]) -> tuple[Floats, str]:
    """Return the occlusion (n,) of points (n, 3) in the base frame from an eye (1 is hidden), and the main
    occluder."""
    hidden, counts = np.zeros(len(points)), dict[str, int]()
    for other in others:
        to = belief.pose(other.name).inverse()
        shape, start = rays.body(other.geoms), to.apply(eye)
        stopped = [rays.crossed(shape, start[None], to.apply(p)[None]) for p in points]
        counts[other.name] = sum(stopped)
        hidden = np.maximum(hidden, np.array(stopped, dtype=float))
    return hidden, max(counts, key=lambda n: counts[n], default="")
