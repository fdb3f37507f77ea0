"""Where to bring a camera that is on the flange, so that something is in its view."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence

import numpy as np

from cramlite import Answers, Belief, Context, Grounding, Location, Place, Pose, Refused, Unresolvable, hookimpl
from cramlite.geometry import Floats

DISTANCES = (0.55, 0.65, 0.75)  # from the middle [m]: depth noise grows with the square, 1.4 mm at 0.55 m
SIDES = (-35.0, 35.0, -20.0, 20.0, -50.0, 50.0, 0.0)  # of the robot's own direction, about the vertical [deg]
HEIGHTS = (25.0, 40.0, 10.0)  # above the horizontal [deg]: from aside and above, two or three faces are seen
BORDER = 40  # pixels that stay free around what is looked at
BELOW = 0.08  # what hangs from a peg is about that far below it [m]


@hookimpl
def resolve_location(location: Location, belief: Belief, context: Context) -> Answers:
    return _views(location, belief, context) if location.relation == "view" else None


def _views(location: Location, belief: Belief, context: Context) -> Iterator[Grounding | Refused]:
    from cramlite_plugins.experts.reach import bound, make_scene, stance

    if context.camera is None or context.camera.mount is None:
        raise Unresolvable("the robot has no camera on its flange; the scenario's 'camera' says where one is", ("",))
    around = list(location.parameters.get("around", ())) or [bound(context, location.of)]
    points = np.array([p for name in around for p in _points(belief, name)])
    to_flange = context.camera.pose.inverse()
    scene = make_scene(belief, context)
    for k, (name, eye) in enumerate(_eyes(points.mean(axis=0))):
        optical = _optical(eye, points.mean(axis=0))
        if not _in_view(optical, points):
            yield Refused(name, "not all of it would be in view", 1)
            continue
        tool = optical * to_flange * context.robot.gripper.tcp
        there = stance(scene, context, tool, belief.joints)
        if isinstance(there, str):
            yield Refused(name, there, 2)
            continue
        yield Grounding(Place(tool, tool), f"{', '.join(around)} in view from {name}", 0.05 * k, key=name)


def _points(belief: Belief, entity: str) -> Sequence[Sequence[float]]:
    """What should be in view of a thing, base frame: along its peg and below, or where it is."""
    thing, pose = belief.thing(entity), belief.pose(entity.split("/")[0])
    peg = thing.feature("vrps:Peg")
    if peg is None:
        return [tuple(pose.position)]
    ends = (pose * peg.pose).apply([(0, 0, 0), (0, 0, peg.size["length"])])
    return [*ends.tolist(), *(ends - (0, 0, 2 * BELOW)).tolist()]


def _eyes(target: Floats) -> Iterator[tuple[str, Floats]]:
    """Points around the target, on the robot's side, with a name for people."""
    towards = math.atan2(-target[1], -target[0])
    for distance, height, side in itertools.product(DISTANCES, HEIGHTS, SIDES):
        a, h = towards + math.radians(side), math.radians(height)
        way = np.array([math.cos(a) * math.cos(h), math.sin(a) * math.cos(h), math.sin(h)])
        yield f"{distance:.2f} m, {side:+.0f} deg aside, {height:.0f} deg above", target + distance * way


def _optical(eye: Floats, target: Floats) -> Pose:
    from .camera import looking_at

    return looking_at(
        (float(eye[0]), float(eye[1]), float(eye[2])), (float(target[0]), float(target[1]), float(target[2]))
    )


def _in_view(optical: Pose, points: Floats) -> bool:
    from .camera import D435

    pixels = D435.project(optical.inverse().apply(points))
    low, high = BORDER, np.array([D435.width, D435.height]) - BORDER
    return bool(((pixels > low) & (pixels < high)).all())
