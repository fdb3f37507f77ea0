"""Expert: which objects are fixtures that the map knows, such as a peg or a basket."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

from cramlite import Expert, Geom, Inputs, Judged, Parameter, Thing, hookimpl

if TYPE_CHECKING:
    import numpy as np

    Floats = np.ndarray[Any, np.dtype[np.float64]]


def fixture(inputs: Inputs) -> Mapping[str, Any]:
    """The fixture that most of the points lie on; None for an object of its own."""
    import numpy as np

    points = np.asarray(inputs["points"], dtype=float)
    points = points[:: max(1, len(points) // 150)]
    best: tuple[float, Thing | None] = (0.0, None)
    for thing in inputs["fixtures"]:
        share = float((_distance(points, thing) < inputs.parameters["tolerance_m"]).mean())
        best = max(best, (share, thing), key=lambda b: b[0])
    share, found = best
    if found is None or share < inputs.parameters["share"]:
        return {"fixture": Judged(None, min(1.0, 1 - share / 2), f"{100 * share:.0f} % of its points are on a fixture")}
    return {"fixture": Judged(found, share, f"{100 * share:.0f} % of its points are on '{found.name}'")}


def _distance(points: Floats, thing: Thing) -> Floats:
    """From points of the world frame to the surface of a thing's geoms, outside them [m]."""
    import numpy as np

    away = np.full(len(points), np.inf)
    local = thing.pose.inverse().apply(points)
    for geom in thing.geoms:
        away = np.minimum(away, _to_geom(geom.pose.inverse().apply(local), geom))
    return away


def _to_geom(p: Floats, geom: Geom) -> Floats:
    """Distances to a primitive in its own frame, 0 inside."""
    import numpy as np

    if geom.shape in ("box", "convex"):
        return np.asarray(np.linalg.norm(np.maximum(np.abs(p) - np.array(geom.size), 0.0), axis=1))
    if geom.shape == "sphere":
        return np.asarray(np.maximum(np.linalg.norm(p, axis=1) - geom.size[0], 0.0))
    if geom.shape == "cylinder":
        across = np.maximum(np.hypot(p[:, 0], p[:, 1]) - geom.size[0], 0.0)
        return np.asarray(np.hypot(across, np.maximum(np.abs(p[:, 2]) - geom.size[1], 0.0)))
    along = np.clip(p[:, 2], -geom.size[1], geom.size[1])
    return np.asarray(np.maximum(np.linalg.norm(p - np.outer(along, (0, 0, 1)), axis=1) - geom.size[0], 0.0))


@hookimpl
def experts() -> Iterable[Expert]:
    parameters = (
        Parameter("tolerance_m", 0.010, "5 mm of error of the fixture's pose, and the noise of a D435 at 0.8 m"),
        Parameter("share", 0.7, "flying pixels are no more than 15 % of an edge; a tab touches a peg with less"),
    )
    return [
        Expert("known_fixture", "whether it is a part of the known surroundings", ("points", "fixtures"), ("fixture",),
               fixture, "object", cost_ms=2.0, parameters=parameters),
    ]  # fmt: skip
