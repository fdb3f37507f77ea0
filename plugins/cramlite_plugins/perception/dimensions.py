"""Experts for size and shape: extents of an object's points, and the primitive that fits them best."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from cramlite.model import Floats
from cramlite.plugin import Expert, Inputs, Judged, Parameter, Unresolvable, hookimpl

if TYPE_CHECKING:
    from .values import Extents


SIZES = (("small", 0.09), ("medium", 0.16), ("large", math.inf))
"""Longest extents of a thing that a hand lifts, by word [m]: a box of matches, a pack of tea, a pack of cereals."""
TURNS = 18  # directions about the vertical that are tried for the smallest rectangle, over a quarter turn


def size(inputs: Inputs) -> Mapping[str, Any]:
    """Measure an object: its vertical extent, and the smallest rectangle around it from above, without outliers."""
    found = extents(inputs["points"])
    word = next(w for w, end in SIZES if found.longest < end)
    edge = min(abs(found.longest - end) for _, end in SIZES)
    sure = min(1.0, 0.5 + edge / 0.02)
    lengths = " x ".join(f"{1000 * v:.0f}" for v in (found.width, found.depth, found.height))
    reason = f"it looks {lengths} mm large"
    return {
        "extents": found,
        "size": Judged(found.longest, 0.9, reason),
        "size_word": Judged(word, sure, reason),
    }


def extents(points: Any) -> Extents:
    """Return the extents of points (N, 3) in the world frame, without the outermost hundredth on each side."""
    from .values import Extents

    p = np.asarray(points[:: max(1, len(points) // 2000)], dtype=float)
    angles = np.arange(TURNS) * (math.pi / 2 / TURNS)
    along = p[:, :2] @ np.array([np.cos(angles), np.sin(angles)])
    across = p[:, :2] @ np.array([-np.sin(angles), np.cos(angles)])
    low_a, high_a = np.percentile(along, (1, 99), axis=0)
    low_c, high_c = np.percentile(across, (1, 99), axis=0)
    k = int(((high_a - low_a) * (high_c - low_c)).argmin())
    low_z, high_z = np.percentile(p[:, 2], (1, 99))
    width, depth, yaw = float(high_a[k] - low_a[k]), float(high_c[k] - low_c[k]), float(angles[k])
    a, c = (low_a[k] + high_a[k]) / 2, (low_c[k] + high_c[k]) / 2
    centre = (a * math.cos(yaw) - c * math.sin(yaw), a * math.sin(yaw) + c * math.cos(yaw), (low_z + high_z) / 2)
    if depth > width:
        width, depth, yaw = depth, width, yaw + math.pi / 2
    return Extents(float(high_z - low_z), width, depth, (float(centre[0]), float(centre[1]), float(centre[2])), yaw)


def shape(inputs: Inputs) -> Mapping[str, Any]:
    """Fit a box, a cylinder, a sphere and a flat plate to an object's points, and return which fits best.

    Planes: two planes explain a box's visible sides. A sphere is fitted linearly, a cylinder as a circle from above.
    """
    points = np.asarray(inputs["points"], dtype=float)
    points = points[:: max(1, len(points) // 800)]
    if len(points) < inputs.parameters["least"]:
        raise Unresolvable(f"{len(points)} points are too few to recognise a shape")
    found = extents(points)
    if min(found.height, found.width, found.depth) < 0.05 * found.longest:
        return {"shape": Judged("flat", 0.8, f"{1000 * min(found.height, found.depth):.0f} mm thick")}
    errors = {"box": _planes(points), "sphere": _sphere(points), "cylinder": _circle(points[:, :2])}
    weights = {k: math.exp(-((v / inputs.parameters["noise_m"]) ** 2) / 2) for k, v in errors.items()}
    total = sum(weights.values()) or 1.0
    order = sorted(errors, key=lambda k: errors[k])
    said = [Judged(k, weights[k] / total, f"its points are {1000 * errors[k]:.1f} mm off a {k}") for k in order]
    return {"shape": Judged(said[0].value, said[0].confidence, said[0].reason, tuple(said[1:]))}


def _planes(points: Floats) -> float:
    """70th percentile of the points' distances [m] from the nearest of three planes, fitted one after another."""
    rng, rest = np.random.default_rng(0), points
    best = np.full(len(points), np.inf)
    for _ in range(3):
        if len(rest) < 20:
            break
        triples = rest[rng.integers(len(rest), size=(60, 3))]
        normals = np.cross(triples[:, 1] - triples[:, 0], triples[:, 2] - triples[:, 0])
        normals /= np.maximum(np.linalg.norm(normals, axis=1), 1e-9)[:, None]
        offsets = np.einsum("ij,ij->i", normals, triples[:, 0])
        near = (np.abs(rest @ normals.T - offsets) < 0.004).sum(axis=0)
        n, d = normals[int(near.argmax())], offsets[int(near.argmax())]
        best = np.minimum(best, np.abs(points @ n - d))
        rest = rest[np.abs(rest @ n - d) >= 0.004]
    return float(np.percentile(best, 70))


def _sphere(points: Floats) -> float:
    """70th percentile of the points' distances [m] from the sphere of the linear fit |p|^2 = 2 c p + r^2 - |c|^2
    (Coope, JOTA 76, 1993); 1 for a radius over 0.15 m."""
    system = np.column_stack([2 * points, np.ones(len(points))])
    solution, *_ = np.linalg.lstsq(system, (points**2).sum(axis=1), rcond=None)
    radius = math.sqrt(max(float(solution[-1] + solution[:-1] @ solution[:-1]), 0.0))
    away = np.abs(np.linalg.norm(points - solution[:-1], axis=1) - radius)
    return float(np.percentile(away, 70)) if radius < 0.15 else 1.0


_circle = _sphere  # of two coordinates: a cylinder that stands upright, seen from above


@hookimpl
def experts() -> Iterable[Expert]:
    noise = Parameter("noise_m", 0.0015, "a D435's depth noise at 0.6 m")
    least = Parameter("least", 80, "fewer points fit anything")
    return [
        Expert("extents", "size from the box around the points", ("points",), ("extents", "size", "size_word"), size,
               "object", domains={"size_word": tuple(w for w, _ in SIZES)}, cost_ms=0.8),
        Expert("shape_fit", "the surface that the points lie on best", ("points",), ("shape",), shape, "object",
               domains={"shape": ("box", "cylinder", "sphere", "flat")}, cost_ms=3.0, parameters=(noise, least)),
    ]  # fmt: skip
