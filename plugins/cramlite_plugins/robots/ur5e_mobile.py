"""A Universal Robots UR5e with a Robotiq 2F-85 on an omnidirectional platform, as IAI Bremen's Donbot is one.

The platform is a Neobotix MPO-500 with four mecanum wheels. Its documentation
(neobotix-docs.de, hardware, MPO-500, "Mechanical Properties") gives length 988 mm, width 662 mm, height of the mounting
plane 386 mm, 0.9 m/s, 2.4 m/s2, wheels of 254 mm, 500 mm apart along and 548 mm across; motors of 0.95 Nm rated torque
with gears of 25:1. So four wheels push with 4 * 0.95 * 25 / 0.127 = 748 N, and turn with 748 N * (0.25 + 0.274) m.
Its highest turn is 0.9 / (0.25 + 0.274) = 1.7 rad/s. Its mass is not published there; ours is 80 kg.

Three servos drive it: along x, along y and about z, with those forces. That is what the wheels' controller makes
of an omnidirectional base (the Donbot's own description has the same three joints, odom_x, odom_y and odom_z); single wheels, their
slip and an uneven floor are left out. It cannot tip: it has no other joint. Its skirt reaches down to 15 mm above the floor,
not to the real one's 45 mm, so that it bumps into whatever lies on the floor.

The arm is bolted to the front end of the inner profiles (680 mm long); where is ours. Parked it reaches back over the deck.
"""

from __future__ import annotations

import math

from msgspec.structs import replace

from cramlite.model import Platform, Pose

from .ur5e import UR5E
from .ur5e import mjcf as arm

LENGTH, WIDTH, HEIGHT, GROUND = 0.988, 0.662, 0.386, 0.015
MASS = 80.0
PUSH, LEVER = 748.0, 0.524  # [N], [m]
STIFF = (2.0e5, 2.0e5, 1.0e5)  # of the servos [N/m, Nm/rad]: 50 N at the tool move it by less than 1 mm
DAMP = (9.0e3, 9.0e3, 2.5e3)  # critical, for 105 kg and 16 kg m2

PLATFORM = Platform(
    body="platform",
    joints=("base_x", "base_y", "base_turn"),
    arm=Pose((0.25, 0.0, HEIGHT)),
    size=(LENGTH, WIDTH, HEIGHT),
    speed=(0.9, 1.7),
    acceleration=(2.4, 2.4 / LEVER),
)


def mjcf() -> str:
    """Write the platform, arm and gripper as MJCF text."""
    return arm(carrier=(_body(), "</frame></body>", _servos()))


def _body() -> str:
    x, y, z = PLATFORM.joints
    half, middle = (HEIGHT - GROUND) / 2, (HEIGHT + GROUND) / 2
    inertia = (WIDTH**2 + HEIGHT**2, LENGTH**2 + HEIGHT**2, LENGTH**2 + WIDTH**2)
    return (
        f'<body name="{PLATFORM.body}"><joint name="{x}" type="slide" axis="1 0 0"/>'
        f'<joint name="{y}" type="slide" axis="0 1 0"/><joint name="{z}" type="hinge" axis="0 0 1"/>'
        f'<inertial pos="0 0 {middle / 2}" mass="{MASS}" diaginertia="{" ".join(f"{MASS * i / 12:.9g}" for i in inertia)}"/>'
        f'<geom name="{PLATFORM.body}/0" type="box" pos="0 0 {middle}" size="{LENGTH / 2} {WIDTH / 2} {half}"'
        f' rgba="0.88 0.55 0.15 1" mass="0"/><frame pos="{" ".join(map(str, PLATFORM.arm.position))}">'
    )


def _servos() -> str:
    forces = (PUSH, PUSH, PUSH * LEVER)
    return "".join(
        f'<position name="{j}" joint="{j}" kp="{kp}" kv="{kv}" forcerange="{-f} {f}"/>'
        for j, kp, kv, f in zip(PLATFORM.joints, STIFF, DAMP, forces, strict=True)
    )


UR5E_MOBILE = replace(
    UR5E,
    type="ur5e_mobile",
    home=(UR5E.home[0] - math.pi, *UR5E.home[1:]),  # the tool over the deck
    backend="typed_json",  # URScript moves the arm, and cannot drive
    mjcf=mjcf,
    platform=PLATFORM,
)
