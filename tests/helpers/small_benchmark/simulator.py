"""A small benchmark for tests: a block, a tray and a Panda on a table, in cramlite's MuJoCo, behind the lines of LIBERO's process.

``python simulator.py [WHAT WHEN]``: at the WHEN-th request it dies, hangs, answers garbage, stops the robot, or a can comes. Tasks
of its suite: 0, the block in the tray; 1, the same, but the benchmark looks at the block elsewhere, so that it is never true; 2, a goal
without words; 3, one that is never begun.
"""

from __future__ import annotations

import json
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent))
from robot_process import RATE, Robot, say  # noqa: E402

from cramlite.model import Pose  # noqa: E402
from cramlite.plugin.catalogue import Knowledge  # noqa: E402
from cramlite.plugin.selection import PluginChoice  # noqa: E402
from cramlite.scenario.worlds import read_world  # noqa: E402
from cramlite_plugins.simulation.model.compile import compile_world  # noqa: E402

PANDA = HERE.parents[2] / "experiments" / "libero" / "panda.py"
TASKS = {0: ["in", "block_1", "tray_1_contain_region"], 1: ["in", "block_1", "tray_1_contain_region"], 2: ["juggled", "block_1"]}
THINGS = ("block_1_main", "tray_1_main", "can_1_main")
STATES = {0: (0.45, -0.1), 1: (0.48, -0.15)}
"""Horizontal position of the block for each initial state [m]."""


class Simulator:
    """Simulator of the small benchmark, with one episode at a time."""

    def __init__(self) -> None:
        self.knowledge = Knowledge(PluginChoice((PANDA,)).registry())
        self.can = False

    def reset(self, suite: str, task: int, state: int) -> dict[str, Any]:
        if task not in TASKS:
            return {"error": f"task {task} of '{suite}' is broken"}
        self.task, self.steps, self.first = task, 0, None
        world = read_world(str(HERE / "world.yaml"), self.knowledge, 0)
        block = world.thing("block_1_main").pose
        world = world.moved({"block_1_main": Pose((*STATES[state], block.position[2]), block.quaternion)})
        self.robot = Robot(compile_world(world, self.knowledge.robots), world.robots[0].base, "deltas", True)
        return {"task": f"task {task}"}

    def scene(self, model: bool = True) -> dict[str, Any]:
        poses = {n: self.at(n) for n in THINGS}
        state = {"xml": (HERE / "table.xml").read_text(), "qpos": [v for n in THINGS for v in poses[n]]} if model else {"poses": poses}
        return {
            **state, "goal": [TASKS[self.task]], "bodies": {n.removesuffix("_main"): n for n in THINGS},
            "absent": [] if self.can else ["can_1_main"],
            "regions": {"tray_1_contain_region": {"bodies": ["tray_1_main"]}}, "base": [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0],
        }  # fmt: skip

    def hello(self, **_: Any) -> dict[str, Any]:
        hello = {"protocol": 1, "robot": "libero_panda", "actions": "deltas", "rate": RATE, "lag": self.robot.lag}
        return hello | self.robot.state()

    def step(self, **ask: Any) -> dict[str, Any]:
        self.robot.step(ask)
        self.steps += 1
        if self.first is None and self.there():
            self.first = self.steps
        return self.robot.state() | {"poses": {n: self.at(n) for n in THINGS[: 3 if self.can else 2]}}

    def at(self, name: str) -> list[float]:
        pose = self.robot.compiled.pose(self.robot.data, name)
        return [*pose.position, *pose.quaternion]

    def check(self) -> dict[str, Any]:
        return {"success": self.there(), "first": self.first, "steps": self.steps}

    def there(self) -> bool:
        """Check whether the block's origin is in the box of the goal's region; in task 1 that box is a metre away."""
        data, pose = self.robot.data, self.robot.compiled.pose
        block, tray = pose(data, "block_1_main").position, pose(data, "tray_1_main").position
        away = np.array([0.0, 0.0, 1.0 if self.task == 1 else 0.0])
        return bool(np.all(np.abs(np.subtract(block, tray) - (0.0, 0.0, 0.05) - away) < (0.1, 0.1, 0.05)))


def main() -> None:
    simulator, (what, when) = Simulator(), (*sys.argv[1:], "", 0)[:2]
    for number, line in enumerate(sys.stdin, 1):
        ask = json.loads(line)
        name = ask.pop("ask")
        if name == "end":
            return
        simulator.can = what == "come" and number >= int(when)
        if what and what != "come" and number == int(when):
            go_wrong(what)
            if what == "stop":
                say(simulator.step(**ask) | {"stop": "somebody pressed the button"})
        elif name not in ("reset", "scene", "hello", "step", "check"):
            say({"error": f"there is no request '{name}'"})
        else:
            say(getattr(simulator, name)(**ask))


def go_wrong(what: str) -> None:
    if what == "die":
        sys.exit("segmentation fault")
    if what == "hang":
        time.sleep(600)
    if what == "garbage":
        print("MOTOR OK", flush=True)


if __name__ == "__main__":
    main()
