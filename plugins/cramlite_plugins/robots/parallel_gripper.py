"""Parallel grippers as MJCF text: two coupled sliding joints with a pad each, driven by one tendon.

Whatever opens and closes the fingers of the real gripper (a linkage, a belt, a rack) is left out: both slides are
coupled, and one actuator pulls on their mean. Tool frame: z is the approach direction, y the closing direction.
"""

from __future__ import annotations

from cramlite.model import Value, Vector3


class Jaws(Value):
    """The moving part of a parallel gripper; lengths in metres.

    Args:
        stroke: largest distance between the pads.
        pad: width (x), length (z) and thickness (y) of a pad.
        palm, tip: from the gripper's mounting face to the palm and to the finger tips.
        back: half width (x) and half thickness (y) of the finger behind its pad.
        knuckle: half sizes of the block that carries the finger.
        mass: of a finger [kg]; its centre of mass is at ``centre`` along z.
        force: grip force of each pad that the actuator's range is set to [N]; a controller that commands another
            one sets ``actuator_forcerange``.
        nose: width (x) and length (z) of the finger's face beyond its pad, which grips, too, and how far it is behind the pad's.
        corners: whose hull is the finger on the +y side, where its pad's face is at y = 0; where there are none, ``back`` and ``knuckle``
            are its shape.
    """

    stroke: float
    pad: tuple[float, float, float]
    palm: float
    tip: float
    back: tuple[float, float]
    knuckle: tuple[float, float, float]
    mass: float
    centre: float
    force: float
    nose: tuple[float, float, float] = (0.0, 0.0, 0.0)
    corners: tuple[Vector3, ...] = ()


def finger(jaws: Jaws, name: str, side: int) -> str:
    """Write a finger at rest in the open position as MJCF text; side +1 is the +y side of the tool frame.

    Damping is the gear train's: 50 N move a finger at 0.15 m/s, the 2F-85's data sheet's speed. Armature is the motor's
    reflected inertia: below 0.1 kg the stiff pads chatter at the 2 ms step and a held product creeps at 1.6 mm/s; at
    0.5 kg the pad force is 50.0 N and a 0.8 kg product creeps less than 0.01 mm/s (measured).
    """
    (width, length, thickness), (narrow, beyond, behind) = jaws.pad, jaws.nose
    inner, end = jaws.stroke / 2, jaws.tip - beyond
    faces = [(width, end - length, end - length / 2, 0.0), (width, end - length / 2, end, 0.0), (narrow, end, jaws.tip, behind)]
    pads = "".join(
        f'<geom name="{name}_pad{k + 1}" type="box" pos="0 {side * (inner + back + thickness / 2):.6g}'
        f' {(low + high) / 2:.6g}" size="{x / 2} {thickness / 2} {(high - low) / 2:.6g}"'
        ' friction="0.9 0.005 0.0001" condim="4" priority="1" solref="0.004 1" rgba="0.24 0.24 0.27 1"/>'
        for k, (x, low, high, back) in enumerate(faces if beyond else faces[:2])
    )
    back = inner + thickness + jaws.back[1]
    return (
        f'<body name="{name}_finger" gravcomp="1"><inertial pos="0 {side * back:.6g} {jaws.centre}" mass="{jaws.mass}"'
        ' diaginertia="0.00008 0.00008 0.00002"/>'
        f'<joint name="{name}_finger" type="slide" axis="0 {-side} 0" range="0 {inner}"'
        ' damping="330" armature="0.5"/>'
        f"{_shape(jaws, name, side)}{pads}</body>"
    )


def _shape(jaws: Jaws, name: str, side: int) -> str:
    """Geoms of a finger without its pad, as MJCF text."""
    if jaws.corners:
        return f'<geom name="{name}_finger/0" type="mesh" mesh="{name}_finger/0" rgba="0.35 0.35 0.38 1" mass="0"/>'
    half_width, half_thickness = jaws.back
    back = jaws.stroke / 2 + jaws.pad[2] + half_thickness
    x, y, z = jaws.knuckle
    return (
        f'<geom name="{name}_finger/0" type="box" pos="0 {side * back:.6g} {(jaws.palm + jaws.tip) / 2:.6g}"'
        f' size="{half_width} {half_thickness} {(jaws.tip - jaws.palm) / 2:.6g}" rgba="0.35 0.35 0.38 1"/>'
        f'<geom name="{name}_finger/1" type="box" pos="0 {side * (back + half_thickness - y):.6g}'
        f' {jaws.palm + 0.004 - z:.6g}" size="{x} {y} {z}" rgba="0.16 0.16 0.18 1"/>'
    )


def _mesh(jaws: Jaws, name: str, side: int) -> str:
    vertices = " ".join(f"{x:.6g} {side * (jaws.stroke / 2 + y):.6g} {z:.6g}" for x, y, z in jaws.corners)
    return f'<mesh name="{name}_finger/0" vertex="{vertices}"/>'


def actuation_elements(jaws: Jaws, wrist: str) -> str:
    """Write the elements beside worldbody: actuator "gripper" (0 open .. 255 closed), tendon, coupling, sensors."""
    bodies = ("gripper", "left_finger", "right_finger")
    pairs = [(wrist, b) for b in bodies[1:]] + [(bodies[i], bodies[j]) for i, j in ((0, 1), (0, 2), (1, 2))]
    skip = "".join(f'<exclude body1="{a}" body2="{b}"/>' for a, b in pairs)
    meshes = "".join(_mesh(jaws, n, s) for n, s in (("left", 1), ("right", -1)))
    assets = f"<asset>{meshes}</asset>" if jaws.corners else ""
    stiffness = 40000.0  # saturates within 2.5 mm, so that the grip force hardly depends on the object's width
    return (
        f"{assets}<contact>{skip}</contact>"
        '<tendon><fixed name="closing"><joint joint="left_finger" coef="0.5"/>'
        '<joint joint="right_finger" coef="0.5"/></fixed></tendon>'
        '<equality><joint joint1="left_finger" joint2="right_finger" solref="0.004 1"/></equality>'
        f'<actuator><general name="gripper" tendon="closing" ctrlrange="0 255"'
        f' forcerange="{-2 * jaws.force} {2 * jaws.force}"'
        f' gainprm="{stiffness * jaws.stroke / 2 / 255:.9g}" biastype="affine" biasprm="0 {-stiffness} -180"/></actuator>'
        '<sensor><force name="ft_force" site="ft"/><torque name="ft_torque" site="ft"/></sensor>'
    )
