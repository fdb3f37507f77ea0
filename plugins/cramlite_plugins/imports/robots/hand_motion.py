"""How a hand opens and closes: its own actuators drive its own mechanism from one end of the stroke to the other, without contacts.

So linkages with closed loops, mimicking joints and tendons need no formulas: what moves with what is what MuJoCo finds.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from cramlite.model import Floats, Value
from cramlite.plugin import UserError, checkpoint

SAMPLES = 33  # along the stroke: 2.7 mm of a 2F-85, between which openings are straight lines to 0.02 mm
STILL, PATIENCE = 1e-4, 2000  # speed of joints at rest [rad/s, m/s]; steps until then at most
NEAR = 0.001  # fingers that come as near meet [m]
LEAST = 0.005  # a gripper opens at least so far [m]
FAR = 1.0  # a hand is smaller [m]


class Driven(Value):
    """Hand with its drives, and the drives' control values at both ends of the stroke.

    Args:
        model: compiled; without gravity and contacts.
        names: of the actuators.
        ends: controls of the actuators at each end (2, A), wide first.
        pair: geoms, one of each finger, that come nearest to each other.
    """

    model: Any
    names: tuple[str, ...]
    ends: Floats
    pair: tuple[int, int]


def driven(where: Path, spec: Any, fingers: Sequence[Sequence[int]] | None = None) -> Driven:
    """Find both ends of a hand's stroke: where its fingers are farthest apart, and where they are nearest.

    Args:
        fingers: geoms of each finger, where they are known; else those that come nearest to each other are looked for.

    Raises:
        UserError: nothing opens or closes.
    """
    model = _alone(spec)
    _check_size(where, model)
    names = tuple(a.name for a in spec.actuators)
    orders = [np.array(c) for c in itertools.product(*(model.actuator(n).ctrlrange for n in names))]
    states = [settled(model, order)[0] for order in orders]
    pairs = _pairs(model, states, fingers)
    far = np.array([[_distance(model, state, *pair) for state in states] for pair in pairs]).reshape(-1, len(states))
    travel = far.max(axis=1, initial=0.0) - far.min(axis=1, initial=FAR)
    if not len(pairs) or travel.max() < LEAST:
        raise UserError(
            f"{where}: no two fingers of the hand come nearer to each other when its drives move, so it is no parallel gripper; "
            "if it is one, name the faces that grip by 'pads' of 'gripper': two geoms or bodies, one of each finger."
        )
    nearest = np.where(travel >= LEAST, np.maximum(far.min(axis=1), NEAR), FAR)
    best = min(range(len(pairs)), key=lambda k: (round(float(nearest[k]), 3), -float(travel[k])))
    wide, narrow = int(far[best].argmax()), int(far[best].argmin())
    return Driven(model, names, np.array([orders[wide], orders[narrow]]), pairs[best])


def stroke(hand: Driven) -> tuple[Floats, Floats, Floats]:
    """Drive the fingers of a hand in steps from where they are farthest apart to where they are nearest.

    Returns:
        controls (K, A), positions of all joints (K, nq) and lengths of the drives (K, A) at rest.
    """
    orders = np.array([hand.ends[0] + s * (hand.ends[1] - hand.ends[0]) for s in np.linspace(0.0, 1.0, SAMPLES)])
    data, rows = None, []
    for order in orders:
        q, data = settled(hand.model, order, data)
        rows.append((q, data.actuator_length.copy()))
    return orders, np.array([q for q, _ in rows]), np.array([length for _, length in rows])


def _check_size(where: Path, model: Any) -> None:
    far = float(np.linalg.norm(at(model, model.qpos0).geom_xpos, axis=1).max(initial=0.0))
    if far > FAR:
        raise UserError(
            f"{where}: a shape of the hand is {far:.3g} m from the flange; files are in metres. If this one is in millimetres, scale its "
            "lengths and meshes by 0.001; if it is mounted elsewhere, state where by 'at' of 'gripper'."
        )


def _alone(spec: Any) -> Any:
    model = spec.compile()
    model.opt.gravity[:] = 0.0
    model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONTACT)
    model.opt.integrator = int(mujoco.mjtIntegrator.mjINT_IMPLICITFAST)
    model.opt.timestep = 0.002
    return model


def settled(model: Any, order: Floats, data: Any = None) -> tuple[Floats, Any]:
    """Send control values to the drives, and return the joints' positions (nq,) once they rest, with
    MuJoCo's data."""
    data = mujoco.MjData(model) if data is None else data
    data.ctrl[:] = order
    for _ in range(PATIENCE):
        checkpoint()
        mujoco.mj_step(model, data, 10)
        if float(np.abs(data.qvel).max()) < STILL:
            break
    mujoco.mj_forward(model, data)
    return data.qpos.copy(), data


def _pairs(model: Any, states: Sequence[Floats], fingers: Sequence[Sequence[int]] | None) -> list[tuple[int, int]]:
    """Pairs of geoms on different fingers (branches of the body tree), at least one of which moves."""
    if fingers is not None:
        return list(itertools.product(*fingers))  # type: ignore[arg-type]
    places = np.array([_places(model, q) for q in states])
    moves = np.linalg.norm(places.max(axis=0) - places.min(axis=0), axis=1) > NEAR
    limbs = [_limb(model, int(model.geom_bodyid[g])) for g in range(model.ngeom)]
    both = itertools.combinations([g for g in range(model.ngeom) if limbs[g]], 2)
    return [(a, b) for a, b in both if limbs[a] != limbs[b] and (moves[a] or moves[b])]


def _limb(model: Any, body: int) -> int:
    """The first body with a joint on the way from the root to a body; 0 if there is none."""
    found = 0
    while body > 0:
        found = body if model.body_jntnum[body] else found
        body = int(model.body_parentid[body])
    return found


def _places(model: Any, q: Floats) -> Floats:
    return np.array(at(model, q).geom_xpos)


def at(model: Any, q: Floats) -> Any:
    """Return MuJoCo's data with the joints at these positions, and kinematics computed."""
    data = mujoco.MjData(model)
    data.qpos[:] = q
    mujoco.mj_kinematics(model, data)
    return data


def _distance(model: Any, q: Floats, a: int, b: int) -> float:
    return float(mujoco.mj_geomDistance(model, at(model, q), a, b, FAR, None))
