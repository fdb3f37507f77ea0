"""Every task type with a scenario of its own is proven by physics, and its sibling is refused for the stated reason."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from helpers.task_scenarios import BLOCKED, COMPOUND, MORE, REFUSED, attempt, attempted
from helpers.task_scenarios import engine as shared

from cramlite import Engine, data_folder, find_scenario
from cramlite.plugin import UserError
from cramlite.plugin.task_type import task_type
from cramlite.scenario.scenario import PoseSpec, RobotSpec
from cramlite.testing.task_checks import check_task_type

USUAL = {
    "closing", "extract_hole_from_peg", "grasping", "looking_at", "navigating", "opening", "parking_arms", "placing", "pushing",
    "sliding_gripper", "turning_on", "ungrasping",
}  # fmt: skip
"""Scenarios of the usual run, with their siblings: one of each kind of motion, of those that take two seconds at most."""


def named(name: str, *more: str) -> Any:
    """A scenario as a parameter of tests."""
    marks = () if name.removesuffix("_fails") in USUAL else pytest.mark.heavy
    return pytest.param(name, *more, marks=marks, id="-".join((name, *more)))


@pytest.fixture(scope="module")
def engine() -> Engine:
    return shared()


@pytest.mark.parametrize("name", [named(n) for n in (*sorted(REFUSED), *MORE)])
def test_it_is_proven(engine: Engine, name: str) -> None:
    candidate, verdict, reasons = attempted(name)
    assert candidate is not None and verdict is not None, reasons
    assert verdict.passed, reasons
    wanted = MORE.get(name) or task_type(engine.knowledge.tasks, "".join(w.capitalize() for w in name.split("_"))).task
    judged = {f.origin for f in verdict.findings if f.validator == "task_rules"}
    assert {a.name for a in candidate.actions if a.task == wanted} <= judged, f"no rule judged {wanted}: {judged}"
    assert any(a.task == wanted for a in candidate.actions)


SIBLINGS = (*((f"{n}_fails", s) for n, s in sorted(REFUSED.items())), *BLOCKED.items())


@pytest.mark.parametrize(("name", "says"), [named(*pair) for pair in SIBLINGS])
def test_its_sibling_is_refused(name: str, says: str) -> None:
    _, verdict, reasons = attempted(name)
    assert verdict is None or not verdict.passed
    assert says in reasons


@pytest.mark.heavy
@pytest.mark.parametrize("name", [named(n) for n in sorted(COMPOUND)])
def test_several_tasks_are_proven_together_and_their_sibling_is_refused(name: str) -> None:
    _, verdict, reasons = attempted(name, "compound")
    assert verdict is not None and verdict.passed, reasons
    _, verdict, reasons = attempted(f"{name}_fails", "compound")
    assert verdict is None or not verdict.passed
    assert COMPOUND[name] in reasons


def test_a_push_moves_the_block_as_far_as_asked_and_away_from_the_robot() -> None:
    candidate, _, reasons = attempted("pushing")
    assert candidate is not None and candidate.rollout is not None, reasons
    track = candidate.rollout.poses["block"][:, :2]
    way, out = track[-1] - track[0], track[0] / float((track[0] @ track[0]) ** 0.5)
    assert float(way @ out) > 0.04
    assert 0.05 < float((way @ way) ** 0.5) < 0.075  # 60 mm, and what it was pushed until it was felt
    assert candidate.belief.poses["block"].sigma >= 0.06


@pytest.mark.parametrize("name", ["parking_arms_fails", pytest.param("reaching", marks=pytest.mark.heavy)])
def test_one_line_makes_it_a_seven_axis_arm(engine: Engine, name: str) -> None:
    """All of them: tests/benchmarks/seven_axis.py."""
    arm = RobotSpec(type="fr3_2f85", at=PoseSpec.model_validate({"position": [0.1, 0, 0]}))
    candidate, verdict, reasons = attempt(engine, name, robot=arm)
    assert candidate is not None and verdict is not None, reasons
    assert candidate.program.robot_type == "fr3_2f85" and len(candidate.program.start) == 7
    assert verdict.passed == (not name.endswith("_fails")), reasons


def test_no_scenario_is_left_out() -> None:
    shipped = {p.stem for p in (data_folder("scenarios") / "tasks").glob("*.yaml")}
    assert shipped == {*REFUSED, *(f"{name}_fails" for name in REFUSED), *MORE, *BLOCKED}


def test_every_task_type_keeps_its_contract(engine: Engine) -> None:
    for task in engine.knowledge.tasks.values():
        check_task_type(task)


@pytest.mark.parametrize(
    ("alias", "task"),
    [
        ("PickUp", "PickingUp"), ("Place", "Placing"), ("Transport", "Transporting"), ("Open", "Opening"),
        ("Close", "Closing"), ("Push", "Pushing"), ("ParkArms", "ParkingArms"), ("LookAt", "LookingAt"),
        ("Detect", "LookingFor"), ("HoleOnPeg", "InsertHoleOntoPeg"), ("Sliding", "SlidingObject"), ("PutDown", "PuttingDown"),
    ],
)  # fmt: skip
def test_names_that_users_of_cram_know(engine: Engine, alias: str, task: str) -> None:
    assert task_type(engine.knowledge.tasks, alias) is task_type(engine.knowledge.tasks, task)


def test_shipped_scenarios_have_short_and_full_names() -> None:
    assert find_scenario("tasks/grasping") == find_scenario("grasping")
    assert find_scenario("tasks/grasping").parent.name == "tasks"
    with pytest.raises(UserError, match="grasping"):
        find_scenario("tasks/graspin")


def test_a_scenario_in_the_folder_comes_first(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "grasping").write_text("")
    assert find_scenario("grasping") == Path("grasping")
