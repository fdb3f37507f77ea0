"""The Robotiq 2F-85 as a parallel gripper of primitives.

The linkage is replaced by two coupled slides: its fingertips move in parallel when they grip between
the pads, and the 13 mm arc that they follow over the full stroke is left out.
Dimensions: Robotiq 2F-85 instruction manual, section "Specifications" (stroke 85 mm, grip force 20 to
235 N, 0.9 kg, 162.8 mm from the mounting face to the fingertip) and a 11.7 mm coupling; pads 22 x 37.5 mm.
"""

from __future__ import annotations

from cramlite.geometry import Pose
from cramlite.robots import Gripper

STROKE = 0.085
TIP = 0.1745  # flange to fingertip: 162.8 mm and the coupling
PAD_WIDTH, PAD_LENGTH, PAD_THICKNESS = 0.022, 0.0375, 0.008
PALM = 0.098  # flange to palm
TCP = TIP - PAD_LENGTH / 2
FORCE = 50.0  # grip force a pad [N]: measured to hold 0.8 kg; the actuator's force range sets it

GRIPPER = Gripper(
    type="robotiq_2f85",
    opening=(0.0, STROKE),
    pad=(PAD_WIDTH, PAD_LENGTH),
    depth=TCP - PALM,
    mass=0.925,
    tcp=Pose((0.0, 0.0, TCP)),
    force=(20.0, 235.0),
)


def gripper_mjcf(wrist: str, sensor: float = 0.0, sensor_mass: float = 0.0) -> tuple[str, str]:
    """The gripper as (body element to put on the flange, elements beside worldbody).

    Actuator "gripper": 0 open .. 255 closed, on a tendon that is the mean of both slides. Its force range is
    twice the grip force a pad; a controller that commands a force sets ``actuator_forcerange``.

    Args:
        wrist: name of the body that carries the flange.
        sensor, sensor_mass: height [m] and mass [kg] of a force-torque sensor, 82 mm thick, in between.
    """
    return _body(sensor, sensor_mass), _beside(wrist)


def _body(sensor: float, sensor_mass: float) -> str:
    """Readings are at the flange, also with a sensor behind the gripper: drivers transform them to it."""
    mass = 0.725 + sensor_mass
    centre = (0.725 * 0.055 - sensor_mass * sensor / 2) / mass
    disc = f'<geom name="gripper/2" type="cylinder" fromto="0 0 {-sensor} 0 0 0" size="0.041" rgba=".7 .7 .72 1"/>'
    return (
        f'<body name="gripper" pos="0 0 {sensor}" gravcomp="1"><site name="ft" pos="0 0 {-sensor}"/>'
        f'<site name="tcp" pos="0 0 {TCP}"/>'
        f'<inertial pos="0 0 {centre:.9g}" mass="{mass:.9g}" diaginertia="0.0009 0.0009 0.0005"/>{disc if sensor else ""}'
        '<geom name="gripper/0" type="cylinder" fromto="0 0 0 0 0 0.014" size="0.0375" rgba="0.5 0.5 0.53 1"/>'
        f'<geom name="gripper/1" type="cylinder" fromto="0 0 0.014 0 0 {PALM}" size="0.0375" rgba=".16 .16 .18 1"/>'
        f'{_finger("left", 1)}{_finger("right", -1)}</body>'
    )


def _finger(name: str, side: int) -> str:
    """A finger at rest in the open position; side +1 is the +y side of the tool frame.

    Damping is the gear train's: 50 N move a finger at 0.15 m/s, the data sheet's speed. Armature is the motor's
    reflected inertia: below 0.1 kg the stiff pads chatter at the 2 ms step and a held product creeps at 1.6 mm/s; at
    0.5 kg the pad force is 50.0 N and a 0.8 kg product creeps less than 0.01 mm/s (measured).
    """
    inner = STROKE / 2
    pads = "".join(
        f'<geom name="{name}_pad{k + 1}" type="box" pos="0 {side * (inner + PAD_THICKNESS / 2):.6g}'
        f' {TIP - PAD_LENGTH * (3 - 2 * k) / 4:.6g}" size="{PAD_WIDTH / 2} {PAD_THICKNESS / 2} {PAD_LENGTH / 4}"'
        ' friction="0.9 0.005 0.0001" condim="4" priority="1" solref="0.004 1" rgba="0.24 0.24 0.27 1"/>'
        for k in (0, 1)
    )
    back = inner + PAD_THICKNESS + 0.006
    return (
        f'<body name="{name}_finger" gravcomp="1"><inertial pos="0 {side * back:.6g} 0.13" mass="0.1"'
        ' diaginertia="0.00008 0.00008 0.00002"/>'
        f'<joint name="{name}_finger" type="slide" axis="0 {-side} 0" range="0 {inner}"'
        ' damping="330" armature="0.5"/>'
        f'<geom name="{name}_finger/0" type="box" pos="0 {side * back:.6g} {(PALM + TIP) / 2:.6g}"'
        f' size="{PAD_WIDTH / 2} 0.006 {(TIP - PALM) / 2:.6g}" rgba="0.35 0.35 0.38 1"/>'
        f'<geom name="{name}_finger/1" type="box" pos="0 {side * (back - 0.007):.6g} {PALM - 0.01:.6g}"'
        f' size="0.0135 0.013 0.014" rgba="0.16 0.16 0.18 1"/>{pads}</body>'
    )


def _beside(wrist: str) -> str:
    bodies = ("gripper", "left_finger", "right_finger")
    pairs = [(wrist, b) for b in bodies[1:]] + [(bodies[i], bodies[j]) for i, j in ((0, 1), (0, 2), (1, 2))]
    skip = "".join(f'<exclude body1="{a}" body2="{b}"/>' for a, b in pairs)
    stiffness = 40000.0  # saturates within 2.5 mm, so that the grip force hardly depends on the object's width
    return (
        f'<contact>{skip}</contact><tendon><fixed name="closing"><joint joint="left_finger" coef="0.5"/>'
        '<joint joint="right_finger" coef="0.5"/></fixed></tendon>'
        '<equality><joint joint1="left_finger" joint2="right_finger" solref="0.004 1"/></equality>'
        f'<actuator><general name="gripper" tendon="closing" ctrlrange="0 255" forcerange="{-2 * FORCE} {2 * FORCE}"'
        f' gainprm="{stiffness * STROKE / 2 / 255:.9g}" biastype="affine" biasprm="0 {-stiffness} -180"/></actuator>'
        '<sensor><force name="ft_force" site="ft"/><torque name="ft_torque" site="ft"/></sensor>'
    )
