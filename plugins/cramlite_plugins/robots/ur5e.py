"""Universal Robots UR5e with a Robotiq 2F-85.

Denavit-Hartenberg parameters, masses and centres of mass: Universal Robots, "DH parameters for calculations
of kinematics and dynamics". Inertia tensors: UniversalRobots/Universal_Robots_ROS2_Description,
config/ur5e/physical_parameters.yaml. Joint limits, 180 deg/s and 150/28 Nm: UR5e data sheet; acceleration:
the 5 rad/s2 of the manufacturer's MoveIt configuration. Radii of the links: measured on the UR5e drawing, to 5 mm.
"""

from __future__ import annotations

import math

from cramlite.model import Robot

from .dh_arm import Cylinder, DhRow, Link, arm_mjcf
from .robotiq_2f85 import GRIPPER, gripper_mjcf

JOINTS = ("shoulder_pan", "shoulder_lift", "elbow", "wrist_1", "wrist_2", "wrist_3")
DH: tuple[DhRow, ...] = (
    (0.0, 0.1625, math.pi / 2),
    (-0.425, 0.0, 0.0),
    (-0.3922, 0.0, 0.0),
    (0.0, 0.1333, math.pi / 2),
    (0.0, 0.0997, -math.pi / 2),
    (0.0, 0.0996, 0.0),
)
LIMITS = tuple((-limit, limit) for limit in (math.tau, math.tau, math.pi, math.tau, math.tau, math.tau))
BLUE = "0.42 0.63 0.80 1"
BASE = (Cylinder((0, 0, 0), (0, 0, 0.085), 0.075),)

LINKS = (
    Link(
        "shoulder_link", 3.761, (0.0, -0.02561, 0.00193),
        (0.00700210, 0.00648091, 0.00657286, 0.00000073, -0.00001053, 0.00049994), 150.0, 2000.0,
        (Cylinder((0, 0, -0.075), (0, 0, 0.055), 0.06), Cylinder((0, 0, 0), (0, -0.07, 0), 0.058, BLUE)),
    ),
    Link(
        "upper_arm_link", 8.058, (0.2125, 0.0, 0.11336),
        (0.01505885, 0.33388086, 0.33247207, -0.00005400, 0.00000563, -0.00000181), 150.0, 2000.0,
        (
            Cylinder((0, 0, 0.072), (0, 0, 0.195), 0.058, BLUE),
            Cylinder((0, 0, 0.138), (-0.425, 0, 0.138), 0.05),
            Cylinder((-0.425, 0, 0.076), (-0.425, 0, 0.188), 0.053, BLUE),
        ),
    ),
    Link(
        "forearm_link", 2.846, (0.15, 0.0, 0.0265),
        (0.00399632, 0.07879254, 0.07848510, -0.00001365, 0.00137272, -0.00000660), 150.0, 2000.0,
        (
            Cylinder((0, 0, -0.045), (0, 0, 0.075), 0.053),
            Cylinder((0, 0, 0.007), (-0.3922, 0, 0.007), 0.042),
            Cylinder((-0.3922, 0, -0.035), (-0.3922, 0, 0.055), 0.042, BLUE),
        ),
    ),
    Link(
        "wrist_1_link", 1.37, (0.0, -0.0018, 0.01634),
        (0.00165491, 0.00135962, 0.00126279, -0.00000282, -0.00000438, 0.00010157), 28.0, 500.0,
        (Cylinder((0, 0, -0.078), (0, 0, 0.045), 0.042), Cylinder((0, 0, 0), (0, -0.055, 0), 0.042, BLUE)),
    ),
    Link(
        "wrist_2_link", 1.3, (0.0, 0.0018, 0.01634),
        (0.00135617, 0.00127827, 0.00096614, -0.00000274, 0.00000444, -0.00005048), 28.0, 500.0,
        (Cylinder((0, 0, -0.045), (0, 0, 0.045), 0.042), Cylinder((0, 0, 0), (0, 0.06, 0), 0.042, BLUE)),
    ),
    Link(
        "wrist_3_link", 0.365, (0.0, 0.0, -0.001159),
        (0.00018694, 0.00018908, 0.00025756, 0.00000006, -0.00000017, -0.00000092), 28.0, 500.0,
        (Cylinder((0, 0, -0.038), (0, 0, 0), 0.0375),),
    ),
)  # fmt: skip


def mjcf(carrier: tuple[str, str, str] = ("", "", "")) -> str:
    """Write the arm and its gripper as MJCF text; ``carrier`` are the MJCF elements of a platform under the arm."""
    tool = gripper_mjcf(LINKS[-1].name)
    return arm_mjcf("ur5e", DH, LINKS, JOINTS, LIMITS, BASE, tool, carrier=carrier)


UR5E = Robot(
    type="ur5e",
    joints=JOINTS,
    dh=DH,
    limits=LIMITS,
    velocity=(math.pi,) * 6,
    acceleration=(5.0,) * 6,
    home=(2.8186, -1.7747, 1.5780, -1.3741, -1.5708, 1.2478),  # tool 0.4 m above the table, pointing down
    reach=0.85,
    payload=5.0,
    gripper=GRIPPER,
    sensor="flange",
    backend="urscript",
    mjcf=mjcf,
    controller="e-Series",
)
