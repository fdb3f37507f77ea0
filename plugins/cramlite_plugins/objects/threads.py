"""Jars and the lids that are screwed onto them."""

from __future__ import annotations

import math

from cramlite.model import Feature, Geom, Joint, Pose, Thing
from cramlite.plugin import Length, Mass

Colour = tuple[float, float, float, float]
THIN = 0.005  # half the thickness of a grip [m]
GRIP, PADS = 0.035, 0.012  # height of a grip, and from its upper end to the middle of the pads that hold it [m]


def jar(
    name: str, pose: Pose, radius: Length = 0.034, height: Length = 0.09, friction: float = 0.6, rgba: Colour = (0.75, 0.82, 0.80, 1.0),
) -> Thing:  # fmt: skip
    """Make a jar that is fixed where it stands, as in a holder. Frame: the middle of its rim, z up.

    Args:
        radius, height: of the whole.
    """
    body = Geom("cylinder", (radius, height / 2), Pose((0, 0, -height / 2)), rgba=rgba)
    return Thing(name, "cram:Jar", pose, (body,), (), None, friction)


def screw_lid(
    name: str, pose: Pose, parent: str = "", radius: Length = 0.036, thickness: Length = 0.014, pitch: Length = 0.004,
    turns: float = 4.5, turned: float = 0.0, mass: Mass = 0.06, damping: float = 0.01, joint_friction: float = 0.1, friction: float = 0.8,
    rgba: Colour = (0.70, 0.35, 0.20, 1.0),
) -> Thing:  # fmt: skip
    """Make a lid on a right-hand thread, with a bar across it to turn it by. Frame: its jar's when the lid is shut.
    Feature "handle": on the bar along x, z up.

    Args:
        parent: the jar, with which it does not collide.
        radius, thickness: of the disc.
        pitch: how far it rises in one turn.
        turns: how many turns the thread has.
        turned: how many turns it is open at the start; at 0 it is shut.
        damping: of its thread, Nm s/rad.
        joint_friction: of its thread, Nm.
    """
    disc = Geom("cylinder", (radius, thickness / 2), Pose((0, 0, thickness / 2)), rgba=rgba)
    grip = Geom("box", (0.9 * radius, THIN, GRIP / 2), Pose((0, 0, thickness + GRIP / 2)), "handle", rgba=rgba)
    value = math.tau * turned
    thread = Joint("hinge", Pose(), 0.0, math.tau * turns, value, parent, damping, joint_friction, pitch=pitch)
    handle = Feature("handle", "cram:Handle", Pose((0, 0, thickness + GRIP - PADS)), {"radius": THIN, "length": 1.8 * radius})
    return Thing(name, "soma:Lid", thread.moved(pose, value), (disc, grip), (handle,), mass, friction, joint=thread)
