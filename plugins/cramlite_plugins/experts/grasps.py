"""Where to grasp a thing: opposite faces of its box-shaped geoms that fit between the fingers."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from cramlite import (
    Answers,
    Belief,
    Context,
    Geom,
    Grounding,
    Location,
    Place,
    Pose,
    Refused,
    Thing,
    Unresolvable,
    hookimpl,
)

STANDOFF = 0.10  # pre-grasp distance [m]: the longest finger pad and the tab of a product fit in between
SLACK = 0.010  # wider than the object when approaching, both sides together [m]
LEAST_SLACK = 0.004  # a thing that leaves less than this does not go between the pads of a known pose [m]
MARGIN = 0.004  # pads end this far inside a face's edge [m]
SHIFTS = (0.0, 0.5, 1.0, -0.5, -1.0)  # along a face, as fractions of what the pads leave


@dataclass(frozen=True)
class Grip:
    """A candidate in the thing's frame.

    Args:
        pose: of the TCP.
        width: between the faces [m].
        lever: from the thing's centre to the pinch point, along the face [m].
        name: for people.
    """

    pose: Pose
    width: float
    lever: float
    name: str


@hookimpl
def resolve_location(location: Location, belief: Belief, context: Context) -> Answers:
    if location.relation != "grasp":
        return None
    return _places(location, belief, context)


def _places(location: Location, belief: Belief, context: Context) -> Iterator[Grounding | Refused]:
    from .reach import bound, make_scene, stance

    entity = bound(context, location.of)
    thing = belief.thing(entity)
    grips = sorted(candidates(thing, context), key=lambda g: (round(g.lever, 4), g.name))
    if not grips:
        widths = ", ".join(f"{2000 * min(g.size):.0f} mm" for g in thing.geoms if g.shape == "box" and not g.part)
        limit = 1000 * (context.robot.gripper.opening[1] - LEAST_SLACK)
        raise Unresolvable(
            f"no face pair of '{thing.name}' ({widths}) fits the gripper's {limit:.0f} mm", (location.of or "",)
        )
    pose = belief.pose(thing.name)
    scenes: dict[float, tuple[object, object]] = {}
    for grip in grips:
        opening = min(grip.width + SLACK, context.robot.gripper.opening[1])
        if opening not in scenes:
            scenes[opening] = (
                make_scene(belief, context, [thing.name], opening),
                make_scene(belief, context, (), opening),
            )
        at = pose * grip.pose
        before = at * Pose((0, 0, -STANDOFF))
        near, free = scenes[opening]
        there = stance(near, context, at, belief.joints)  # type: ignore[arg-type]
        if isinstance(there, str):
            yield Refused(grip.name, f"at the grasp: {there}")
            continue
        off = stance(free, context, before, there)  # type: ignore[arg-type]
        if isinstance(off, str):
            yield Refused(grip.name, f"at the pre-grasp: {off}")
            continue
        place = Place(at, before, opening, tuple(at.turn((0, 0, 1))), thing=thing.name, values={"width_m": grip.width})
        yield Grounding(
            place,
            f"{grip.name}: {1000 * grip.width:.0f} mm wide, {1000 * grip.lever:.0f} mm from the centre",
            grip.lever,
            key=grip.name,
        )


def candidates(thing: Thing, context: Context) -> Iterator[Grip]:
    """Antipodal grasps of all boxes of the thing's body; parts such as tabs are not gripped."""
    for geom in thing.geoms:
        if geom.shape == "box" and not geom.part:
            yield from _of_box(geom, context)


def _of_box(geom: Geom, context: Context) -> Iterator[Grip]:
    gripper = context.robot.gripper
    for closing, approach in itertools.permutations(range(3), 2):
        width = 2 * geom.size[closing]
        if width + LEAST_SLACK > gripper.opening[1]:
            continue
        along = 3 - closing - approach
        room = max(geom.size[along] - gripper.pad[0] / 2 - MARGIN, 0.0)
        for sign, shift in itertools.product((1.0, -1.0), SHIFTS if room > 0.002 else (0.0,)):
            yield _grip(geom, closing, approach, sign, along, shift * room, width, gripper.depth)


def _grip(
    geom: Geom, closing: int, approach: int, sign: float, along: int, offset: float, width: float, depth: float
) -> Grip:
    """TCP z into the box, TCP y across it; as deep as the hand is, at most to the middle."""
    axes = np.eye(3)
    z, y = sign * axes[approach], axes[closing]
    depth_in = min(geom.size[approach], depth - MARGIN)
    centre = -z * (geom.size[approach] - depth_in) + axes[along] * offset
    pose = geom.pose * Pose.from_axes(tuple(centre), z, np.cross(y, z))
    side = "+-"[sign > 0] + "xyz"[approach]
    name = f"from {side} across {'xyz'[closing]} at {1000 * offset:+.0f} mm along {'xyz'[along]}"
    return Grip(pose, width, abs(offset), name)
