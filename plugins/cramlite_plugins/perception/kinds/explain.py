"""Experts for things with a printed texture: they find which known models, at which poses, explain a picture."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from cramlite.model import Value
from cramlite.plugin import SEGMENTS, UNKNOWN, Expert, Inputs, Judged, Parameter, Unresolvable, hookimpl

from ..category import types
from ..pose.registration import Fit

if TYPE_CHECKING:
    from cramlite.model import Mask

    from .appearance import Appearance
    from .reading import Part, Reading


class Explanation(Value, eq=False):
    """Explanation of an image segment: the probability of each known model, and the models' poses.

    Args:
        segment: the very segment.
        shares: (model, probability), the likeliest first; "" is none of the known ones.
        fits: the readings, best first.
    """

    segment: Any
    shares: tuple[tuple[str, float], ...]
    fits: tuple[Fit, ...]


def explained(inputs: Inputs) -> Mapping[str, Any]:
    """Segment a picture by explaining it with known models, some of which have a printed texture.

    Raises:
        Unresolvable: no known model has a printed texture, or nothing stands out.
    """
    from ..own_surface import widened
    from ..values import Segment
    from .agreement import Picture
    from .bearers import with_bearers
    from .joined import interpreted
    from .reading import Scene
    from .turned import turned

    known: Sequence[Appearance] = inputs["appearances"]
    if not any(a.printed for a in known):
        raise Unresolvable("no known model has a printed texture")
    view, cloud = inputs["view"], inputs["cloud"]
    front, own = cloud.mask & ~_surroundings(inputs, known), inputs.get("robot")
    robot = None if own is None else widened(own, view.intrinsics)
    scene = Scene(Picture.of(view), cloud.points, tuple(known), inputs.parameters, front, tuple(inputs["fixtures"]), robot)
    parts = with_bearers(scene, turned(scene, interpreted(scene)))
    if not parts:
        raise Unresolvable(f"nothing stands out from the background: {int(front.sum())} pixels in front of it")
    segments = tuple(Segment(p.mask) for p in parts)
    found = tuple(_explanation(s, p, inputs.parameters) for s, p in zip(segments, parts, strict=True))
    return {SEGMENTS: segments, "explanations": found}


def _surroundings(inputs: Inputs, known: Sequence[Appearance]) -> Mask:
    """Pixels of furniture whose place is known, and of planes that are larger than any known model."""
    from ..fixtures import on_fixtures
    from ..segmentation.planes import on_planes

    limits, cloud = inputs.parameters, inputs["cloud"]
    largest = max(a.surface.diameter for a in known)
    walls = on_planes(cloud, inputs["planes"], limits["thickness_m"], max(limits["extent_m"], largest))
    return walls | on_fixtures(cloud, inputs["fixtures"], limits["fixture_m"])


def _explanation(segment: Any, part: Part, limits: Mapping[str, float]) -> Explanation:
    """Probabilities by Bayes' rule over the models' best scores and "none", with equal priors."""
    from .reading import rarity

    best: dict[str, Reading] = {}
    for reading in part.readings:
        best.setdefault(reading.appearance.model.name, reading)
    names = ["", *best]
    scores = np.array([limits["none"] * rarity(part.mask, limits), *(r.score for r in best.values())])
    weights = np.exp((scores - scores.max()) / limits["doubt"])
    shares = weights / weights.sum()
    order = sorted(range(len(names)), key=lambda k: (-shares[k], names[k]))
    likely = {names[k]: float(shares[k]) for k in order}
    fits = [_fit(r, likely[r.appearance.model.name], part.readings, limits) for r in part.readings
            if likely[r.appearance.model.name] > limits["least"]]  # fmt: skip
    return Explanation(segment, tuple(likely.items()), tuple(sorted(fits, key=lambda f: -f.score)))


def _fit(reading: Reading, likely: float, others: Sequence[Reading], limits: Mapping[str, float]) -> Fit:
    """Convert an explanation to a fit with its confidence, which is at most ``DOUBT`` if the model fits as
    well at another pose."""
    from ..pose.estimate import DOUBT, OTHER
    from .joint_states import unsettled

    sure = min(1.0, reading.score / limits["full"]) * (0.5 + 0.5 * likely)
    own, model = reading.appearance.model.name, reading.appearance.surface
    reasons = reading.reasons
    for rival in others:
        if rival.appearance.model.name == own and abs(reading.score - rival.score) < limits["tie"]:
            metres, turn = model.difference(rival.pose, reading.pose)
            if metres > OTHER[0] or turn > OTHER[1]:
                sure, reasons = min(sure, DOUBT), (*reasons, f"another pose, {1000 * metres:.0f} mm away, fits as well")
                break
    return Fit(own, reading.pose, sure, "; ".join(reasons), reading.joints or unsettled(reading.appearance.model))


def kind(inputs: Inputs) -> Mapping[str, Any]:
    """Return the class of an object, the models that may explain it, and the poses at which they do.

    Raises:
        Unresolvable: it was segmented without known models.
    """
    segment = inputs["segment"]
    found = next((e for e in inputs["explanations"] if e.segment is segment), None)
    if found is None:
        raise Unresolvable("the object was segmented without known models")
    models = {m.name: m for m in inputs["models"]}
    by_type: dict[str, float] = {}
    for name, share in found.shares:
        own = models[name].type if name else UNKNOWN
        by_type[own] = by_type.get(own, 0.0) + share
    why = {f.model: f.reason for f in reversed(found.fits)}
    said = sorted(by_type.items(), key=lambda p: (-p[1], p[0]))
    first = next((n for n, _ in found.shares), "")
    reason = f"'{first}': {why[first]}" if first in why else "no known model explains it"
    judged = [Judged(t, min(1.0, s), reason if k == 0 else "") for k, (t, s) in enumerate(said)]
    unknown = not first
    candidates = tuple(Judged(n, min(1.0, s), why.get(n, "")) for n, s in found.shares if n)
    return {
        "type": Judged(judged[0].value, judged[0].confidence, reason, tuple(judged[1:])),
        "candidates": candidates,
        "hypotheses": () if unknown else found.fits,
    }


def appearances(inputs: Inputs) -> Mapping[str, Any]:
    """Return the appearances of each known model that has a shape, one for each state of its joints in which it is looked for."""
    from .appearance import appearance_of
    from .joint_states import states_of

    return {"appearances": tuple(appearance_of(s) for m in inputs["models"] if m.geoms for s in states_of(m))}


PARAMETERS = (
    Parameter("thickness_m", 0.010, "five times the median error of a D435 below 1 m"),
    Parameter("extent_m", 0.20, "longer than any product that a gripper of 85 mm takes, and than any known model"),
    Parameter("fixture_m", 0.010, "5 mm of error of a fixture's pose, and the noise of depth"),
    Parameter("cell_m", 0.0075, "neighbouring pixels at 1.3 m are 4 mm apart; things nearer than that touch"),
    Parameter("pixels", 60, "a small carton at 1.3 m has 125"),
    Parameter("least_m", 0.02, "smaller rests are edges of what was explained"),
    Parameter("again", 2, "rests of rests"),
    Parameter("candidates", 8, "of 32 kinds, by colour"),
    Parameter("states", 8, "of each kind with joints, the likeliest by size and colour"),
    Parameter("shows", 0.25, "of a model's pixels that tell where its joints are"),
    Parameter("shape", 0.7, "score by shape above which no other state of a joint is tried: a wrong one reaches 0.6"),
    Parameter("shut_m", 0.012, "a part that is nearer to where its file has it is there: depth noise at a metre"),
    Parameter("alike", 0.35, "of the most alike model's likeness"),
    Parameter("apart_m", 0.10, "what hides the middle of a thing is seldom wider"),
    Parameter("handle_m", 0.06, "what stands off furniture, as a handle does, is no farther from the rest that is seen of it"),
    Parameter("covered", 0.15, "of a part's border; noise makes less of a thing that stands alone"),
    Parameter("pieces", 4, "of a cluster that are read on their own: what two things on each other show"),
    Parameter("partly", 4, "of them where things may touch, for each part"),
    Parameter("models", 2, "registered in full; the coarse registration has ranked them"),
    Parameter("poses", 4, "of each model that are registered in full"),
    Parameter("far", 0.3, "of a model's diameter, from which coarse registration draws points near"),
    Parameter("large_m", 0.25, "diameter above which coarse registration has twice the iterations"),
    Parameter("slow", 4, "times the iterations of full registration for such a model: a rack 25 mm aside comes to its place"),
    Parameter("yaws", 8, "coarse poses of each model whose print is compared"),
    Parameter("tried", 6, "times as many poses of a model whose other parts may be hidden: many fit, few are possible"),
    Parameter("started", 0.5, "of the best model's score by shape after the first stage, below which a model is not refined"),
    Parameter("half", 0.5, "of a pose's score, above which a turn of it is registered: a can turned by 180 deg about its box has 0.6"),
    Parameter("as_well", 0.85, "of a pose's score, above which shape does not tell a turn of it"),
    Parameter("missing_m", 0.07, "half of a carton may be hidden, by others or by itself"),
    Parameter("excess_m", 0.035, "the box around a leaning thing is larger than the thing"),
    Parameter("tie", 0.02, "difference of scores that tells no pose from another"),
    Parameter("larger_m", 0.015, "flying pixels at both ends make a thing that much larger"),
    Parameter("near", 0.75, "of the best coarse score, above which a second model is registered in full"),
    Parameter("hopeless", 0.08, "coarse score below which no model is registered in full"),
    Parameter("strip", 0.03, "the same for a strip, whose coarse ranks tell little: below it none of 66 came to more than 0.04 in full"),
    Parameter("good", 0.45, "above it a cluster is one thing"),
    Parameter("bad", 0.35, "below it a model does not explain it"),
    Parameter("divided", 0.15, "of furniture's pixels in its second piece, from which this may be a thing on it: handles have a twentieth"),
    Parameter("gain", 0.05, "by which several things must explain more than one"),
    Parameter("within_m", 0.022, "furniture is drawn up to 20 mm into what it stands on; what is deeper inside of it cannot be there"),
    Parameter("loose_m", 0.012, "what can be moved lies on a thing, not in it: errors of both places, and of depth"),
    Parameter("hover_m", 0.006, "half of that: above it a thing stands on something else, or is nowhere"),
    Parameter("hover", 0.8, "of the score of what hovers, where another explanation of the same points stands on known furniture"),
    Parameter("floor_m", 0.03, "lowest points that are seen of what stands on furniture are so near it, if nothing hides them"),
    Parameter("touches_m", 0.012, "hover_m, and half the distance between a model's points"),
    Parameter("bears_m", 0.008, "errors of both heights: three times those of poses at 95 %"),
    Parameter("bearer", 1.4, "of the score of what must bear a thing that hovers: few kinds are as high, so that none fits by chance"),
    Parameter("within", 0.1, "of a model's surface that deep inside of furniture"),
    Parameter("robot_m", 0.05, "depth noise at a metre, links drawn simpler than they are"),
    Parameter("robot", 0.3, "of a model's surface that near to the robot's own"),
    Parameter("edged", 0.5, "of the outline of one of several things that touch: faces of two may be alike for a part of it"),
    Parameter("owns_m", 0.003, "beside what depth noise explains"),
    Parameter("small", 1500, "pixels: a carton at 0.9 m; larger parts are explained by chance less often"),
    Parameter("rarer", 0.25, "power of the number of pixels with which a chance fit gets rarer"),
    Parameter("none", 0.40, "score that a wrong model reaches by chance"),
    Parameter("doubt", 0.04, "difference of scores by which a model is e times likelier"),
    Parameter("full", 0.60, "score of a right model in full view"),
    Parameter("least", 0.02, "less likely models are no hypotheses"),
)
"""Parameters of the expert ``printed_things``, with the reason for each value."""


@hookimpl
def experts() -> Iterable[Expert]:
    return [
        Expert("appearances", "surface, colours and usual attitudes of each known model", ("models",), ("appearances",), appearances,
               cost_ms=5.0),
        Expert("printed_things", "things that known models with prints explain", ("view", "cloud", "planes", "appearances", "fixtures"),
               (SEGMENTS, "explanations"), explained, uses=("robot",), cost_ms=1500.0, parameters=PARAMETERS),
        Expert("printed_kind", "the model that explains it, by shape and print", ("segment", "explanations", "models"),
               ("type", "candidates", "hypotheses"), kind, "object", domains={"type": types}, cost_ms=0.1),
    ]  # fmt: skip
