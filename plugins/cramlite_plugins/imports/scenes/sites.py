"""Sites of a scene file that say where things go: boxes inside of a thing are its cavities, boxes upon it areas of its surface."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from typing import Any

import numpy as np

from cramlite.model import Feature, Floats, Pose, Thing

from ...shapes import ray_casting as rays
from ...shapes.bounds import box_around
from ...shapes.cavities import DEEP
from ...shapes.surfaces import surfaces
from .geoms import pose_of

PLACES = re.compile(r"contain|inside|cavity|interior|_in$|region|side$|area|zone|compartment|slot|shelf|level", re.IGNORECASE)
"""Words in the names of sites that things are put into or onto."""
BOX_SITE = 6
UPRIGHT = math.cos(math.radians(5.0))
"""Least cosine of the lean of a site that counts as level."""
STEEP = math.cos(math.radians(75.0))
"""Least cosine of the lean of a site on which things can be placed; a site that leans more is ignored."""
THIN = 0.5
"""Largest ratio to the next longer side of a box that counts as flat, and shows the way it faces."""
OVER = 0.01
"""Largest height of a cavity above its walls [m]."""
UPON = 0.05
"""Largest distance between a site and a face that it marks [m]."""
LARGE, NARROW = 0.0025, 0.015
"""Least area [m2] and least width [m] of a marked area that becomes a feature."""


def places(model: Any, data: Any, bodies: Iterable[int], thing: Thing) -> tuple[Feature, ...]:
    """Return the cavities and the areas of surfaces that the sites of some bodies mark, in the frame of their thing.

    A site is what its box shows, whatever it is called: a table's "region" holds nothing, and is upon it.
    """
    inside = set(bodies)
    sites = [s for s in range(model.nsite) if int(model.site_bodyid[s]) in inside and int(model.site_type[s]) == BOX_SITE]
    named = [s for s in sites if PLACES.search(model.site(s).name)]
    found = (
        _place(thing, _upright(thing, model, data, s), _own_name(model, s)) or _leaning(thing, model, data, s) for s in named
    )
    return tuple(f for f in found if f is not None)


def _upright(thing: Thing, model: Any, data: Any, site: int) -> tuple[Pose, Floats] | None:
    """Box of a site in its thing's frame, z upright, with its half lengths; None if it leans."""
    turned = pose_of(data.site_xpos[site], data.site_xmat[site])
    half, heights = np.asarray(model.site_size[site], dtype=float), turned.rotation[2]
    up = int(np.argmax(np.abs(heights)))
    if abs(heights[up]) < UPRIGHT:
        return None
    across = (up + 1) % 3
    z, x = math.copysign(1.0, heights[up]) * turned.rotation[:, up], turned.rotation[:, across]
    pose = thing.pose.inverse() * Pose.from_axes(turned.position, z, x)
    return pose, half[[across, 3 - up - across, up]]


def _leaning(thing: Thing, model: Any, data: Any, site: int) -> Feature | None:
    """Area that a flat site marks on a leaning support, such as a rack, z pointing away from the support;
    None if it is level or on nothing."""
    turned = pose_of(data.site_xpos[site], data.site_xmat[site])
    half = np.asarray(model.site_size[site], dtype=float)
    thin, second, long = np.argsort(half, kind="stable").tolist()
    up = float(turned.rotation[2, thin])
    if half[thin] > THIN * half[second] or not STEEP <= abs(up) < UPRIGHT:
        return None
    pose = thing.pose.inverse() * Pose.from_axes(
        turned.position, math.copysign(1.0, up) * turned.rotation[:, thin], turned.rotation[:, long]
    )
    size = {"width": round(2 * float(half[long]), 5), "depth": round(2 * float(half[second]), 5)}
    enough = size["width"] * size["depth"] >= LARGE and size["depth"] >= NARROW
    on_it = enough and _upon(thing, pose, float(half[thin]), "", size) is not None and not _over_level(thing, pose)
    return Feature(_own_name(model, site), "vrps:SurfaceFeature", pose, size) if on_it else None


