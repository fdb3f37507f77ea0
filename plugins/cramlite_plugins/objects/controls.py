"""Knobs and switches on a panel, which turn an appliance on and off, latches, which keep a door shut, and levers on doors.

All have the same frame: on the panel, x out of it, z up. At 0 they are off, or closed. Each is held by a grip that the fingers of a 2F-85
close around, and stays where it is left by the friction of its hinge; a lever is drawn back by a spring.
"""

from __future__ import annotations

from cramlite.model import Feature, Geom, Joint, Pose, Thing
from cramlite.plugin import Angle, Length, Mass

Colour = tuple[float, float, float, float]
THIN = 0.005  # half the thickness of a grip [m]
GAP = 0.002  # between what turns and its panel [m]
GRIP, HALF_GRIP = 0.035, 0.02  # how far the grip of a latch stands out of its bar, and half its length along that [m]
REACH = 0.045  # from the door to the lever of a door [m]: a finger goes behind it
PADS = 0.012  # from the outer end of a grip to the middle of the pads that hold it [m]


def knob(
    name: str,
    pose: Pose,
    parent: str = "",
    radius: Length = 0.022,
    depth: Length = 0.045,
    turn: Angle = 1.5,
    turned: Angle = 0.0,
    mass: Mass = 0.05,
    damping: float = 0.01,
    joint_friction: float = 0.03,
    friction: float = 0.8,
    rgba: Colour = (0.25, 0.25, 0.28, 1.0),
) -> Thing:
    """Make a knob that turns about x: a disc with a grip across it, upright when it is off. Feature "handle": on the grip, z out.

    Args:
        parent: the panel that it is mounted on, with which it does not collide.
        radius: of the disc.
        depth: from the panel to the end of the grip.
        turn: how far it can be turned.
        turned: how far it is turned at the start; at 0 it is off.
        damping: of its hinge, Nm s/rad.
        joint_friction: of its hinge, Nm.
    """
    disc = Geom("cylinder", (radius, 0.005), Pose.from_axes((GAP + 0.005, 0, 0), (1, 0, 0), (0, 0, 1)), rgba=rgba)
    grip = Geom("box", ((depth - GAP) / 2, THIN, radius * 0.9), Pose(((depth + GAP) / 2, 0, 0)), "handle", rgba=rgba)
    hinge = Joint(
        "hinge", Pose.from_axes((0, 0, 0), (1, 0, 0), (0, 0, 1)), 0.0, turn, turned, parent, damping, joint_friction
    )  # fmt: skip
    features = (_handle(Pose.from_axes((depth - PADS, 0, 0), (1, 0, 0), (0, 0, 1)), 1.8 * radius),)
    return Thing(name, "cram:Knob", hinge.moved(pose, turned), (disc, grip), features, mass, friction, joint=hinge)


def switch(
    name: str,
    pose: Pose,
    parent: str = "",
    length: Length = 0.07,
    turn: Angle = 0.8,
    turned: Angle = 0.0,
    mass: Mass = 0.05,
    damping: float = 0.01,
    joint_friction: float = 0.05,
    friction: float = 0.8,
    rgba: Colour = (0.75, 0.2, 0.15, 1.0),
) -> Thing:
    """Make a lever that turns about y, from below to above the level by the same angle. Feature "handle": at its end, z out.

    Args:
        parent: the panel that it is mounted on, with which it does not collide.
        length: of the lever.
        turn: how far it can be turned, the level in the middle.
        turned: how far it is turned at the start; at 0 it is off.
        damping: of its hinge, Nm s/rad.
        joint_friction: of its hinge, Nm.
    """
    down = Pose.from_rotvec((0, 0, 0), (0, turn / 2, 0))
    lever = Geom("box", (length / 2, THIN, THIN), down * Pose((length / 2 + GAP, 0, 0)), "handle", rgba=rgba)
    axis = Pose.from_axes((0, 0, 0), (0, -1, 0), (1, 0, 0))
    hinge = Joint("hinge", axis, 0.0, turn, turned, parent, damping, joint_friction)
    features = (_handle(down * Pose.from_axes((length - PADS, 0, 0), (1, 0, 0), (0, 0, 1)), 2 * THIN),)
    return Thing(name, "cram:Switch", hinge.moved(pose, turned), (lever,), features, mass, friction, joint=hinge)


