"""Expert that localises the fixtures of the map, by their pegs and panels."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from cramlite.model import Floats, Geom, Pose, Thing
from cramlite.plugin import Expert, Inputs, Judged, Parameter, Unresolvable, hookimpl

from ..category import _model_chroma
from ..fixtures import signed_distances
from .segments import chromaticity


def refined(inputs: Inputs) -> Mapping[str, Any]:
    """Refine the positions of fixtures with a peg by point-to-surface registration of the translation.

    Source: Besl and McKay, PAMI 14, 1992. Thin parts and flat ones count the same, so that the panel, with a hundred times
    the points, says how far away it is, and the peg says the rest. A fixture that is not located has the value None, with the reason.
    """
    pegs = [t for t in inputs["fixtures"] if t.feature("vrps:Peg") is not None]
    if not pegs:
        raise Unresolvable("no fixture has a peg")
    found = {t.name: _refined(t, inputs) for t in pegs}
    return {"refined": {n: j if isinstance(j, Judged) else Judged(None, 0.0, j) for n, j in found.items()}}


def _refined(thing: Thing, inputs: Inputs) -> Judged | str:
    limits = inputs.parameters
    eye = np.array(inputs["view"].camera.position)
    groups = _groups(thing, inputs, eye)
    if sum(len(p) for part, p in groups if part) < limits["least"]:
        return f"{sum(len(p) for part, p in groups if part)} points on its peg are too few"
    shift = np.zeros(3)
    for _ in range(int(limits["iterations"])):
        system, right = 1e-6 * np.eye(3), np.zeros(3)
        for part, points in groups:
            away, normal = _residuals(thing, part, points - shift, eye - shift)
            near = np.abs(away) < limits["reach_m"]
            weight = 1.0 / max(1, int(near.sum()))
            n = normal[near]
            system += weight * n.T @ n
            right += weight * n.T @ away[near]
        step = np.linalg.solve(system, right)
        shift = shift + step
        if float(np.linalg.norm(step)) < 1e-5:
            break
    length = float(np.linalg.norm(shift))
    if length > limits["reach_m"]:
        return f"it would be {1000 * length:.0f} mm from where the map has it"
    noise, error = (_misfit(thing, [g for g in groups if bool(g[0]) is peg], shift, eye) for peg in (False, True))
    leaning = max((_leaning(thing, p, shift, eye) for part, p in groups if part), default=0.0)
    if error > max(limits["misfit_m"], limits["misfit"] * noise) or leaning > max(limits["misfit_m"], limits["leaning"] * noise):
        return f"after registration the points of its peg are {1000 * error:.1f} mm from the model's peg: something else was taken for it"
    pose = Pose(tuple((np.array(thing.pose.position) + shift).tolist()), thing.pose.quaternion)
    sure = float(np.clip(1.0 - error / limits["reach_m"], 0.0, 1.0))
    return Judged(pose, sure, f"moved by {1000 * length:.1f} mm, then the points of its peg are {1000 * error:.1f} mm from the model's peg")


def _misfit(thing: Thing, groups: Iterable[tuple[str, Floats]], shift: Floats, eye: Floats) -> float:
    """Median distance [m] of points from the parts of a shifted fixture that they belong to; 0 without points."""
    import numpy as np

    rest = np.concatenate([np.abs(_residuals(thing, part, p - shift, eye - shift)[0]) for part, p in groups])
    return float(np.median(rest)) if len(rest) else 0.0


def _leaning(thing: Thing, points: Floats, shift: Floats, eye: Floats) -> float:
    """Largest distance [m] of a quarter of a peg's points, along the peg, from the peg; over a quarter noise averages out."""
    import numpy as np

    away = _residuals(thing, "peg", points - shift, eye - shift)[0]
    along = np.linalg.norm(points - np.array(thing.pose.position), axis=1)
    quarters = np.array_split(away[np.argsort(along)], 4)
    return max((abs(float(np.median(q))) for q in quarters if len(q)), default=0.0)


