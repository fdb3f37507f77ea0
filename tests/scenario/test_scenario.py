"""Scenario and rule files hold no joint value, waypoint or task-specific pose; quantities mean what they say."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import yaml
from conftest import ROOT
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from cramlite import read_scenario
from cramlite.base.quantities import MOST, UNITS
from cramlite.model import HandFile, Pose
from cramlite.plugin import parse_quantity
from cramlite.scenario.robots import file_of
from cramlite.scenario.scenario import PoseSpec
from cramlite.scenario.task_specs import task_entry

SCENARIOS = sorted((ROOT / "scenarios").glob("*.yaml"))
RULES = sorted((ROOT / "task_rules").glob("*.yaml"))
WORLD = re.compile(
    r"^(record\.)?things\.\d+\.(at\.(position\.\d|roll|pitch|yaw)|hangs_on\.(depth|yaw)|with\..*)$"
    r"|^tasks\.\d+\.(retry|monitor|repeat)\."
    r"|^(record\.)?vary\.\d+\.(position|yaw|with\..*)$|^unknown_error\.position$|^late\.\d+\.(position|yaw)$|^(robot|camera)\.at\.|^physics\.|^budget\."
)
"""The only places where a scenario may hold a number: the world, what varies in it, physics, budgets, and, where it starts
from tasks, what the user asks of them."""
FORBIDDEN = re.compile(r"joint|waypoint|\bvia\b|trajectory|quaternion|tcp", re.IGNORECASE)


def _leaves(node: Any, place: str = "") -> Iterator[tuple[str, Any]]:
    if isinstance(node, dict | list):
        for key, value in node.items() if isinstance(node, dict) else enumerate(node):
            yield from _leaves(value, f"{place}.{key}" if place else str(key))
    else:
        yield place, node


def _numbers(text: str) -> list[tuple[str, Any]]:
    return [
        (place, value)
        for place, value in _leaves(yaml.safe_load(text))
        if (isinstance(value, int | float) and not isinstance(value, bool))
        or (isinstance(value, str) and re.fullmatch(r"\s*[-+.\d][-+.\de]*\s*[a-z]*\s*", value))
    ]


def _wrong(text: str) -> list[str]:
    words = [p for p, v in _leaves(yaml.safe_load(text)) if FORBIDDEN.search(p)]
    return words + [place for place, _ in _numbers(text) if not WORLD.match(place)]


@pytest.mark.parametrize("path", SCENARIOS, ids=lambda p: p.stem)
def test_numbers_in_scenarios_are_of_the_world(path: Path) -> None:
    assert _wrong(path.read_text()) == []
    assert _numbers(path.read_text()), "the test looks at something"


@pytest.mark.parametrize(
    "text",
    [
        "tasks: [{task: Grasping, at: [0.1, 0.2, 0.3]}]",
        "robot: {type: ur5e, joints: [0, 1, 2, 3, 4, 5]}",
        "tasks: [{task: Grasping, parameters: {height_m: 30 mm}}]",
        "objects: {tea: {waypoint: here}}",
    ],
)
def test_the_look_sees_a_pose(text: str) -> None:
    assert _wrong(text)


@pytest.mark.parametrize("path", RULES, ids=lambda p: p.stem)
def test_rules_hold_no_pose(path: Path) -> None:
    assert _poses(path.read_text()) == []


@pytest.mark.parametrize("text", ["post: [near(Patient, 0.1, 0.2, 0.3)]", "joints: [0.1]", "pre: [{at: 30 mm}]"])
def test_the_look_at_rules_sees_a_pose(text: str) -> None:
    assert _poses(text)


def _poses(text: str) -> list[str]:
    """Places in a rule file with a number that is no threshold of one comparison, or with a forbidden key."""
    keys = [p for p, _ in _leaves(yaml.safe_load(text)) if FORBIDDEN.search(p)]
    leaves = [(p, str(v)) for p, v in _leaves(yaml.safe_load(text)) if p.split(".")[0] not in ("source", "explain")]
    threshold = re.compile(r"[<>=]=?\s*[-\d.]+( ?[a-z]+)?")
    return keys + [p for p, v in leaves if re.search(r"(?<![A-Za-z_\d])\d", threshold.sub("", v))]


@given(st.floats(-1e6, 1e6, allow_nan=False), st.sampled_from([(k, u) for k, t in UNITS.items() for u in t]))
def test_quantities(number: float, unit: tuple[str, str]) -> None:
    kind, name = unit
    number *= 1e-6 * MOST[kind]
    assert math.isclose(parse_quantity(f"{number!r} {name}", kind), number * UNITS[kind][name], abs_tol=1e-300)
    assert parse_quantity(number, kind) == number


@pytest.mark.parametrize(("most", "kind", "unit"), [(1e6, "length", "mm"), (1e3, "angle", "rad"), (1e7, "mass", "g"), (1e4, "force", "N")])
def test_what_cannot_be_meant_is_refused_and_what_is_just_inside_is_not(most: float, kind: str, unit: str) -> None:
    assert parse_quantity(f"{most:g} {unit}", kind) == pytest.approx(MOST[kind])
    for sign in (1, -1):
        with pytest.raises(ValueError, match=f"is beyond reason: an? {kind} here is at most"):
            parse_quantity(f"{sign * most * 1.001!r} {unit}", kind)


@pytest.mark.parametrize(
    ("name", "most"), [("force_n", 1e4), ("speed_m_s", 1e3), ("lift_m", 1e3), ("duration_s", 1e5), ("acceleration_rad_s2", 1e4)]
)
def test_parameters_of_tasks_too(name: str, most: float) -> None:
    assert task_entry({"task": "Grasping", "parameters": {name: most}})
    retried = {"do": {"task": "Grasping"}, "with": [{name: 1.001 * most}]}
    for wrong in ({"task": "Grasping", "parameters": {name: -1.001 * most}}, {"retry": retried}):
        with pytest.raises(ValidationError, match=f"'{name}: .*' is beyond reason"):
            task_entry(wrong)
    with pytest.raises(ValidationError, match="is not finite"):
        task_entry({"task": "Grasping", "parameters": {name: math.nan}})


@pytest.mark.parametrize("value", [True, None, "", "mm", "1 kg", "nan", "inf", "1e999", "1 2", "0x10", [1]])
def test_what_is_no_length(value: Any) -> None:
    with pytest.raises(ValueError, match="length"):
        parse_quantity(value, "length")


def test_turns_are_about_fixed_axes() -> None:
    pose = PoseSpec(roll="90 deg", yaw="90 deg").pose()  # type: ignore[arg-type]
    assert pose.rotate((0, 1, 0)) == pytest.approx((0, 0, 1), abs=1e-12), "first about x"
    assert pose.rotate((1, 0, 0)) == pytest.approx((0, 1, 0), abs=1e-12), "then about z"


def test_all_that_is_stated_of_a_hand_reaches_its_reader(tmp_path: Path) -> None:
    (tmp_path / "arm.xml").write_text("<mujoco/>")
    stated = {
        "file": str(tmp_path / "arm.xml"), "at": {"position": ["10 mm", 0, 0]}, "pads": ["l", "r"], "tcp": "pinch",
        "opening": ["5 mm", "80 mm"], "force": ["5 N", "60 N"], "speed": [0.02, 0.15], "torsion": "12 mm",
    }  # fmt: skip
    robot = {"file": str(tmp_path / "arm.xml"), "gripper": stated}
    read = file_of(read_scenario({"scenario": "hand", "designator": "ParkingArms", "robot": robot, "things": []}))
    assert read is not None
    hand = HandFile(
        str(tmp_path / "arm.xml"), Pose((0.01, 0.0, 0.0)), ("l", "r"), "pinch", (0.005, 0.08), (5.0, 60.0), (0.02, 0.15), 0.012
    )
    assert read.stated.gripper == hand
