"""Rest of things that a picture shows: poses that are off by millimetres leave things within others, or just over them."""

from __future__ import annotations

from typing import Any

import numpy as np

SECONDS = 1.0
DAMPED = 0.9
"""Share of its velocity that a thing keeps in a step of simulation: it sinks to its rest, and does not jump out of what it overlaps."""
SHARES, SIGNS = (4, 8, 16), (-1.0, 0.0, 1.0)
"""Sides of a thing for one of half the box that hides under it, widest first."""
NEAR = 0.010, 0.17
"""Distance [m] and turn [rad] within which a thing rests near where it is seen: three times the errors of poses, at 95 %."""

DEEP = 0.005
"""Depth that the checks of a scene allow between things [m]; what cannot come out of a fixed thing by ``NEAR`` is no thing of its own."""


def settled(model: Any, state: Any) -> tuple[Any, set[int]]:
    """Return the state (nq,) of a scene at rest, and the free joints of the things that are held there.

    A thing that would come to rest farther than ``NEAR`` from where it is seen stays where it is seen: what it rests on was not recognised.
    Joints of fixed things stay.
    """
    held: set[int] = set()
    while True:
        found = _played(model, state, held)
        free = [j for j in range(model.njnt) if _is_free(model, j)]
        gone = {j for j in free if j not in held and not _is_near(model, j, state, found)}
        if not gone:
            return found, held
        held |= gone


def inside(model: Any, state: Any, held: set[int]) -> list[str]:
    """Return the names of held things that are deeper than ``DEEP`` inside of fixed ones."""
    import mujoco

    data = mujoco.MjData(model)
    data.qpos[:] = state
    mujoco.mj_forward(model, data)
    loose = {int(model.jnt_bodyid[j]) for j in range(model.njnt) if _is_free(model, j)}
    own = {int(model.jnt_bodyid[j]) for j in held}
    pairs = [tuple(int(model.body_rootid[model.geom_bodyid[g]]) for g in c.geom) for c in data.contact if c.dist < -DEEP]
    found = {a for pair in pairs for a, b in (pair, pair[::-1]) if a in own and b not in loose}
    return [str(model.body(b).name) for b in sorted(found)]


def held_up(model: Any, state: Any, held: set[int]) -> list[tuple[Any, Any]]:
    """Return boxes, each as its middle and its half sides [m], of what hides under held things that touch nothing: from under the thing
    down to the next body, half as wide as the thing, or narrower where another known thing stands there.
    """
    import mujoco

    data = mujoco.MjData(model)
    data.qpos[:] = state
    mujoco.mj_forward(model, data)
    touched = {int(model.geom_bodyid[g]) for c in data.contact for g in c.geom}
    found = []
    for body in sorted(int(model.jnt_bodyid[j]) for j in held):
        low, high = _around(model, data, body)
        middle, under = (low + high) / 2, np.array([*(low + high)[:2] / 2, low[2]])
        gap = _gap(model, data, body, under)
        sides = [(high - low)[:2] / share for share in SHARES]
        around = ([_gap(model, data, body, np.add(under, (x * s[0], y * s[1], 0.0))) for x in SIGNS for y in SIGNS] for s in sides)
        half = next((s for s, gaps in zip(sides, around, strict=True) if min(gaps) > gap - NEAR[0]), None)
        if body not in touched and gap > NEAR[0] and half is not None:
            found.append((np.array([*middle[:2], low[2] - gap / 2]), np.array([*half, gap / 2])))
    return found


def _gap(model: Any, data: Any, body: int, start: Any) -> float:
    """Return the distance from a point (3,) down to the next body but one [m]."""
    import mujoco

    return float(mujoco.mj_ray(model, data, start, np.array([0.0, 0.0, -1.0]), None, 1, body, np.zeros(1, np.int32)))


def _around(model: Any, data: Any, body: int) -> tuple[Any, Any]:
    """Return the least and the greatest corner of the box around a body's shapes, along the world's axes [m]."""
    own = [g for g in range(model.ngeom) if model.geom_bodyid[g] == body]
    middle = [data.geom_xpos[g] + data.geom_xmat[g].reshape(3, 3) @ model.geom_aabb[g][:3] for g in own]
    half = [np.abs(data.geom_xmat[g].reshape(3, 3)) @ model.geom_aabb[g][3:] for g in own]
    return np.min(np.subtract(middle, half), axis=0), np.max(np.add(middle, half), axis=0)


def _played(model: Any, state: Any, held: set[int]) -> Any:
    """Simulate a scene from a state with damped velocities, some joints held, and return the state afterwards."""
    import mujoco

    data = mujoco.MjData(model)
    data.qpos[:] = state
    still = held | {j for j in range(model.njnt) if not _is_free(model, j)}
    for _ in range(round(SECONDS / model.opt.timestep)):
        mujoco.mj_step(model, data)
        data.qvel *= DAMPED
        for j in still:
            data.qpos[_values(model, j)] = state[_values(model, j)]
            data.qvel[model.jnt_dofadr[j] : model.jnt_dofadr[j] + (6 if _is_free(model, j) else 1)] = 0.0
    return data.qpos.copy()


def _is_free(model: Any, joint: int) -> bool:
    return int(model.jnt_type[joint]) == 0


def _values(model: Any, joint: int) -> slice:
    first = int(model.jnt_qposadr[joint])
    return slice(first, first + (7 if _is_free(model, joint) else 1))


def _is_near(model: Any, joint: int, before: Any, after: Any) -> bool:
    """Whether a free joint's pose is near to another one."""
    one, other = before[_values(model, joint)], after[_values(model, joint)]
    turn = 2 * float(np.arccos(min(1.0, abs(float(one[3:] @ other[3:])))))
    return float(np.linalg.norm(one[:3] - other[:3])) < NEAR[0] and turn < NEAR[1]
