"""The Panda of robosuite 1.4 as a robot of cramlite, a plugin file: the robot of LIBERO's scenes.

Kinematics: links and joint ranges of robosuite 1.4, models/assets/robots/panda/robot.xml: the Franka Research 3's but for the flange
(106.5 mm) and the ranges. Speeds: Panda data sheet. Masses of the links are the FR3's (cramlite_plugins/robots/fr3.py). Hand:
models/assets/grippers/panda_gripper.xml: fingers from 52.4 mm, pads of 16 x 16 x 8 mm whose middle is at 93.4 mm, tips at 106.2 mm, 20 N a
finger; the site that its controller moves is at 97 mm. Its frame is that of cramlite_plugins/robots/franka_hand.py.
"""

from __future__ import annotations

import os
from collections.abc import Iterable
from pathlib import Path

from msgspec.structs import replace

from cramlite.model import Pose, Robot
from cramlite.plugin import hookimpl
from cramlite_plugins.robots.dh_arm import arm_mjcf
from cramlite_plugins.robots.fr3 import DH, FR3, JOINTS
from cramlite_plugins.robots.fr3 import LINKS as FR3_LINKS
from cramlite_plugins.robots.franka_hand import HEIGHT, TURN
from cramlite_plugins.robots.hull import Circle, Hull
from cramlite_plugins.robots.looks import Skin, covered
from cramlite_plugins.robots.parallel_gripper import Jaws, actuation_elements, finger

