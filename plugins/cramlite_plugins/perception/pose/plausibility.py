"""Experts that select a pose hypothesis: by physical plausibility, or by the fit alone."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from msgspec.structs import replace

from cramlite.model import Thing
from cramlite.plugin import Expert, Inputs, Judged, Parameter, Unresolvable, hookimpl

from ..category import types
from .registration import Fit


def plausible(inputs: Inputs) -> Mapping[str, Any]:
    """Select the best-fitting hypothesis among those that are physically possible.

    What hangs has its hole around the peg and its axis along it; its front looks away from the panel, as whoever
    filled the hanger left it: depth alone cannot tell front from back. What stands has its bottom on the surface.
    """
    fits: Sequence[Fit] = inputs["hypotheses"]
    models = {m.name: m for m in inputs["models"]}
    weighed = []
    for fit in fits:
        factor, why = _possible(fit, models[fit.model], inputs)
        weighed.append(replace(fit, score=fit.score * factor, reason=f"{fit.reason}; {why}" if why else fit.reason))
    return _values_of_best(sorted(weighed, key=lambda f: -f.score), models)


def best_fit(inputs: Inputs) -> Mapping[str, Any]:
    """Select the best-fitting hypothesis on an object's model and pose, without a check of physical
    plausibility."""
    return _values_of_best(inputs["hypotheses"], {m.name: m for m in inputs["models"]})


def _values_of_best(fits: Sequence[Fit], models: Mapping[str, Thing]) -> Mapping[str, Any]:
    if not fits:
        raise Unresolvable("no known model looks like the object and fits its points")
    best = fits[0]
    sure = min(1.0, best.score)
    lost = list(fits[1:])
    classes = {models[f.model].type: f for f in reversed(fits)}
    own = models[best.model].type
    return {
        "pose": Judged(best.pose, sure, best.reason, tuple(Judged(f.pose, min(1.0, f.score), f.reason) for f in lost)),
        "model": Judged(best.model, sure, best.reason,
                        tuple(Judged(f.model, min(1.0, f.score), f.reason) for f in lost if f.model != best.model)),
        "type": Judged(own, sure, f"'{best.model}' fits best: {best.reason}",
                       tuple(Judged(t, min(1.0, f.score), f.reason) for t, f in classes.items() if t != own)),
        "joints": Judged(best.joints, sure, best.reason if best.joints else f"'{best.model}' has none"),
        "features": Judged(tuple(f.type for f in models[best.model].features), sure, f"of the model '{best.model}'"),
    }  # fmt: skip


def _possible(fit: Fit, model: Thing, inputs: Inputs) -> tuple[float, str]:
    """Factor by which physical plausibility lowers a fit's score, and the reason; 1 and "" where it does not."""
    fixtures = {t.name: t for t in inputs.get("fixtures", ())}
    limits = inputs.parameters
    facts = [f for f in inputs.get("relations", ()) if f[1] in fixtures]
    hung = next((fixtures[n] for p, n, _ in facts if p == "hangs_on"), None)
    if hung is not None:
        return _hanging(fit, model, hung, limits)
    stood = next((fixtures[n] for p, n, _ in facts if p == "on"), None)
    return _standing(fit, model, stood, limits) if stood is not None else (1.0, "")


def _hanging(fit: Fit, model: Thing, hanger: Thing, limits: Mapping[str, float]) -> tuple[float, str]:
    hole, peg = model.feature("vrps:Hole"), hanger.feature("vrps:Peg")
    if hole is None or peg is None:
        return limits["impossible"], f"'{model.name}' has no hole to hang by" if hole is None else ""
    ring, axis = fit.pose * hole.pose, hanger.pose * peg.pose
    x, y, _ = axis.inverse().apply(ring.position)
    along = float(ring.rotate((0, 0, 1)) @ axis.rotate((0, 0, 1)))
    off = math.hypot(x, y)
    if off > limits["hole_m"] or abs(along) < limits["axis"]:
        angle = math.degrees(float(np.arccos(min(1.0, abs(along)))))
        return limits["impossible"], f"its hole would be {1000 * off:.0f} mm and {angle:.0f} deg off the peg"
    if along < 0:
        return limits["back"], "its front would face the panel"
    return 1.0, f"its hole is {1000 * off:.0f} mm from the peg's axis, its front faces away from the panel"


def _standing(fit: Fit, model: Thing, support: Thing, limits: Mapping[str, float]) -> tuple[float, str]:
    from ...shapes.bounds import lowest

    top = next((support.pose * f.pose for f in support.features if f.type == "vrps:SurfaceFeature"), None)
    if top is None:
        return 1.0, ""
    low = fit.pose.position[2] + lowest(model, fit.pose) - top.position[2]
    if abs(low) > limits["stand_m"]:
        return limits["impossible"], f"its lowest point would be {1000 * low:+.0f} mm from '{support.name}'"
    return 1.0, f"it stands on '{support.name}'"


@hookimpl
def experts() -> Iterable[Expert]:
    physics = (
        Parameter("impossible", 0.5, "a wrong relation must not kill a good fit"),
        Parameter("back", 0.9, "fits of front and back differ by less where the tab is in the middle"),
        Parameter("hole_m", 0.015, "hole radius 5 mm, 5 mm of error of the peg, 5 mm of the pose"),
        Parameter("axis", 0.77, "cosine of 40 degrees: a tab on a peg swings less"),
        Parameter("stand_m", 0.015, "error of a surface and of the pose, and depth noise"),
    )
    made = ("pose", "model", "type", "joints", "features")
    return [
        Expert("plausibility", "the best fit that is physically possible", ("hypotheses", "models"), made, plausible,
               "object", uses=("relations", "fixtures"), domains={"type": types}, cost_ms=0.5, parameters=physics),
        Expert("best_fit", "the best fit, where nothing more is known", ("hypotheses", "models"), made, best_fit,
               "object", domains={"type": types}, cost_ms=0.6),
    ]  # fmt: skip
