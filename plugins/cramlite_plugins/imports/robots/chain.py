"""The arm in a file: its joints from base to flange, with limits, torques and the axes at zero."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from cramlite.model import Floats, Pose, Value
from cramlite.plugin import UserError, nearest

from ..scenes.source import Source

AXES = (6, 7)
FLANGES = re.compile(r"attachment|flange|tool0|right_hand|ee_?site|end_?effector|link_?ee", re.IGNORECASE)
"""Names of the place where a tool is bolted on: Menagerie's "attachment_site", ROS-Industrial's "tool0" and "flange"."""
TAKEN = ("base_link", "gripper", "left_finger", "right_finger")
"""Names of bodies of the base and of our grippers."""
LONGEST = 3.0
"""Longest distance between neighbouring joints [m]: the largest arms in catalogues reach 5 m in all."""


class Chain(Value):
    """Joints of an arm as a file has them, in the frame of its base.

    Args:
        base: id of the body that the arm stands on; 0 if it is the world.
        bodies: ids of the bodies that move with the joints, base to tip.
        links: names of these bodies here: as in the file, unless it has none or the gripper has it.
        joints: names of the joints.
        limits: (lower, upper) of each joint, as the file counts [rad].
        torques: highest of each joint [Nm]; 0 where the file has none.
        speeds: highest of each joint [rad/s]; 0 where the file has none.
        axes: (point, direction) of each joint in the base's frame, all joints at zero [m].
        flange: where tools are bolted on, in the base's frame, all joints at zero.
        said: what the flange was taken from.
        place: "site" or "body", and the name of what it was taken from.
        hand: whether something moves behind the last joint.
    """

    base: int
    bodies: tuple[int, ...]
    links: tuple[str, ...]
    joints: tuple[str, ...]
    limits: tuple[tuple[float, float], ...]
    torques: tuple[float, ...]
    speeds: tuple[float, ...]
    axes: tuple[tuple[Floats, Floats], ...]
    flange: Pose
    said: str
    place: tuple[str, str]
    hand: bool


def find_chain(source: Source, flange: str = "", limits: Sequence[tuple[str, float, float]] = ()) -> Chain:
    """Find the arm in a compiled file: the first six or seven hinges in a row.

    Args:
        flange: name of the site or body where the tool is bolted on; empty looks for usual names behind the last joint.
        limits: (joint, lower, upper) of joints without a range in the file [rad].

    Raises:
        UserError: there is no such row of hinges, a joint has no limits, or the flange is not there.
    """
    model, where = source.model, source.path
    bodies = _hinged(source)
    joints = [int(model.body_jntadr[b]) for b in bodies]
    names = tuple(model.joint(j).name for j in joints)
    if "" in names:
        raise UserError(f"{where}: joint {names.index('') + 1} of the arm has no name; give it one, since programs name joints.")
    ranges = _ranges(source, names, joints, limits)
    wrong = [n for n, (lo, hi) in zip(names, ranges, strict=True) if not (math.isfinite(lo) and math.isfinite(hi) and lo < hi)]
    if wrong:
        raise UserError(f"{where}: the range of joint '{wrong[0]}' is no two finite angles, the lower one first.")
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    for j in joints:
        data.qpos[model.jnt_qposadr[j]] = 0.0
    mujoco.mj_kinematics(model, data)
    base = int(model.body_parentid[bodies[0]])
    stand = pose_of(data.xpos[base], data.xmat[base])
    at, said, place = _flange(source, data, bodies[-1], flange)
    hand = any(_moves(model, b) for b in range(1, model.nbody) if int(model.body_parentid[b]) == bodies[-1])
    axes = tuple((_in(stand, data.xanchor[j]), stand.rotation.T @ data.xaxis[j]) for j in joints)
    _check_size(where, names, axes)
    torques = tuple(_torque(model, j) for j in joints)
    speeds, flat = _speeds(source, names), stand.inverse() * at
    return Chain(base, bodies, _links(model, bodies), names, ranges, torques, speeds, axes, flat, said, place, hand)


def _ranges(
    source: Source, names: tuple[str, ...], joints: list[int], limits: Sequence[tuple[str, float, float]]
) -> tuple[tuple[float, float], ...]:
    """Ranges of the joints: as the scenario states them, else as the file has them."""
    model, stated = source.model, {name: (low, high) for name, low, high in limits}
    for name in stated:
        if name not in names:
            raise UserError(f"{source.path}: 'limits' names '{name}', and the arm has no such joint; {nearest(name, names)}.")
    free = [n for n, j in zip(names, joints, strict=True) if not model.jnt_limited[j] and n not in stated]
    if free:
        raise UserError(
            f"{source.path}: joint '{free[0]}' has no limits; state them by 'limits', 360 deg each way if it turns endlessly: "
            f"limits: {{{', '.join(f'{n}: [-360 deg, 360 deg]' for n in free)}}}."
        )
    own = {n: (float(model.jnt_range[j][0]), float(model.jnt_range[j][1])) for n, j in zip(names, joints, strict=True)}
    return tuple({**own, **stated}[n] for n in names)


def _hinged(source: Source) -> tuple[int, ...]:
    """Bodies on the longest row of hinges of a robot file: the arm's, up to where it branches into a hand."""
    model = source.model

    def rows(body: int, row: tuple[int, ...]) -> list[tuple[int, ...]]:
        count = int(model.body_jntnum[body])
        hinge = count == 1 and int(model.jnt_type[model.body_jntadr[body]]) == int(mujoco.mjtJoint.mjJNT_HINGE)
        if count and not hinge:
            return [row]
        row = (*row, body) if hinge else row
        below = [b for b in range(1, model.nbody) if int(model.body_parentid[b]) == body and b != body]
        moving = [b for b in below if _moves(model, b)]
        if len(row) >= AXES[0] and len(moving) != 1:
            return [row]
        return [r for b in moving for r in rows(b, row)] or [row]

    found = rows(0, ())
    longest, arms = max(found, key=len), [r for r in found if len(r) in AXES]
    if len({r[0] for r in arms}) > 1:
        called = " and ".join(f"'{model.body(r[0]).name}'" for r in arms)
        raise UserError(f"{source.path}: this file has {len(arms)} arms, which begin at {called}; take the file of one arm alone.")
    if len(longest) not in AXES:
        what = f"{len(longest)} hinges in a row" if longest else "no hinge"
        raise UserError(
            f"{source.path}: an arm has six or seven hinges in a row, one in each body, and this file has {what}; it describes "
            "another machine, or its joints are fixed: take the file of the arm alone."
        )
    return longest


