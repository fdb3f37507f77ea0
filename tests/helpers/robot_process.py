"""A robot that takes actions, for tests: a MuJoCo world behind the JSON lines of docs/how-to/drive_a_robot.md.

``python robot_process.py WORLD [options]``. It knows nothing of programs: it sends its servos where an action says, in physics steps of
2 ms, and answers with what its encoders, fingers and wrist feel. Actions are joint positions, or deltas that a resolved-rate controller
follows as a first-order system. Somebody may take a thing away, for negative tests.
"""

from __future__ import annotations

import argparse
import json
import sys
from typing import Any

import mujoco
import numpy as np

from cramlite.model import Pose
from cramlite.plugin.catalogue import Knowledge
from cramlite.plugin.selection import INSTALLED
from cramlite.scenario.worlds import read_world
from cramlite_plugins.simulation.model.compile import Compiled, compile_world

RATE = 20.0
FOLLOWS = 0.08  # time constant of the resolved-rate controller [s]
DAMPING = 1e-4


class Robot:
    """Simulated robot behind the protocol, with the world around it."""

    def __init__(self, compiled: Compiled, base: Pose, actions: str, feels: bool) -> None:
        self.compiled, self.model, self.data = compiled, compiled.model, compiled.data()
        (self.index,) = compiled.robots.values()
        self.turn, self.actions, self.feels = base.rotation, actions, feels
        self.servos, self.joints, self.dofs = (list(v) for v in (self.index.actuators, self.index.joints, self.index.dofs))
        self.sent = self.data.qpos[self.joints].copy()
        self.steps = round(1.0 / RATE / self.model.opt.timestep)
        self.hand(self.index.reach[1], 40.0)
        for _ in range(250):
            mujoco.mj_step(self.model, self.data)

    @property
    def lag(self) -> float:
        """Time constant of the robot's lag behind its commands [s]."""
        k = self.servos[0]
        servo = -float(self.model.actuator_biasprm[k, 2] / self.model.actuator_gainprm[k, 0])
        return servo + (FOLLOWS if self.actions == "deltas" else 0.0)

    def hand(self, opening: float, grip: float) -> None:
        low, high = self.index.reach
        self.model.actuator_forcerange[self.index.gripper] = (-2 * grip, 2 * grip)
        self.data.ctrl[self.index.gripper] = 255 * (high - opening) / (high - low)

    def step(self, ask: dict[str, Any]) -> None:
        """Execute an action, for one control period."""
        self.hand(ask["opening"], ask["grip"])
        if self.actions == "joints":
            for way in np.linspace(self.sent, ask["joints"], self.steps + 1)[1:]:
                self.advance(way)
            return
        goal = self.tool() * Pose()
        shift, turned = self.turn @ ask["delta"][:3], self.turn @ ask["delta"][3:]
        place = np.array(goal.position) + shift
        quaternion = np.zeros(4)
        mujoco.mju_axisAngle2Quat(quaternion, turned / (np.linalg.norm(turned) + 1e-12), np.linalg.norm(turned))
        mujoco.mju_mulQuat(target := np.zeros(4), quaternion, np.array(goal.quaternion))
        for _ in range(self.steps):
            self.advance(self.sent + self.towards(place, target) * self.model.opt.timestep)

    def towards(self, place: Any, quaternion: Any) -> Any:
        """Return the joint speeds that lead the tool to a pose [rad/s]."""
        here = self.tool()
        error = np.zeros(6)
        error[:3] = place - here.position
        back = np.array(here.quaternion) * (1, -1, -1, -1)
        mujoco.mju_mulQuat(turn := np.zeros(4), quaternion, back)
        mujoco.mju_quat2Vel(error[3:], turn, 1.0)
        jacobian = np.zeros((6, self.model.nv))
        mujoco.mj_jacSite(self.model, self.data, jacobian[:3], jacobian[3:], self.index.tcp)
        j = jacobian[:, self.dofs]
        return j.T @ np.linalg.solve(j @ j.T + DAMPING * np.eye(6), error / FOLLOWS)

    def advance(self, q: Any) -> None:
        self.sent = np.asarray(q)
        self.data.ctrl[self.servos] = q
        mujoco.mj_step(self.model, self.data)

    def tool(self) -> Pose:
        return self.index.pose(self.data)

    def state(self) -> dict[str, Any]:
        said: dict[str, Any] = {
            "joints": self.data.qpos[self.joints].tolist(), "opening": float(self.index.opening(self.data.qpos)),
        }  # fmt: skip
        if self.feels:
            said["wrench"] = [*self.felt().tolist(), 0.0, 0.0, 0.0]
        return said

    def felt(self) -> Any:
        """Return the force of the environment on the tool, base axes [N]."""
        turn = self.data.site_xmat[self.index.ft].reshape(3, 3)
        reading = self.data.sensordata[self.index.ft_force : self.index.ft_force + 3]
        weight = -self.index.robot.gripper.mass * 9.81 * turn[2]
        return -self.turn.T @ (turn @ (reading + weight))

    def places(self) -> str:
        """Return the positions of the movable things, as JSON."""
        free = [t.name for t in self.compiled.world.things if t.movable]
        return json.dumps({n: [round(v, 4) for v in self.compiled.pose(self.data, n).position] for n in free})


def say(what: dict[str, Any]) -> None:
    print(json.dumps(what), flush=True)


def serve(robot: Robot, options: argparse.Namespace) -> None:
    """Answer requests until the client sends "end" or closes the connection."""
    steps = 0
    for line in sys.stdin:
        ask = json.loads(line)
        if ask["ask"] == "end":
            break
        if ask["ask"] == "hello":
            hello = {"protocol": 1, "robot": robot.index.robot.type, "actions": options.actions, "rate": RATE}
            say(hello | {"lag": robot.lag} | robot.state())
            continue
        steps += 1
        if steps == options.at:
            take(robot, options.take)
        robot.step(ask)
        say(robot.state())
    if options.result:
        with open(options.result, "w") as file:
            file.write(robot.places())


def take(robot: Robot, name: str) -> None:
    """Remove a thing from the scene: move it half a metre down."""
    thing = robot.compiled.world.thing(name)
    robot.compiled.place(robot.data, name, Pose((0.0, 0.0, -0.5)) * thing.pose)


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("world")
    parser.add_argument("--actions", default="joints", choices=["joints", "deltas"])
    parser.add_argument("--numb", action="store_true", help="it feels nothing")
    parser.add_argument("--take", default="", help="a thing that somebody takes away")
    parser.add_argument("--at", type=int, default=0, help="the step at which that happens")
    parser.add_argument("--result", default="", help="file for where things are at the end")
    options = parser.parse_args()
    knowledge = Knowledge(INSTALLED.registry())
    world = read_world(options.world, knowledge, 0)
    compiled = compile_world(world, knowledge.robots)
    serve(Robot(compiled, world.robots[0].base, options.actions, not options.numb), options)


if __name__ == "__main__":
    main()
