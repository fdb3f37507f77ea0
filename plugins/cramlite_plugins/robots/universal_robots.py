"""Arms of Universal Robots: their common part, from the published data of each (``ur_arms``).

All are six joints in the same order: turn, two links, and a wrist of three axes that meet in pairs. They differ in lengths, masses,
torques and speeds. Shapes are drawn from the lengths by the proportions of the UR5e's drawing (``ur5e``), which were
measured; radii of joints are ours, to 10 mm. ``ur5`` and ``ur5e`` have shapes measured on their own drawings.

Servo gains are ours: shoulder and elbow are as stiff against the arm's inertia as the UR5e's, so that all follow a path with the
same relative error; none is softer than the UR5e's.
"""

from __future__ import annotations

import math

from cramlite.model import Gripper, Robot, SensorErrors, Value

from .axia80 import ERRORS, HEIGHT, MASS, with_sensor
from .dh_arm import Cylinder, DhRow, Link, arm_mjcf
from .robotiq_2f85 import GRIPPER, gripper_mjcf
from .ur5e import BLUE, JOINTS, LIMITS

Triple = tuple[float, float, float]
Six = tuple[float, float, float, float, float, float]
NAMES = ("shoulder_link", "upper_arm_link", "forearm_link", "wrist_1_link", "wrist_2_link", "wrist_3_link")
GAP = 0.001  # between the shapes of neighbours that turn on a common plane [m]
UR5E_INERTIA = 17.7 * 0.85**2  # mass times reach squared [kg m2], for servo gains
WRIST = (28.0, 500.0)  # torque [Nm] and gain [Nm/rad] of a UR5e's wrist joint


class UrArm(Value):
    """Published data of an arm of Universal Robots.

    Args:
        type, controller: as in ``Robot``.
        lengths: d1, a2, a3, d4, d5, d6 of the Denavit-Hartenberg table [m].
        offsets: of upper arm and forearm along the axis of joint 2 [m]: they run side by side.
        radii: of the base's foot, and of the joints at shoulder, elbow and wrist [m].
        masses: of the links [kg].
        centres: centre of mass of each link in its Denavit-Hartenberg frame [m].
        inertia: (ixx, iyy, izz, ixy, ixz, iyz) of each link about its centre of mass, axes of that frame [kg m2].
        torques: of joints 1 and 2, of the elbow, and of the wrist [Nm].
        speeds: of the same joints [deg/s].
        payload: [kg]; reach: [m].
        home: as in ``Robot``.
        precision: of the force sensor in the flange [N]; None for a controller that has no sensor there.
    """

    type: str
    controller: str
    lengths: Six
    offsets: tuple[float, float]
    radii: tuple[float, float, float, float]
    masses: Six
    centres: tuple[Triple, ...]
    inertia: tuple[Six, ...]
    torques: Triple
    speeds: Triple
    payload: float
    reach: float
    home: Six
    precision: float | None


def rows(lengths: Six) -> tuple[DhRow, ...]:
    """Return the standard Denavit-Hartenberg table (a, d, alpha) of an arm with these lengths [m, rad]."""
    d1, a2, a3, d4, d5, d6 = lengths
    quarter = math.pi / 2
    return ((0.0, d1, quarter), (a2, 0.0, 0.0), (a3, 0.0, 0.0), (0.0, d4, quarter), (0.0, d5, -quarter), (0.0, d6, 0.0))


def robot(arm: UrArm) -> Robot:
    """Build the robot: the arm with a 2F-85, behind an Axia80 where the arm has no force sensor of its own."""
    return Robot(
        type=arm.type,
        joints=JOINTS,
        dh=rows(arm.lengths),
        limits=LIMITS,
        velocity=tuple(math.radians(v) for v in _each(arm.speeds)),
        acceleration=(5.0,) * 6,
        home=arm.home,
        reach=arm.reach,
        payload=arm.payload,
        gripper=_gripper(arm),
        sensor="axia80" if arm.precision is None else "flange",
        sensor_errors=ERRORS if arm.precision is None else SensorErrors(precision=arm.precision),
        backend="urscript",
        mjcf=lambda: mjcf(arm),
        controller=arm.controller,
    )


def mjcf(arm: UrArm) -> str:
    """Write the arm with its gripper as MJCF text, and with a wrist sensor if the arm has none built in."""
    sensor = (HEIGHT, MASS) if arm.precision is None else (0.0, 0.0)
    tool = gripper_mjcf(NAMES[-1], *sensor)
    return arm_mjcf(arm.type, rows(arm.lengths), links(arm), JOINTS, LIMITS, _foot(arm), tool)


