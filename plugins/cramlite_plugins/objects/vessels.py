"""Object models of round vessels: cans, bottles, bowls with a rim, mugs and jugs with a handle, lids. All sizes in metres.

Frame of each: on its axis, half way up the body, z up. Feature "bottom": what it stands on, z down. Hollow ones
have a "cavity": at the centre of the opening, z out of it; ``grains`` balls are loose in it at the start.
"""

from __future__ import annotations

import math

from cramlite.model import Feature, Filling, Geom, Pose, Thing
from cramlite.plugin import Length, Mass

SIDES = 12
Colour = tuple[float, float, float, float]


def can(
    name: str, pose: Pose, radius: Length = 0.033, height: Length = 0.115, mass: Mass = 0.35, friction: float = 0.6,
    rgba: Colour = (0.70, 0.30, 0.30, 1.0),
) -> Thing:  # fmt: skip
    """Make a can: a solid cylinder."""
    body = Geom("cylinder", (radius, height / 2), rgba=rgba)
    return Thing(name, "cram:Product", pose, (body,), (_bottom(radius, height),), mass, friction)


def bottle(
    name: str, pose: Pose, radius: Length = 0.034, height: Length = 0.15, neck: Length = 0.014,
    neck_height: Length = 0.06, mass: Mass = 0.5, friction: float = 0.6, rgba: Colour = (0.30, 0.55, 0.35, 1.0),
) -> Thing:  # fmt: skip
    """Make a bottle: a cylinder with a thinner one, the neck, on top. ``height`` is the lower cylinder's, ``neck`` the
    neck's radius.

    Args:
        radius, height: of the body.
        neck: radius of the neck.
    """
    body = Geom("cylinder", (radius, height / 2), rgba=rgba)
    top = Geom("cylinder", (neck, neck_height / 2), Pose((0, 0, (height + neck_height) / 2)), rgba=rgba)
    return Thing(name, "cram:Product", pose, (body, top), (_bottom(radius, height),), mass, friction)


def bowl(
    name: str, pose: Pose, radius: Length = 0.07, height: Length = 0.05, wall: Length = 0.006, mass: Mass = 0.3,
    friction: float = 0.6, grains: int = 0, grain_radius: Length = 0.005, grain_mass: Mass = 0.0006,
    rgba: Colour = (0.85, 0.82, 0.72, 1.0),
) -> Thing:  # fmt: skip
    """Make a bowl: a plate with an upright rim of boxes. ``radius`` is the rim's outer radius.

    Args:
        radius: outer.
        wall: thickness of rim and floor.
        grains: how many balls are loose in it at the start.
        grain_radius, grain_mass: of each.
    """
    geoms, features = _shell(radius, height, wall, rgba), (_bottom(radius, height), _cavity(radius, height, wall))
    filling = _filling(grains, grain_radius, grain_mass)
    return Thing(name, "soma:Bowl", pose, geoms, features, mass, friction, filling=filling)


def mug(
    name: str, pose: Pose, radius: Length = 0.042, height: Length = 0.095, wall: Length = 0.005,
    handle: Length = 0.032, mass: Mass = 0.3, friction: float = 0.6, rgba: Colour = (0.35, 0.45, 0.70, 1.0),
) -> Thing:  # fmt: skip
    """Make a hollow cylinder of boxes with a handle on +x. ``handle`` is how far it sticks out.

    Args:
        radius: outer.
        wall: thickness of wall and floor.
        handle: how far the handle sticks out.
    """
    grip = (0.006, 0.007, height * 0.35)
    arms = [
        Geom("box", (handle / 2, 0.007, 0.005), Pose((radius + handle / 2 - 0.004, 0, s * height * 0.3)), rgba=rgba)
        for s in (1, -1)
    ]
    bar = Geom("box", grip, Pose((radius + handle - 0.006, 0, 0)), rgba=rgba)
    geoms = (*_shell(radius, height, wall, rgba), *arms, bar)
    features = (_bottom(radius, height), _cavity(radius, height, wall))
    return Thing(name, "soma:Cup", pose, geoms, features, mass, friction)