def _links(model: Any, bodies: tuple[int, ...]) -> tuple[str, ...]:
    names = [model.body(b).name or f"link_{k}" for k, b in enumerate(bodies, 1)]
    return tuple(f"arm_{name}" if name in TAKEN else name for name in names)


def _moves(model: Any, body: int) -> bool:
    """Whether a body, or one below it in the body tree, has a joint."""
    below = [b for b in range(1, model.nbody) if int(model.body_parentid[b]) == body and b != body]
    return bool(model.body_jntnum[body]) or any(_moves(model, b) for b in below)


def _flange(source: Source, data: Any, last: int, named: str) -> tuple[Pose, str, tuple[str, str]]:
    """Find an arm's flange: its pose in the world, the element of the file that it was taken from (in words), and
    that element's kind and name."""
    model = source.model
    sites = {model.site(s).name: int(s) for s in range(model.nsite) if _behind(model, int(model.site_bodyid[s]), last)}
    bodies = {model.body(b).name: b for b in range(1, model.nbody) if _behind(model, b, last)}
    if named and named not in (*sites, *bodies):
        raise UserError(
            f"{source.path}: there is no site or body '{named}' behind the last joint; {nearest(named, [*sites, *bodies])}."
        )
    name = named or next((n for n in (*sites, *bodies) if FLANGES.search(n)), "")
    if name in sites:
        return pose_of(data.site_xpos[sites[name]], data.site_xmat[sites[name]]), f"site '{name}'", ("site", name)
    b = bodies[name] if name else last
    said = f"body '{name}'"
    if not name:
        said = f"the last body, '{model.body(last).name}': no site or body has a usual name; 'flange' can name one"
    return pose_of(data.xpos[b], data.xmat[b]), said, ("body", model.body(b).name)


def _behind(model: Any, body: int, last: int) -> bool:
    """Whether a body is the last one of the arm, or fixed to it."""
    while body != last and body > 0 and not model.body_jntnum[body]:
        body = int(model.body_parentid[body])
    return body == last


def _check_size(where: Path, names: tuple[str, ...], axes: tuple[tuple[Floats, Floats], ...]) -> None:
    for k, ((a, _), (b, _)) in enumerate(pairwise(axes)):
        far = float(np.linalg.norm(b - a))
        if far > LONGEST:
            raise UserError(
                f"{where}: joints '{names[k]}' and '{names[k + 1]}' are {far:.3g} m apart; files are in metres. If this one is in "
                "millimetres, scale its lengths and meshes by 0.001."
            )


def _torque(model: Any, joint: int) -> float:
    """The highest torque of a joint that the file states, of itself or of its actuator; 0 if none [Nm]."""
    found = [float(model.jnt_actfrcrange[joint][1])] if model.jnt_actfrclimited[joint] else []
    for a in range(model.nu):
        if int(model.actuator_trnid[a][0]) != joint or int(model.actuator_trntype[a]) != 0:
            continue
        gear = abs(float(model.actuator_gear[a][0]))
        if model.actuator_forcelimited[a]:
            found.append(float(model.actuator_forcerange[a][1]) * gear)
        elif model.actuator_ctrllimited[a] and int(model.actuator_biastype[a]) == 0:  # a motor: its order is its torque
            found.append(abs(float(model.actuator_ctrlrange[a][1] * model.actuator_gainprm[a][0])) * gear)
    return min(found, default=0.0)


def _speeds(source: Source, names: tuple[str, ...]) -> tuple[float, ...]:
    """Return the highest speed of each joint that the file states, 0 where it states none [rad/s].

    An MJCF cannot state any.
    """
    if not source.urdf:
        return (0.0,) * len(names)
    text = source.path.read_text(encoding="utf-8", errors="replace")
    found = {}
    for joint in re.finditer(r"<joint\b[^>]*name\s*=\s*[\"']([^\"']+)[\"'].*?</joint>", text, re.DOTALL):
        speed = re.search(r"<limit\b[^>]*\bvelocity\s*=\s*[\"']([\d.eE+-]+)", joint[0])
        found[joint[1]] = float(speed[1]) if speed else 0.0
    return tuple(v if math.isfinite(v) and v > 0 else 0.0 for v in (found.get(n, 0.0) for n in names))


def pose_of(position: Floats, matrix: Floats) -> Pose:
    """Return a pose from a position (3,) [m] and a rotation matrix (9,) or (3, 3)."""
    return Pose.at(position, Pose.from_matrix(np.asarray(matrix).reshape(3, 3)))


def _in(frame: Pose, point: Floats) -> Floats:
    return np.asarray(frame.rotation.T @ (np.asarray(point) - np.array(frame.position)))