KINDS, USUAL = "CRAMLITE_LIBERO_KINDS", "~/.local/share/cramlite/libero_kinds"
"""Environment variable that says where the library of known kinds is, and its usual place."""
FLANGE, SITE = 0.1065, 0.097
KEPT = 0.1
"""Distance kept from each joint's stops [rad]: joints at rest were seen up to 0.05 rad from the values that ``POSTURE`` predicts (1 % of
855 rests), and farther in motion. With joint 7 at 2.85 rad one was stuck at that one's stop, 13 mm from its tool pose."""
STOPS = (
    (-2.8973, 2.8973), (-1.7628, 1.7628), (-2.8973, 2.8973), (-3.0718, -0.0698),
    (-2.8973, 2.8973), (-0.0175, 3.7525), (-2.8973, 2.8973),
)  # fmt: skip
LIMITS = tuple((low + KEPT, high - KEPT) for low, high in STOPS)
POSTURE = (0.0, -0.161, 0.0, -2.445, 0.0, 2.227, 0.785)
"""Joint positions at which LIBERO's robot begins, within 0.02 rad, and to which OSC_POSE pulls the joints: MountedPanda's init_qpos."""
ROTORS = tuple(5.0 / k for k in range(1, 8))
"""Inertia of the Panda's motors [kg m2], ten times the links' own at most joints: armature of robosuite 1.4, models/robots/robot_model.py.
Of 855 rests of drawn problems 90 % had joints within 0.03 rad of the posture so expected, without it within 0.12 rad."""
CONDITIONING = 0.08
"""Least conditioning of a posture, which keeps the arm away from stretched postures and other singularities: the controller treats
position and rotation of the tool apart, and comes through the stretched elbow out on its other side, where it is stuck against its stop.
Of the freeze's 83 programs 12 came below 0.065 with the arm stretched: 11 of them did so, and none of the 70 that kept 0.09."""
TABLE = (*DH[:-1], (DH[-1][0], DH[-1][1] - 0.107 + FLANGE, DH[-1][2]))
CIRCLES = (
    (
        ("z", (-0.0022, 0.0, 0.0), 0.0741, 24), ("z", (0.0, 0.0, 0.141), 0.0553, 24), ("z", (-0.0735, -0.0136, 0.0619), 0.0489, 24),
        ("z", (-0.0803, 0.0171, 0.0598), 0.0428, 24), ("z", (-0.1109, 0.0308, -0.001), 0.0406, 24),
        ("x", (0.0035, 0.0444, 0.0429), 0.0395, 24), ("z", (0.0005, -0.0478, 0.07), 0.0296, 24),
        ("z", (-0.1177, 0.0444, 0.0091), 0.027, 24), ("z", (-0.1211, -0.0478, -0.001), 0.0241, 24),
        ("z", (-0.1211, -0.0478, 0.0091), 0.0227, 24), ("y", (-0.0565, -0.0753, 0.0463), 0.021, 24),
        ("z", (0.0, 0.082, -0.001), 0.014, 24), ("z", (0.0, -0.0825, -0.001), 0.0135, 24),
        ("z", (-0.1279, 0.0581, 0.0005), 0.0125, 24), ("x", (-0.153, -0.0239, 0.0023), 0.0033, 6),
        ("x", (-0.151, -0.0341, 0.0023), 0.0033, 6), ("x", (-0.1551, -0.0034, 0.0023), 0.0025, 6),
        ("x", (-0.153, 0.0239, 0.0057), 0.0023, 6),
    ),
    (
        ("z", (0.0, 0.0, -0.192), 0.055), ("z", (0.0, 0.0005, -0.129), 0.0555), ("y", (0.0, -0.0005, -0.001), 0.056),
        ("y", (0.0, -0.06, 0.0), 0.0555), ("y", (0.0, -0.1065, -0.0005), 0.0495), ("y", (0.0, -0.1295, 0.0005), 0.021),
    ),
    (
        ("y", (0.0, -0.194, 0.0), 0.0555), ("y", (0.0, -0.1275, 0.0), 0.0555), ("z", (0.0, 0.0005, 0.0005), 0.055),
        ("z", (0.0, 0.0, 0.065), 0.055), ("z", (0.0, -0.001, 0.108), 0.0485), ("z", (0.0, 0.001, 0.1295), 0.0205),
    ),
    (
        ("z", (0.0, 0.0, -0.121), 0.058), ("z", (-0.001, 0.0, -0.0335), 0.046), ("y", (0.0815, -0.0005, -0.0015), 0.057),
        ("y", (0.082, 0.06, 0.0), 0.054), ("y", (0.082, 0.093, -0.001), 0.049), ("y", (0.083, 0.1115, 0.0), 0.021),
    ),
    (
        ("y", (-0.0825, 0.124, 0.0), 0.058), ("y", (-0.082, 0.0335, 0.0), 0.047), ("z", (-0.0005, 0.0005, 0.0), 0.056),
        ("z", (0.0005, -0.0005, 0.057), 0.054), ("z", (-0.0005, 0.001, 0.0945), 0.0475), ("z", (0.0, -0.001, 0.111), 0.0205),
    ),
    (
        ("z", (0.0, 0.0, -0.2593), 0.0556, 24), ("z", (0.0, 0.0005, -0.2278), 0.0551, 24), ("y", (0.0, 0.1015, 0.0), 0.0515, 24),
        ("y", (0.0, 0.1036, -0.0064), 0.0511, 24), ("y", (0.0, 0.0973, 0.0041), 0.0491, 24), ("y", (0.0, 0.0153, 0.0), 0.0487, 24),
        ("x", (0.0, 0.0825, 0.0041), 0.0485, 24), ("y", (0.0, 0.1183, 0.0), 0.0388, 24), ("y", (0.0, -0.0435, -0.227), 0.0343, 24),
        ("y", (0.0, 0.0868, -0.1675), 0.0309, 24), ("y", (0.0005, 0.1267, 0.0041), 0.0257, 24),
        ("x", (-0.0519, -0.0007, -0.2445), 0.0203, 24), ("x", (0.0312, 0.0928, 0.0251), 0.0181, 24),
    ),
    (
        ("z", (0.0, 0.0001, -0.0149), 0.0486, 24), ("z", (-0.0016, 0.0, 0.0287), 0.0463, 24), ("y", (0.088, -0.0509, 0.0), 0.0447, 24),
        ("z", (0.0005, 0.0001, 0.0347), 0.0445, 24), ("y", (0.0883, 0.0136, 0.0), 0.0443, 24),
        ("z", (0.0783, 0.0352, -0.0269), 0.0441, 24), ("y", (0.0883, -0.0524, 0.0), 0.0424, 24),
        ("y", (0.0883, 0.0467, 0.0), 0.0415, 24), ("y", (0.088, 0.0602, 0.0005), 0.0381, 24),
        ("z", (-0.0016, -0.0024, 0.0408), 0.0367, 24), ("y", (0.0009, 0.0227, 0.0199), 0.0363, 24),
        ("y", (0.088, 0.0647, 0.0049), 0.0338, 24), ("y", (0.0858, 0.0692, -0.0051), 0.0328, 24),
        ("x", (0.0579, 0.0502, -0.0026), 0.0321, 24), ("y", (0.0858, 0.0707, 0.0074), 0.0299, 24),
        ("y", (0.0783, 0.0752, 0.0049), 0.0296, 24), ("y", (0.082, 0.0737, -0.0076), 0.0283, 24),
        ("z", (0.0009, -0.0024, 0.0498), 0.0281, 24), ("x", (0.1212, 0.0402, -0.0001), 0.027, 24),
        ("z", (0.0209, 0.0005, 0.0558), 0.0263, 24), ("y", (0.0808, 0.0752, -0.0101), 0.0246, 24),
        ("x", (0.1166, 0.0527, -0.0126), 0.0164, 24), ("y", (0.0708, 0.0797, 0.0099), 0.0156, 24),
        ("x", (-0.0159, -0.0399, 0.0224), 0.0058), ("y", (-0.0066, -0.0239, 0.0498), 0.0057), ("z", (0.0184, -0.0199, 0.0573), 0.0057),
        ("x", (0.0775, -0.0499, -0.0425), 0.0018, 6),
    ),
    (
        ("z", (0.0, 0.0, -0.0545), 0.0441, 24), ("z", (0.0, 0.0, -0.0096), 0.044, 24), ("z", (0.0004, 0.0004, 0.0003), 0.031, 24),
        ("z", (-0.0346, -0.0369, -0.0216), 0.0041), ("z", (-0.0378, -0.0355, -0.0182), 0.0034), ("z", (0.0757, 0.037, -0.0305), 0.0033),
        ("z", (0.0369, 0.0779, -0.0308), 0.0022), ("z", (0.0766, 0.0383, -0.0241), 0.0049), ("z", (0.0387, 0.0766, -0.0208), 0.0056),
        ("z", (0.0772, 0.0383, -0.0115), 0.0031), ("z", (0.0376, 0.0773, -0.013), 0.0033), ("z", (0.074, 0.0344, -0.0128), 0.0041),
        ("z", (0.0354, 0.0731, -0.0102), 0.0043), ("z", (0.0606, 0.0614, -0.0231), 0.0026), ("z", (0.0594, 0.0568, -0.0123), 0.0041),
        ("z", (0.0603, 0.0563, -0.0277), 0.0049), ("z", (0.06, 0.0588, -0.0181), 0.0045),
    ),
)  # fmt: skip
"""Circles whose hulls are base and links: axis, centre, radius [m], sides; in the frames of robosuite's bodies, of the last link from the
flange. MuJoCo collides the convex hulls of robosuite's meshes, meshes/link0.stl to link7.stl, the same files in 1.4 and 1.5.2; these were
fitted about them: no corner of a mesh is outside by more than 0.11 mm (base, 5, 6 and 7: 0.4 mm), and none of theirs is farther from it
than 4.4 (links 1, 2), 5.6 (3, 4), 1.9 (5), 1.7 (6), 1.6 (7) and 2.0 mm (base). LIBERO's robot collides all but link 7, that of 1.5.2 this
one, too: a shape that stuck out by 9.5 mm let no hand lead a nut by its handle down beside its peg."""
HULLS = tuple(Hull(tuple(Circle(*c) for c in circles)) for circles in CIRCLES)
LINKS = tuple(replace(link, shape=(hull,)) for link, hull in zip(FR3_LINKS, HULLS[1:], strict=True))
FINGER = tuple(
    (sign * x, y, z)
    for z, x, near, far in (
        (0.0524, 0.0105, 0.0030, 0.0269), (0.0716, 0.0105, 0.0015, 0.0258), (0.0886, 0.0092, 0.0005, 0.0200),
        (0.1034, 0.0088, 0.0005, 0.0144), (0.1062, 0.0062, 0.0005, 0.0148),
    )
    for sign in (1, -1) for y in (near, far)
)  # fmt: skip
"""Corners of a finger: distance along the finger, half its width there, and the range of depth behind the face of its pad [m]. Outline
of the hull of robosuite's mesh, meshes/panda_gripper/finger.stl, whose face is 0.5 mm behind the pad's, and grips what reaches beyond
the pad."""
JAWS = Jaws(
    stroke=0.080, pad=(0.016, 0.016, 0.0075), palm=HEIGHT, tip=0.1062, back=(0.0092, 0.004), knuckle=(0.0105, 0.0075, 0.004), mass=0.11,
    centre=0.10, force=20.0, nose=(0.015, 0.0048, 0.0005), corners=FINGER,
)  # fmt: skip
SPEED = 0.2
"""Speed of the pads towards each other [m/s]: PandaGripper moves the command of its fingers by 10 mm of opening an action at 20 Hz."""
PAD = (0.016, 0.020)
"""Size of a pad in the planning of grasps [m]: the pad and the finger's face beyond it, up to 0.8 mm beyond the tips, which
so stay off tables. With 16 mm grasps were planned 1.2 mm short of the tips, and a plate that lies flat had a finger pressed onto the table
beside it, with 21 N."""
SEEN = {"gripper": "right_gripper", "left_finger": "leftfinger", "right_finger": "rightfinger"}
"""Bodies of the hand, and the names of their meshes in robosuite."""
MASS = 0.52
"""Mass of the hand and its fingers [kg]."""
SLICES = ((0.0, 0.022, 0.0316, 0.104), (0.022, 0.044, 0.0276, 0.1028), (0.044, 0.057, 0.0221, 0.1013), (0.057, HEIGHT, 0.0189, 0.1003))
"""Sections of the hand from the flange on: their ranges along the hand's axis, half thickness and half width [m]. Outline of the hull of
robosuite's mesh, meshes/panda_gripper/hand.stl, which gets thinner towards the fingers."""


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
    return body, actuation_elements(JAWS, wrist)


