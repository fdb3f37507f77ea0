"""Expert for pose hypotheses: registration of the models that an object may be."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

from cramlite.model import Pose, Value
from cramlite.plugin import Expert, Inputs, Judged, Parameter, hookimpl

JointValue = tuple[str, float, float]
"""Name of a joint of a known model, its value, and the value's standard deviation [m, rad]."""


class Fit(Value):
    """Pose of a known model that was registered with measured points, with its score and the reason for the
    score.

    Args:
        model: its name; pose: of its frame in the world.
        score: 0 to 1, how well it explains what is seen.
        reason: a clause with numbers.
        joints: of the model, where it has some.
    """

    model: str
    pose: Pose
    score: float
    reason: str
    joints: tuple[JointValue, ...] = ()


Method = Callable[..., Sequence[Any]]
"""(view, mask, model, prior) -> pose hypotheses, best first."""


def hypotheses(inputs: Inputs) -> Mapping[str, Any]:
    """Register the models that colour and size allow, by the batched ICP of the package ``pose``."""
    from .estimate import estimate

    return registered(inputs, estimate)


def registered(inputs: Inputs, method: Method) -> Mapping[str, Any]:
    """Register the models that colour and size allow; upright first, and in any orientation if that fits badly.

    That nothing looks like it, or fits, is an answer (no hypotheses): nobody else need be asked.
    """
    from .prior import UPRIGHT, Prior

    values, limits = inputs["candidates"], inputs.parameters
    best = max((c.confidence for c in values), default=0.0)
    tried = [c for c in values if c.confidence >= max(limits["least"], limits["share"] * best)][: int(limits["models"])]
    fits = _fits(inputs, tried, method, UPRIGHT)
    if not fits or fits[0].score < limits["bad"]:
        fits = sorted([*fits, *_fits(inputs, tried, method, Prior())], key=lambda f: -f.score)
    return {"hypotheses": tuple(fits)}


def _fits(inputs: Inputs, tried: Sequence[Judged], method: Method, prior: Any) -> list[Fit]:
    from .model import surface_of

    models = {m.name: m for m in inputs["models"]}
    found = []
    for candidate in tried:
        surface = surface_of(models[candidate.value])
        for h in method(inputs["view"], inputs["clean"], surface, prior)[:4]:
            weight = 0.7 + 0.3 * candidate.confidence  # equal fits: the likelier model
            found.append(Fit(candidate.value, h.pose, h.score * weight, "; ".join(h.reasons)))
    return sorted(found, key=lambda f: -f.score)


FITTING = (
    Parameter("least", 0.05, "less likely models lose in any case: the others fit better"),
    Parameter("share", 0.15, "of the likeliest model's confidence"),
    Parameter("models", 3, "colour and size leave two in clutter of four types"),
    Parameter("bad", 0.45, "below 0.6 a pose is doubtful; retrying costs as much again"),
)
NEEDED = ("view", "clean", "candidates", "models")


@hookimpl
def experts() -> Iterable[Expert]:
    about = "known models, registered many times as one batch, judged against the image"
    return [
        Expert("registration", about, NEEDED, ("hypotheses",), hypotheses, "object", cost_ms=90.0, parameters=FITTING)
    ]
