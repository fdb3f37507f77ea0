"""Force-controlled steps of typed programs: contact, force mode, search, insertion, extraction, sliding.

A step that fails raises ``StepFailed``. Numbers and conditions: backends/urscript/parts.py and search.py, as for ``steps``.
"""

from __future__ import annotations

import math
from collections.abc import Generator, Sequence

import numpy as np

from cramlite.model import (
    CompliantSlide,
    Floats,
    ForceExtract,
    ForceInsert,
    ForceMove,
    MoveUntilContact,
    Pose,
    SpiralSearch,
)

from ..controller.commanded_arm import CommandedArm
from ..controller.force_mode import ForceMode
from .steps import Cycles, Running, StepFailed, brake, force

GENTLE = 0.25  # acceleration of guarded and force-controlled motions [m/s2]
CHORD = 0.001  # of the spiral [m]
RIM = 2.0  # a force across of more than this times the pressing force is more than the friction of a face
PRESSING = (0.15, 0.15, 0.02, 0.35, 0.35, 0.35)  # limits of force mode while pressing along z [m, m/s, rad]
SLIDING = (0.15, 0.15, 0.01, 0.35, 0.35, 0.35)  # the same while sliding: backends/urscript_steps.py
TURNING = 0.35  # rotational limit of force mode while pushing [rad]
LEAST = 0.25  # share of the pressing force below which a slide has lost its contact


def until_contact(run: Running, step: MoveUntilContact) -> Cycles:
    """Move along a direction until the reaction force exceeds its threshold."""
    arm, way = run.arm, np.array(step.direction)
    here, waited, reaction = arm.actual_tcp(), 0.0, 0.0
    arm.move_linear(_moved(here, step.distance * way), step.speed, GENTLE)
    while arm.motion is not None and reaction <= step.force and waited < step.timeout:
        yield
        waited += arm.period
        reaction = -float(arm.force_vector() @ way)
    arrived = arm.motion is None
    yield from brake(arm)
    if reaction > step.force:
        run.log(f"{step.origin}: contact, {reaction:.3f} N")
    elif not arrived:
        raise StepFailed(f"{step.origin}: no contact within {step.timeout:g} s")
    elif step.expect == "contact":
        raise StepFailed(f"{step.origin}: no contact within {step.distance:g} m")


def force_move(run: Running, step: ForceMove) -> Cycles:
    """Move along waypoints while some axes of a frame comply."""
    arm, waited = run.arm, 0.0
    _comply(arm, step.frame, step.compliant, step.wrench, step.limits)
    for waypoint in step.waypoints:
        motion = arm.move_linear(waypoint, step.speed, GENTLE)
        while arm.motion is motion and force(arm) <= step.force_limit and waited < step.timeout:
            yield
            waited += arm.period
        if arm.motion is motion:
            break
    yield from _end(run, step.origin, step.force_limit, step.timeout, done=arm.motion is None)


def spiral_search(run: Running, step: SpiralSearch) -> Cycles:
    """Press the tool along z of a frame and move it across z on a spiral until it advances into a hole, or a
    rim holds it."""
    arm, axis = run.arm, _axis(step.frame)
    start, waited, way, across = arm.actual_tcp(), 0.0, 0.0, 0.0
    spiral = _spiral(step, arm.kinematics.forward(arm.q))
    _comply(arm, step.frame, (0, 0, 1, 0, 0, 0), (0, 0, step.force, 0, 0, 0), PRESSING)
    ended = False
    while way < step.advance and across < RIM * step.force and force(arm) <= step.force_limit and waited < step.timeout:
        if arm.motion is None:
            target = next(spiral, None)
            if target is None:
                ended = True
                break
            arm.move_linear(target, step.speed, GENTLE)
        yield
        waited += arm.period
        way = _along(start, arm.actual_tcp(), axis)
        across = _across(arm.force_vector(), axis)
    measured = force(arm)
    yield from _rest(arm)
    if way >= step.advance:
        run.log(f"{step.origin}: it gave way after {waited:.3f} s")
    elif across >= RIM * step.force:
        run.log(f"{step.origin}: a rim holds it after {waited:.3f} s, {across:.3f} N")
    elif measured > step.force_limit:
        raise StepFailed(f"{step.origin}: force {measured:.3f} N > {step.force_limit:g} N")
    elif ended:
        raise StepFailed(f"{step.origin}: nothing gave way within a radius of {step.radius:g} m")
    else:
        raise StepFailed(f"{step.origin}: nothing gave way within {step.timeout:g} s")


