"""Universal Robots UR5 (CB3) with an ATI Axia80 force-torque sensor and a Robotiq 2F-85.

Denavit-Hartenberg parameters, masses and centres of mass: Universal Robots, "DH parameters for calculations
of kinematics and dynamics". Inertia: UniversalRobots/Universal_Robots_ROS2_Description,
config/ur5/physical_parameters.yaml (cylinders), turned into Denavit-Hartenberg axes. Joint range +-360 deg (elbow +-180
deg, as in the manufacturer's MoveIt configuration, so that a posture has one name), 180 deg/s, 850 mm, 5 kg: UR5 data
sheet; 150/28 Nm: UR, "Max. joint torques"; 5 rad/s2 as for the UR5e. Radii of the links: UR5 drawing, to 5 mm.
"""

from __future__ import annotations

import math

from cramlite.model import Robot

from .axia80 import ERRORS, HEIGHT, MASS, with_sensor
from .dh_arm import Cylinder, DhRow, Link, arm_mjcf
from .robotiq_2f85 import GRIPPER, gripper_mjcf
from .ur5e import BLUE, JOINTS, LIMITS

DH: tuple[DhRow, ...] = (
    (0.0, 0.089159, math.pi / 2),
    (-0.425, 0.0, 0.0),
    (-0.39225, 0.0, 0.0),
    (0.0, 0.10915, math.pi / 2),
    (0.0, 0.09465, -math.pi / 2),
    (0.0, 0.0823, 0.0),
)
BASE = (Cylinder((0, 0, 0), (0, 0, 0.02), 0.0745), Cylinder((0, 0, 0.02), (0, 0, 0.085), 0.06))

LINKS = (
    Link(
        "shoulder_link", 3.7, (0.0, -0.02561, 0.00193),
        (0.01497236, 0.01040625, 0.01497236, 0.0, 0.0, 0.0), 150.0, 2000.0,
        (Cylinder((0, 0, -0.004), (0, 0, 0.055), 0.06), Cylinder((0, 0, 0), (0, -0.07, 0), 0.058, BLUE)),
    ),
    Link(
        "upper_arm_link", 8.393, (0.2125, 0.0, 0.11336),
        (0.0151074, 0.13388584, 0.13388584, 0.0, 0.0, 0.0), 150.0, 2000.0,
        (
            Cylinder((0, 0, 0.072), (0, 0, 0.193), 0.058, BLUE),
            Cylinder((0, 0, 0.136), (-0.425, 0, 0.136), 0.05),
            Cylinder((-0.425, 0, 0.076), (-0.425, 0, 0.186), 0.053, BLUE),
        ),
    ),
    Link(
        "forearm_link", 2.33, (0.15, 0.0, 0.0265),
        (0.004095, 0.0312168, 0.0312168, 0.0, 0.0, 0.0), 150.0, 2000.0,
        (
            Cylinder((0, 0, -0.043), (0, 0, 0.073), 0.053),
            Cylinder((0, 0, 0.0165), (-0.39225, 0, 0.0165), 0.04),
            Cylinder((-0.39225, 0, -0.035), (-0.39225, 0, 0.052), 0.04, BLUE),
        ),
    ),
    Link(
        "wrist_1_link", 1.219, (0.0, -0.0018, 0.01634),
        (0.00201389, 0.0021942, 0.00201389, 0.0, 0.0, 0.0), 28.0, 500.0,
        (Cylinder((0, 0, -0.054), (0, 0, 0.043), 0.04), Cylinder((0, 0, 0), (0, -0.05, 0), 0.04, BLUE)),
    ),
    Link(
        "wrist_2_link", 1.219, (0.0, 0.0018, 0.01634),
        (0.00183104, 0.0021942, 0.00183104, 0.0, 0.0, 0.0), 28.0, 500.0,
        (Cylinder((0, 0, -0.043), (0, 0, 0.043), 0.04), Cylinder((0, 0, 0), (0, 0.045, 0), 0.04, BLUE)),
    ),
    Link(
        "wrist_3_link", 0.1879, (0.0, 0.0, -0.001159),
        (0.00008062, 0.00008062, 0.00013212, 0.0, 0.0, 0.0), 28.0, 500.0,
        (Cylinder((0, 0, -0.036), (0, 0, 0), 0.0375),),
    ),
)  # fmt: skip


def mjcf() -> str:
    """Write the arm, its sensor and its gripper as MJCF text."""
    tool = gripper_mjcf(LINKS[-1].name, HEIGHT, MASS)
    return arm_mjcf("ur5", DH, LINKS, JOINTS, LIMITS, BASE, tool)


UR5 = Robot(
    type="ur5",
    joints=JOINTS,
    dh=DH,
    limits=LIMITS,
    velocity=(math.pi,) * 6,
    acceleration=(5.0,) * 6,
    home=(2.8787, -1.69, 1.2913, -1.172, -1.5708, 1.3079),  # the tool where the UR5e has it
    reach=0.85,
    payload=5.0,
    gripper=with_sensor(GRIPPER),
    sensor="axia80",
    sensor_errors=ERRORS,
    backend="urscript",
    mjcf=mjcf,
    controller="CB3",
)
