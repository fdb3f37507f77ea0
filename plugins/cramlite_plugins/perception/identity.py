"""Expert for data association: objects keep their names over frames."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from cramlite.plugin import Expert, Inputs, Judged, Parameter, hookimpl

UNLIKELY = 1e6


def instances(inputs: Inputs) -> Mapping[str, Any]:
    """Match objects with those of an earlier frame; an unmatched one gets a new name: its class and a number, or its model
    and a number if several known models share its class.

    Solves the assignment problem of least total distance (Kuhn, 1955) among pairs of one class that are near enough.
    """
    from scipy.optimize import linear_sum_assignment

    objects: Sequence[Mapping[str, Judged]] = inputs["objects"]
    earlier: Mapping[str, tuple[str, Any]] = inputs.get("earlier", {})
    known = sorted(earlier)
    centres = [np.median(o["points"].value, axis=0) if "points" in o else None for o in objects]
    costs = np.full((len(objects), len(known)), UNLIKELY)
    for i, values in enumerate(objects):
        for j, name in enumerate(known):
            kind, place = earlier[name]
            if centres[i] is not None and kind == _type(values):
                costs[i, j] = float(np.linalg.norm(centres[i] - np.asarray(place)))
    limit = inputs.parameters["way_m"]
    kept = {int(i): known[j] for i, j in zip(*linear_sum_assignment(costs), strict=True) if costs[i, j] <= limit}
    count = Counter(m.type for m in inputs.get("models", ()))
    names = _named(objects, kept, set(known), {t for t, models in count.items() if models > 1})
    judged = tuple(
        None if c is None else Judged(n, _sure(i, n, kept, known, costs, limit), _why(i, n, kept, known, costs))
        for i, (n, c) in enumerate(zip(names, centres, strict=True))
    )
    return {"instance": judged}


def _type(values: Mapping[str, Judged]) -> str:
    return str(values["type"].value) if "type" in values else "unknown"


def _stem(values: Mapping[str, Judged], shared: Collection[str]) -> str:
    """Beginning of a new object's name, before its number."""
    candidates = values["candidates"].value if "candidates" in values else ()
    if candidates and _type(values) in shared:
        return str(candidates[0].value)
    return _type(values).split(":")[-1].lower()


def _named(
    objects: Sequence[Mapping[str, Judged]], kept: Mapping[int, str], used: set[str], shared: Collection[str]
) -> list[str]:
    names = []
    for i, values in enumerate(objects):
        if i in kept:
            names.append(kept[i])
            continue
        stem = _stem(values, shared)
        number = next(k for k in range(1, 1000) if f"{stem}_{k}" not in used)
        used.add(f"{stem}_{number}")
        names.append(f"{stem}_{number}")
    return names


def _sure(i: int, name: str, kept: Mapping[int, str], known: list[str], costs: Any, limit: float) -> float:
    """Confidence that an object is the one that it was matched with; 0.9 for a new object.

    It grows with the gap between the cost of this match and that of the next best one.
    """
    if i not in kept:
        return 0.9
    others = sorted(c for j, c in enumerate(costs[i]) if known[j] != name)
    gap = (others[0] if others else limit) - costs[i, known.index(name)]
    return float(min(0.99, max(0.5, 0.5 + gap / limit / 2)))


def _why(i: int, name: str, kept: Mapping[int, str], known: list[str], costs: Any) -> str:
    if i not in kept:
        return "not seen before"
    return f"{1000 * costs[i, known.index(name)]:.0f} mm from where '{name}' was"


@hookimpl
def experts() -> Iterable[Expert]:
    way = Parameter(
        "way_m", 0.06, "half the distance of neighbouring products on a hanger; things move less in a frame"
    )
    return [
        Expert("assignment", "names that stay over frames", ("objects", "points", "type"), ("instance",), instances,
               "scene", uses=("earlier", "models", "candidates"), cost_ms=2.0, parameters=(way,)),
    ]  # fmt: skip