def force_insert(run: Running, step: ForceInsert) -> Cycles:
    """Push along z of a frame until the tool has gone deep enough."""
    yield from _along_axis(run, step, (0.0, 0.0, step.force), step.depth, "inserted", "deep")


def force_extract(run: Running, step: ForceExtract) -> Cycles:
    """Pull along z of a frame until the tool has come out far enough."""
    yield from _along_axis(run, step, (*step.across, step.force), step.way, "out", "out")


def _along_axis(
    run: Running, step: ForceInsert | ForceExtract, wrench: Sequence[float], goal: float, done: str, how: str
) -> Cycles:
    """Apply forces along x, y and z of a frame, until the tool has moved far enough along z."""
    arm, axis = run.arm, _axis(step.frame)
    start, waited, way = arm.actual_tcp(), 0.0, 0.0
    limits = (step.speed,) * 3 + (TURNING,) * 3
    _comply(arm, step.frame, (1, 1, 1, 0, 0, 0), (*wrench, 0, 0, 0), limits)
    while way < goal and force(arm) <= step.force_limit and waited < step.timeout:
        yield
        waited += arm.period
        way = _along(start, arm.actual_tcp(), axis)
    measured = force(arm)
    arm.end_force_mode()
    if way >= goal:
        run.log(f"{step.origin}: {done} after {waited:.3f} s")
    elif measured > step.force_limit:
        raise StepFailed(f"{step.origin}: force {measured:.3f} N > {step.force_limit:g} N")
    else:
        raise StepFailed(f"{step.origin}: only {way:.6f} m {how} within {step.timeout:g} s")


def compliant_slide(run: Running, step: CompliantSlide) -> Cycles:
    """Slide along waypoints while pressing along z of a frame."""
    arm, axis, waited, lost = run.arm, _axis(step.frame), 0.0, 0.0
    _comply(arm, step.frame, (0, 0, 1, 0, 0, 0), (0, 0, step.force, 0, 0, 0), SLIDING)
    path = iter(step.waypoints)
    while force(arm) <= step.force_limit and lost <= step.lost and waited < step.timeout:
        if arm.motion is None:
            target = next(path, None)
            if target is None:
                break
            arm.move_linear(target, step.speed, GENTLE)
        yield
        waited += arm.period
        pressed = -float(arm.force_vector() @ axis)
        lost = 0.0 if pressed >= LEAST * step.force else lost + arm.period
    if arm.motion is not None and lost > step.lost and force(arm) <= step.force_limit:
        yield from _rest(arm)
        raise StepFailed(f"{step.origin}: no contact for {lost:.3f} s")
    yield from _end(run, step.origin, step.force_limit, step.timeout, done=arm.motion is None)


def _comply(
    arm: CommandedArm, frame: Pose, axes: Sequence[float], wrench: Sequence[float], limits: Sequence[float]
) -> None:
    turn = Pose((0.0, 0.0, 0.0), frame.quaternion)
    selection, wanted, most = (np.array(v, dtype=float) for v in (axes, wrench, limits))
    arm.start_force_mode(ForceMode(turn, selection, wanted, most))


def _rest(arm: CommandedArm) -> Cycles:
    """Stop the arm, and leave force mode."""
    yield from brake(arm)
    arm.end_force_mode()


def _end(run: Running, origin: str, limit: float, timeout: float, *, done: bool) -> Cycles:
    """Bring the arm to rest; fail if the step is not done, naming its force limit if exceeded, else its timeout."""
    measured = force(run.arm)
    yield from _rest(run.arm)
    if not done and measured > limit:
        raise StepFailed(f"{origin}: force {measured:.3f} N > {limit:g} N")
    if not done:
        raise StepFailed(f"{origin}: not done within {timeout:g} s")


def _spiral(step: SpiralSearch, center: Pose) -> Generator[Pose, None, None]:
    """An Archimedean spiral, radius = pitch * angle / (2 pi), in chords, around the pose that the tool was sent to."""
    angle = radius = 0.0
    while radius < step.radius:
        angle += CHORD / (radius + CHORD)
        radius = step.pitch * angle / math.tau
        yield _moved(center, step.frame.rotate((radius * math.cos(angle), radius * math.sin(angle), 0.0)))


def _moved(pose: Pose, way: Floats) -> Pose:
    return Pose.at(pose.position + way, pose)


def _axis(frame: Pose) -> Floats:
    return np.array(frame.rotate((0.0, 0.0, 1.0)))


def _along(start: Pose, here: Pose, axis: Floats) -> float:
    return float(np.subtract(here.position, start.position) @ axis)


def _across(measured: Floats, axis: Floats) -> float:
    return float(np.linalg.norm(measured - (measured @ axis) * axis))
