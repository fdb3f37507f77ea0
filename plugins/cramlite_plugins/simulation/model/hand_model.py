"""A free-floating hand with thumb and index: the simulated hand of a demonstrator.

It is moved by servos of finite strength and holds by friction alone. Its tool frame is a gripper's: z is
the approach direction, y the closing direction, thumb (left) on +y.
At rest tool z is world +x and tool y is world +y: approaches forward, sideways and downward are at most 120 degrees
away. The ball joint's servos act on the rotation vector from rest, so targets stay within 170 degrees of it; a
demonstration that needs others compiles its world with another rest (``compile_world(..., hand=rest)``).

Sizes: a fingertip 20 mm wide and 30 mm long, a palm 90 x 30 x 60 mm, an opening of 100 mm; forces: 60 N by the arm,
40 N by the pinch (adult lateral pinch strength is 40 to 100 N, Mathiowetz et al. 1985).
"""

from __future__ import annotations

import itertools
import math

from cramlite.model import Pose
from cramlite.plugin import UserError

from .index import Data, EffectorIndex, Model, effector_fields

OPENING = 0.10
TCP = 0.12
PINCH = 40.0
REST = Pose.from_axes((0, 0, 0), z=(1, 0, 0), x=(0, 0, -1))
HANDS = ("hand", "other_hand")
"""Names of a demonstrator's hands: the acting one, and the other, if the person has two."""
FARTHEST = math.radians(170)


class WristTooFar(UserError):
    """Raised when a demonstration needs a hand pose that the wrist cannot turn to."""


class HandIndex(EffectorIndex):
    """Indices of a hand in the MuJoCo model.

    Args:
        slides, ball: qpos addresses of the position and of the orientation.
        dofs: address of its first of six dofs.
        servos: the six actuators, position first.
        rest: the tool's orientation at zero rotation.
    """

    slides: int
    ball: int
    dofs: int
    servos: tuple[int, ...]
    rest: Pose

    @property
    def home(self) -> Pose:
        """Return the pose at which the hand waits: the tool frame in the world."""
        return Pose((0.3, 0.4, 0.5)) * self.rest

    def set_target(self, data: Data, pose: Pose, opening: float) -> None:
        """Servo the tool frame towards a pose (world) and the fingers towards an opening [m].

        Raises:
            WristTooFar: the pose is turned more than 170 degrees away from rest.
        """
        turn = _turn(pose, self.rest)
        data.ctrl[list(self.servos)] = (*pose.position, *turn.rotvec)
        data.ctrl[self.gripper] = (self.reach[1] - opening) / 2

    def teleport(self, model: Model, data: Data, pose: Pose, opening: float = OPENING) -> None:
        """Set the state of the hand: a pose (world) and an opening [m], at rest, without any physics."""
        data.qpos[self.slides : self.slides + 3] = pose.position
        data.qpos[self.ball : self.ball + 4] = _turn(pose, self.rest).quaternion
        data.qvel[self.dofs : self.dofs + 6] = 0.0
        self.set_opening(data, opening)


def _turn(pose: Pose, rest: Pose) -> Pose:
    """Rotation of a free-floating hand from its rest orientation to that of a pose."""
    turn = Pose((0, 0, 0), pose.quaternion) * rest.inverse()
    angle = math.hypot(*turn.rotvec)
    if angle > FARTHEST:
        raise WristTooFar(
            f"the simulated person's wrist would have to turn by {math.degrees(angle):.0f} degrees from how the hand rests, and"
            f" turns by {math.degrees(FARTHEST):.0f} degrees at most; move or turn what the hand is to handle, or take another seed"
        )
    return turn


def hand_index(model: Model, rest: Pose, name: str = HANDS[0]) -> HandIndex:
    """Look up the joints and actuators of a hand whose names in the MuJoCo model begin with ``{name}/``."""
    slide, ball = model.joint(f"{name}/x"), model.joint(f"{name}/turn")
    return HandIndex(
        slides=int(slide.qposadr[0]),
        ball=int(ball.qposadr[0]),
        dofs=int(slide.dofadr[0]),
        servos=tuple(model.actuator(f"{name}/{n}").id for n in ("x", "y", "z", "rx", "ry", "rz")),
        rest=rest,
        **effector_fields(model, name, "palm", (0.0, OPENING)),
    )


