"""An independent collision checker: the planning model's shapes in Coal.

Where they are comes from mj_kinematics, which test_kinematics checks against the DH table.
"""

from __future__ import annotations

from typing import Any

import coal
import mujoco
import numpy as np

from cramlite_plugins.motion_planning.planning_scene import PlanningScene


def shapes(scene: PlanningScene) -> list[Any]:
    """Return a Coal shape for each geom of the planning model."""
    model, kinds = scene.compiled.model, mujoco.mjtGeom
    result = []
    for kind, size in zip(model.geom_type, model.geom_size, strict=True):
        if kind == kinds.mjGEOM_BOX:
            result.append(coal.Box(*(2 * size)))
        elif kind == kinds.mjGEOM_CYLINDER:
            result.append(coal.Cylinder(size[0], 2 * size[1]))
        elif kind == kinds.mjGEOM_SPHERE:
            result.append(coal.Sphere(size[0]))
        else:
            raise AssertionError(f"geom type {kind} in a planning model")
    return result


def pairs(scene: PlanningScene) -> list[tuple[int, int]]:
    """Return the pairs of geoms that may not touch, without neighbouring links and pairs that the models exclude."""
    model = scene.compiled.model
    excluded = {(int(s) >> 16, int(s) & 0xFFFF) for s in model.exclude_signature}
    result = []
    for g in range(model.ngeom):
        for h in range(g + 1, model.ngeom):
            a, b = int(model.geom_bodyid[g]), int(model.geom_bodyid[h])
            near = model.body_weldid[a] == model.body_weldid[b] or _parent(model, a, b) or _parent(model, b, a)
            if scene.need[g, h] > -np.inf and not near and (a, b) not in excluded and (b, a) not in excluded:
                result.append((g, h))
    return result


def _parent(model: Any, a: int, b: int) -> bool:
    """Check whether a body is the parent of another and not the world: MuJoCo ignores contacts of such pairs."""
    parent = model.body_weldid[model.body_parentid[model.body_weldid[b]]]
    return bool(parent == model.body_weldid[a] and parent != 0)


def distances(
    scene: PlanningScene, q: Any, solids: list[Any], checked: list[tuple[int, int]]
) -> dict[tuple[int, int], float]:
    """Return Coal's signed distance of each pair of geoms at joint positions [m]."""
    scene.tcp(q)
    data = scene.data
    places = [
        coal.Transform3s(np.array(m).reshape(3, 3), np.array(p))
        for m, p in zip(data.geom_xmat, data.geom_xpos, strict=True)
    ]
    request, result = coal.DistanceRequest(), {}
    for g, h in checked:
        answer = coal.DistanceResult()
        result[g, h] = coal.distance(solids[g], places[g], solids[h], places[h], request, answer)
    return result
