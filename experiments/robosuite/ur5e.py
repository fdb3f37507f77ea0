"""The UR5e of robosuite 1.5 as a robot of cramlite, a plugin file.

Kinematics and joint ranges: robosuite 1.5.2, models/assets/robots/ur5e/robot.xml, whose base is turned by 180 deg against that of
Denavit and Hartenberg. Links and their masses are those of cramlite's UR5e (cramlite_plugins/robots/ur5e.py), which differ by up to
3 mm. Hand: models/assets/grippers/robotiq_gripper_85.xml: measured in its model, the open pads are 108 mm apart and the closed ones
13 mm, their middle is at 136 mm, their tips at 155 mm; the site that its controller moves is at 145 mm. It is modelled as cramlite's
Robotiq 2F-85, whose pads do not tilt, with the lower 20 mm of its pads, so that their middle is at that site.
"""

from __future__ import annotations

import math
from collections.abc import Iterable

from cramlite.model import Gripper, Pose, Robot, replace
from cramlite.plugin import hookimpl
from cramlite_plugins.robots.dh_arm import arm_mjcf
from cramlite_plugins.robots.parallel_gripper import Jaws, actuation_elements, finger
from cramlite_plugins.robots.ur5e import BASE, JOINTS, LIMITS, LINKS, UR5E

DH = (
    (0.0, 0.163, math.pi / 2), (-0.425, 0.0, 0.0), (-0.392, 0.0, 0.0), (0.0, 0.134, math.pi / 2), (0.0, 0.1, -math.pi / 2),
    (0.0, 0.098, 0.0),
)  # fmt: skip
PALM, TCP, CLOSED, OPEN = 0.0914, 0.145, 0.013, 0.105
JAWS = Jaws(
    stroke=OPEN, pad=(0.020, 0.020, 0.008), palm=PALM, tip=0.155, back=(0.011, 0.006), knuckle=(0.0135, 0.013, 0.014), mass=0.03,
    centre=0.12, force=50.0,
)  # fmt: skip
POSTURE = (-0.47, -1.735, 2.48, -2.275, -1.59, -1.991)
"""Joint positions to which robosuite's resets bring the arm, but for noise [rad]: models/robots/manipulators/ur5e_robot.py. Its controller
leads the tool, so that the arm keeps shoulder, elbow and wrist on the sides where they are here."""
MASS = 0.158
"""Mass of the hand and its fingers [kg]."""
HAND = Gripper(
    type="robosuite_robotiq_85", opening=(CLOSED, OPEN), pad=JAWS.pad[:2], depth=TCP - PALM, mass=MASS,
    tcp=Pose((0.0, 0.0, TCP)), force=(20.0, 60.0), speed=(0.02, 0.15),
)  # fmt: skip


def gripper_mjcf(wrist: str) -> tuple[str, str]:
    """Write the hand as MJCF text: the body to put on the flange, and the elements that go outside of
    worldbody, such as actuators."""
    body = (
        f'<body name="gripper" gravcomp="1"><site name="ft"/><site name="tcp" pos="0 0 {TCP}"/>'
        f'<inertial pos="0 0 0.04" mass="{MASS - 2 * JAWS.mass}" diaginertia="0.0002 0.0002 0.0002"/>'
        f'<geom name="gripper/0" type="box" pos="0 0 {PALM / 2}" size="0.0375 0.0438 {PALM / 2}" rgba=".16 .16 .18 1"/>'
        f"{finger(JAWS, 'left', 1)}{finger(JAWS, 'right', -1)}</body>"
    )
    return body, actuation_elements(JAWS, wrist)


def mjcf() -> str:
    """Write the arm and its hand as MJCF text."""
    return arm_mjcf("robosuite_ur5e", DH, LINKS, JOINTS, LIMITS, BASE, gripper_mjcf(LINKS[-1].name))


@hookimpl
def robots() -> Iterable[Robot]:
    """Declare the UR5e of robosuite as a type of robot."""
    return [replace(UR5E, type="robosuite_ur5e", dh=DH, gripper=HAND, mjcf=mjcf, backend="stream", controller="", posture=POSTURE)]
