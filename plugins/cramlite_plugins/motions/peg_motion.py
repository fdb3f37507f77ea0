"""Motions that lead a hole onto a peg and off it by touch: the spiral search, the force-limited push and pull."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from cramlite import Belief, Context, ForceExtract, ForceInsert, Grounding, Motion, MoveLinear, Pose, SpiralSearch

from .kinds import value
from .knowledge import known

Found = Iterator[Grounding]
CORRECTION = 0.25  # acceleration of the short way back to the path after a pull [m/s2]: as of motions that feel
# Where no ontology says anything of the hole (ontologies/motions.ttl has the same values, with their sources).
REACH, SHARE, PITCH = 0.0095, 0.75, 0.0015


def spiral_search(motion: Motion, belief: Belief, context: Context) -> Found:
    """Around where the tool is, pressing the way the place is approached.

    The pitch follows from the radial play of hole and peg.
    """
    from .free_motion import line, place_of

    place, p = place_of(motion, context), motion.parameters
    points = line(motion, belief, context, [place.path[int(p["corner"])]])
    pitch, radius, why = _spiral(motion, place.values["play_m"], belief, context)
    speed, force = value(motion, "speed_m_s"), value(motion, "force_n")
    # length of an Archimedean spiral, to first order: pi radius^2 / pitch
    seconds = math.ceil(2 * math.pi * radius**2 / pitch / speed + 3)
    step = SpiralSearch(
        _towards(place.approach), force, pitch, radius, speed, value(motion, "advance_m"), value(motion, "force_limit_n"),
        float(seconds), points[-1], origin=motion.name, comment=motion.reason,
    )  # fmt: skip
    shape = f"radius {1000 * radius:.0f} mm, pitch {1000 * pitch:.1f} mm for a play of {1000 * place.values['play_m']:.1f} mm"
    yield Grounding((step,), f"{shape}{why}, pressing with {force:.0f} N", 0.0, belief.moved(points[-1]), key="spiral")


def _spiral(motion: Motion, play: float, belief: Belief, context: Context) -> tuple[float, float, str]:
    """Pitch and radius [m] from the radial play of hole and peg [m], and who says so; a task may say the radius."""
    hole = belief.feature(belief.held.thing, "vrps:Hole") if belief.held else None
    said = {
        name: known(hole.type if hole else "vrps:Hole", f"cram:{name}", context)
        for name in ("searchReach", "searchPitchPerPlay", "searchPitch")
    }
    reach, share, most = (k.value if k else d for k, d in zip(said.values(), (REACH, SHARE, PITCH), strict=True))
    radius, sources = value(motion, "radius_m"), dict.fromkeys(k.source.rpartition("[")[2] for k in said.values() if k)
    why = f" (from {', '.join(s.rstrip(']') for s in sources)})" if sources else ""
    return min(share * play, most), radius or max(reach - play, play), why


def force_insert(motion: Motion, belief: Belief, context: Context) -> Found:
    """As deep as the place says, beyond the corner that the tool has reached; the peg leads the hole."""
    from .contact_motion import timeout
    from .free_motion import line, place_of

    place, p = place_of(motion, context), motion.parameters
    first, last = int(p["corner"]), int(p["end"])
    points = line(motion, belief, context, list(place.path[first + 1 : last + 1]))
    depth, speed, force = place.values["push_m"], value(motion, "speed_m_s"), value(motion, "force_n")
    step = ForceInsert(
        _towards(place.approach), force, depth, speed, value(motion, "force_limit_n"), timeout(depth, speed), points[-1],
        origin=motion.name, comment=motion.reason,
    )  # fmt: skip
    reason = f"{1000 * depth:.0f} mm with {force:.0f} N, sideways compliant, abort over {step.force_limit:.0f} N"
    yield Grounding((step,), reason, 0.0, belief.moved(points[-1]), key="insert")


def force_extract(motion: Motion, belief: Belief, context: Context) -> Found:
    """Off along the path of the place: its end says how far, the peg says where along."""
    from cramlite_plugins.experts.reach import tcp

    from .contact_motion import carried, frame_along, timeout
    from .free_motion import line, place_of

    place = place_of(motion, context)
    points = line(motion, belief, context, list(place.path))
    corners = np.array([tcp(belief, context).position, *(c.position for c in place.path)])
    legs = np.diff(corners, axis=0)
    frame = frame_along(legs[int(np.argmax(np.linalg.norm(legs, axis=1)))])
    x, y, _ = frame.inverse().turn((0.0, 0.0, carried(motion, belief)))
    way = float((corners[-1] - corners[0]) @ np.array(frame.turn((0.0, 0.0, 1.0))))
    speed, force = value(motion, "speed_m_s"), value(motion, "force_n")
    step = ForceExtract(
        frame, force, (float(x), float(y)), way, speed, value(motion, "force_limit_n"), timeout(way, speed), points[-1],
        origin=motion.name, comment=motion.reason,
    )  # fmt: skip
    # The peg has led the tool aside; what comes next was planned from where the path ends, in the open.
    there = MoveLinear(
        place.path[-1], speed, CORRECTION, points[-1], origin=motion.name, comment="from where the peg led it"
    )  # fmt: skip
    reason = f"{1000 * way:.0f} mm with {force:.0f} N, sideways compliant, abort over {step.force_limit:.0f} N"
    yield Grounding((step, there), reason, 0.0, belief.moved(points[-1]), key="extract")


def _towards(axis: tuple[float, float, float]) -> Pose:
    """z along an axis, x as far up as it can be."""
    upright = abs(axis[2]) > 0.9
    return Pose.from_axes((0, 0, 0), axis, (1.0, 0.0, 0.0) if upright else (0.0, 0.0, 1.0))
