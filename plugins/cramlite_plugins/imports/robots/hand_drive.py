"""Drives of a hand from a file: the file's own actuators if they hold a position, else position servos made
by cramlite."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import mujoco

from cramlite.plugin import UserError

from .hand_spec import ROOT, moving_joints

JOINT, TENDON = int(mujoco.mjtTrn.mjTRN_JOINT), int(mujoco.mjtTrn.mjTRN_TENDON)
SLIDE = int(mujoco.mjtJoint.mjJNT_SLIDE)
AFFINE = int(mujoco.mjtBias.mjBIAS_AFFINE)
MOST = 2
STIFF = {True: 40000.0, False: 100.0}
"""Stiffness of an added servo on a slide [N/m], as in our own grippers (robots/parallel_gripper.py), and on a hinge [Nm/rad], as
Menagerie's 2F-85 has."""
EFFORT = {True: 200.0, False: 5.0}
"""Force limit of an added servo while no grip force is stated [N, Nm]; a stated grip force replaces it."""
ARMATURE = {True: 0.5, False: 0.005}
"""Reflected inertia of an added servo's motor, where the file states less [kg, kg m2]; sources as for the stiffness."""

COUPLED = (0.004, 1.0)
"""Time constant and damping ratio of a coupling of finger joints, the time [s]; source as for the stiffness."""


def complete_drives(where: Path, spec: Any) -> tuple[str, ...]:
    """Make each drive of a hand hold a position; return notes on the changes, for people.

    Raises:
        UserError: nothing can be driven, or by more than two drives, or through what is no joint or fixed tendon.
    """
    joints = {j.name: j for j in moving_joints(where, spec)}
    if not joints:
        raise UserError(f"{where}: the hand has no joint, so nothing closes; take a file whose fingers move.")
    weak = [a for a in spec.actuators if not _holds(a)]
    targets = [(int(a.trntype), a.target, _reach(a)) for a in weak]
    notes = [f"drive '{_short(a.name)}' pushes without holding a position: a servo of its strength replaces it" for a in weak]
    for actuator in weak:
        spec.delete(actuator)
    if not spec.actuators and not targets:
        coupled = {e.name1 for e in spec.equalities if int(e.type) == int(mujoco.mjtEq.mjEQ_JOINT) and e.name2}
        targets = [(JOINT, n, None) for n in joints if n not in coupled]
        notes.append(f"no actuator drives the hand: servos drive {', '.join(map(_short, (t[1] for t in targets)))}")
        _stiffen(spec, joints)
    for kind, target, effort in targets:
        _add_servo(spec, kind, target, joints, effort)
    if not 1 <= len(spec.actuators) <= MOST:
        raise UserError(
            f"{where}: {len(spec.actuators)} drives move the hand; a parallel gripper has one or two. Couple its joints in the file "
            "(an equality in MJCF, a mimic in URDF), or take a gripper that comes with cramlite."
        )
    _check_drives(where, spec)
    return tuple(notes)


def _short(name: str) -> str:
    return name.removeprefix(f"{ROOT}/")


def _holds(actuator: Any) -> bool:
    return int(actuator.biastype) == AFFINE and float(actuator.biasprm[1]) < 0 and float(actuator.gainprm[0]) > 0


def _reach(actuator: Any) -> float | None:
    """Largest force or torque of a motor at its joint; None if the file states none."""
    if actuator.forcelimited and actuator.forcerange[1] > 0:
        return abs(float(actuator.forcerange[1]) * float(actuator.gear[0]))
    most = abs(float(actuator.ctrlrange[1]) * float(actuator.gainprm[0]) * float(actuator.gear[0]))
    return most or None


def _add_servo(spec: Any, kind: int, target: str, joints: dict[str, Any], effort: float | None) -> None:
    tendon = spec.tendon(target) if kind == TENDON else None
    own = [joints[target]] if tendon is None else [joints[w.target.name] for w in tendon.path]
    slides = all(int(j.type) == SLIDE for j in own)
    for joint in own:
        joint.armature = max(float(joint.armature), ARMATURE[slides])
    limit = float(own[0].actfrcrange[1]) if own[0].actfrcrange[1] > 0 else 0.0
    most = effort or limit or EFFORT[slides]
    servo = spec.add_actuator(name=f"{ROOT}/{_short(target)}_servo", target=target, trntype=kind)
    servo.set_to_position(kp=STIFF[slides], dampratio=1.0)
    servo.ctrlrange = [min(float(j.range[0]) for j in own), max(float(j.range[1]) for j in own)]
    servo.forcerange = [-most, most]


def _stiffen(spec: Any, joints: dict[str, Any]) -> None:
    """Stiffen the coupling of a hand's joints, which gives way by 6 mm under 12 N with MuJoCo's defaults (measured).

    The joints also get the armature that a gear would have.
    """
    for joint in joints.values():
        joint.armature = max(float(joint.armature), ARMATURE[int(joint.type) == SLIDE])
    for equality in spec.equalities:
        equality.solref = COUPLED


def _check_drives(where: Path, spec: Any) -> None:
    for k, actuator in enumerate(spec.actuators):
        actuator.name = actuator.name or f"{ROOT}/drive_{k}"
        said = f"{where}: drive '{_short(actuator.name)}' of the hand"
        if int(actuator.trntype) not in (JOINT, TENDON) or float(actuator.gear[0]) == 0:
            raise UserError(f"{said} acts through neither a joint nor a fixed tendon; put it on a joint.")
        low, high = (float(v) for v in actuator.ctrlrange)
        if not low < high:
            raise UserError(f"{said} has no 'ctrlrange' to drive it through; state the control values for open and closed.")
