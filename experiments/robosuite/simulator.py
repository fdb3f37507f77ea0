"""robosuite's simulator and checks as a process: it runs in an environment of its own and speaks JSON lines.

Nothing of cramlite is imported here; ``connection.py`` starts it. Requests: ``reset`` (suite, task, state), ``scene``, ``check``,
``cameras``, and those of a robot process (``hello``, ``step``, ``end``; docs/how-to/drive_a_robot.md). A suite is one of robosuite's
environments with one of its robots, a state the seed that its reset draws from. The arm takes deltas of its end effector through
robosuite's default controller, OSC_POSE. A request that cannot be served is answered with ``error``.
"""

from __future__ import annotations

import base64
import io
import os
import re
import sys
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

os.environ.setdefault("MUJOCO_GL", "egl")

import mujoco
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from benchmark_lines import Refused, serve
from wrist_force import WristForce

RATE = 20
"""Actions in a second [Hz]: robosuite's default."""
SETTLED, LONGEST = 0.001, 200
"""Speed below which things have settled after a reset [m/s or rad/s], and the largest number of idle actions until then.
PickPlaceCan parks the products that it does not ask for 10 m up and aside, from where they fall to the floor."""
WALL = 0.02
"""Thickness of the walls of robosuite's bins [m]."""
PIXELS = 256


class Task(NamedTuple):
    """Task of robosuite.

    Args:
        environment: what robosuite calls it.
        goal: what its check asks for, in sentences about bodies: in cramlite's words.
        options: of the environment, where they are not its own.
        compartment: body that a bin has a quarter for, which only the environment's numbers mark: it is shown as a site of the bin.
    """

    environment: str
    goal: tuple[str, ...]
    options: Mapping[str, Any] = MappingProxyType({})
    compartment: str = ""


TASKS = {
    "nut_square": Task("NutAssemblySquare", ("SquareNut_main on peg1",)),
    "nut_round": Task("NutAssemblyRound", ("RoundNut_main on peg2",)),
    "lift": Task("Lift", ("cube_main off table",)),
    "stack": Task("Stack", ("cubeA_main on cubeB_main",)),
    "can": Task("PickPlaceCan", ("Can_main in bin2/can_compartment",), compartment="can"),
    "door": Task("Door", ("Door_door open",), MappingProxyType({"use_latch": False})),
    "latch": Task("Door", ("Door_door open",), MappingProxyType({"use_latch": True})),
}
"""Beginning of a suite's name -> its task."""


PADS = "gripper0_right_{}_fingerpad_collision"
TURNED = np.array([-1.0, -1.0, 1.0])
"""Factors on x, y and z that convert a vector between cramlite's base frame and one turned by 180 deg about z."""


class Robot(NamedTuple):
    """Robot of robosuite.

    Args:
        there: what robosuite calls it.
        name: what cramlite calls it.
        joints: of the arm.
        base: body that it stands by.
        turned: whether cramlite's base of it is turned by 180 deg about the vertical.
        opening: between the pads with the hand's command at 1 and at -1 [m].
        quantum: what an action changes of that command: ``speed`` of robosuite's grippers.
        give: by how much the command must be ahead of the fingers to press with a newton [m/N]; 0: it presses with what robosuite has.
    """

    there: str
    name: str
    joints: int
    base: str
    turned: bool
    opening: tuple[float, float]
    quantum: float = 0.2
    give: float = 0.0


ROBOTS = {
    "panda": Robot("Panda", "libero_panda", 7, "robot0_link0", False, (0.0, 0.08)),
    "ur5e": Robot("UR5e", "robosuite_ur5e", 6, "robot0_base", True, (0.0126, 0.108), give=0.0006),
}


