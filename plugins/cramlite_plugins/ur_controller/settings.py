"""URScript functions for settings and state: payload, force mode tuning, freedrive, safety limits.

Names and parameters: the URScript manual (e-Series 5.x), modules "internals" and "motion".
Wrong arguments raise ``ScriptError``.
"""

from __future__ import annotations

from collections import deque
from typing import Any

import numpy as np

from cramlite.model import Floats

from ..kinematics.inverse import nearest_solution
from ..simulation.controller.controller import Controller
from ..simulation.controller.protective_stop import ProtectiveStop
from .urscript.values import PoseValue, ScriptError, as_pose, from_pose, numbers, real

SETTINGS = (
    "get_target_payload", "get_target_payload_cog", "get_target_payload_inertia", "get_tcp_offset",
    "get_actual_tool_flange_pose", "tool_pose", "get_target_tcp_speed", "get_actual_tcp_speed",
    "get_actual_joint_speeds", "get_target_joint_speeds",
    "get_joint_torques", "get_inverse_kin_has_solution", "is_within_safety_limits", "force_mode_set_damping",
    "force_mode_set_gain_scaling", "protective_stop", "tool_contact", "get_actual_joint_positions_history",
    "freedrive_mode", "end_freedrive_mode", "get_freedrive_status", "teach_mode", "end_teach_mode", "set_gravity",
    "get_target_waypoint", "ft_rtde_input_enable", "enable_external_ft_sensor",
)  # fmt: skip
HISTORY = 100  # cycles that a program may look back on (manual, "get_actual_joint_positions_history")
TOUCH = (1.0, 4.0)
"""Force against the direction of ``tool_contact`` at which a contact begins, and at which it is confirmed [N]: twice and eight times the
dead band of our force mode. UR's own detection is not published."""