def links(arm: UrArm) -> tuple[Link, ...]:
    """Return the six moving links of a Universal Robots arm with masses, servos and shapes."""
    shapes = (_shoulder(arm), _upper_arm(arm), _forearm(arm), _wrist_1(arm), _wrist_2(arm), _wrist_3(arm))
    stiffer = max(1.0, sum(arm.masses) * arm.reach**2 / UR5E_INERTIA)
    gains = _each((2000.0 * stiffer, 2000.0 * stiffer, WRIST[1] * max(1.0, arm.torques[2] / WRIST[0])))
    return tuple(
        Link(*data)
        for data in zip(NAMES, arm.masses, arm.centres, arm.inertia, _each(arm.torques), gains, shapes, strict=True)
    )


def _each(values: Triple) -> Six:
    """One value for each of the six joints, from a value for joints 1 and 2, one for the elbow, and one
    for the three wrist joints."""
    turn, elbow, wrist = values
    return turn, turn, elbow, wrist, wrist, wrist


def _gripper(arm: UrArm) -> Gripper:
    return with_sensor(GRIPPER) if arm.precision is None else GRIPPER


def _foot(arm: UrArm) -> tuple[Cylinder, ...]:
    foot, shoulder, _, _ = arm.radii
    top = arm.lengths[0] - 1.3 * shoulder
    return Cylinder((0, 0, 0), (0, 0, 0.02), foot), Cylinder((0, 0, 0.02), (0, 0, top), max(shoulder, 0.8 * foot))


def _shoulder(arm: UrArm) -> tuple[Cylinder, ...]:
    radius, side = arm.radii[1], arm.offsets[0]
    return (
        Cylinder((0, 0, -1.25 * radius), (0, 0, 0.92 * radius), radius),
        Cylinder((0, 0, 0), (0, -(side - 1.1 * radius - GAP), 0), 0.97 * radius, BLUE),
    )


def _upper_arm(arm: UrArm) -> tuple[Cylinder, ...]:
    (_, shoulder, elbow, _), (side, _), length = arm.radii, arm.offsets, arm.lengths[1]
    return (
        Cylinder((0, 0, side - 1.1 * shoulder), (0, 0, side + 0.95 * shoulder), 0.97 * shoulder, BLUE),
        Cylinder((0, 0, side), (length, 0, side), 0.83 * shoulder),
        Cylinder((length, 0, _between(arm) + GAP), (length, 0, side + 0.95 * elbow), elbow, BLUE),
    )


def _forearm(arm: UrArm) -> tuple[Cylinder, ...]:
    (_, _, elbow, wrist), (_, side), length = arm.radii, arm.offsets, arm.lengths[2]
    return (
        Cylinder((0, 0, side - 0.98 * elbow), (0, 0, _between(arm)), elbow),
        Cylinder((0, 0, side), (length, 0, side), wrist),
        Cylinder((length, 0, side - wrist), (length, 0, side + 1.1 * wrist), wrist, BLUE),
    )


def _between(arm: UrArm) -> float:
    """Joint between upper arm and forearm, along the axis of the elbow."""
    return sum(arm.offsets) / 2


def _wrist_1(arm: UrArm) -> tuple[Cylinder, ...]:
    wrist, side, (_, _, _, d4, d5, _) = arm.radii[3], arm.offsets[1], arm.lengths
    start = side + 1.1 * wrist + GAP - d4
    return (
        Cylinder((0, 0, start), (0, 0, 1.1 * wrist), wrist),
        Cylinder((0, 0, 0), (0, -(d5 - 1.1 * wrist - GAP), 0), wrist, BLUE),
    )


def _wrist_2(arm: UrArm) -> tuple[Cylinder, ...]:
    wrist = arm.radii[3]
    end = 0.62 * arm.lengths[5] - GAP
    return Cylinder((0, 0, -1.1 * wrist), (0, 0, 1.1 * wrist), wrist), Cylinder((0, 0, 0), (0, end, 0), wrist, BLUE)


def _wrist_3(arm: UrArm) -> tuple[Cylinder, ...]:
    return (Cylinder((0, 0, -0.38 * arm.lengths[5]), (0, 0, 0), 0.9 * arm.radii[3]),)
