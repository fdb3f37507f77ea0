"""Viewpoints of a camera on the flange, from which something is in its view."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike

from cramlite.model import Belief, Feature, Floats, Intrinsics, Location, Place, Pose, Thing, thing_of
from cramlite.plugin import Answer, Context, Refused, Unresolvable

from ..motion_planning.reach import bound
from ..shapes.bounds import box_around
from .parameters import Sight, asked
from .placing.visibility import hidden_by
from .reached import Arm, Candidate, Leg, reached


def looking_at(eye: ArrayLike, target: ArrayLike) -> Pose:
    """Return the optical frame of a camera at ``eye`` [m] that looks at ``target`` [m], its image upright."""
    forward = np.subtract(target, eye)
    right = np.cross(forward, (0.0, 0.0, 1.0))
    return Pose.from_axes(eye, forward, right if np.linalg.norm(right) > 1e-9 else (1.0, 0.0, 0.0))


DISTANCES = (0.55, 0.65, 0.75)  # from the middle [m]: depth noise grows with the square, 1.4 mm at 0.55 m
SIDES = (-35.0, 35.0, -20.0, 20.0, -50.0, 50.0, 0.0)  # of the robot's own direction, about the vertical [deg]
HEIGHTS = (25.0, 40.0, 10.0)  # above the horizontal [deg]: from aside and above, two or three faces are seen
INTO = (60.0, 75.0, 45.0)  # the same of a cavity, over whose rim the camera looks [deg]
FLOOR = 0.6  # share of a cavity's floor, about its middle, that is looked at: in its corners little can lie
BORDER = 1 / 16  # share of the image's width that stays free around what is looked at
SEEN = 0.5  # share of each thing that must be visible, as for places that a camera looks at
COST = 0.05  # of each viewpoint that comes before
BELOW = 0.08  # what hangs from a peg is about that far below it [m]


def views(location: Location, belief: Belief, context: Context) -> Iterator[Answer]:
    """Generate hand poses from which the camera on the flange sees certain things."""
    if context.camera is None or context.camera.mount is None:
        reason = "the robot has no camera on its flange; the scenario's 'camera' says where one is"
        raise Unresolvable(reason, ("",))
    around = asked(location, Sight).around or (bound(context, location.of),)
    points = np.array([p for name in around for p in _points(belief, name)])
    heights = INTO if all(_cavity(belief.thing(name)) for name in around) else HEIGHTS
    eyes = enumerate(_eyes(points.mean(axis=0), heights))
    found = (_candidate(k, name, eye, points, around, belief, context) for k, (name, eye) in eyes)
    yield from reached(found, Arm(belief, context))


def _candidate(
    k: int, name: str, eye: Floats, points: Floats, around: Sequence[str], belief: Belief, context: Context
) -> Candidate | Refused:
    """Proposal to bring the camera to a point; a refusal if something to be seen is outside of the picture or
    hidden."""
    assert context.camera is not None
    optical = looking_at(eye, points.mean(axis=0))
    if not _in_view(context.camera.intrinsics, optical, points):
        return Refused(name, "not all of the thing would be in view", 1)
    if reason := _hidden(eye, around, belief):
        return Refused(name, reason, 2)
    tool = optical * context.camera.pose.inverse() * context.robot.gripper.tcp
    said = f"{', '.join(around)} in view from {name}"
    return Candidate(name, Place(tool, tool), (Leg(tool),), said, COST * k, passed=3)


def _points(belief: Belief, entity: str) -> Sequence[Sequence[float]]:
    """Points of a thing that a camera should see, base frame: points of its cavity; else of its peg and of
    the space below the peg; else its origin."""
    thing, pose = belief.thing(entity), belief.pose(thing_of(entity))
    if cavity := _cavity(thing):
        inside: Sequence[Sequence[float]] = _floor(pose * cavity.pose, cavity.size).tolist()
        return inside
    peg = thing.feature("vrps:Peg")
    if peg is None:
        return [tuple(pose.position)]
    ends = (pose * peg.pose).apply([(0, 0, 0), (0, 0, peg.size["length"])])
    return [*ends.tolist(), *(ends - (0, 0, 2 * BELOW)).tolist()]


def _cavity(thing: Thing) -> Feature | None:
    """Cavity of a thing that is only a container; None for a thing with a peg or a surface as well, and
    for one without a cavity."""
    if any(f.type in ("vrps:Peg", "vrps:SurfaceFeature") for f in thing.features):
        return None
    return thing.feature("cram:Cavity")


def _floor(opening: Pose, size: Mapping[str, float]) -> Floats:
    """Middle and corners (5, 3) of the inner part of a cavity's cross-section half way up, which the camera
    looks at; ``opening`` is the pose of its opening, z outwards."""
    sides = (size[side] / 2 if side in size else size.get("radius", 0.0) for side in ("width", "depth"))
    x, y = (FLOOR * side for side in sides)
    corners = [(0, 0), (x, y), (x, -y), (-x, y), (-x, -y)]
    points: Floats = opening.apply([(a, b, -size.get("height", 0.0) / 2) for a, b in corners])
    return points


def _eyes(target: Floats, heights: Sequence[float]) -> Iterator[tuple[str, Floats]]:
    """Yield candidate positions of a camera around its target, on the robot's side, each with a name for
    people."""
    towards = math.atan2(-target[1], -target[0])
    for distance, height, side in itertools.product(DISTANCES, heights, SIDES):
        a, h = towards + math.radians(side), math.radians(height)
        way = np.array([math.cos(a) * math.cos(h), math.sin(a) * math.cos(h), math.sin(h)])
        yield f"{distance:.2f} m, {side:+.0f} deg aside, {height:.0f} deg above", target + distance * way


def _in_view(camera: Intrinsics, optical: Pose, points: Floats) -> bool:
    pixels = camera.project(optical.inverse().apply(points))
    low, high = BORDER * camera.width, np.array([camera.width, camera.height]) - BORDER * camera.width
    return bool(((pixels > low) & (pixels < high)).all())


def _hidden(eye: Floats, around: Sequence[str], belief: Belief) -> str:
    """Reason why a viewpoint sees too little of some thing, as other things are known to hide it; "" if it
    sees enough of all."""
    for name in around:
        points = _seen_of(belief, name)
        whole = thing_of(name)
        walls = _cavity(belief.thing(whole)) is not None  # of a container its own walls hide what is inside
        others = [
            t for t in belief.world.things
            if t.name in belief.poses and (walls if t.name == whole else not _belongs(t, name, belief))
        ]  # fmt: skip
        hidden, by = hidden_by(points, eye, belief, others)
        if (share := 1.0 - float(hidden.mean())) < SEEN:
            return (
                f"{100 * share:.0f} % of '{name}' would be seen, {100 * SEEN:.0f} % is needed; '{by}' hides "
                "most"
            )
    return ""


def _seen_of(belief: Belief, entity: str) -> Floats:
    """Points of a thing that should be seen, base frame: those for its peg or cavity if it has one; else the
    middle of the box around the thing and its corners, drawn in by a tenth."""
    thing = belief.thing(entity)
    if thing.feature("vrps:Peg") is not None or _cavity(thing):
        return np.array(_points(belief, entity))
    low, high = box_around(thing.geoms)
    signs = np.array([(0, 0, 0), *itertools.product((-0.9, 0.9), repeat=3)])
    found: Floats = belief.pose(thing.name).apply((low + high) / 2 + signs * (high - low) / 2)
    return found


def _belongs(thing: Thing, place: str, belief: Belief) -> bool:
    """Whether a thing is the target of a view, or is known to hang on the target or to lie on or in it."""
    whole = thing_of(place)
    return thing.name == whole or any(s == thing.name and o == whole for _, s, o in belief.relations)
