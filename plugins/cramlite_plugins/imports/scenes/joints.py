"""Joints of a scene file, turned round where needed, so that their lower value is the closed end."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any

import mujoco
import numpy as np

from cramlite.model import Floats, Joint, Pose, StatedJoint
from cramlite.plugin import UserError

from ...simulation.model.index import joints_of
from .bodies import SLIDE, Group

COMPACT = 0.95
"""Share of volume by which an end of a joint is the closed one: the box around the jointed thing and its mount has at most
this share of its volume at the other end."""

STARTS = 1e-3  # a joint may start so far outside of the range that is stated [m, rad]
MODELLED = 0.1
"""A joint whose zero is within this share of its range of an end was modelled in that state: knobs off, switches up."""


def joint_of(source: Any, group: Group, parent: str, meets: bool, stated: StatedJoint) -> tuple[Joint, list[str]]:
    """Return the joint that carries a group of bodies, closed at its lower value, and notes on what was guessed or changed.

    Closed is where it and its carrier take the least room: a drawer that starts open is still drawn out of its cabinet. Where
    that tells nothing, as of a knob, it is the end near which its zero is: the pose in which it was modelled; else the end that
    it starts nearer to.

    Args:
        source: a ``Source``.
        parent: name of the thing that it is mounted in.
        meets: whether it collides with that.
        stated: what the user says of it.

    Raises:
        UserError: what is stated does not fit the joint.
    """
    model, data = source.model, source.data
    j = joints_of(model, group.root)[0]
    slide, dof = int(model.jnt_type[j]) == SLIDE, int(model.jnt_dofadr[j])
    name, value, notes = model.joint(j).name or model.body(group.root).name, float(data.qpos[model.jnt_qposadr[j]]), list[str]()
    low, high = _range(model, j, value, name, stated, notes)
    axis = np.asarray(model.jnt_axis[j], dtype=float)
    spring = float(np.ravel(model.jnt_stiffness[j])[0])
    rest = float(model.qpos_spring[model.jnt_qposadr[j]])
    if stated.closed:
        above, why = stated.closed == "upper", "the scenario says so"
    elif spring and min(abs(rest - low), abs(rest - high)) <= MODELLED * (high - low):
        above, why = abs(rest - high) < abs(rest - low), "a spring draws it there"
    else:
        above, why = _closed_above(source, group, j, (low, high))
    notes.append(f"joint '{name}' is closed at its {'upper' if above else 'lower'} end{'; its axis is turned round' * above}: {why}")
    if above:
        axis = -axis
        low, high, value, rest = -high, -low, -value, -rest
    notes += _left_out(model, dof, name)
    x = (1.0, 0.0, 0.0) if abs(axis[0]) < 0.9 else (0.0, 1.0, 0.0)
    pose = Pose.from_axes(tuple(float(v) for v in model.jnt_pos[j]), axis, x)
    kind: Any = "slide" if slide else "hinge"
    damping, friction = float(np.max(model.dof_damping[dof])), float(model.dof_frictionloss[dof])
    rest = rest if spring else 0.0
    return Joint(kind, pose, low, high, min(max(value, low), high), parent, damping, friction, meets, spring, rest), notes


def _range(model: Any, joint: int, value: float, name: str, stated: StatedJoint, notes: list[str]) -> tuple[float, float]:
    """Range of a joint from the file's own zero [m, rad]: the scenario's, else the file's.

    What differs from the file is appended to the notes.
    """
    slide = int(model.jnt_type[joint]) == SLIDE
    unit, low, high = "m" if slide else "rad", *(float(v) for v in model.jnt_range[joint])
    if stated.ends is not None:
        _check_stated(name, slide, value, stated, unit)
        own = f", the file {low:.3g} to {high:.3g}" if model.jnt_limited[joint] else ", the file no limits"
        low, high = stated.ends
        notes.append(f"joint '{name}' goes from {low:.3g} to {high:.3g} {unit}: the scenario says so{own}")
    elif not model.jnt_limited[joint]:
        low, high = (value - 1.0, value + 1.0) if slide else (value - math.pi, value + math.pi)
        notes.append(f"joint '{name}' has no limits; it is taken for {low:.2f} to {high:.2f} {unit}")
    return low, high


def _check_stated(name: str, slide: bool, value: float, stated: StatedJoint, unit: str) -> None:
    if (stated.kind == "slide") != slide:
        does, key = ("slides", "slides") if slide else ("turns", "turns")
        raise UserError(f"'joints' states the range of another kind of joint: '{name}' {does}, and '{key}' says its range in {unit}")
    low, high = stated.ends or (value, value)
    if not low - STARTS <= value <= high + STARTS:
        raise UserError(
            f"'joints' says that '{name}' goes from {low:.3g} to {high:.3g} {unit}, and it starts at {value:.3g}; widen the range, or take "
            "a 'keyframe' that lies in it"
        )


def _left_out(model: Any, dof: int, name: str) -> list[str]:
    notes = []
    if float(model.dof_armature[dof]) > 0:
        notes.append(f"joint '{name}' has an armature of {float(model.dof_armature[dof]):g}, which is left out")
    return notes


def _closed_above(source: Any, group: Group, joint: int, ends: tuple[float, float]) -> tuple[bool, str]:
    """Whether a joint is closed at the upper limit of its range, and why."""
    low, high = ends
    below, above = (_room(source, group, joint, at) for at in ends) if group.carrier else (1.0, 1.0)
    if min(below, above) <= COMPACT * max(below, above):
        return above < below, "there it and what it is mounted in take the least room"
    if min(abs(low), abs(high)) <= MODELLED * (high - low) and abs(low) != abs(high):
        return abs(high) < abs(low), "its zero is there"
    value = float(source.data.qpos[source.model.jnt_qposadr[joint]])
    near = value - low > high - value and not math.isclose(value - low, high - value)
    return near, "it starts nearer to that end, and nothing else tells"


def _room(source: Any, group: Group, joint: int, value: float) -> float:
    """Volume of the box, along the carrier's axes, around the carrier and a thing that is jointed to it,
    at a joint value [m3]."""
    frame = source.data.xmat[group.parent].reshape(3, 3)
    points = _points(source, (*group.bodies, *group.carrier), joint, value) @ frame
    return float(np.prod(np.ptp(points, axis=0)))


def _points(source: Any, bodies: Iterable[int], joint: int, value: float) -> Floats:
    """Corners (N, 3) of the boxes around the geoms of bodies that collide, in the world, at a joint value [m]."""
    model, data = source.model, mujoco.MjData(source.model)
    data.qpos[:] = source.data.qpos
    data.qpos[model.jnt_qposadr[joint]] = value
    mujoco.mj_kinematics(model, data)
    points: Floats = np.concatenate([_corners(model, data, g) for g in _geoms(model, bodies)])
    return points


def _geoms(model: Any, bodies: Iterable[int]) -> list[int]:
    return [g for g in range(model.ngeom) if int(model.geom_bodyid[g]) in set(bodies) and model.geom_contype[g] | model.geom_conaffinity[g]]


def _corners(model: Any, data: Any, geom: int) -> Floats:
    """Corners (8, 3) of the box around a geom, in the world [m]."""
    centre, half = model.geom_aabb[geom, :3], model.geom_aabb[geom, 3:]
    signs = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=float)
    corners: Floats = data.geom_xpos[geom] + (centre + signs * half) @ data.geom_xmat[geom].reshape(3, 3).T
    return corners
