"""The Franka Hand as a parallel gripper of primitives.

Published: 80 mm opening, 50 mm/s a finger, 70 N continuous force, 0.7 kg (Franka Hand product manual, technical data).
Geometry and masses: frankaemika/franka_description, end_effectors/common/franka_hand.xacro (fingers 58.4 mm above the
flange, rubber tips 17.5 x 18.5 mm, tool centre point 103.4 mm) and end_effectors/franka_hand/inertials.yaml; the hand is
turned by -45 degrees on the flange. Its body is a box of 63 x 204 x 66 mm, from the outline of the hand.
The lowest force of 10 N is ours: none is published.
"""

from __future__ import annotations

import math

from cramlite.model import Gripper, Pose

from .parallel_gripper import Jaws, actuation_elements, finger

TURN = Pose((0.0, 0.0, 0.0), (math.cos(-math.pi / 8), 0.0, 0.0, math.sin(-math.pi / 8)))
TCP, PALM, HEIGHT = 0.1034, 0.066, 0.066
TIP_CENTRE = 0.0584 + 0.04525
PAD = 0.0175, 0.0185, 0.008  # the rubber tip is 15.2 mm thick: pad and the finger behind it
HAND_MASS, FINGER_MASS = 0.6544, 0.0291

JAWS = Jaws(
    stroke=0.080, pad=PAD, palm=PALM, tip=TIP_CENTRE + PAD[1] / 2, back=(0.00875, 0.0036),
    knuckle=(0.011, 0.0075, 0.004), mass=FINGER_MASS, centre=0.0584 + 0.022, force=70.0,
)  # fmt: skip

FRANKA_HAND = Gripper(
    type="franka_hand",
    opening=(0.0, JAWS.stroke),
    pad=PAD[:2],
    depth=TCP - PALM,
    mass=HAND_MASS + 2 * FINGER_MASS,
    tcp=TURN * Pose((0.0, 0.0, TCP)),
    force=(10.0, 70.0),
    speed=(0.010, 0.100),
)


def gripper_mjcf(wrist: str) -> tuple[str, str]:
    """Write the hand as MJCF text: (body element to put on the flange, elements beside worldbody).

    Readings are those of a sensor in the flange, in the flange's axes.
    """
    turn, back = (" ".join(f"{v:.9g}" for v in p.quaternion) for p in (TURN, TURN.inverse()))
    body = (
        f'<body name="gripper" quat="{turn}" gravcomp="1"><site name="ft" quat="{back}"/>'
        f'<site name="tcp" pos="0 0 {TCP}"/>'
        f'<inertial pos="0 0.0119128 0.020726" mass="{HAND_MASS}" diaginertia="0.00186 0.0003 0.00174"/>'
        f'<geom name="gripper/0" type="box" pos="0 0 {HEIGHT / 2}" size="0.0315 0.102 {HEIGHT / 2}" rgba=".9 .9 .9 1"/>'
        f"{finger(JAWS, 'left', 1)}{finger(JAWS, 'right', -1)}</body>"
    )
    return body, actuation_elements(JAWS, wrist)
