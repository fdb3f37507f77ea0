"""Expert for spatial relations: hanging from a peg, on a surface, in a container, beside each other."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from cramlite.model import Floats, Thing
from cramlite.plugin import RELATIONS, Expert, Inputs, Judged, Parameter, hookimpl

Fact = tuple[str, str, str]


def relations(inputs: Inputs) -> Mapping[str, Any]:
    """Return the relations of each object to fixtures with known poses and to other objects, as facts
    (predicate, name, class).

    Left and right are the camera's; names of other objects are their numbers, "#2".
    """
    objects: Sequence[Mapping[str, Judged]] = inputs["objects"]
    found: list[Judged | None] = []
    fixtures: Sequence[Thing] = inputs.get("fixtures", ())
    for number, values in enumerate(objects, 1):
        if "points" not in values:
            found.append(None)
            continue
        points = values["points"].value
        own = values["fixture"].value if "fixture" in values else None
        around = [t for t in fixtures if own is None or t.name != own.name]
        facts = [f for t in around for f in _to_fixture(points, t, inputs.parameters)]
        facts += _to_others(number, objects, inputs["view"].camera)
        names = ", ".join(f"{p} {n}" for p, n, _ in facts) or "nothing near it is known"
        found.append(Judged(tuple(facts), 0.9, names))
    return {"relations": tuple(found)}


def _to_fixture(points: Any, thing: Thing, parameters: Mapping[str, float]) -> Iterator[Fact]:
    p = np.asarray(points[:: max(1, len(points) // 400)], dtype=float)
    for feature in thing.features:
        local = (thing.pose * feature.pose).inverse().apply(p)
        if feature.type == "vrps:Peg" and _hangs(local, p, thing, feature, parameters):
            yield ("hangs_on", thing.name, thing.type)
            yield ("on", thing.name, thing.type)
        if feature.type == "vrps:SurfaceFeature" and _stands(local, feature.size, parameters["gap_m"]):
            yield ("on", thing.name, thing.type)
        if feature.type == "cram:Cavity" and _inside(local, feature.size):
            yield ("in", thing.name, thing.type)


def _hangs(local: Floats, points: Floats, thing: Thing, peg: Any, parameters: Mapping[str, float]) -> bool:
    """Whether an object hangs on a peg: it has points near the peg's axis, and most of its points are
    below that."""
    tip = thing.feature("vrps:Tip")
    end = peg.size["length"] + (tip.size["length"] if tip else 0.0)
    beside = np.hypot(local[:, 0], local[:, 1])
    near = (beside < parameters["peg_m"]) & (local[:, 2] > -0.005) & (local[:, 2] < end + 0.01)
    height = float((thing.pose * peg.pose).apply((0.0, 0.0, float(np.median(local[:, 2]))))[2])
    return bool(near.sum() >= 3 and np.mean(points[:, 2] < height) > 0.6)


def _stands(local: Floats, size: Mapping[str, float], gap: float) -> bool:
    """Whether an object's lowest points are at a surface, within its edges."""
    low = float(np.percentile(local[:, 2], 2))
    middle = np.median(local[:, :2], axis=0)
    half = np.array([size.get("width", 0.0), size.get("depth", 0.0)]) / 2
    return bool(-gap < low < gap and (np.abs(middle) < half).all())


def _inside(local: Floats, size: Mapping[str, float]) -> bool:
    x, y, z = np.median(local, axis=0)
    return bool(abs(x) < size["width"] / 2 and abs(y) < size["depth"] / 2 and -size["height"] < z < 0.05)


def _to_others(number: int, objects: Sequence[Mapping[str, Judged]], camera: Any) -> Iterator[Fact]:
    """Directions from an object to others within 0.4 m in the image plane, each along the axis on which
    the two are further apart."""
    own = _centre(objects[number - 1], camera)
    for other, values in enumerate(objects, 1):
        if other == number or "points" not in values:
            continue
        x, y, _ = _centre(values, camera) - own
        if float(np.hypot(x, y)) > 0.4:
            continue
        predicate = ("left_of" if x > 0 else "right_of") if abs(x) > abs(y) else ("above" if y > 0 else "below")
        kind = values["type"].value if "type" in values else "unknown"
        yield (predicate, f"#{other}", str(kind))


def _centre(values: Mapping[str, Judged], camera: Any) -> Floats:
    """The middle of an object in the optical frame: x right, y down."""
    return np.asarray(camera.inverse().apply(np.median(values["points"].value, axis=0)))


@hookimpl
def experts() -> Iterable[Expert]:
    parameters = (
        Parameter("peg_m", 0.022, "a tab's hole and rim reach 13 mm from the peg; 5 mm of error of the peg's pose"),
        Parameter("gap_m", 0.025, "of the lowest visible point from a surface: depth noise, and an edge of 10 mm"),
    )
    return [
        Expert("relations", "on, in, hanging from, beside", ("view", "objects", "points"), ("relations",), relations,
               "scene", uses=("fixtures", "fixture", "type"), domains={"relations": RELATIONS}, cost_ms=8.0, parameters=parameters),
    ]  # fmt: skip
