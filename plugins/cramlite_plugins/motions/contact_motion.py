"""Motions that feel: along a path giving way sideways, until contact, standing still."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from typing import Any

import numpy as np

from cramlite import (
    Answers,
    Belief,
    Context,
    ForceMove,
    Grounding,
    Motion,
    MoveUntilContact,
    Pose,
    Unresolvable,
    Wait,
    ZeroSensor,
    hookimpl,
)  # fmt: skip
from cramlite.geometry import Floats

Found = Iterator[Grounding]
COMPLIANT_SPEED = 0.02  # of compliant axes [m/s]; faster oscillates against a stiff peg in simulation
STIFF = 0.15, 0.35  # deviation limits of the other axes [m, rad]: documented, the controller stops beyond them
BEYOND = 0.03  # how far past where contact is expected a guarded motion goes [m]: six sigma of a 5 mm estimate
PATIENCE = 2.0, 3.0  # a time-out is the nominal time times the first plus the second [s]
GRAVITY = 9.81


@hookimpl
def resolve_motion(motion: Motion, belief: Belief, context: Context) -> Answers:
    from .peg_motion import force_insert, spiral_search

    kinds: Mapping[str, Callable[[Motion, Belief, Context], Found]] = {
        "force_path": _force_path, "until_contact": _until_contact, "zero_sensor": _zero, "hold": _hold,
        "spiral_search": spiral_search, "force_insert": force_insert,
    }  # fmt: skip
    kind = kinds.get(motion.kind)
    return kind(motion, belief, context) if kind else None


def _force_path(motion: Motion, belief: Belief, context: Context) -> Found:
    """Along the corners of a place's path; sideways the arm gives way, and carries what it holds."""
    from cramlite_plugins.experts.reach import tcp

    from .free_motion import line, place_of

    place = place_of(motion, context)
    points = line(motion, belief, context, list(place.path))
    corners = np.array([tcp(belief, context).position, *(p.position for p in place.path)])
    legs = np.diff(corners, axis=0)
    lengths = np.linalg.norm(legs, axis=1)
    frame = _frame(legs[int(np.argmax(lengths))])
    speed, limit = float(motion.parameters["speed_m_s"]), float(motion.parameters["force_limit_n"])
    x, y, _ = frame.inverse().turn((0.0, 0.0, _carried(motion, belief)))
    step = ForceMove(
        place.path, frame, (True, True, False, False, False, False), (float(x), float(y), 0.0, 0.0, 0.0, 0.0),
        (COMPLIANT_SPEED, COMPLIANT_SPEED, STIFF[0], STIFF[1], STIFF[1], STIFF[1]), speed, limit,
        timeout(float(lengths.sum()), speed), points[-1], origin=motion.name, comment=motion.reason,
    )  # fmt: skip
    reason = f"{1000 * lengths.sum():.0f} mm at {1000 * speed:.0f} mm/s, sideways compliant, abort over {limit:.0f} N"
    yield Grounding((step,), reason, 0.0, belief.moved(points[-1]), key="force path")


def _frame(axis: Floats) -> Pose:
    """z along the path; x up, unless the path itself goes up."""
    upright = abs(axis[2]) > 0.9 * float(np.linalg.norm(axis))
    return Pose.from_axes((0, 0, 0), axis, (1.0, 0.0, 0.0) if upright else (0.0, 0.0, 1.0))


def _carried(motion: Motion, belief: Belief) -> float:
    """Upward force of the compliant arm [N]: the weight of what it holds, less what presses on a surface."""
    weight = GRAVITY * (belief.world.thing(belief.held.thing).mass or 0.0) if belief.held else 0.0
    return weight - float(motion.parameters.get("press_n", 0.0))


def timeout(length: float, speed: float) -> float:
    return float(math.ceil(PATIENCE[0] * length / speed + PATIENCE[1]))


def _until_contact(motion: Motion, belief: Belief, context: Context) -> Found:
    """From here towards the place, or a corner of its path, and up to a little beyond it, until something is felt."""
    from cramlite_plugins.experts.reach import tcp

    from .free_motion import line, place_of

    place, here = place_of(motion, context), tcp(belief, context)
    corner = motion.parameters.get("corner")
    target = place.pose if corner is None else place.path[corner]
    way: Any = np.array(target.position) - np.array(here.position)
    distance = float(np.linalg.norm(way)) + float(motion.parameters.get("beyond_m", BEYOND))
    x, y, z = way / np.linalg.norm(way)
    points = line(motion, belief, context, [target])
    speed, force = float(motion.parameters["speed_m_s"]), float(motion.parameters["force_n"])
    step = MoveUntilContact(
        (float(x), float(y), float(z)), speed, force, distance, timeout(distance, speed),
        motion.parameters.get("expect", "contact"), points[-1], origin=motion.name, comment=motion.reason,
    )  # fmt: skip
    reason = f"at most {1000 * distance:.0f} mm at {1000 * speed:.0f} mm/s until {force:.0f} N"
    yield Grounding((step,), reason, 0.0, belief.moved(points[-1]), key="until contact")


def _zero(motion: Motion, belief: Belief, context: Context) -> Found:
    if context.robot.sensor is None:
        raise Unresolvable(f"robot '{context.robot.type}' has no force-torque sensor, which '{motion.name}' needs")
    yield Grounding(
        (ZeroSensor(origin=motion.name, comment=motion.reason),), "tare the sensor standing still", key="zero"
    )


def _hold(motion: Motion, belief: Belief, context: Context) -> Found:
    step = Wait(float(motion.parameters["duration_s"]), origin=motion.name, comment=motion.reason)
    yield Grounding((step,), f"stand still for {step.duration:.1f} s", key="hold")
