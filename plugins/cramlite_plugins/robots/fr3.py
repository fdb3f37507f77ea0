"""Franka Research 3: seven axes, with a Franka Hand or a Robotiq 2F-85.

Kinematics: the Denavit-Hartenberg parameters of "Robot and interface specifications" (frankaemika.github.io/docs/
control_parameters.html), which are of the modified kind (Craig), Rx(alpha_i-1) Tx(a_i-1) Rz(q) Tz(d). As Rx and Tx commute
and the first row has neither, the same product read with the bars shifted by one is a standard table: row i has d_i, and
a and alpha of modified row i + 1. The flange's 107 mm are the last row's.

Joint limits, speeds and torques: frankaemika/franka_description, robots/fr3/joint_limits.yaml, the FR3's data sheet values;
near the ends of a joint's range a real one allows less speed. Acceleration 10 rad/s2: libfranka, rate_limiting.h. Masses and
inertia: robots/fr3/inertials.yaml. Reach 855 mm and 3 kg: FR3 data sheet. Shapes: the capsules of robots/common/
franka_arm.xacro as cylinders, longer than their straight parts by half a radius and more.

What is modelled of its sense of force: a six-axis sensor in the flange, as for the other arms. The real arm has none; it
estimates the wrench at the flange from torque sensors in its joints, which is less exact near singularities.
"""

from __future__ import annotations

import math
from itertools import pairwise

from msgspec.structs import replace

from cramlite.model import Robot, SensorErrors

from . import franka_hand, robotiq_2f85
from .dh_arm import Cylinder, DhRow, Link, arm_mjcf

JOINTS = tuple(f"joint{i}" for i in range(1, 8))
FLANGE = 0.107
MODIFIED: tuple[DhRow, ...] = (
    (0.0, 0.333, 0.0),
    (0.0, 0.0, -math.pi / 2),
    (0.0, 0.316, math.pi / 2),
    (0.0825, 0.0, math.pi / 2),
    (-0.0825, 0.384, -math.pi / 2),
    (0.0, 0.0, math.pi / 2),
    (0.088, 0.0, math.pi / 2),
    (0.0, FLANGE, 0.0),  # the flange
)


def standard(modified: tuple[DhRow, ...]) -> tuple[DhRow, ...]:
    """Convert modified Denavit-Hartenberg rows (a_i-1, d_i, alpha_i-1), the flange last, to a standard table.

    Raises:
        ValueError: the first row turns or shifts, which a standard table cannot say; or the flange does.
    """
    if modified[0][::2] != (0.0, 0.0) or modified[-1][::2] != (0.0, 0.0):
        raise ValueError("the first row and the flange of a modified Denavit-Hartenberg table must have a = alpha = 0")
    rows = [(after[0], row[1], after[2]) for row, after in pairwise(modified[:-1])]
    return (*rows, (0.0, modified[-2][1] + modified[-1][1], 0.0))


DH = standard(MODIFIED)
LIMITS = (
    (-2.7437, 2.7437), (-1.7837, 1.7837), (-2.9007, 2.9007), (-3.0421, -0.1518), (-2.8065, 2.8065), (0.5445, 4.5169),
    (-3.0159, 3.0159),
)  # fmt: skip
GREY = "0.55 0.57 0.60 1"
BASE = (Cylinder((0, 0, 0), (0, 0, 0.14), 0.07), Cylinder((-0.135, 0, 0.06), (0, 0, 0.06), 0.06))
SIDE = math.sqrt(0.5)  # the bump on the last link points between x and y of the flange