def latch(
    name: str,
    pose: Pose,
    parent: str = "",
    length: Length = 0.05,
    stand_off: Length = 0.02,
    turn: Angle = 1.57,
    turned: Angle = 0.0,
    mass: Mass = 0.05,
    damping: float = 0.01,
    joint_friction: float = 0.05,
    friction: float = 0.8,
    rgba: Colour = (0.45, 0.40, 0.30, 1.0),
) -> Thing:
    """Make a door latch: a bar that turns about x, level towards +y to keep the door shut, upright to let it open.

    Feature "handle": on the grip, x along the level bar, z away from the door.

    Args:
        parent: the panel that it is mounted on, with which it does not collide.
        length: of the bar.
        stand_off: from the panel to the bar.
        turn: how far it can be turned.
        turned: how far it is turned at the start.
        damping: of its hinge, Nm s/rad.
        joint_friction: of its hinge, Nm.
    """
    outer = stand_off + 2 * THIN
    post = Geom("cylinder", (THIN, (outer - GAP) / 2), Pose.from_axes(((outer + GAP) / 2, 0, 0), (1, 0, 0), (0, 0, 1)), rgba=rgba)
    bar = Geom("box", (THIN, (length + THIN) / 2, THIN), Pose((stand_off + THIN, (length - THIN) / 2, 0)), rgba=rgba)
    grip = Geom("box", (GRIP / 2, HALF_GRIP, THIN), Pose((outer + GRIP / 2, 0, 0)), "handle", rgba=rgba)
    hinge = Joint(
        "hinge", Pose.from_axes((0, 0, 0), (1, 0, 0), (0, 0, 1)), 0.0, turn, turned, parent, damping, joint_friction
    )  # fmt: skip
    features = (_handle(Pose.from_axes((outer + GRIP - PADS, 0, 0), (1, 0, 0), (0, 1, 0)), 2 * HALF_GRIP),)
    return Thing(name, "cram:Latch", hinge.moved(pose, turned), (post, bar, grip), features, mass, friction, joint=hinge)


def lever(
    name: str,
    pose: Pose,
    parent: str = "",
    length: Length = 0.11,
    tongue: Length = 0.075,
    turn: Angle = 1.57,
    turned: Angle = 0.0,
    mass: Mass = 0.1,
    spring: float = 0.5,
    damping: float = 0.02,
    joint_friction: float = 0.05,
    friction: float = 0.8,
    rgba: Colour = (0.45, 0.40, 0.30, 1.0),
) -> Thing:
    """Make the lever of a door, which turns about x: level towards +y, its end downwards when it is turned. A tongue points the other way,
    to lie behind something that stands still. Feature "handle": on the lever, z out.

    Args:
        parent: the door that it is mounted on, with which it does not collide and along with which it moves.
        length: of the lever, from its axis.
        tongue: its length, from the axis.
        turn: how far it can be turned.
        turned: how far it is turned at the start.
        spring: stiffness of what draws it back, Nm/rad.
        damping: of its hinge, Nm s/rad.
        joint_friction: of its hinge, Nm.
    """
    post = Geom("cylinder", (0.01, (REACH - GAP) / 2), Pose.from_axes(((REACH + GAP) / 2, 0, 0), (1, 0, 0), (0, 0, 1)), rgba=rgba)
    bar = Geom("box", (THIN, length / 2, 0.01), Pose((REACH + THIN, length / 2, 0)), "handle", rgba=rgba)
    bolt = Geom("box", (THIN, tongue / 2, THIN), Pose((GAP + THIN, -tongue / 2, 0)), rgba=rgba)
    hinge = Joint(
        "hinge", Pose.from_axes((0, 0, 0), (-1, 0, 0), (0, 0, 1)), 0.0, turn, turned, parent, damping, joint_friction, spring=spring
    )  # fmt: skip
    at = Pose.from_axes((REACH + THIN, 0.6 * length, 0), (1, 0, 0), (0, 1, 0))
    handle = Feature("handle", "cram:Handle", at, {"radius": 0.01, "length": length})
    return Thing(name, "cram:Latch", hinge.moved(pose, turned), (post, bar, bolt), (handle,), mass, friction, joint=hinge)


def _handle(at: Pose, length: float) -> Feature:
    return Feature("handle", "cram:Handle", at, {"radius": THIN, "length": length})
