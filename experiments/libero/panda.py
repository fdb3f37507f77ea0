"""The Panda of robosuite 1.4 as a robot of cramlite, a plugin file: what LIBERO's scenes are driven with.

Kinematics: links and joint ranges of robosuite 1.4, models/assets/robots/panda/robot.xml: the Franka Research 3's but for the flange
(106.5 mm) and the ranges. Speeds: Panda data sheet. Links and their masses are the FR3's (cramlite_plugins/robots/fr3.py), not those of
the Panda: the hulls of robosuite's meshes, with which MuJoCo collides, stick out of them by up to 40 mm (link 5; link 6 by 16 mm, roughly
measured in one posture). Hand: models/assets/grippers/panda_gripper.xml: fingers from 52.4 mm, pads of 16 x 16 x 8 mm whose middle is at
93.4 mm, tips at 106 mm, 20 N a finger; the site that its controller moves is at 97 mm. Its frame is that of
cramlite_plugins/robots/franka_hand.py.
"""

from __future__ import annotations

from collections.abc import Iterable

from msgspec.structs import replace

from cramlite.model import Pose, Robot
from cramlite.plugin import hookimpl
from cramlite_plugins.robots.dh_arm import arm_mjcf
from cramlite_plugins.robots.fr3 import APART, BASE, DH, FR3, JOINTS, LINKS
from cramlite_plugins.robots.franka_hand import HEIGHT, TURN
from cramlite_plugins.robots.parallel_gripper import Jaws, beside, finger

FLANGE, SITE = 0.1065, 0.097
ELBOW = 0.1
"""Kept from the elbow's stop [rad]: joints were seen as far as 0.13 rad from what POSTURE lets expect (10 % of 81 rests). Folded near
its base an arm that was planned without it ended at the stop, 21 mm from its tool pose."""
LIMITS = (
    (-2.8973, 2.8973), (-1.7628, 1.7628), (-2.8973, 2.8973), (-3.0718 + ELBOW, -0.0698),
    (-2.8973, 2.8973), (-0.0175, 3.7525), (-2.8973, 2.8973),
)  # fmt: skip
POSTURE = (0.0, -0.161, 0.0, -2.445, 0.0, 2.227, 0.785)
"""Where LIBERO's robot begins, but for 0.02 rad, and what OSC_POSE pulls the joints to: MountedPanda's init_qpos."""
CONDITIONING = 0.08
"""Kept from stretched postures and other singularities: the controller treats position and rotation of the tool apart, and comes
through the stretched elbow out on its other side, where it is stuck against its stop. Of the freeze's 83 programs 12 came
below 0.065 with the arm stretched: 11 of them did so, and none of the 70 that kept 0.09."""
TABLE = (*DH[:-1], (DH[-1][0], DH[-1][1] - 0.107 + FLANGE, DH[-1][2]))
JAWS = Jaws(
    stroke=0.080, pad=(0.016, 0.020, 0.008), palm=HEIGHT, tip=0.106, back=(0.0105, 0.004), knuckle=(0.0105, 0.0075, 0.004), mass=0.11,
    centre=0.10, force=20.0,
)  # fmt: skip
SPEED = 0.2
"""Of the pads towards each other [m/s]: PandaGripper moves the command of its fingers by 10 mm of opening an action at 20 Hz."""
MASS = 0.52
"""Of the hand and its fingers [kg]."""
SLICES = ((0.0, 0.022, 0.0316, 0.104), (0.022, 0.044, 0.0276, 0.1028), (0.044, 0.057, 0.0221, 0.1013), (0.057, HEIGHT, 0.0189, 0.1003))
"""The hand from the flange on: from where to where, half thickness and half width there [m]. Outline of the hull of robosuite's mesh,
meshes/panda_gripper/hand.stl, which gets thinner towards the fingers."""


def _slice(k: int) -> str:
    low, high, x, y = SLICES[k]
    size = f"{x} {y} {(high - low) / 2:.6g}"
    return f'<geom name="gripper/{k}" type="box" pos="0 0 {(low + high) / 2:.6g}" size="{size}" rgba=".9 .9 .9 1"/>'


def gripper_mjcf(wrist: str) -> tuple[str, str]:
    """Write the hand as MJCF text: (body element to put on the flange, elements beside worldbody)."""
    turn, back = (" ".join(f"{v:.9g}" for v in p.quaternion) for p in (TURN, TURN.inverse()))
    body = (
        f'<body name="gripper" quat="{turn}" gravcomp="1"><site name="ft" quat="{back}"/><site name="tcp" pos="0 0 {SITE}"/>'
        f'<inertial pos="0 0 0.05" mass="{MASS - 2 * JAWS.mass}" diaginertia="0.0005 0.0003 0.0005"/>'
        f"{''.join(_slice(k) for k in range(len(SLICES)))}"
        f"{finger(JAWS, 'left', 1)}{finger(JAWS, 'right', -1)}</body>"
    )
    return body, beside(JAWS, wrist)


def mjcf() -> str:
    """Write the arm and its hand as MJCF text."""
    return arm_mjcf("libero_panda", TABLE, LINKS, JOINTS, LIMITS, BASE, gripper_mjcf(LINKS[-1].name), APART)


HAND = replace(
    FR3.gripper, type="libero_panda_hand", pad=JAWS.pad[:2], depth=SITE - HEIGHT, mass=MASS, tcp=TURN * Pose((0.0, 0.0, SITE)),
    force=(5.0, 20.0), speed=(FR3.gripper.speed[0], SPEED),
)  # fmt: skip
PANDA = replace(
    FR3, type="libero_panda", dh=TABLE, limits=LIMITS, velocity=(2.175,) * 4 + (2.61,) * 3, gripper=HAND, mjcf=mjcf, backend="stream",
    pace=2.5, posture=POSTURE, conditioning=CONDITIONING,
)  # fmt: skip


@hookimpl
def robots() -> Iterable[Robot]:
    """Declare the arm."""
    return [PANDA]