def mjcf() -> str:
    """Write the arm and its hand as MJCF text."""
    return arm_mjcf("libero_panda", TABLE, LINKS, JOINTS, LIMITS, HULLS[:1], gripper_mjcf(LINKS[-1].name))


def library() -> Path:
    """Return the folder with what kinds.py made of LIBERO's files: the library of kinds, and in ``robot`` the robot's visible meshes."""
    return Path(os.environ.get(KINDS) or USUAL).expanduser()


def looks() -> str:
    """Write the arm and its hand as MJCF text, as LIBERO's cameras see them."""
    folder, flange = library() / "robot", Pose((0.0, 0.0, -FLANGE))
    names = {"base_link": "link0", **{link.name: f"link{k}" for k, link in enumerate(LINKS, 1)}}
    skins = {body: Skin(folder / f"{name}.obj", flange if body == LINKS[-1].name else Pose()) for body, name in (names | SEEN).items()}
    return covered(mjcf(), skins)


HAND = replace(
    FR3.gripper, type="libero_panda_hand", pad=PAD, depth=SITE - HEIGHT, mass=MASS, tcp=TURN * Pose((0.0, 0.0, SITE)),
    force=(5.0, 20.0), speed=(FR3.gripper.speed[0], SPEED),
)  # fmt: skip
PANDA = replace(
    FR3, type="libero_panda", dh=TABLE, limits=LIMITS, velocity=(2.175,) * 4 + (2.61,) * 3, gripper=HAND, mjcf=mjcf, backend="stream",
    pace=2.5, posture=POSTURE, conditioning=CONDITIONING, rotors=ROTORS,
    looks=looks if (library() / "robot").is_dir() else None,
)  # fmt: skip


@hookimpl
def robots() -> Iterable[Robot]:
    """Declare the Panda of LIBERO's scenes as a type of robot."""
    return [PANDA]
