"""What a robot declares of its axes and its controller is what backends obey, for a plugin's own robot too: names say nothing."""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import Any

import pytest
from msgspec.structs import replace
from test_urscript import STEPS, program

from cramlite import Engine
from cramlite.model import Program, Robot, ZeroSensor
from cramlite.plugin import UserError
from cramlite_plugins.backends.rapid import emit as rapid
from cramlite_plugins.backends.ur_rtde import emit as ur_rtde
from cramlite_plugins.backends.urscript import emit as urscript
from cramlite_plugins.robots.irb1200 import IRB1200
from cramlite_plugins.robots.ur5 import UR5
from cramlite_plugins.robots.ur5e import UR5E

ZEROS = (0.1, -0.2, 0.3, -0.4, 0.5, -0.6)
PLUGIN = """
from cramlite.plugin import hookimpl
from cramlite.model import replace
from cramlite_plugins.robots.irb1200 import IRB1200
from cramlite_plugins.robots.ur5e import UR5E

@hookimpl
def robots():
    return [{declared}]
"""


def engine(folder: Path, declared: str) -> Engine:
    """An engine with a plugin of one robot."""
    file = folder / "arms_of_mine.py"
    file.write_text(PLUGIN.format(declared=declared))
    return Engine(files=[file])


def tared(robot: Robot) -> Program:
    """A program that tares the sensor, for a robot."""
    return Program("p", "arm", robot.type, robot.gripper.tcp, robot.home, (ZeroSensor(),), ())


def written_start(text: str) -> list[float]:
    """The start posture in a RAPID text [rad]."""
    said = re.search(r"jStart := \[\[(.*?)\]", text)
    assert said is not None
    return [math.radians(float(v)) for v in said[1].split(",")]


def test_rapid_counts_from_the_zeros_that_a_robot_of_a_plugin_declares(tmp_path: Path) -> None:
    knowledge = engine(tmp_path, f"replace(IRB1200, type='upright', axis_zeros={ZEROS})").knowledge
    robot = knowledge.robots["upright"]
    start = written_start(knowledge.backends["rapid"].emit(tared(robot), robot).text)
    assert start == pytest.approx([q - z for q, z in zip(IRB1200.home, ZEROS, strict=True)], abs=2e-6)
    assert start != pytest.approx(written_start(rapid.emit(tared(IRB1200), IRB1200, forces=False).text), abs=1e-2)


def test_rapid_refuses_an_arm_whose_zeros_nobody_declared() -> None:
    robot = replace(IRB1200, axis_zeros=None)
    with pytest.raises(UserError, match=r"'irb1200' does not declare where its axes are zero.*'axis_zeros'"):
        rapid.emit(tared(robot), robot, forces=False)


@pytest.mark.parametrize("backend", [urscript, ur_rtde])
def test_universal_robots_languages_refuse_axes_that_are_zero_elsewhere(backend: Any) -> None:
    level = replace(UR5E, axis_zeros=(0.0,) * 6)
    assert backend.emit(tared(level), level).text == backend.emit(tared(UR5E), UR5E).text
    shifted = replace(UR5E, axis_zeros=ZEROS)
    with pytest.raises(UserError, match="'ur5e' declares axes that are not zero where"):
        backend.emit(tared(shifted), shifted)


@pytest.mark.parametrize(
    ("robot", "cb3", "said"),
    [
        (replace(UR5, type="mine"), True, "CB3, PolyScope 3.15 or later; no sensor in the flange: the axia80"),
        (replace(UR5E, type="mine"), False, "PolyScope 5.11 or later\n"),
        (replace(UR5, type="mine", controller="e-Series"), False, "PolyScope 5.11 or later; the axia80 between"),
        (replace(UR5E, type="mine", controller="CB3", sensor=None), True, "no sensor in the flange; forces are estimated by"),
    ],
    ids=["CB3", "e-Series", "e-Series with a sensor of another make", "CB3 without a sensor"],
)
def test_the_controller_is_the_declared_one_whatever_sensor_there_is(robot: Robot, cb3: bool, said: str) -> None:
    text = urscript.emit(tared(robot), robot).text
    code = "\n".join(line.split("#")[0] for line in text.split("\n"))
    assert ("zero_ftsensor()" in code) is not cb3
    assert said in text
    python = ur_rtde.emit(tared(robot), robot).text
    assert f"program, zero={not cb3})" in python
    assert said.strip() in python


@pytest.mark.parametrize("backend", [urscript, ur_rtde])
@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"controller": ""}, "'ur5e' declares no controller .*valid are: CB3, e-Series"),
        ({"controller": "e-series"}, "its controller as 'e-series'.*did you mean 'e-Series'"),
        ({"controller": "IRC5"}, "its controller as 'IRC5'.*valid are: CB3, e-Series"),
        ({"controller": "CB3"}, "a CB3 with a force sensor in the flange"),
    ],
)
def test_a_controller_that_nobody_writes_for_is_refused(backend: Any, changes: dict[str, Any], said: str) -> None:
    robot = replace(UR5E, **changes)
    with pytest.raises(UserError, match=said):
        backend.emit(replace(program(*STEPS), robot_type=robot.type), robot)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ("axis_zeros=(0.0, 0.0)", "axis_zeros is a finite angle for each of 6 joints"),
        ("axis_zeros=(float('nan'),) * 6", "axis_zeros is a finite angle for each of 6 joints"),
        ("controller=5", "'controller' is 5; it must be one word"),
        ("force_limit=0.0", "force_limit 0 N is not in 0 .. 150 N"),
        ("force_limit=500.0", "force_limit 500 N is not in 0 .. 150 N"),
        ("force_limit=float('nan')", "force_limit nan N is not in 0 .. 150 N"),
    ],
)
def test_wrong_declarations_are_refused_with_the_plugin_that_made_them(changes: str, said: str, tmp_path: Path) -> None:
    with pytest.raises(UserError, match=f"arms_of_mine.py' cannot be used: hook robots: .*{re.escape(said)}"):
        _ = engine(tmp_path, f"replace(UR5E, type='mine', {changes})").knowledge.robots
    (tmp_path / "right").mkdir()
    assert "mine" in engine(tmp_path / "right", "replace(UR5E, type='mine')").knowledge.robots
