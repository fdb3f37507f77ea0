"""Expert for object classification: class and model by colour and size, against known models."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from cramlite.model import Floats, Value
from cramlite.plugin import UNKNOWN, Expert, Judged, Parameter, hookimpl

if TYPE_CHECKING:
    from cramlite.model import Thing
    from cramlite.plugin import Inputs


def types(priors: Mapping[str, Any]) -> tuple[str, ...]:
    """Return the classes of the known models and fixtures, and "unknown"."""
    known = (*priors.get("models", ()), *priors.get("fixtures", ()))
    return (*dict.fromkeys(m.type for m in known), UNKNOWN)


class Known(Value, eq=False):
    """Appearance of a known model: the colour of its largest geom, and its sizes.

    ``chroma`` are the colour's red and green shares, ``lengths`` the sorted extents of the bounding box [m].
    """

    model: Thing
    chroma: Floats
    lengths: list[float]


def printed(looks: Iterable[Known]) -> bool:
    """Check whether some known model has a printed texture."""
    from ..shapes.skins import skin_of

    return any(skin_of(k.model.mesh) is not None for k in looks)


def known_looks(inputs: Inputs) -> Mapping[str, Any]:
    """Return the appearance of each known model."""
    return {"looks": tuple(Known(m, _model_chroma(m), _lengths(m)) for m in inputs["models"])}


def category(inputs: Inputs) -> Mapping[str, Any]:
    """Classify an object by Bayes' rule over the known models and "unknown", with equal priors.

    An object that was associated with a fixture gets the fixture's class.

    p(model | chroma, extents) ~ N(chroma; model's) N(what is too large; 0) N(what is missing; 0): an extent that looks
    larger than the model speaks against it, a smaller one hardly: something may hide the rest.
    """
    if inputs.get("fixture"):
        judged = inputs.judged("fixture")
        return {"type": Judged(judged.value.type, judged.confidence, judged.reason), "candidates": ()}
    known: tuple[Known, ...] = inputs["looks"]
    own = _chroma_of(inputs["view"], inputs["segment"].mask)
    seen = inputs["extents"]
    lengths = sorted((seen.height, seen.width, seen.depth))
    weights = [_weight(m, own, lengths, inputs.parameters) for m in known]
    total = sum(weights) + inputs.parameters["unknown"]
    order = sorted(range(len(known)), key=lambda k: (-weights[k], known[k].model.name))
    ranked = [Judged(known[k].model.name, weights[k] / total, _why(known[k], own, lengths)) for k in order]
    by_type: dict[str, float] = {UNKNOWN: inputs.parameters["unknown"] / total}
    for k in order:
        by_type[known[k].model.type] = by_type.get(known[k].model.type, 0.0) + weights[k] / total
    reasons = {UNKNOWN: "no known model looks like it"}
    reasons |= {known[k].model.type: _why(known[k], own, lengths) for k in order[::-1]}
    said = [Judged(t, min(1.0, w), reasons[t]) for t, w in sorted(by_type.items(), key=lambda p: (-p[1], p[0]))]
    return {
        "type": Judged(said[0].value, said[0].confidence, said[0].reason, tuple(said[1:])),
        "candidates": tuple(ranked),
    }


def _chroma_of(view: Any, mask: Any) -> Floats:
    """Median red and green shares of a part of the image."""
    pixels = view.rgb[mask].astype(float)
    total = np.maximum(pixels.sum(axis=1), 1.0)
    return np.asarray(np.median(pixels[:, :2] / total[:, None], axis=0))


def _model_chroma(model: Thing) -> Floats:
    """Red and green shares (2,) of the colour of a model's largest geom."""
    largest = max(model.geoms, key=lambda g: math.prod(sorted(g.size)[-2:]))
    rgb = np.array(largest.rgba[:3])
    return rgb[:2] / max(float(rgb.sum()), 1e-6)


def _lengths(model: Thing) -> list[float]:
    """Sorted extents of the box around a model's geoms [m]."""
    from ..shapes.bounds import extents

    return sorted(extents(model.geoms))


def _weight(known: Known, chroma: Floats, lengths: list[float], parameters: Mapping[str, float]) -> float:
    off = float(np.abs(chroma - known.chroma).max()) / parameters["chroma"]
    excess = [max(0.0, a - b) / parameters["excess_m"] for a, b in zip(lengths, known.lengths, strict=True)]
    missing = [max(0.0, b - a) / parameters["missing_m"] for a, b in zip(lengths, known.lengths, strict=True)]
    return math.exp(-(off**2 + sum(e**2 for e in excess) + sum(m**2 for m in missing)) / 2)


def _why(known: Known, chroma: Floats, lengths: list[float]) -> str:
    off = float(np.abs(chroma - known.chroma).max())
    differ = max(abs(a - b) for a, b in zip(lengths, known.lengths, strict=True))
    return f"its colour differs by {off:.2f} and its extents by {1000 * differ:.0f} mm from those of '{known.model.name}'"


@hookimpl
def experts() -> Iterable[Expert]:
    parameters = (
        Parameter("chroma", 0.030, "share of red or green: noise, shading and the camera's gamma"),
        Parameter("excess_m", 0.012, "flying pixels at both ends"),
        Parameter("missing_m", 0.060, "half a product may be hidden"),
        Parameter("unknown", 0.02, "about the likelihood of what is three standard deviations off"),
    )
    return [
        Expert("known_looks", "colour and size of each known model", ("models",), ("looks",), known_looks, cost_ms=2.0),
        Expert("category", "the known model that it looks like", ("view", "segment", "extents", "looks"),
               ("type", "candidates"), category, "object", uses=("fixture",), domains={"type": types}, cost_ms=1.0,
               parameters=parameters),
    ]  # fmt: skip
