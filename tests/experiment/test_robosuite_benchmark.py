"""The benchmark of robosuite, as far as it needs no robosuite: its lines, what it refuses, and what its actions become.

The script runs with this Python, as a process; where a simulator is needed, one of a few lines stands for it.
"""

from __future__ import annotations

import importlib.util
import json
import subprocess
import sys
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
from conftest import ROOT

from cramlite import UserError
from cramlite.experiment.benchmark.protocol import module_of
from cramlite.experiment.benchmark.spec import read_benchmark

ROBOSUITE = ROOT / "experiments" / "robosuite"


@pytest.fixture(scope="module")
def script() -> ModuleType:
    """The benchmark's script as a module."""
    spec = importlib.util.spec_from_file_location("robosuite_simulator", ROBOSUITE / "simulator.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


class Environment:
    """What the benchmark asks of robosuite's environment; the nut is on its peg after the third action."""

    def __init__(self) -> None:
        arm = SimpleNamespace(output_max=np.array([0.05] * 3 + [0.5] * 3), kp=np.array([150.0]))
        self.robots = [SimpleNamespace(part_controllers={"right": arm})]
        self.actions: list[Any] = []

    def step(self, action: Any) -> None:
        self.actions.append(action)

    def _check_success(self) -> bool:
        return len(self.actions) >= 3


@pytest.fixture
def simulator(script: ModuleType, monkeypatch: pytest.MonkeyPatch) -> Any:
    """A benchmark in the middle of an episode."""
    monkeypatch.setattr(script.Simulator, "feel", lambda self: {})
    monkeypatch.setattr(script.Simulator, "_opening", lambda self: 0.05)
    found = script.Simulator()
    found.env, found.force = Environment(), SimpleNamespace(begin=lambda: None)
    return found


def answers(lines: list[str]) -> list[dict[str, Any]]:
    """What the process answers to lines, each an object; it ends by itself with the input."""
    ran = subprocess.run(
        [sys.executable, str(ROBOSUITE / "simulator.py")], input="\n".join(lines), capture_output=True, text=True, timeout=60, check=True
    )
    return [json.loads(line) for line in ran.stdout.splitlines()]


def test_requests_that_cannot_be_served_are_refused_in_a_line_each() -> None:
    asked = [
        {"ask": "scene"}, {"ask": "dance"}, {"ask": "reset", "suite": "nut_oval_panda", "task": 0, "state": 0},
        {"ask": "reset", "suite": "nut_square_panda", "task": 1, "state": 0},
        {"ask": "reset", "suite": "nut_square_ur5e", "task": 0, "state": -1},
        {"ask": "reset"},
    ]  # fmt: skip
    said = answers([*map(json.dumps, asked), "no JSON", "[1]", '{"ask": "end"}', '{"ask": "scene"}'])
    for one, expected in zip(said, (
        "'scene' needs an episode", "no request 'dance'", "no suite 'nut_oval_panda'; there are nut_square_panda", "one task, 0, not 1",
        "from 0, not -1", "TypeError", "JSONDecodeError", "AttributeError",
    ), strict=True):  # fmt: skip
        assert list(one) == ["error"] and expected in one["error"]


@pytest.mark.parametrize(("robot", "sign"), [("panda", 1.0), ("ur5e", -1.0)])
def test_an_action_is_what_the_controller_takes_in_its_own_base(script: ModuleType, simulator: Any, robot: str, sign: float) -> None:
    """In shares of the largest step, cut off at it; x and y of the UR5e are turned round."""
    simulator.robot = script.ROBOTS[robot]
    simulator.step(delta=[0.025, 0.2, -0.05, 0.0, 0.25, 0.5], opening=simulator.robot.opening[1], grip=20.0)
    assert simulator.env.actions[0] == pytest.approx([sign * 0.5, sign * 1.0, -1.0, 0.0, sign * 0.5, 1.0, -1.0])


def test_the_hand_follows_what_is_asked_a_quantum_an_action(script: ModuleType, simulator: Any) -> None:
    closed, opened = script.ROBOTS["panda"].opening
    still = [0.0] * 6
    for _ in range(7):
        simulator.step(delta=still, opening=closed, grip=20.0)
    assert simulator.hand == pytest.approx(1.0) and [a[-1] for a in simulator.env.actions] == [1.0] * 5 + [0.0] * 2
    simulator.step(delta=still, opening=opened, grip=20.0)
    assert simulator.env.actions[-1][-1] == -1.0 and simulator.hand == pytest.approx(0.8)


def test_a_hand_that_gives_is_commanded_no_farther_than_it_shall_press(script: ModuleType, simulator: Any) -> None:
    """Fingers that a thing holds 50 mm apart."""
    simulator.robot, between = script.ROBOTS["ur5e"], simulator._opening()
    closed, opened = simulator.robot.opening
    for _ in range(12):
        simulator.step(delta=[0.0] * 6, opening=closed, grip=33.0)
    ahead = between - (closed + (1.0 - simulator.hand) / 2 * (opened - closed))
    assert ahead == pytest.approx(33.0 * simulator.robot.give, abs=simulator.robot.quantum / 4 * (opened - closed))
    simulator.step(delta=[0.0] * 6, opening=opened, grip=33.0)
    assert simulator.env.actions[-1][-1] == -1.0  # it opens as before


def test_a_bin_shows_the_compartment_that_its_check_asks_for(script: ModuleType, simulator: Any) -> None:
    """``PickPlace.not_in_bin``: of the can the quarter at growing x and y."""
    simulator.env.bin_size = (0.39, 0.49, 0.82)
    text = '<mujoco><body name="bin1"/><body name="bin2" pos="0 0 0"><geom size=".2 .25 .02" type="box"/></body></mujoco>'
    simulator.env.sim = SimpleNamespace(model=SimpleNamespace(get_xml=lambda: text))
    simulator.task = script.TASKS["lift"]
    assert simulator._model() == text
    simulator.task = script.TASKS["can"]
    (site,) = ElementTree.fromstring(simulator._model()).findall("body[@name='bin2']/site")
    middle, half = ([float(v) for v in site.attrib[key].split()] for key in ("pos", "size"))
    low, high = np.subtract(middle, half), np.add(middle, half)
    assert site.attrib["name"] == "can_compartment"
    assert low == pytest.approx([0.01, 0.01, 0.02], abs=1e-4) and high == pytest.approx([0.185, 0.235, 0.1], abs=1e-4)


def test_the_first_action_that_is_true_is_kept(simulator: Any) -> None:
    for _ in range(5):
        simulator.step(delta=[0.0] * 6, opening=0.08, grip=20.0)
    assert simulator.check() == {"success": True, "first": 3, "steps": 5}


def test_every_suite_is_one_of_the_script(script: ModuleType) -> None:
    named = {f"{suite}_{robot}" for suite in script.TASKS for robot in script.ROBOTS}
    assert set(read_benchmark(ROBOSUITE / "experiment.yaml").spec.suites) == named


def test_an_environment_that_is_not_there_is_said_with_the_command_that_makes_it(tmp_path: Path) -> None:
    with pytest.raises(UserError, match=r"robosuite's environment is not installed: .*pip install robosuite==1.5.2 mujoco==3.3.0"):
        module_of(ROBOSUITE / "connection.py").connect(tmp_path)
