"""Good programs, each edited in one line: judged by what ran, during which task, and refused for the stated reason."""

from __future__ import annotations

import pytest
from edited import against, engine, findings, objections, proven, replaced, run, without
from msgspec.structs import replace

from cramlite.model import JudgingLimits, Pose, World
from cramlite.plugin import Candidate
from cramlite_plugins.simulation.objects.products_and_fixtures import block

PULL = "[2.943, 0.0, 8.0]"


def told_to_pull(force: float) -> tuple[Candidate, str]:
    """An extraction that pulls with another force, and all that would stop it taken out."""
    good = proven("extract_hole_from_peg")
    off = (", 25.0, 9.0,", ", 2500.0, 9.0,"), ("global force_limit = 60.0", "global force_limit = 6000.0")
    return good, replaced(good, (PULL, f"[0.0, 0.0, {force}]"), *off)


def with_bystander(good: Candidate, x: float, y: float, height: float) -> World:
    """The candidate's world, and a slender box that stands in it unknown to the program."""
    box = block("bystander", Pose((x, y, 0.005 + height / 2)), size=(0.04, 0.04, height), mass=0.2)
    return replace(good.world, things=(*good.world.things, box))


def test_the_text_as_it_is_passes() -> None:
    good = proven("placing")
    assert good.code is not None
    assert against(good, good.code.text) == {}


def test_an_arm_pose_whose_code_is_gone_was_not_assumed() -> None:
    good = proven("parking_arms")
    said = against(good, without(good, "2.ParkingArms"))
    assert "2.ParkingArms was not executed: none of the code of its 1 steps ran" in said["task_rules"]


def test_an_extraction_without_its_pull_is_not_one() -> None:
    good = proven("extract_hole_from_peg")
    said = against(good, without(good, "2.ExtractHoleFromPeg/pull"))
    assert "nothing is left of the code of 2.ExtractHoleFromPeg/pull" in said["task_rules"]


def test_what_is_let_go_above_its_place_was_not_put_down() -> None:
    good = proven("placing")
    said = against(good, without(good, "3.Placing/PuttingDown/lower"))
    assert "nothing is left of the code of 3.Placing/PuttingDown/lower" in said["task_rules"]


def test_waiting_instead_of_lowering_is_no_putting_down_either() -> None:
    good = proven("placing")
    assert good.code is not None
    (line,) = (t for t in good.code.text.splitlines() if t.lstrip().startswith("move_until_contact([0.0"))
    said = against(good, good.code.text.replace(line, "  sleep(0.1)"))
    assert "after 3.Placing/PuttingDown 'touches(Locatum, Relatum)' does not hold" in said["task_rules"]


def test_a_pull_of_80_n_without_a_limit_is_refused_though_nothing_jams() -> None:
    said = against(*told_to_pull(80.0))
    assert "told the arm to apply 80.0 N" in said["commanded_force"]
    assert "limit 25 N of 2.ExtractHoleFromPeg" in said["commanded_force"]


def test_a_pull_just_inside_the_limit_of_its_task_is_not() -> None:
    assert "commanded_force" not in against(*told_to_pull(24.9))


def test_a_carried_block_that_knocks_a_bystander_over_is_an_objection() -> None:
    good = proven("placing")
    assert good.code is not None
    said = against(good, good.code.text, with_bystander(good, 0.53, -0.05, 0.25))
    assert "'block' hit 'bystander'" in said["collision"] or "'bystander' hit 'block'" in said["collision"]
    assert "limit 2 N by default" in said["collision"] and "3.Placing/PuttingDown" in said["collision"]
    assert "'bystander', which no task moved then, got" in said["bystanders"]
    assert "limit 5 mm by default" in said["bystanders"]


def test_a_bystander_that_nothing_touches_is_none() -> None:
    good = proven("placing")
    assert good.code is not None
    assert against(good, good.code.text, with_bystander(good, 0.2, 0.5, 0.25)) == {}


@pytest.mark.parametrize("name", ["bystander_motion", "bystander_tilt", "brush"])
def test_limits_are_the_scenarios_and_are_kept_to_the_last_digit(name: str) -> None:
    good = proven("placing")
    assert good.code is not None
    ran = run(good, good.code.text, with_bystander(good, 0.53, -0.05, 0.25))
    unit = {"bystander_motion": "m", "bystander_tilt": "rad", "brush": "N"}[name]
    judge = "collision" if name == "brush" else "bystanders"
    open_ = {"bystander_motion": 100.0, "bystander_tilt": 100.0, "brush": 1e6}
    measured = {f.unit: f.value for f in findings(ran) if f.validator == judge and not f.passed}[unit]
    assert measured is not None
    inside, outside = (JudgingLimits(**{**open_, name: measured * share}, of_scenario=(name,)) for share in (1.001, 0.999))
    assert judge not in {k: v for k, v in objections(replace(ran, limits=inside)).items() if "still moves" not in v}
    assert "of the scenario" in objections(replace(ran, limits=outside))[judge]


def test_a_drawers_contents_go_with_it() -> None:
    good = proven("from_drawer", folder="compound")
    (said,) = (f.reason for f in findings(good) if f.validator == "bystanders")
    assert "limit 5 mm by default" in said


def test_a_task_without_steps_says_that_nothing_was_left_to_do() -> None:
    from cramlite import find_scenario, read_scenario

    solution = next(engine().resolve(read_scenario(find_scenario("fetch_from_hanger"))))
    said = [f.reason for f in solution.verdict.findings if f.origin == "5.OpenGripperTask" and f.validator == "task_rules"]
    assert said == ["5.OpenGripperTask: nothing was left to do, its program has no steps; afterwards: gripper_open()"]


def test_what_slips_is_one_grip_until_the_fingers_open() -> None:
    """Pads that carry 3 kg slide up a block of 4 kg and press it again higher up: it was not held all the way."""
    from cramlite import find_scenario, read_scenario

    scenario = read_scenario(find_scenario("picking_up_fails"))
    tried = [one for candidate in engine().candidates(scenario) for one in candidate.attempts()]
    assert tried and not any(one.verdict.passed for one in tried)
    assert any("in the hand, limit 12 mm" in f.reason for f in tried[0].verdict.objections)
