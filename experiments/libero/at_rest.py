"""Rest of things that a picture shows: poses that are off by millimetres leave things within others, or just over them."""

from __future__ import annotations

from typing import Any

import numpy as np

SECONDS = 1.0
DAMPED = 0.9
"""Share of its velocity that a thing keeps in a step of simulation: it sinks to its rest, and does not jump out of what it overlaps."""
NEAR = 0.010, 0.17
"""Distance [m] and turn [rad] within which a thing rests near where it is seen: three times the errors of poses, at 95 %."""


def settled(model: Any, state: Any) -> Any:
    """Return the state (nq,) of a scene at rest.

    A thing that would come to rest farther than ``NEAR`` from where it is seen stays where it is seen: what it rests on was not recognised.
    Joints of fixed things stay.
    """
    held: set[int] = set()
    while True:
        found = _played(model, state, held)
        free = [j for j in range(model.njnt) if _is_free(model, j)]
        gone = {j for j in free if j not in held and not _is_near(model, j, state, found)}
        if not gone:
            return found
        held |= gone


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
