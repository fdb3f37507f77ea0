"""The Robotiq 2F-85 as a parallel gripper of primitives.

The linkage is replaced by two coupled slides: its fingertips move in parallel when they grip between
the pads, and the 13 mm arc that they follow over the full stroke is left out.
Dimensions: Robotiq 2F-85 instruction manual, section "Specifications" (stroke 85 mm, 20 to 150 mm/s, grip
force 20 to 235 N, 0.9 kg, 162.8 mm from the mounting face to the fingertip) and a 11.7 mm coupling; pads 22 x 37.5 mm.
"""

from __future__ import annotations

from cramlite.model import Gripper, Pose

from .parallel_gripper import Jaws, actuation_elements, finger

STROKE = 0.085
TIP = 0.1745  # flange to fingertip: 162.8 mm and the coupling
PAD_WIDTH, PAD_LENGTH, PAD_THICKNESS = 0.022, 0.0375, 0.008
PALM = 0.098  # flange to palm
TCP = TIP - PAD_LENGTH / 2
FORCE = 50.0  # grip force a pad [N]: measured to hold 0.8 kg; the actuator's force range sets it

JAWS = Jaws(
    stroke=STROKE, pad=(PAD_WIDTH, PAD_LENGTH, PAD_THICKNESS), palm=PALM, tip=TIP, back=(PAD_WIDTH / 2, 0.006),
    knuckle=(0.0135, 0.013, 0.014), mass=0.1, centre=0.13, force=FORCE,
)  # fmt: skip

GRIPPER = Gripper(
    type="robotiq_2f85",
    opening=(0.0, STROKE),
    pad=(PAD_WIDTH, PAD_LENGTH),
    depth=TCP - PALM,
    mass=0.925,
    tcp=Pose((0.0, 0.0, TCP)),
    force=(20.0, 235.0),
    speed=(0.020, 0.150),
)


def gripper_mjcf(wrist: str, sensor: float = 0.0, sensor_mass: float = 0.0) -> tuple[str, str]:
    """Write the gripper as MJCF text: (body element to put on the flange, elements beside worldbody).

    Actuator "gripper": 0 open .. 255 closed, on a tendon that is the mean of both slides. Its force range is
    twice the grip force a pad; a controller that commands a force sets ``actuator_forcerange``.

    Args:
        wrist: name of the body that carries the flange.
        sensor, sensor_mass: height [m] and mass [kg] of a force-torque sensor, 82 mm thick, in between.
    """
    return _body(sensor, sensor_mass), actuation_elements(JAWS, wrist)


def _body(sensor: float, sensor_mass: float) -> str:
    """Return MJCF of the gripper's body; its force site is at the flange, to which drivers convert a sensor's
    readings."""
    mass = 0.725 + sensor_mass
    centre = (0.725 * 0.055 - sensor_mass * sensor / 2) / mass
    disc = f'<geom name="gripper/2" type="cylinder" fromto="0 0 {-sensor} 0 0 0" size="0.041" rgba=".7 .7 .72 1"/>'
    return (
        f'<body name="gripper" pos="0 0 {sensor}" gravcomp="1"><site name="ft" pos="0 0 {-sensor}"/>'
        f'<site name="tcp" pos="0 0 {TCP}"/>'
        f'<inertial pos="0 0 {centre:.9g}" mass="{mass:.9g}" diaginertia="0.0009 0.0009 0.0005"/>{disc if sensor else ""}'
        '<geom name="gripper/0" type="cylinder" fromto="0 0 0 0 0 0.014" size="0.0375" rgba="0.5 0.5 0.53 1"/>'
        f'<geom name="gripper/1" type="cylinder" fromto="0 0 0.014 0 0 {PALM}" size="0.0375" rgba=".16 .16 .18 1"/>'
        f'{finger(JAWS, "left", 1)}{finger(JAWS, "right", -1)}</body>'
    )
