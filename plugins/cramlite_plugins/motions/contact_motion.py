"""Motions that feel: along a path giving way sideways, until contact, standing still."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from typing import Any

import numpy as np
from msgspec.structs import replace

from cramlite import (
    Answers,
    Belief,
    CompliantSlide,
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

from .kinds import KINDS, value
from .knowledge import adapted, noted

Found = Iterator[Grounding]
Kind = Callable[[Motion, Belief, Context], Found]
COMPLIANT_SPEED = 0.02  # of compliant axes [m/s]; faster oscillates against a stiff peg in simulation
STIFF = 0.15, 0.35  # deviation limits of the other axes [m, rad]: documented, the controller stops beyond them
PATIENCE = 2.0, 3.0  # a time-out is the nominal time times the first plus the second [s]
GRAVITY = 9.81


@hookimpl
def resolve_motion(motion: Motion, belief: Belief, context: Context) -> Answers:
    from .peg_motion import force_extract, force_insert, spiral_search

    kinds: Mapping[str, Kind] = {
        "force_path": _force_path, "until_contact": _until_contact, "zero_sensor": _zero, "hold": _hold,
        "spiral_search": spiral_search, "force_insert": force_insert, "force_extract": force_extract,
        "compliant_slide": _slide,
    }  # fmt: skip
    kind = kinds.get(motion.kind)
    return _known(kind, motion, belief, context) if kind else None


def _known(kind: Kind, motion: Motion, belief: Belief, context: Context) -> Found:
    """A motion with parameters that suit the things, and the belief widened by what the motion leaves unknown."""
    motion = adapted(motion, belief, context)
    for found in kind(motion, belief, context):
        after, widened = widen(motion, found.belief or belief)
        reason = "; ".join(filter(None, (found.reason + noted(motion), widened)))
        yield replace(found, belief=after, reason=reason)


def widen(motion: Motion, belief: Belief) -> tuple[Belief, str]:
    """What a motion in contact leaves unknown: where the held thing is in the hand; variances add."""
    added, held = KINDS[motion.kind].widens, belief.held
    if held is None or added == 0.0:
        return belief, ""
    sigma = math.hypot(held.sigma, added)
    said = f"'{held.thing}' is known to {1000 * sigma:.1f} mm in the hand, not {1000 * held.sigma:.1f} mm"
    return replace(belief, held=replace(held, sigma=sigma)), said


def _force_path(motion: Motion, belief: Belief, context: Context) -> Found:
    """Along the corners of a place's path; sideways the arm gives way, and carries what it holds."""
    from cramlite_plugins.experts.reach import tcp

    from .free_motion import line, place_of

    place = place_of(motion, context)
    points = line(motion, belief, context, list(place.path))
    corners = np.array([tcp(belief, context).position, *(p.position for p in place.path)])
    legs = np.diff(corners, axis=0)
    lengths = np.linalg.norm(legs, axis=1)
    frame = frame_along(legs[int(np.argmax(lengths))])
    speed, limit = value(motion, "speed_m_s"), value(motion, "force_limit_n")
    x, y, _ = frame.inverse().turn((0.0, 0.0, carried(motion, belief)))
    step = ForceMove(
        place.path, frame, (True, True, False, False, False, False), (float(x), float(y), 0.0, 0.0, 0.0, 0.0),
        (COMPLIANT_SPEED, COMPLIANT_SPEED, STIFF[0], STIFF[1], STIFF[1], STIFF[1]), speed, limit,
        timeout(float(lengths.sum()), speed), points[-1], origin=motion.name, comment=motion.reason,
    )  # fmt: skip
    reason = f"{1000 * lengths.sum():.0f} mm at {1000 * speed:.0f} mm/s, sideways compliant, abort over {limit:.0f} N"
    yield Grounding((step,), reason, 0.0, belief.moved(points[-1]), key="force path")


def frame_along(axis: Floats) -> Pose:
    """z along the path; x up, unless the path itself goes up."""
    upright = abs(axis[2]) > 0.9 * float(np.linalg.norm(axis))
    return Pose.from_axes((0, 0, 0), axis, (1.0, 0.0, 0.0) if upright else (0.0, 0.0, 1.0))


def carried(motion: Motion, belief: Belief) -> float:
    """Upward force of the compliant arm [N]: the weight of what it holds, less what presses on a surface."""
    held = belief.world.thing(belief.held.thing) if belief.held else None
    weight = GRAVITY * (held.mass or 0.0) if held is not None and held.joint is None else 0.0  # rails carry a drawer
    return weight - float(motion.parameters.get("press_n", 0.0))


def timeout(length: float, speed: float) -> float:
    return float(math.ceil(PATIENCE[0] * length / speed + PATIENCE[1]))


def _slide(motion: Motion, belief: Belief, context: Context) -> Found:
    """Along a place's path, pressing against its approach: the surface that it lies on."""
    from cramlite_plugins.experts.reach import tcp

    from .free_motion import line, place_of

    place = place_of(motion, context)
    points = line(motion, belief, context, list(place.path))
    corners = np.array([tcp(belief, context).position, *(c.position for c in place.path)])
    length = float(np.linalg.norm(np.diff(corners, axis=0), axis=1).sum())
    speed, press = value(motion, "speed_m_s"), value(motion, "press_n")
    step = CompliantSlide(
        place.path, frame_along(np.array([0.0, 0.0, -1.0])), press, speed, value(motion, "lost_s"),
        value(motion, "force_limit_n"), timeout(length, speed), points[-1], origin=motion.name, comment=motion.reason,
    )  # fmt: skip
    reason = f"{1000 * length:.0f} mm at {1000 * speed:.0f} mm/s, pressing with {press:.0f} N, abort over {step.force_limit:.0f} N"
    yield Grounding((step,), reason, 0.0, belief.moved(points[-1]), key="slide")


def _until_contact(motion: Motion, belief: Belief, context: Context) -> Found:
    """From here towards the place, or a corner of its path, and up to a little beyond it, until something is felt."""
    from cramlite_plugins.experts.reach import tcp

    from .free_motion import line, place_of

    place, here = place_of(motion, context), tcp(belief, context)
    corner = motion.parameters.get("corner")
    target = place.pose if corner is None else place.path[corner]
    way: Any = np.array(target.position) - np.array(here.position)
    distance = float(np.linalg.norm(way)) + value(motion, "beyond_m")
    x, y, z = way / np.linalg.norm(way)
    points = line(motion, belief, context, [target])
    speed, force = value(motion, "speed_m_s"), value(motion, "force_n")
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
    step = Wait(value(motion, "duration_s"), origin=motion.name, comment=motion.reason)
    yield Grounding((step,), f"stand still for {step.duration:.1f} s", key="hold")
