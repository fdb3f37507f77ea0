"""Franka Emika Panda with the Franka Hand: a plugin file.

Joint limits, speeds and accelerations: Panda data sheet, version 1.1. Kinematics and hand are the FR3's; masses and shapes of the links
are taken from it, for the data sheet has none.
"""

from __future__ import annotations

from collections.abc import Iterable

from cramlite.model import Robot, replace
from cramlite.plugin import hookimpl
from cramlite_plugins.robots import franka_hand
from cramlite_plugins.robots.dh_arm import arm_mjcf
from cramlite_plugins.robots.fr3 import APART, BASE, DH, FR3, JOINTS, LINKS

LIMITS = (
    (-2.8973, 2.8973), (-1.7628, 1.7628), (-2.8973, 2.8973), (-3.0718, -0.0698),
    (-2.8973, 2.8973), (-0.0175, 3.7525), (-2.8973, 2.8973),
)  # fmt: skip


def mjcf() -> str:
    """Write the arm and its hand as MJCF text."""
    return arm_mjcf("panda", DH, LINKS, JOINTS, LIMITS, BASE, franka_hand.gripper_mjcf(LINKS[-1].name), APART)


PANDA = replace(
    FR3, type="panda", limits=LIMITS, mjcf=mjcf,
    velocity=(2.175, 2.175, 2.175, 2.175, 2.61, 2.61, 2.61), acceleration=(15.0, 7.5, 10.0, 12.5, 15.0, 20.0, 20.0),
)  # fmt: skip


@hookimpl
def robots() -> Iterable[Robot]:
    """Declare the Panda as a type of robot."""
    return [PANDA]
