"""Experts that find the region of interest of a query, and the point cloud in it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from cramlite.model import Thing
from cramlite.plugin import Expert, Inputs, Parameter, Unresolvable, hookimpl

from ..own_surface import widened


def region(inputs: Inputs) -> Mapping[str, Any]:
    """Return an axis-aligned box around the fixtures that the query names as a place, with room for their
    content."""
    from cramlite.plugin import RELATIONS

    from ...shapes.bounds import corners
    from ..values import Box

    places = [str(c.value) for c in inputs["query"].conditions if c.key in RELATIONS]
    taxonomy = inputs["taxonomy"]
    named = [t for t in inputs["fixtures"] if any(_is(t, p, taxonomy) for p in places)]
    if not named:
        raise Unresolvable("the query names no place whose pose is known")
    points = np.concatenate([corners(t, t.pose) for t in named])
    beside, over = inputs.parameters["beside_m"], inputs.parameters["over_m"]
    margin = np.array([beside, beside, over])
    low, high = points.min(axis=0) - margin, points.max(axis=0) + margin
    return {"region": Box(tuple(low.tolist()), tuple(high.tolist()))}


def _is(thing: Thing, place: str, taxonomy: Any) -> bool:
    known = taxonomy.resolve(place)
    return thing.name == place or (known is not None and taxonomy.is_a(thing.type, known))


def cloud(inputs: Inputs) -> Mapping[str, Any]:
    """Return the measured points in the region, in the camera's depth range, without those of the robot itself."""
    from ..values import Cloud

    view = inputs["view"]
    points = view.world_cloud.astype(np.float32)
    mask = view.valid & (view.depth < inputs.parameters["range_m"])
    own = inputs.get("robot")
    if own is not None:
        mask &= ~_near(widened(own, view.intrinsics), view.depth, inputs.parameters["robot_m"], inputs.parameters["behind_m"])
    box = inputs.get("region")
    if box is not None:
        mask &= box.contains(points)
    if not mask.any():
        where = "in the region of the query" if box is not None and view.valid.any() else "at all"
        raise Unresolvable(f"there is no depth {where}: {int(view.valid.sum())} of {view.depth.size} pixels measured")
    return {"cloud": Cloud(points, mask)}


def _near(own: Any, depth: Any, least: float, behind: float) -> Any:
    """Return a mask of the pixels whose depth is near the robot's expected depths: between the smallest and the largest one within two
    pixels, at most ``least`` [m] before these or ``behind`` [m] behind them.

    ``own`` is NaN where the robot is not expected. Where one link hides a part of another, both are within two pixels of the edge.
    """
    from scipy import ndimage

    nearest = ndimage.minimum_filter(np.where(np.isfinite(own), own, np.inf), 5)
    farthest = ndimage.maximum_filter(np.where(np.isfinite(own), own, -np.inf), 5)
    return (depth > nearest - least) & (depth < farthest + behind)


@hookimpl
def experts() -> Iterable[Expert]:
    margins = (
        Parameter("over_m", 0.30, "above and below: the tallest known product hangs 0.2 m below its peg"),
        Parameter("beside_m", 0.06, "half the width of the widest known product, and a turn of 20 degrees"),
    )
    reach = Parameter("range_m", 1.6, "a D435's depth error grows with the square: 8 mm at 1.6 m")
    robot = Parameter("robot_m", 0.05, "depth noise at a metre, links drawn simpler than they are, and their edges")
    behind = Parameter("behind_m", 0.12, "a link's thickness: what is seen behind its expected surface is still the robot")
    return [
        Expert("region_of_place", "a box around the place that the query names", ("query", "fixtures", "taxonomy"),
               ("region",), region, cost_ms=0.3, parameters=margins),
        Expert("cut_out", "measured points, cut out of the region", ("view",), ("cloud",), cloud,
               uses=("region", "robot"), cost_ms=12.0, parameters=(reach, robot, behind)),
    ]  # fmt: skip