def _over_level(thing: Thing, pose: Pose) -> bool:
    """Whether a thing has a level surface close to a pose in the thing's frame, so that nothing would rest there
    leaning."""
    import shapely

    middle = thing.pose.apply(pose.position)
    there = ((s, s.pose.inverse().apply(middle)) for s in surfaces(thing, thing.pose))
    return any(abs(p[2]) < UPON and s.area.covers(shapely.Point(p[:2])) for s, p in there)


def _place(thing: Thing, site: tuple[Pose, Floats] | None, name: str) -> Feature | None:
    if site is None:
        return None
    pose, (x, y, z) = site
    low, high = box_around(thing.geoms)
    top, middle = np.asarray(pose.apply((0.0, 0.0, z - OVER))), np.asarray(pose.position)
    size = {"width": round(2 * float(x), 5), "depth": round(2 * float(y), 5)}
    if 2 * z >= DEEP and ((low < middle) & (middle < high) & (low < top + OVER) & (top - OVER < high)).all() and _hollow(thing, middle):
        roof, floor = _next(thing, pose)
        if roof is None or floor is not None or roof >= z:
            return _cavity_of_site(pose, float(z), name, size, roof, floor)
    return _upon(thing, pose, float(z), name, size)


def _next(thing: Thing, pose: Pose) -> tuple[float | None, float | None]:
    """Distances to the next shapes above and below a pose in its thing's frame [m], each None without one.

    A site that a board passes through, with nothing below, is the underside of a table's top.
    """
    middle, up = np.asarray(pose.position), np.asarray(pose.rotate((0.0, 0.0, 1.0)))
    met = ([low for low, _, _ in rays.spans(rays.body(thing.geoms), middle, way) if low >= 0] for way in (up, -up))
    roof, floor = (min(m, default=None) for m in met)
    return roof, floor


def _cavity_of_site(pose: Pose, half: float, name: str, size: dict[str, float], roof: float | None, floor: float | None) -> Feature:
    """Feature for a site of a scene file: a cavity down to the floor below it or, under a roof, an area on
    that floor with a height."""
    if roof is None or floor is None:
        deep = max(floor or 0.0, half)
        return Feature(name, "cram:Cavity", pose * Pose((0.0, 0.0, half)), {**size, "height": round(half + deep, 5)})
    return Feature(name, "vrps:SurfaceFeature", pose * Pose((0.0, 0.0, -floor)), {**size, "height": round(floor + half, 5)})


def _hollow(thing: Thing, point: Floats) -> bool:
    """Whether a point is in none of a thing's shapes."""
    up = np.array([0.0, 0.0, 1.0])
    return not any(low < 0.0 < high for low, high, _ in rays.spans(rays.body(thing.geoms), point, up))


def _upon(thing: Thing, pose: Pose, half: float, name: str, size: dict[str, float]) -> Feature | None:
    """Area on the surface just below a site, with the height of the site's lower end above the surface; None
    without one."""
    above = half + UPON
    down = -np.asarray(pose.rotate((0.0, 0.0, 1.0)))
    met = [low for low, _, _ in rays.spans(rays.body(thing.geoms), np.asarray(pose.apply((0, 0, above))), down) if low >= 0]
    if not met or min(met) > 2 * above:
        return None
    over = min(met) - above
    size = size | ({"lowest": round(over - half, 5)} if over > half else {})
    return Feature(name, "vrps:SurfaceFeature", pose * Pose((0.0, 0.0, -over)), size)


def _own_name(model: Any, site: int) -> str:
    """Name of a site without the leading words that it shares with the name of its body."""
    words, body = model.site(site).name.split("_"), model.body(int(model.site_bodyid[site])).name.split("_")
    shared = next((k for k, (a, b) in enumerate(zip(words, body, strict=False)) if a != b), min(len(words), len(body)))
    own = re.sub(r"\W", "_", "_".join(words[shared:]) or model.site(site).name, flags=re.ASCII)
    return own if own[:1].isalpha() else f"place_{own}"