class Simulator:
    """robosuite's simulator, with one episode at a time, and its checks."""

    def __init__(self) -> None:
        self.env: Any = None
        self.robot, self.task = ROBOTS["panda"], TASKS["lift"]
        self.steps, self.first, self.hand = 0, None, 0.0
        self.force: Any = None

    def reset(self, suite: str, task: int, state: int) -> dict[str, Any]:
        """Begin an episode, and wait until its things are at rest."""
        name, _, robot = suite.rpartition("_")
        if name not in TASKS or robot not in ROBOTS:
            raise Refused(f"there is no suite '{suite}'; there are {', '.join(f'{s}_{r}' for s in TASKS for r in ROBOTS)}")
        if task != 0:
            raise Refused(f"a suite has one task, 0, not {task}")
        if state < 0:
            raise Refused(f"a state is the seed of an episode, from 0, not {state}")
        import robosuite
        from robosuite.controllers import load_composite_controller_config

        self.robot, self.task = ROBOTS[robot], TASKS[name]
        if self.env is not None:
            self.env.close()
        kind = self.robot.there
        self.env = robosuite.make(
            self.task.environment, robots=kind, controller_configs=load_composite_controller_config(controller="BASIC", robot=kind),
            has_renderer=False, has_offscreen_renderer=False, use_camera_obs=False, control_freq=RATE, horizon=100_000,
            ignore_done=True, seed=state, **self.task.options,
        )  # fmt: skip
        self.env.reset()
        arm = self.env.robots[0]
        self.force = WristForce(self.env, lambda: arm.ee_force["right"])
        for k in range(LONGEST):
            self.env.step(np.zeros(self.env.action_dim))
            if k and np.abs(self.env.sim.data.qvel).max() < SETTLED:
                break
        self.hand, self.steps, self.first = 0.0, 0, None
        return {"task": self.task.environment}

    def scene(self) -> dict[str, Any]:
        """Describe the world: the model as MJCF, its state, the goal, and where the robot stands."""
        sim, robot = self.env.sim, self.robot
        base = sim.model.body_name2id(robot.base)
        return {
            "xml": self._model(), "qpos": sim.data.qpos.tolist(), "goal": self.task.goal,
            "base": sim.data.body_xpos[base].tolist(), "yaw": 180 if robot.turned else 0,
        }  # fmt: skip

    def _model(self) -> str:
        """Model as MJCF, with a site for the compartment that the task's success check asks for: between
        the walls of its bin, up to their tops."""
        text: str = self.env.sim.model.get_xml()
        if not self.task.compartment:
            return text
        x, y, _ = np.array(self.env.bin_size) / 4
        size = f'size="{x - WALL / 2:.4f} {y - WALL / 2:.4f} 0.04" pos="{x:.4f} {y:.4f} 0.06"'
        site = f'<site name="{self.task.compartment}_compartment" type="box" {size} rgba="0 0 0 0"/>'
        return re.sub(r'(<body name="bin2"[^>]*>)', rf"\1{site}", text, count=1)

    def hello(self, **_: Any) -> dict[str, Any]:
        """Return what a client must know of the robot: its type, the kind of its actions, their rate and their limits."""
        controller, robot = self.env.robots[0].part_controllers["right"], self.robot
        inertia = 1.0 / float(controller.kp[0])  # of a critically damped spring, which is pulled along and holds an action for a period
        lag = 2.0 * inertia**0.5 - 0.5 / RATE
        return {
            "protocol": 1, "robot": robot.name, "actions": "deltas", "rate": RATE, "lag": lag, "inertia": inertia,
            "most": [float(controller.output_max[0]), float(controller.output_max[3])], "tolerance": [0.004, 0.02],
            "fingers": float(np.ptp(robot.opening)) * robot.quantum / 4 * 1.1, "hesitation": 2 / robot.quantum / RATE + 0.05,
        } | self.feel()  # fmt: skip

    def step(self, delta: list[float], opening: float, grip: float) -> dict[str, Any]:
        """Take an action; for a hand that is commanded by position, ``grip`` sets how far the command may run
        ahead of the fingers."""
        robot = self.robot
        opening = max(opening, self._opening() - grip * robot.give) if robot.give else opening
        most = self.env.robots[0].part_controllers["right"].output_max
        action = np.clip(self._turned(np.array(delta)) / most, -1.0, 1.0)
        closed, opened = robot.opening
        wanted = 1.0 - 2.0 * (opening - closed) / (opened - closed)
        turn = 0.0 if abs(wanted - self.hand) <= robot.quantum / 2 else float(np.sign(wanted - self.hand))
        self.hand = float(np.clip(self.hand + robot.quantum * turn, -1.0, 1.0))
        self.force.begin()
        self.env.step(np.array([*action, turn]))
        self.steps += 1
        if self.first is None and self.env._check_success():
            self.first = self.steps
        return self.feel()

    def _turned(self, vectors: Any) -> Any:
        """Convert translation and rotation between cramlite's base and robosuite's, in either direction."""
        return vectors * np.tile(TURNED, 2) if self.robot.turned else vectors

    def feel(self) -> dict[str, Any]:
        """Return the robot's state."""
        sim, robot = self.env.sim, self.env.robots[0]
        body = sim.model.body_name2id(robot.gripper["right"].root_body)
        turn = sim.data.get_site_xmat("gripper0_right_ft_frame")
        weight = np.array([0.0, 0.0, -9.81 * float(sim.model.body_subtreemass[body])])
        force = -(turn @ self.force.mean() + weight)
        return {
            "joints": np.array(robot._joint_positions).tolist(), "opening": self._opening(),
            "wrench": self._turned(np.array([*force, 0.0, 0.0, 0.0])).tolist(),
        }  # fmt: skip

    def _opening(self) -> float:
        """Distance between the pads [m]: of fingers that slide from their joints, of a linkage from the
        positions of its pads.

        The pads of a linkage are 2 mm thick.
        """
        sim, gripper = self.env.sim, self.env.robots[0].gripper["right"]
        if len(gripper.joints) == 2:
            return float(sum(abs(sim.data.get_joint_qpos(j)) for j in gripper.joints))
        left, right = (sim.data.get_geom_xpos(PADS.format(side)) for side in ("left", "right"))
        return float(np.linalg.norm(left - right)) - 0.002

    def check(self) -> dict[str, Any]:
        """Return the result of robosuite's check: now, and at which step it was true for the first time."""
        return {"success": bool(self.env._check_success()), "first": self.first, "steps": self.steps}

    def cameras(self) -> dict[str, Any]:
        """Take a picture with the camera of robosuite's examples, as PNG in base64."""
        from PIL import Image

        renderer = mujoco.Renderer(self.env.sim.model._model, PIXELS, PIXELS)
        renderer.update_scene(self.env.sim.data._data, "agentview")
        Image.fromarray(renderer.render()).save(buffer := io.BytesIO(), "png")
        return {"agentview": {"png": base64.b64encode(buffer.getvalue()).decode()}}


if __name__ == "__main__":
    serve(Simulator())
