"""A Denavit-Hartenberg arm as MJCF text, built from primitives.

Body ``i`` carries joint ``i``. Its origin is frame ``i - 1`` moved by d_i along the joint axis (the
convention of the manufacturer's URDF), so that the last body's frame is the flange frame when a = alpha = 0.
Shapes are cylinders, boxes and convex hulls, never capsules: MuJoCo 4.0.0 misses a capsule whose axis passes
through a thin box (docs/explanation/simulation.md).
"""

from __future__ import annotations

import math

import numpy as np
from msgspec import field

from cramlite.model import Floats, Pose, Value

from .hull import Hull, corners

DhRow = tuple[float, float, float]


class Cylinder(Value):
    """A cylinder of a link between two points of the link's body frame [m]."""

    start: tuple[float, float, float]
    end: tuple[float, float, float]
    radius: float
    rgba: str = "0.82 0.83 0.85 1"


class Link(Value):
    """Moving link of an arm: its inertia, its shapes, and the servo of its joint.

    Args:
        name: of the body.
        mass: [kg].
        com: centre of mass in Denavit-Hartenberg frame i [m], or in the body's own frame if ``own``.
        inertia: (ixx, iyy, izz, ixy, ixz, iyz) about the centre of mass, axes of that frame [kg m2].
        torque: limit of its joint [Nm].
        kp: position gain of its servo [Nm/rad]; the velocity gain is 0.04 kp.
        shape: its cylinders and hulls.
        own: mass data are in the body's frame, as in a URDF, not in the Denavit-Hartenberg frame.
    """

    name: str
    mass: float
    com: tuple[float, float, float]
    inertia: tuple[float, float, float, float, float, float]
    torque: float
    kp: float
    shape: tuple[Cylinder | Hull, ...] = field(default_factory=tuple)
    own: bool = False


def forward(dh: tuple[DhRow, ...], q: Floats | tuple[float, ...]) -> Pose:
    """Solve forward kinematics: the flange in the base frame, the product of Rz(q) Tz(d) Tx(a) Rx(alpha).

    Args:
        dh: rows (a, d, alpha) [m, rad].
        q: joint angles [rad].
    """
    pose = Pose()
    for (a, d, alpha), angle in zip(dh, q, strict=True):
        turn = Pose((0, 0, d), (math.cos(angle / 2), 0, 0, math.sin(angle / 2)))
        pose = pose * turn * Pose((a, 0, 0), (math.cos(alpha / 2), math.sin(alpha / 2), 0, 0))
    return pose


def arm_mjcf(
    name: str,
    dh: tuple[DhRow, ...],
    links: tuple[Link, ...],
    joints: tuple[str, ...],
    limits: tuple[tuple[float, float], ...],
    base: tuple[Cylinder | Hull, ...],
    tool: tuple[str, str],
    apart: tuple[tuple[str, str], ...] = (),
    carrier: tuple[str, str, str] = ("", "", ""),
) -> str:
    """Write an arm with its tool as MJCF text.

    Args:
        name: of the model.
        dh, limits: as in ``cramlite.model.Robot``.
        base: shape of the part that does not move.
        tool: (body element for the flange, elements beside worldbody) of the gripper.
        apart: pairs of bodies whose shapes overlap although the real ones never meet.
        carrier: elements before and after the base's body, and further actuators, of what the arm stands on.
    """
    inner = f'<site name="flange"/>{tool[0]}'
    for i in reversed(range(len(links))):
        inner = _body(i, dh, links[i], joints[i], limits[i], inner)
    servos = "".join(
        f'<position name="{j}" joint="{j}" kp="{k.kp}" kv="{0.04 * k.kp}" ctrlrange="{lo} {hi}"'
        f' forcerange="{-k.torque} {k.torque}"/>'
        for j, k, (lo, hi) in zip(joints, links, limits, strict=True)
    )
    pairs = (("base_link", links[0].name), *apart)
    skip = "<contact>" + "".join(f'<exclude body1="{a}" body2="{b}"/>' for a, b in pairs) + "</contact>"
    still = "".join(_geom(c, "base_link", i) for i, c in enumerate(base))
    assets = "".join(_mesh(s, n, k) for n, shape in [("base_link", base), *((v.name, v.shape) for v in links)] for k, s in enumerate(shape))
    return (
        f'<mujoco model="{name}"><compiler angle="radian" autolimits="true"/><asset>{assets}</asset><worldbody>{carrier[0]}'
        f'<body name="base_link">{still}{inner}</body>{carrier[1]}</worldbody>'
        f"<actuator>{servos}{carrier[2]}</actuator>{skip}{tool[1]}</mujoco>"
    )


def _body(i: int, dh: tuple[DhRow, ...], link: Link, joint: str, limit: tuple[float, float], inner: str) -> str:
    a, _, alpha = dh[i - 1] if i else (0.0, 0.0, 0.0)
    turn = Pose((0, 0, 0), (math.cos(alpha / 2), math.sin(alpha / 2), 0, 0))
    place = Pose((a, 0, 0)) * turn * Pose((0, 0, dh[i][1]))
    shape = "".join(_geom(c, link.name, k) for k, c in enumerate(link.shape))
    return (
        f'<body name="{link.name}" pos="{_text(place.position)}" quat="{_text(place.quaternion)}" gravcomp="1">'
        f'<joint name="{joint}" axis="0 0 1" range="{limit[0]} {limit[1]}" armature="0.1"/>'
        f"{_inertial(dh[i], link)}{shape}{inner}</body>"
    )


def _inertial(row: DhRow, link: Link) -> str:
    """Inertial element of a link: mass, centre and inertia, converted from Denavit-Hartenberg frame i to
    the body frame."""
    a, _, alpha = (0.0, 0.0, 0.0) if link.own else row
    turn = Pose((a, 0, 0), (math.cos(alpha / 2), math.sin(alpha / 2), 0, 0))
    xx, yy, zz, xy, xz, yz = link.inertia
    m = turn.rotation @ np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) @ turn.rotation.T
    full = (m[0, 0], m[1, 1], m[2, 2], m[0, 1], m[0, 2], m[1, 2])
    return f'<inertial pos="{_text(turn.apply(link.com))}" mass="{link.mass}" fullinertia="{_text(full)}"/>'


def _mesh(shape: Cylinder | Hull, owner: str, k: int) -> str:
    return f'<mesh name="{owner}/{k}" vertex="{_text(corners(shape).ravel())}"/>' if isinstance(shape, Hull) else ""


def _geom(shape: Cylinder | Hull, owner: str, k: int) -> str:
    if isinstance(shape, Hull):
        form = f'type="mesh" mesh="{owner}/{k}"'
    else:
        form = f'type="cylinder" fromto="{_text((*shape.start, *shape.end))}" size="{shape.radius}"'
    return f'<geom name="{owner}/{k}" {form} rgba="{shape.rgba}" mass="0"/>'


def _text(values: object) -> str:
    return " ".join(f"{float(v):.9g}" for v in values)  # type: ignore[attr-defined]