class Settings:
    """URScript functions that read or change settings and state of the virtual controller during one run."""

    def __init__(self, controller: Controller) -> None:
        self.arm = controller
        self.inertia = [0.0] * 6
        self.past: deque[tuple[Floats, Floats]] = deque(maxlen=HISTORY)

    def remember(self) -> None:
        """Record joint positions and force of a control cycle, for the functions that return values of past
        cycles."""
        self.past.append((self.arm.actual_joints(), self.arm.force_vector()))

    # Payload and tool

    def get_target_payload(self) -> float:
        """Return the mass of the payload [kg]."""
        return float(self.arm.sensor.mass)

    def get_target_payload_cog(self) -> list[float]:
        """Return the centre of gravity of the payload in the flange frame [m]."""
        return [float(v) for v in self.arm.sensor.center]

    def get_target_payload_inertia(self) -> list[float]:
        """Return the inertia of the payload (6,) [kg m2]."""
        return list(self.inertia)

    def get_tcp_offset(self) -> PoseValue:
        """Return the tool centre point in the flange frame."""
        return from_pose(self.arm.arm.gripper.tcp)

    def get_actual_tool_flange_pose(self) -> PoseValue:
        """Return the flange in the base frame, from the encoders."""
        from cramlite.model import Pose

        return from_pose(Pose.from_matrix(self.arm.kinematics.flange(self.arm.actual_joints())))

    def tool_pose(self) -> PoseValue:
        """Return the TCP in the base frame, from the encoders; programs of PolyScope 3 call this when they
        set a force in the tool's frame."""
        return from_pose(self.arm.actual_tcp())

    # Speeds and torques

    def get_actual_tcp_speed(self) -> PoseValue:
        """Return the measured twist (6,) of the TCP, base axes [m/s, rad/s]."""
        return PoseValue(map(float, self.arm.kinematics.speed(self.arm.actual_joints(), self.arm.actual_speeds())))

    def get_target_tcp_speed(self) -> PoseValue:
        """Return the commanded twist (6,) of the TCP, base axes [m/s, rad/s]."""
        return PoseValue(map(float, self.arm.tool_speed()))

    def get_target_joint_speeds(self) -> list[float]:
        """Return the commanded joint speeds [rad/s]."""
        return [float(v) for v in self.arm.rate]

    def get_actual_joint_speeds(self) -> list[float]:
        """Return the measured joint speeds [rad/s]."""
        return [float(v) for v in self.arm.actual_speeds()]

    def get_joint_torques(self) -> list[float]:
        """Return the joint torques beyond those that hold the arm's own weight [Nm]."""
        return [float(v) for v in self.arm.joint_torques()]

    # Where it may go

    def get_inverse_kin_has_solution(
        self, pose: Any, qnear: Any = None, maxPositionError: Any = 1e-10, maxOrientationError: Any = 1e-10, tcp: Any = None
    ) -> bool:
        """Check whether inverse kinematics has a solution for a TCP pose, on whatever branch."""
        near = self.arm.q if qnear is None else np.array(numbers(qnear, len(self.arm.q), "qnear"))
        place = as_pose(pose, "get_inverse_kin_has_solution")
        if tcp is not None:
            place = place * as_pose(tcp, "get_inverse_kin_has_solution").inverse() * self.arm.arm.gripper.tcp
        return nearest_solution(self.arm.arm, place, tuple(near)) is not None

    def is_within_safety_limits(self, pose: Any) -> bool:
        """Check whether joint positions are within their limits, or a pose has a solution."""
        if isinstance(pose, PoseValue):
            return self.get_inverse_kin_has_solution(pose)
        q = np.array(numbers(pose, len(self.arm.q), "is_within_safety_limits"))
        return bool(((q >= self.arm.watch.limits[0]) & (q <= self.arm.watch.limits[1])).all())

    def get_target_waypoint(self) -> PoseValue:
        """Refuse ``get_target_waypoint``: it is not modelled."""
        raise ScriptError("get_target_waypoint is not modelled here: keep the target in a variable")

    # Force mode and contact

    def force_mode_set_damping(self, damping: Any) -> None:
        """Check the damping of force mode, 0 to 1, without effect: the model keeps its own."""
        self._tune(damping, "damping", 0.0, 1.0)

    def force_mode_set_gain_scaling(self, scaling: Any) -> None:
        """Set the gain scaling of force mode, 0 to 2."""
        self.arm.force_gain = self._tune(scaling, "gain scaling", 0.0, 2.0)

    def tool_contact(self, direction: Any = None) -> int:
        """Count the control cycles since the tool began to touch something in its way; 0 without a contact."""
        way = np.array(self.get_target_tcp_speed() if direction is None else numbers(direction, 6, "tool_contact"))[:3]
        if (size := np.linalg.norm(way)) < 1e-9:
            return 0
        against = [-float(force @ way) / size for _, force in self.past]
        if not against or against[-1] < TOUCH[1]:
            return 0
        return next((n for n, f in enumerate(reversed(against)) if f < TOUCH[0]), len(against))

    def get_actual_joint_positions_history(self, steps: Any = 0) -> list[float]:
        """Return the joint positions a number of control cycles ago [rad]."""
        if type(steps) is not int or not 0 <= steps < HISTORY:
            raise ScriptError(f"get_actual_joint_positions_history: steps must be 0 .. {HISTORY - 1}")
        back = min(steps, len(self.past) - 1)
        q = self.past[-1 - back][0] if self.past else self.arm.actual_joints()
        return [float(v) for v in q]

    # Hand guiding

    def freedrive_mode(self, freeAxes: Any = None, feature: Any = None) -> None:
        """Switch freedrive on."""
        self.arm.freedrive = True

    def end_freedrive_mode(self) -> None:
        """Switch freedrive off."""
        self.arm.freedrive = False

    def get_freedrive_status(self) -> int:
        """Return 1 in freedrive, else 0."""
        return int(self.arm.freedrive)

    def teach_mode(self) -> None:
        """Switch freedrive on."""
        self.freedrive_mode()

    def end_teach_mode(self) -> None:
        """Switch freedrive off."""
        self.end_freedrive_mode()

    # What stops, and what this controller does not have

    def protective_stop(self) -> None:
        """Trigger a protective stop."""
        raise ProtectiveStop("the program asked for it")

    def set_gravity(self, d: Any) -> None:
        """Check that the direction opposite to gravity (3,) [m/s2] agrees with the mount of the robot."""
        wanted = np.array(numbers(d, 3, "set_gravity"))
        if np.linalg.norm(wanted / 9.81 - self.arm.up) > 0.05:
            raise ScriptError(f"set_gravity {[float(v) for v in wanted]}: gravity here is along {self.arm.up.tolist()}")

    def ft_rtde_input_enable(
        self, enable: Any, sensor_mass: Any = 0, sensor_offset: Any = None, sensor_cog: Any = None
    ) -> None:
        """Refuse to enable an external force sensor: the flange's is used."""
        if enable:
            raise ScriptError("no external force sensor is connected: the one of the flange is used")

    def enable_external_ft_sensor(
        self, enable: Any, sensor_mass: Any = 0, sensor_offset: Any = None, sensor_cog: Any = None
    ) -> None:
        """Refuse to enable an external force sensor: the flange's is used."""
        self.ft_rtde_input_enable(enable)

    def _tune(self, value: Any, name: str, low: float, high: float) -> float:
        wanted = real(value, name)
        if not low <= wanted <= high:
            raise ScriptError(f"force mode's {name} is {low:g} .. {high:g}, not {wanted:g}")
        return wanted