def hand_mjcf(rest: Pose = REST) -> str:
    """Write the hand as MJCF text; its body's origin is the tool frame's, so that servos act on it directly."""
    return (
        '<mujoco model="hand"><compiler angle="radian" autolimits="true"/><worldbody>'
        '<body name="carriage" gravcomp="1">'
        '<inertial pos="0 0 0" mass="0.2" diaginertia="0.001 0.001 0.001"/>'
        + "".join(f'<joint name="{n}" type="slide" axis="{a}"/>' for n, a in zip("xyz", _axes(), strict=True))
        + '<body name="wrist" gravcomp="1"><inertial pos="0 0 0" mass="0.1" diaginertia="0.001 0.001 0.001"/>'
        '<joint name="turn" type="ball" armature="0.002"/>'
        f"{_palm(rest)}</body></body></worldbody>{_tendon_and_actuator()}</mujoco>"
    )


def _axes() -> tuple[str, str, str]:
    return ("1 0 0", "0 1 0", "0 0 1")


def _palm(rest: Pose) -> str:
    skin = 'rgba="0.87 0.68 0.57 1"'
    quat = " ".join(f"{v:.9g}" for v in rest.quaternion)
    return (
        f'<body name="palm" quat="{quat}" gravcomp="1"><site name="ft" pos="0 0 {-TCP}"/><site name="tcp"/>'
        '<inertial pos="0 0 -0.08" mass="0.35" diaginertia="0.0005 0.0005 0.0003"/>'
        f'<geom name="palm/0" type="box" pos="0 0 -0.095" size="0.015 0.045 0.03" {skin}/>'
        f'<geom name="palm/1" type="cylinder" fromto="0 0 -0.20 0 0 -0.12" size="0.028" {skin}/>'
        f"{_finger('left', 1, 0.011)}{_finger('right', -1, 0.009)}</body>"
    )


def _finger(name: str, side: int, radius: float) -> str:
    inner = OPENING / 2
    back = side * (inner + 0.008 + radius)
    return (
        f'<body name="{name}_finger" gravcomp="1"><inertial pos="0 {back:.6g} -0.02" mass="0.06"'
        ' diaginertia="0.00003 0.00003 0.00001"/>'
        f'<joint name="{name}_finger" type="slide" axis="0 {-side} 0" range="0 {inner}" damping="100" armature="0.3"/>'
        f'<geom name="{name}_finger/0" type="capsule" fromto="0 {back:.6g} -0.06 0 {back:.6g} 0.005" size="{radius}"'
        ' rgba="0.87 0.68 0.57 1"/>'
        f'<geom name="{name}_pad" type="box" pos="0 {side * (inner + 0.004):.6g} 0" size="0.010 0.004 0.015"'
        ' friction="0.9 0.005 0.0001" condim="4" priority="1" solref="0.004 1" rgba="0.80 0.56 0.46 1"/></body>'
    )


def _tendon_and_actuator() -> str:
    names = ("palm", "left_finger", "right_finger")
    skip = "".join(f'<exclude body1="{a}" body2="{b}"/>' for a, b in itertools.combinations(names, 2))
    move = "".join(
        f'<position name="{n}" joint="{n}" kp="6000" kv="160" forcerange="-60 60" ctrlrange="-10 10"/>' for n in "xyz"
    )
    turn = "".join(
        f'<general name="r{n}" joint="turn" gear="{a} 0 0 0" ctrlrange="-3.2 3.2" forcerange="-6 6" gainprm="40"'
        ' biastype="affine" biasprm="0 -40 -1.2"/>'
        for n, a in zip("xyz", _axes(), strict=True)
    )
    return (
        f'<contact>{skip}</contact><tendon><fixed name="closing"><joint joint="left_finger" coef="0.5"/>'
        '<joint joint="right_finger" coef="0.5"/></fixed></tendon>'
        '<equality><joint joint1="left_finger" joint2="right_finger" solref="0.004 1"/></equality>'
        f"<actuator>{move}{turn}"
        f'<position name="gripper" tendon="closing" kp="20000" kv="100" ctrlrange="0 {OPENING / 2}"'
        f' forcerange="{-2 * PINCH} {2 * PINCH}"/></actuator>'
        '<sensor><force name="ft_force" site="ft"/><torque name="ft_torque" site="ft"/></sensor>'
    )
