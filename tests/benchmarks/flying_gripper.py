"""A Robotiq 2F-85 that flies: six servos move its flange, everything else is the model on the arms.

Servos: 20 kN/m and 400 Ns/m along, 300 Nm/rad and 10 Nms/rad about the axes, at most 150 N and 28 Nm, an arm's own limits.
Joints start at zero; the mount's base is the flange at the grasp. Hinges are at the TCP.
"""

from __future__ import annotations

import math

import mujoco
import numpy as np

from cramlite.model import Physics, Pose, Robot, RobotMount, Thing, World
from cramlite_plugins.objects.products_and_fixtures import table
from cramlite_plugins.robots.robotiq_2f85 import GRIPPER, TCP, gripper_mjcf
from cramlite_plugins.simulation.model.compile import Compiled, compile_world

JOINTS = ("x", "y", "z", "rx", "ry", "rz")
AXES = ("1 0 0", "0 1 0", "0 0 1")
STANDOFF, SHAKE, LIFT = 0.10, 0.015, 0.20
HELD, TURNED = 0.020, math.radians(30)


def mjcf() -> str:
    body, beside = gripper_mjcf("wrist")
    slides = "".join(f'<joint name="{n}" type="slide" axis="{a}"/>' for n, a in zip(JOINTS[:3], AXES, strict=True))
    hinges = "".join(
        f'<joint name="{n}" type="hinge" axis="{a}" pos="0 0 {TCP}" armature="0.01"/>' for n, a in zip(JOINTS[3:], AXES, strict=True)
    )
    servos = "".join(
        f'<position name="{n}" joint="{n}" kp="{20000 if k < 3 else 300}" kv="{400 if k < 3 else 10}"'
        f' forcerange="{"-150 150" if k < 3 else "-28 28"}"/>'
        for k, n in enumerate(JOINTS)
    )
    small = '<inertial pos="0 0 0" mass="0.3" diaginertia="0.001 0.001 0.001"/>'
    return (
        '<mujoco model="flying"><compiler angle="radian" autolimits="true"/><worldbody>'
        f'<body name="carriage" gravcomp="1">{small}{slides}<body name="wrist" gravcomp="1">{small}{hinges}'
        f'<site name="flange"/>{body}</body></body></worldbody>{beside.replace("<actuator>", "<actuator>" + servos)}</mujoco>'
    )


FLYING = Robot(
    "flying_2f85", JOINTS, None, ((-2.0, 2.0),) * 6, (1.0,) * 6, (1.0,) * 6, (0.0,) * 6, 1.0, 10.0, GRIPPER, None, "", mjcf
)  # fmt: skip


def holds(item: Thing, tcp: Pose, width: float, friction: float = 0.9) -> bool:
    """Approach, close, lift by 200 mm, shake by 15 mm at 6 Hz along each axis, turn by 90 degrees about the closing
    direction and 60 about the other; a thing is held if it moved less than 20 mm and 30 degrees in the hand.

    Args:
        item: at rest on a table at z = 0.
        tcp: the grasp in the world.
        width: between the contacts [m].
    """
    world = World(
        (table("table", Pose((0.5, 0, 0))), item),
        (RobotMount("fly", FLYING.type, tcp * Pose((0, 0, -TCP))),),
        Physics(pad_friction=friction),
    )
    compiled = compile_world(world, {FLYING.type: FLYING})
    run = _Run(compiled, tcp, min(width + 0.010, GRIPPER.opening[1]))
    run.move(0.5, lambda s: (0, 0, -STANDOFF * (1 - s), 0, 0, 0))
    run.move(0.5, lambda s: (0,) * 6, close=True)
    before = run.in_hand()
    up = tuple(tcp.inverse().rotate((0, 0, LIFT)))
    run.move(0.8, lambda s: (*(s * v for v in up), 0, 0, 0))
    for axis in range(3):
        way = np.eye(3)[axis] * SHAKE
        run.move(0.5, lambda s, way=way: (*(np.array(up) + way * math.sin(6 * math.pi * s)), 0, 0, 0))
    run.move(0.8, lambda s: (*up, 0, math.pi / 2 * s, 0))
    run.move(0.6, lambda s: (*up, math.pi / 3 * s, math.pi / 2, 0))
    run.move(0.3, lambda s: (*up, math.pi / 3, math.pi / 2, 0))
    moved, turned = before.distance(run.in_hand())
    lifted = compiled.pose(run.data, item.name).position[2] - item.pose.position[2]
    return moved < HELD and turned < TURNED and lifted > LIFT / 2


class _Run:
    """A simulation under way."""

    def __init__(self, compiled: Compiled, tcp: Pose, opening: float) -> None:
        self.compiled, self.item = compiled, compiled.world.things[1].name
        self.index, self.data = compiled.robots["fly"], compiled.data()
        low, high = self.index.reach
        self.open = 255 * (high - opening) / (high - low)
        self.index.set_opening(self.data, opening)
        self.data.qpos[self.index.joints[2]] = -STANDOFF
        self.closing = 0.0
        mujoco.mj_forward(compiled.model, self.data)

    def move(self, seconds: float, targets: object, close: bool = False) -> None:
        count = round(seconds / self.compiled.model.opt.timestep)
        for k in range(1, count + 1):
            self.data.ctrl[list(self.index.actuators)] = targets(k / count)  # type: ignore[operator]
            if close:
                self.closing = min(1.0, 1.25 * k / count)
            self.data.ctrl[self.index.gripper] = self.open + (255 - self.open) * self.closing
            mujoco.mj_step(self.compiled.model, self.data)

    def in_hand(self) -> Pose:
        return self.index.pose(self.data).inverse() * self.compiled.pose(self.data, self.item)