def _groups(thing: Thing, inputs: Inputs, eye: Floats) -> list[tuple[str, Floats]]:
    """Points of a fixture's panel and points of its peg, each with the part's name, which is "" for the panel.

    They are near the surface of the part where the map has it, and of the fixture's colour.
    """
    view, cloud, limits = inputs["view"], inputs["cloud"], inputs.parameters
    index = np.flatnonzero(cloud.mask)
    points = cloud.points.reshape(-1, 3)[index]
    around = np.linalg.norm(points - np.array(thing.pose.position, np.float32), axis=1) < limits["around_m"]
    index, points = index[around], points[around].astype(float)
    chroma = chromaticity(view.rgb).reshape(-1, 2)[index]
    alike = np.abs(chroma - _model_chroma(thing)).max(axis=1) < limits["chroma"]
    found = []
    for part in ("", "peg"):
        away, _ = _residuals(thing, part, points, eye)
        own = (np.abs(away) < limits["reach_m"]) & alike
        if part:  # nearer to the panel is the panel's
            own &= np.abs(_residuals(thing, "", points, eye)[0]) > 2 * limits["reach_m"]
        found.append((part, points[own][:: max(1, int(own.sum()) // 2000)]))
    return found


def _residuals(thing: Thing, part: str, points: Floats, eye: Floats) -> tuple[Floats, Floats]:
    """Signed distances [m] of points from a fixture's panel (``part`` is "") or its peg, and the normals there.

    A camera sees the side that faces it. A point whose nearest surface faces away is measured against the tangent plane
    on the near side, else a thin peg that is believed nearer than it is would be registered with its back side: in
    the first pictures of 7 of the development seeds 0 to 69 of ``hang_onto_hanger_camera`` it was, 4.3 to 4.9 mm off; now
    none is more than 0.4 mm off.
    """
    best, normal = np.full(len(points), np.inf), np.zeros((len(points), 3))
    rays = (points - eye) / np.linalg.norm(points - eye, axis=1)[:, None]
    for geom in thing.geoms:
        if bool(geom.part) == bool(part):
            away, n = facing_distances(geom, thing.pose * geom.pose, points, rays)
            nearer = np.abs(away) < np.abs(best)
            best[nearer], normal[nearer] = away[nearer], n[nearer]
    return best, normal


def facing_distances(geom: Geom, frame: Pose, points: Floats, rays: Floats) -> tuple[Floats, Floats]:
    """Return signed distances (N,) [m] from tangent planes of a geom's side that faces the camera, and their normals, world frame."""
    back = frame.inverse()
    away, normal = signed_distances(back.apply(points), geom)
    normal = frame.rotate(normal)
    hidden = np.einsum("ij,ij->i", normal, rays) > 0
    if hidden.any():
        step = 2 * min(geom.size[: 3 if geom.shape == "box" else 1]) * rays[hidden]
        near, n = signed_distances(back.apply(points[hidden] - step), geom)
        n = frame.rotate(n)
        away[hidden], normal[hidden] = near + np.einsum("ij,ij->i", step, n), n
    return away, normal


@hookimpl
def experts() -> Iterable[Expert]:
    parameters = (
        Parameter("reach_m", 0.012, "an error of the map of 5 mm, and the noise of a D435 at 0.8 m"),
        Parameter("least", 60, "a peg of 6 mm, 100 mm long, has 150 pixels at 0.9 m"),
        Parameter("around_m", 0.30, "half the panel's diagonal and the peg"),
        Parameter("chroma", 0.03, "as the segments: the tab of a product is no peg"),
        Parameter("misfit_m", 0.0007, "development seeds 0 to 99: 0.29 to 0.56 mm where right; pegs that were 4 mm wrong had 0.71 to 0.94"),
        Parameter("misfit", 0.9, "of the panel's, which is noise: right ones .62 to .73, at 1 to 3 times a D435's; .97 where 4 mm wrong"),
        Parameter("leaning", 0.4, "of the panel's, by a quarter of the peg: .28 to .42 where right, .60 and more where it leans by 4 deg"),
        Parameter("iterations", 20, "it moves less than 10 um after 8, measured"),
    )
    return [
        Expert("peg_registration", "where pegs really are", ("view", "cloud", "fixtures"), ("refined",), refined,
               cost_ms=25.0, parameters=parameters),
    ]  # fmt: skip
