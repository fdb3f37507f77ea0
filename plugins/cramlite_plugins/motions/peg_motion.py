"""Motions that thread a hole onto a peg by touch: the spiral search, and the force-limited push along the peg."""

from __future__ import annotations

import math
from collections.abc import Iterator

from cramlite import Belief, Context, ForceInsert, Grounding, Motion, Pose, SpiralSearch

Found = Iterator[Grounding]
# Neighbouring turns lie this share of the radial play apart, at most PITCH: 1.5 mm for a play of 2 mm was measured to
# find every hole (docs/explanation/simulation.md); the next turn then passes the peg well inside the hole.
SHARE, PITCH = 0.75, 0.0015


def spiral_search(motion: Motion, belief: Belief, context: Context) -> Found:
    """Around where the tool is, pressing the way the place is approached.

    The pitch follows from the radial play of hole and peg.
    """
    from .free_motion import line, place_of

    place, p = place_of(motion, context), motion.parameters
    points = line(motion, belief, context, [place.path[int(p["corner"])]])
    pitch, radius = min(SHARE * place.values["play_m"], PITCH), float(p["radius_m"])
    speed, force = float(p["speed_m_s"]), float(p["force_n"])
    # length of an Archimedean spiral, to first order: pi radius^2 / pitch
    seconds = math.ceil(2 * math.pi * radius**2 / pitch / speed + 3)
    step = SpiralSearch(
        _towards(place.approach), force, pitch, radius, speed, float(p["advance_m"]), float(p["force_limit_n"]),
        float(seconds), points[-1], origin=motion.name, comment=motion.reason,
    )  # fmt: skip
    shape = f"radius {1000 * radius:.0f} mm, pitch {1000 * pitch:.1f} mm for a play of {1000 * place.values['play_m']:.1f} mm"
    yield Grounding((step,), f"{shape}, pressing with {force:.0f} N", 0.0, belief.moved(points[-1]), key="spiral")


def force_insert(motion: Motion, belief: Belief, context: Context) -> Found:
    """As deep as the place says, beyond the corner that the tool has reached; the peg leads the hole."""
    from .contact_motion import timeout
    from .free_motion import line, place_of

    place, p = place_of(motion, context), motion.parameters
    first, last = int(p["corner"]), int(p["end"])
    points = line(motion, belief, context, list(place.path[first + 1 : last + 1]))
    depth, speed, force = place.values["push_m"], float(p["speed_m_s"]), float(p["force_n"])
    step = ForceInsert(
        _towards(place.approach), force, depth, speed, float(p["force_limit_n"]), timeout(depth, speed), points[-1],
        origin=motion.name, comment=motion.reason,
    )  # fmt: skip
    reason = f"{1000 * depth:.0f} mm with {force:.0f} N, sideways compliant, abort over {step.force_limit:.0f} N"
    yield Grounding((step,), reason, 0.0, belief.moved(points[-1]), key="insert")


def _towards(axis: tuple[float, float, float]) -> Pose:
    """z along an axis, x as far up as it can be."""
    upright = abs(axis[2]) > 0.9
    return Pose.from_axes((0, 0, 0), axis, (1.0, 0.0, 0.0) if upright else (0.0, 0.0, 1.0))