LINKS = (
    Link(
        "link1", 2.9274653454, (0.0000004128, -0.0181251324, -0.0386035970),
        (0.023927316485, 0.022482161328, 0.006350098259, 0.000013317903, -0.000114047749, -0.001995032063),
        87.0, 2000.0, (Cylinder((0, 0, -0.19), (0, 0, 0), 0.06),), own=True,
    ),
    Link(
        "link2", 2.9355370338, (0.0031828864, -0.0743221644, 0.0088146084),
        (0.041938946257, 0.025145148850, 0.061702144729, 0.000202573315, 0.004077784227, -0.004225215801),
        87.0, 2000.0, (Cylinder((0, 0, -0.10), (0, 0, 0.10), 0.06, GREY),), own=True,
    ),
    Link(
        "link3", 2.2449013699, (0.0407015686, -0.0048200565, -0.0289730823),
        (0.024101425472, 0.019740532667, 0.019044494482, 0.002404694559, -0.002856269270, -0.002104212684),
        87.0, 2000.0, (Cylinder((0, 0, -0.25), (0, 0, -0.04), 0.06),), own=True,
    ),
    Link(
        "link4", 2.6155955791, (-0.0459100965, 0.0630492960, -0.0085187868),
        (0.034529983219, 0.028881621933, 0.041254711711, 0.013225522660, 0.010151429985, -0.000976283387),
        87.0, 2000.0, (Cylinder((0, 0, -0.10), (0, 0, 0.10), 0.06, GREY),), own=True,
    ),
    Link(
        "link5", 2.3271207594, (-0.0016039605, 0.0292536262, -0.0972965990),
        (0.051610278464, 0.047877297134, 0.016423625579, -0.005715173388, -0.003567316763, 0.010673985109),
        12.0, 500.0,
        (Cylinder((0, 0, -0.34), (0, 0, -0.18), 0.06), Cylinder((0, 0.08, -0.215), (0, 0.08, -0.045), 0.025)), own=True,
    ),
    Link(
        "link6", 1.8170376524, (0.0597131221, -0.0410294666, -0.0101692726),
        (0.005412333594, 0.014058329546, 0.016080817924, 0.006193456360, 0.001421928931, -0.001314075374),
        12.0, 500.0, (Cylinder((0, 0, -0.09), (0, 0, 0.04), 0.05, GREY),), own=True,
    ),
    Link(
        "link7", 0.6271432862, (0.0045225817, 0.0086261921, -0.0161633251 - FLANGE),
        (0.000210923891, 0.000177185680, 0.000059931906, -0.000024332991, 0.000045644804, 0.000087440702),
        12.0, 500.0,
        (
            Cylinder((0, 0, -0.19), (0, 0, 0), 0.04),
            Cylinder((0.03 * SIDE, 0.03 * SIDE, -0.025), (0.085 * SIDE, 0.085 * SIDE, -0.025), 0.03),
        ), own=True,
    ),
)  # fmt: skip


APART = (("link1", "link3"), ("link5", "link7"))


def mjcf() -> str:
    """Write the arm and its hand as MJCF text."""
    return arm_mjcf("fr3", DH, LINKS, JOINTS, LIMITS, BASE, franka_hand.gripper_mjcf(LINKS[-1].name), APART)


def mjcf_2f85() -> str:
    """Write the arm with a 2F-85 on its flange (ISO 9409-1-50, as the gripper's coupling) as MJCF text."""
    return arm_mjcf("fr3", DH, LINKS, JOINTS, LIMITS, BASE, robotiq_2f85.gripper_mjcf(LINKS[-1].name), APART)


FR3 = Robot(
    type="fr3",
    joints=JOINTS,
    dh=DH,
    limits=LIMITS,
    velocity=(2.62, 2.62, 2.62, 2.62, 5.26, 4.18, 5.26),
    acceleration=(10.0,) * 7,
    home=(0.0, -math.pi / 4, 0.0, -3 * math.pi / 4, 0.0, math.pi / 2, math.pi / 4),  # the manufacturer's ready posture
    reach=0.855,
    payload=3.0,
    gripper=franka_hand.FRANKA_HAND,
    sensor="flange",
    sensor_errors=SensorErrors(noise=0.1, precision=0.8, drift=0.005),  # accuracy of force: data sheet, not checked; the others are ours
    backend="typed_json",
    mjcf=mjcf,
)

FR3_2F85 = replace(
    FR3, type="fr3_2f85", gripper=robotiq_2f85.GRIPPER, mjcf=mjcf_2f85, home=(*FR3.home[:6], 0.0)
)  # the 2F-85 is not turned on the flange, so that its fingers are where the hand's are
