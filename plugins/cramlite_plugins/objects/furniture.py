"""Articulated furniture: a cabinet, and the drawer or the door that is mounted in it.

All three have the same frame: the middle of the cabinet's front opening, x out of it, z up. So a drawer or a door at the
pose of its cabinet is closed. Handles are bars that the fingers of a 2F-85 close around: 12 mm thick, 32 mm off the front.
"""

from __future__ import annotations

from cramlite.model import Feature, Geom, Joint, Pose, Thing
from cramlite.plugin import Angle, Length, Mass

Size = tuple[Length, Length, Length]
Colour = tuple[float, float, float, float]
WALL = 0.015  # of the cabinet, and of plates [m]
BAR, OFF = 0.006, 0.045  # radius of a handle's bar, and its distance from the front [m]: a finger goes behind it
GAP = 0.003  # between what moves and what it is mounted in [m]


def cabinet(
    name: str,
    pose: Pose,
    size: Size = (0.30, 0.30, 0.20),
    friction: float = 0.4,
    rgba: Colour = (0.80, 0.76, 0.70, 1.0),
) -> Thing:
    """Make a box that is open at the front. Frame: the middle of the front opening, x out of it, z up. Features "top" and "inside": its
    upper face, and the floor under that.

    Args:
        size: depth (x), width (y), height (z).
    """
    depth, width, height = size
    half = WALL / 2
    back = Geom("box", (half, width / 2, height / 2), Pose((half - depth, 0, 0)), rgba=rgba)
    sides = [
        Geom("box", (depth / 2, half, height / 2), Pose((-depth / 2, s * (width / 2 - half), 0)), rgba=rgba)
        for s in (1, -1)
    ]
    plates = [
        Geom("box", (depth / 2, width / 2, half), Pose((-depth / 2, 0, s * (height / 2 - half))), rgba=rgba)
        for s in (1, -1)
    ]
    top = Feature("top", "vrps:SurfaceFeature", Pose((-depth / 2, 0, height / 2)), {"width": depth, "depth": width})
    room = {"width": depth - WALL, "depth": width - 2 * WALL, "height": height - 2 * WALL}
    inside = Feature("inside", "vrps:SurfaceFeature", Pose(((WALL - depth) / 2, 0, WALL - height / 2)), room)
    return Thing(name, "soma:Cupboard", pose, (back, *sides, *plates), (top, inside), None, friction)


def drawer(
    name: str,
    pose: Pose,
    parent: str = "",
    size: Size = (0.25, 0.264, 0.164),
    travel: Length = 0.20,
    opened: Length = 0.0,
    mass: Mass = 1.0,
    damping: float = 5.0,
    joint_friction: float = 1.0,
    friction: float = 0.8,
    rgba: Colour = (0.70, 0.66, 0.60, 1.0),
) -> Thing:
    """Make a drawer that slides out of its cabinet along x. Feature "handle": the middle of its bar, z out.

    Args:
        parent: the cabinet that it is mounted in, with which it does not collide.
        size: depth (x), width (y), height (z) of what is inside.
        travel: how far it opens.
        opened: how far it is open at the start.
        damping: of its rails, N s/m.
        joint_friction: of its rails, N.
    """
    depth, width, height = size
    half = WALL / 2
    front = Geom("box", (half, width / 2 + 0.01, height / 2 + 0.01), Pose((half + GAP, 0, 0)), rgba=rgba)
    floor = Geom("box", (depth / 2, width / 2, half), Pose((-depth / 2, 0, half - height / 2)), rgba=rgba)
    sides = [
        Geom("box", (depth / 2, half, height / 3), Pose((-depth / 2, s * (width / 2 - half), -height / 6)), rgba=rgba)
        for s in (1, -1)
    ]
    back = Geom("box", (half, width / 2, height / 3), Pose((half - depth, 0, -height / 6)), rgba=rgba)
    at = Pose((WALL + GAP + OFF, 0.0, 0.0))
    cavity = {"width": depth - WALL, "depth": width - 2 * WALL, "height": 2 * height / 3 - WALL}  # up to the rim of its sides
    features = (
        _handle(at),
        Feature("cavity", "cram:Cavity", Pose((-depth / 2, 0, height / 6)), cavity),
    )
    slide = Joint(
        "slide", Pose.from_axes((0, 0, 0), (1, 0, 0), (0, 0, 1)), 0.0, travel, opened, parent, damping, joint_friction
    )
    geoms = (front, floor, *sides, back, *_bar(at, Pose.from_axes((0, 0, 0), (0, 1, 0), (0, 0, 1)), rgba))
    return Thing(name, "soma:Drawer", slide.moved(pose, opened), geoms, features, mass, friction, joint=slide)


def door(
    name: str,
    pose: Pose,
    parent: str = "",
    width: Length = 0.30,
    height: Length = 0.20,
    swing: Angle = 1.3,
    opened: Angle = 0.0,
    mass: Mass = 1.0,
    damping: float = 0.3,
    joint_friction: float = 0.1,
    friction: float = 0.8,
    rgba: Colour = (0.70, 0.66, 0.60, 1.0),
) -> Thing:
    """Make a door with its hinge on the side of +y. Feature "handle": the middle of its upright bar, z out.

    Args:
        parent: the cabinet that it is mounted in, with which it does not collide.
        swing: how far it opens.
        opened: how far it is open at the start.
        damping: of its hinge, Nm s/rad.
        joint_friction: of its hinge, Nm.
    """
    half = WALL / 2
    plate = Geom("box", (half, width / 2 - GAP, height / 2 - GAP), Pose((half + GAP, 0, 0)), rgba=rgba)
    at = Pose((WALL + GAP + OFF, 0.04 - width / 2, 0.0))
    hinge = Joint(
        "hinge", Pose((half + GAP, width / 2, 0.0)), 0.0, swing, opened, parent, damping, joint_friction,
    )  # fmt: skip
    geoms = (plate, *_bar(at, Pose(), rgba))
    return Thing(name, "soma:Door", hinge.moved(pose, opened), geoms, (_handle(at),), mass, friction, joint=hinge)


def _handle(at: Pose) -> Feature:
    """Handle feature at the middle of a bar; its z axis points out of the front of the furniture."""
    return Feature(
        "handle", "cram:Handle", Pose.from_axes(at.position, (1, 0, 0), (0, 0, 1)), {"radius": BAR, "length": 0.10}
    )


def _bar(at: Pose, along: Pose, rgba: Colour) -> tuple[Geom, ...]:
    """A square bar of 100 mm with two posts to the front; flat faces hold better between pads than a round one."""
    bar = Geom("box", (BAR, BAR, 0.05), at * along, "handle", rgba=(0.3, 0.3, 0.32, 1.0))
    posts = [
        Geom(
            "box",
            (OFF / 2, 0.004, 0.004),
            at * along * Pose((0, 0, s * 0.046)) * along.inverse() * Pose((-OFF / 2, 0, 0)),
            "handle",
            rgba=rgba,
        )
        for s in (1, -1)
    ]
    return (bar, *posts)
