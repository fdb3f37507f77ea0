"""ABB IRB 1200-5/0.9 with an ATI Axia80 force-torque sensor and a Robotiq 2F-85.

Dimensions 399, 448, 42, 451 and 82 mm, the Denavit-Hartenberg angles and the axes' zero positions: the model of the IRB 1200 in
ARTE (A. Gil, robots/ABB/IRB1200/parameters.m) and robotkinematicscatalogue (ABB_IRB_1200_5_09), which agree; the same two
give the ranges. 5 kg, 901 mm, 54 kg and the axes' speeds: ABB, IRB 1200 data sheet. Link masses, centres of mass, torques and
accelerations are not published: the data sheet's mass is divided by the links' lengths, 5 rad/s2 as for the UR arms; they
shape the simulated motion, not the program. Radii of the links: data sheet's drawing, to 10 mm.

A joint position here is an angle of the Denavit-Hartenberg table; ABB's axis angle is it minus ``AXIS_ZEROS``.
"""

from __future__ import annotations

import math

from cramlite.model import Robot

from .axia80 import ERRORS, HEIGHT, MASS, with_sensor
from .dh_arm import Cylinder, DhRow, Link, arm_mjcf
from .robotiq_2f85 import GRIPPER, gripper_mjcf

JOINTS = tuple(f"axis_{i}" for i in range(1, 7))
DH: tuple[DhRow, ...] = (
    (0.0, 0.3991, -math.pi / 2),
    (0.448, 0.0, 0.0),
    (0.042, 0.0, -math.pi / 2),
    (0.0, 0.451, math.pi / 2),
    (0.0, 0.0, -math.pi / 2),
    (0.0, 0.082, 0.0),
)
AXIS_ZEROS = (0.0, -math.pi / 2, 0.0, 0.0, 0.0, math.pi)
"""Joint angles of the Denavit-Hartenberg table at which ABB's axis angles are zero [rad]."""
RANGES = ((-170, 170), (-100, 130), (-200, 70), (-270, 270), (-130, 130), (-360, 360))
LIMITS = tuple((math.radians(lo) + z, math.radians(hi) + z) for (lo, hi), z in zip(RANGES, AXIS_ZEROS, strict=True))
SPEEDS = tuple(math.radians(v) for v in (288, 240, 297, 400, 405, 600))
ORANGE = "0.95 0.45 0.1 1"
ROUND = (0.05, 0.05, 0.03, 0.0, 0.0, 0.0)

BASE = (Cylinder((0, 0, 0), (0, 0, 0.25), 0.1), Cylinder((-0.1, 0, 0.06), (0, 0, 0.06), 0.06))
LINKS = (
    Link("link_1", 12.0, (0.0, 0.02, 0.0), ROUND, 200.0, 4000.0,
         (Cylinder((0, 0, -0.14), (0, 0, 0.02), 0.09), Cylinder((0, -0.08, 0), (0, 0.08, 0), 0.075, ORANGE))),
    Link("link_2", 10.0, (-0.2, 0.0, 0.0), (0.03, 0.2, 0.2, 0.0, 0.0, 0.0), 200.0, 4000.0,
         (Cylinder((0, 0, 0), (0.448, 0, 0), 0.06), Cylinder((0.448, 0, -0.07), (0.448, 0, 0.07), 0.065, ORANGE))),
    Link("link_3", 8.0, (0.0, 0.0, 0.0), ROUND, 100.0, 3000.0,
         (Cylinder((0, 0, 0), (0.042, 0, 0), 0.06), Cylinder((0.042, -0.05, 0), (0.042, 0.12, 0), 0.055))),
    Link("link_4", 3.0, (0.0, 0.1, 0.0), (0.02, 0.005, 0.02, 0.0, 0.0, 0.0), 40.0, 800.0,
         (Cylinder((0, 0, -0.3), (0, 0, -0.05), 0.048),)),
    Link("link_5", 1.5, (0.0, 0.0, 0.0), (0.004, 0.004, 0.004, 0.0, 0.0, 0.0), 40.0, 800.0,
         (Cylinder((0, -0.04, 0), (0, 0.04, 0), 0.04, ORANGE),)),
    Link("link_6", 0.3, (0.0, 0.0, -0.02), (0.0005, 0.0005, 0.0005, 0.0, 0.0, 0.0), 30.0, 600.0,
         (Cylinder((0, 0, -0.03), (0, 0, 0), 0.035),)),
)  # fmt: skip


def mjcf() -> str:
    """Write the arm, its sensor and its gripper as MJCF text."""
    tool = gripper_mjcf(LINKS[-1].name, HEIGHT, MASS)
    apart = (("link_1", "link_3"), ("link_2", "link_4"), ("link_3", "link_5"), ("link_4", "link_6"))
    return arm_mjcf("irb1200", DH, LINKS, JOINTS, LIMITS, BASE, tool, apart)


IRB1200 = Robot(
    type="irb1200",
    joints=JOINTS,
    dh=DH,
    limits=LIMITS,
    velocity=SPEEDS,
    acceleration=(5.0,) * 6,
    home=(0.0, -1.5573, 0.4974, 0.0, 1.0598, 3.1416),  # the tool where the UR5e has it
    reach=0.901,
    payload=5.0,
    gripper=with_sensor(GRIPPER),
    sensor="axia80",
    sensor_errors=ERRORS,
    backend="rapid",
    mjcf=mjcf,
    axis_zeros=AXIS_ZEROS,
)