def lid(
    name: str, pose: Pose, radius: Length = 0.075, thickness: Length = 0.006, knob: Length = 0.012, knob_height: Length = 0.045,
    mass: Mass = 0.2, friction: float = 0.6, rgba: Colour = (0.60, 0.62, 0.66, 1.0),
) -> Thing:  # fmt: skip
    """Make a round plate with a knob in its middle. Frame: the middle of the plate, z up. ``knob`` is the knob's radius.

    Args:
        radius, thickness: of the plate.
        knob: radius of the knob.
    """
    plate = Geom("cylinder", (radius, thickness / 2), rgba=rgba)
    grip = Geom("cylinder", (knob, knob_height / 2), Pose((0, 0, (thickness + knob_height) / 2)), rgba=rgba)
    return Thing(name, "soma:Lid", pose, (plate, grip), (_bottom(radius, thickness),), mass, friction)


def jug(
    name: str, pose: Pose, radius: Length = 0.035, height: Length = 0.10, wall: Length = 0.004,
    handle: Length = 0.055, bar: Length = 0.02, mass: Mass = 0.25, friction: float = 0.6, grains: int = 0,
    grain_radius: Length = 0.005, grain_mass: Mass = 0.0006, rgba: Colour = (0.45, 0.60, 0.62, 1.0),
) -> Thing:  # fmt: skip
    """Make a hollow cylinder of boxes with a handle on +x that a gripper's fingers fit behind.

    Args:
        radius: outer.
        wall: thickness of wall and floor.
        handle: how far the handle sticks out.
        bar: thickness of its upright part.
        mass: without the balls.
        grains: how many balls are loose in it at the start.
        grain_radius, grain_mass: of each.
    """
    out = radius + handle
    arms = [
        Geom("box", (handle / 2, bar / 2, 0.004), Pose((radius + handle / 2 - wall, 0, s * height * 0.42)), "handle", rgba=rgba)
        for s in (1, -1)
    ]
    upright = Geom("box", (bar / 2, bar / 2, height * 0.42), Pose((out - bar / 2, 0, 0)), rgba=rgba)
    grip = Pose.from_axes((out - bar / 2, 0, 0), (1, 0, 0), (0, 0, 1))
    features = (
        _bottom(radius, height), _cavity(radius, height, wall),
        Feature("handle", "cram:Handle", grip, {"width": bar, "length": height * 0.84}),
    )  # fmt: skip
    geoms, filling = (*_shell(radius, height, wall, rgba), *arms, upright), _filling(grains, grain_radius, grain_mass)
    return Thing(name, "cram:Jug", pose, geoms, features, mass, friction, filling=filling)


def _shell(radius: float, height: float, wall: float, rgba: Colour) -> tuple[Geom, ...]:
    """Return the geoms of a round vessel: a floor, and boxes as its wall, which overlap at their edges
    without a gap."""
    floor = Geom("cylinder", (radius - wall / 2, wall / 2), Pose((0, 0, (wall - height) / 2)), rgba=rgba)
    middle = radius - wall / 2
    half = (wall / 2, (middle + wall / 2) * math.tan(math.pi / SIDES), height / 2)
    sides = []
    for k in range(SIDES):
        angle = math.tau * k / SIDES
        turn = Pose((0, 0, 0), (math.cos(angle / 2), 0, 0, math.sin(angle / 2)))
        sides.append(Geom("box", half, turn * Pose((middle, 0, 0)), rgba=rgba))
    return (floor, *sides)


def _cavity(radius: float, height: float, wall: float) -> Feature:
    inner = radius - wall
    size = {"radius": inner, "width": 2 * inner, "depth": 2 * inner, "height": height - wall}
    return Feature("cavity", "cram:Cavity", Pose((0, 0, height / 2)), size)


def _filling(count: int, radius: float, mass: float) -> Filling | None:
    return Filling(count, radius, mass) if count else None


def _bottom(radius: float, height: float) -> Feature:
    face = Pose.from_axes((0, 0, -height / 2), (0, 0, -1), (1, 0, 0))
    return Feature("bottom", "vrps:SurfaceFeature", face, {"width": 2 * radius, "depth": 2 * radius})
