"""Contents of vessels: volumes, poured fillings, and the positions of a run's grains."""

from __future__ import annotations

import math

import numpy as np

from cramlite.model import Belief, Feature, Filling, Floats, Rollout, Thing, seen_from

SHARE, SPILLED = 0.9, 0.1
"""Shares of the poured contents: the least one that has to arrive, and the largest one that may be lost
beside the vessels; both are measured, see Pouring."""
PACKED = 0.55
"""Loosely packed balls fill this share of a space (Onoda and Liniger, Random loose packings of uniform
spheres and the dilatancy onset, Physical Review Letters 64, 1990)."""
LEVEL = 0.99
"""Least vertical component of the z axis of a face from which grains do not roll: the face leans by 8 deg at
most."""
LYING = 4.0
"""Largest height at which a grain counts as lying on a surface [radii of the grain]."""
POURED = "contains"
"""Relation of a belief: (POURED, vessel, the thing whose contents are in it now)."""


def pouring_obstacle(belief: Belief, source: str, into: str) -> str:
    """Explain why one vessel's contents cannot be poured into another; empty when they can."""
    filling = belief.thing(source).filling
    if filling is None:
        return f"'{source}' is empty; there is nothing to pour"
    gone = next((vessel for p, vessel, of in sorted(belief.relations) if p == POURED and of == source), None)
    if gone is not None:
        return f"'{source}' is empty; its contents were poured into '{gone}'"
    cavity = belief.thing(into).feature("cram:Cavity")
    there = [into, *(of for p, vessel, of in sorted(belief.relations) if p == POURED and vessel == into)]
    has = sum(bulk(f) for name in there if (f := belief.world.thing(name).filling) is not None)
    if cavity is None or has + bulk(filling) <= volume(cavity):
        return ""
    return (
        f"'{into}' would overflow: it holds {1e6 * has:.0f} of {1e6 * volume(cavity):.0f} ml, and "
        f"{1e6 * bulk(filling):.0f} ml are in '{source}'"
    )


def volume(cavity: Feature) -> float:
    """Compute the volume of a cavity, a box or a cylinder [m3]."""
    size = cavity.size
    area = math.pi * size["radius"] ** 2 if "radius" in size else size["width"] * size["depth"]
    return area * size["height"]


def bulk(filling: Filling) -> float:
    """Compute the bulk volume of a filling, loosely packed [m3]."""
    return filling.count * 4 / 3 * math.pi * filling.radius**3 / PACKED


def are_in_cavity(thing: Thing, poses: Floats, centres: Floats) -> Floats:
    """Check which points are in a thing's cavity.

    Args:
        poses: of the thing, (N, 7).
        centres: (N, count, 3), world frame [m].

    Returns:
        Booleans (N, count).
    """
    cavity = thing.feature("cram:Cavity")
    if cavity is None:
        return np.zeros(centres.shape[:2], dtype=bool)
    size = cavity.size
    x, y, z = np.moveaxis(_local(poses, cavity, centres), -1, 0)
    round_ = "radius" in size
    across = (
        np.hypot(x, y) <= size["radius"]
        if round_
        else (abs(x) <= size["width"] / 2) & (abs(y) <= size["depth"] / 2)
    )
    return np.asarray(across & (z <= 0.0) & (z >= -size["height"]))


def where(rollout: Rollout, thing: str) -> dict[str, Floats]:
    """Count the grains of a thing's filling that are in each vessel, sample by sample: vessel -> (N,)."""
    grains = rollout.grains[thing]
    vessels = [t for t in rollout.world.things if t.feature("cram:Cavity") is not None]
    return {v.name: are_in_cavity(v, rollout.poses[v.name], grains).sum(axis=1) for v in vessels}


def lain_on(thing: Thing) -> Feature | None:
    """Return the upward face on which the filling of a thing without a cavity lies at the start.

    None if it has no such face, or has a cavity.
    """
    if thing.feature("cram:Cavity") is not None:
        return None
    return next(
        (f for f in thing.features if f.type == "vrps:SurfaceFeature" and f.pose.rotation[2, 2] > LEVEL), None
    )


def on_its_surface(rollout: Rollout, thing: str) -> Floats:
    """Count the grains that still lie on a thing's upper face, sample by sample (N,); 0 for a thing with a
    cavity."""
    grains, its = rollout.grains[thing], rollout.world.thing(thing)
    surface = lain_on(its)
    if surface is None or its.filling is None:
        return np.zeros(len(grains))
    x, y, z = np.moveaxis(_local(rollout.poses[thing], surface, grains), -1, 0)
    over = (abs(x) <= surface.size["width"] / 2) & (abs(y) <= surface.size["depth"] / 2)
    return np.asarray((over & (z >= 0.0) & (z <= LYING * its.filling.radius)).sum(axis=1))


def _local(poses: Floats, feature: Feature, centres: Floats) -> Floats:
    """Transform points (N, count, 3) from the world to the frame of a feature of a thing with poses (N, 7)
    [m]."""
    inside = seen_from(np.repeat(poses, centres.shape[1], axis=0), centres.reshape(-1, 3))
    return np.asarray(feature.pose.inverse().apply(inside)).reshape(centres.shape)
