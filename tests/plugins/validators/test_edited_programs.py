"""Good programs, each edited in one line: judged by what ran, during which task, and refused for the stated reason."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import pytest
from helpers.edited import against, engine, findings, objections, proven, replaced, run, without
from msgspec.structs import replace

from cramlite.interpretation.fluents import symbolic_world
from cramlite.model import Finding, JudgingLimits, MoveJoints, Pose, World
from cramlite.planning.goal_literals import literals_of_goals
from cramlite.plugin import Candidate
from cramlite_plugins.objects.products_and_fixtures import block

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


@cache
def as_it_is() -> Candidate:
    """The unchanged text of a placing, and what happened when it ran."""
    good = proven("placing")
    return run(good, replaced(good))


@cache
def with_bystander_hit() -> Candidate:
    """The same where the block that is carried hits a bystander."""
    good = proven("placing")
    return run(good, replaced(good), with_bystander(good, 0.53, -0.05, 0.25))


def test_the_text_as_it_is_passes() -> None:
    assert objections(as_it_is()) == {}


def test_an_arm_pose_whose_code_is_gone_was_not_assumed() -> None:
    good = proven("parking_arms")
    said = against(good, without(good, "2.ParkingArms"))
    assert "2.ParkingArms was not executed: none of the code of its 1 steps ran" in said["task_rules"]


@pytest.mark.heavy
def test_an_extraction_without_its_pull_is_not_one() -> None:
    good = proven("extract_hole_from_peg")
    said = against(good, without(good, "2.ExtractHoleFromPeg/pull"))
    assert "2.ExtractHoleFromPeg/pull has no line of code" in said["steps"]


def test_what_is_let_go_above_its_place_was_not_put_down() -> None:
    good = proven("placing")
    said = against(good, without(good, "3.Placing/PuttingDown/lower"))
    assert "3.Placing/PuttingDown/lower has no line of code" in said["steps"]


@pytest.mark.heavy
def test_waiting_instead_of_lowering_is_no_putting_down_either() -> None:
    good = proven("placing")
    assert good.code is not None
    (line,) = (t for t in good.code.text.splitlines() if t.lstrip().startswith("move_until_contact([0.0"))
    said = against(good, good.code.text.replace(line, "  sleep(0.1)"))
    assert "after 3.Placing/PuttingDown 'touches(Locatum, Relatum)' does not hold" in said["task_rules"]


@pytest.mark.heavy
def test_a_pull_of_80_n_without_a_limit_is_refused_though_nothing_jams() -> None:
    said = against(*told_to_pull(80.0))
    assert "told the arm to apply 80.0 N" in said["commanded_force"]
    assert "limit 25 N of 2.ExtractHoleFromPeg" in said["commanded_force"]


@pytest.mark.heavy
def test_a_pull_just_inside_the_limit_of_its_task_is_not() -> None:
    assert "commanded_force" not in against(*told_to_pull(24.9))


@pytest.mark.heavy
def test_a_carried_block_that_knocks_a_bystander_over_is_an_objection() -> None:
    said = objections(with_bystander_hit())
    assert "'bystander' hit 'shelf'" in said["collision"]  # it falls onto it, harder than it was hit
    assert "limit 2 N by default" in said["collision"] and "3.Placing/PuttingDown" in said["collision"]
    assert "'bystander', which no task moved then, was" in said["bystanders"]
    assert "limit 5 mm by default" in said["bystanders"]


@pytest.mark.heavy
def test_a_bystander_that_nothing_touches_is_none() -> None:
    good = proven("placing")
    assert good.code is not None
    assert against(good, good.code.text, with_bystander(good, 0.2, 0.5, 0.25)) == {}


@pytest.mark.heavy
@pytest.mark.parametrize("name", ["bystander_motion", "bystander_tilt", "brush"])
def test_limits_are_the_scenarios_and_are_kept_to_the_last_digit(name: str) -> None:
    ran = with_bystander_hit()
    unit = {"bystander_motion": "m", "bystander_tilt": "rad", "brush": "N"}[name]
    validator = "collision" if name == "brush" else "bystanders"
    open_ = {"bystander_motion": 100.0, "bystander_tilt": 100.0, "brush": 1e6}
    measured = {f.unit: f.value for f in findings(ran) if f.validator == validator and not f.passed}[unit]
    assert measured is not None
    inside, outside = (JudgingLimits(**{**open_, name: measured * share}, of_scenario=(name,)) for share in (1.001, 0.999))
    assert validator not in {k: v for k, v in objections(replace(ran, limits=inside)).items() if "still moves" not in v}
    assert "of the scenario" in objections(replace(ran, limits=outside))[validator]


LOADED = "set_target_payload(1.125,"
LOWER, MOVE = "0.03, 0.01, 3.0, 9.0", "movej(placing_3_putting_down_transfer_joints, a=1.4, v=1.05)"


@pytest.mark.heavy
@pytest.mark.parametrize(
    ("validator", "old", "inside", "outside", "says"),
    [
        ("execution", LOWER, "0.025, 0.01, 3.0, 9.0", "0.01, 0.01, 3.0, 9.0", "3.Placing/PuttingDown/lower: no contact within 0.01 m"),
        ("force_peak", LOWER, "0.03, 0.01, 6.0, 9.0", "0.03, 0.01, 20.0, 9.0", "PuttingDown/lower, which ends at 3 N"),
        ("tool_speed", MOVE, MOVE.replace("1.4, v=1.05", "8.0, v=2.4"), MOVE.replace("1.4, v=1.05", "8.0, v=2.8"), "limit 1.5 m/s"),
        ("payload", LOADED, "set_target_payload(1.18,", "set_target_payload(4.0,", "instead of 1.12 kg"),
    ],
)
def test_one_number_makes_the_difference(validator: str, old: str, inside: str, outside: str, says: str) -> None:
    good = proven("placing")
    assert against(good, replaced(good, (old, inside))) == {}
    assert says in against(good, replaced(good, (old, outside)))[validator]


@pytest.mark.heavy
def test_a_payload_that_is_told_a_little_late_is_harmless() -> None:
    good = proven("placing")
    assert good.code is not None
    comment = "  # 1.Grasping/payload: the arm now carries the object\n"
    late = replaced(good, (comment, "  sleep(0.3)\n"))
    assert LOADED in late.split("sleep(0.3)\n")[1] and against(good, late) == {}


@pytest.mark.heavy
@pytest.mark.parametrize(
    ("register", "passes"),
    [(47, True), (48, False), *(pytest.param(*far, marks=pytest.mark.heavy) for far in ((33, True), (255, False)))],
)
def test_no_thing_is_gripped_harder_than_it_bears(register: int, passes: bool) -> None:
    good, close = proven("placing"), "move_gripper(255, 157, 33,"
    bearing = replace(good.world, things=tuple(replace(t, max_grip_force=60.0) if t.name == "block" else t for t in good.world.things))
    said = against(good, replaced(good, (close, close.replace("33", str(register)))), bearing)
    assert ("grip_limits" not in said) is passes
    assert passes or "limit 60 N (the max_grip_force of 'block')" in said["grip_limits"]


@pytest.mark.heavy
def test_what_was_put_down_is_not_pressed_from_above() -> None:
    good = proven("placing")
    assert good.code is not None
    (back,) = (t for t in good.code.text.splitlines() if t.lstrip().startswith("movel(placing_3_retracting_back_pose"))
    shut = '  move_gripper(255, 157, 0, "any", 3.0, "press")'
    for force, passes in ((5.0, True), (54.0, False)):
        press = f'  move_until_contact([0.0, 0.0, -1.0], 0.12, 0.01, {force}, 12.0, "contact", "press")'
        said = against(good, replaced(good, (back, "\n".join((back, shut, press, back)))))
        assert ("force_peak" not in said) is passes and "execution" not in said
        assert passes or "N of every task that declares none" in said["force_peak"]


def test_joints_turn_no_faster_than_they_can() -> None:
    good = proven("parking_arms")
    park = "parking_arms_2_park_joints = [2.8186, -1.7747, 1.578, -1.3741, -1.5708, 1.2478]"
    move = "movej(parking_arms_2_park_joints, a=1.4, v=1.05)"
    for speed, passes in ((3.2, True), (3.5, False)):
        turn = (park, park.replace("1.2478", "-1.7522")), (move, move.replace("a=1.4, v=1.05", f"a=8.0, v={speed}"))
        said = against(good, replaced(good, *turn))
        assert ("joint_speeds" not in said) is passes
        assert passes or ("wrist_3 reached" in said["joint_speeds"] and "limit 3.14 rad/s" in said["joint_speeds"])


@pytest.mark.heavy
def test_who_does_not_let_go_has_put_nothing_down() -> None:
    good = proven("placing")
    said = against(good, without(good, "3.Placing/Releasing/open", "3.Placing/Retracting"))
    assert said["end_state"] == "the gripper still touches 'block' at the end"


@pytest.mark.heavy
def test_the_goal_is_judged_whatever_the_text_was_for() -> None:
    good = proven("placing")
    scene = symbolic_world(good.world, engine().knowledge.taxonomy)
    held = run(good, without(good, "3.Placing/Releasing/open"))
    for goal, ran, passes in (("block on shelf", as_it_is(), True), ("block on floor", as_it_is(), False), ("block on shelf", held, False)):
        said = objections(replace(ran, goal=literals_of_goals([goal], scene, engine().knowledge)))
        assert ("goal" not in said) is passes
        assert passes or f"'{goal}' is not reached" in said["goal"]


@pytest.mark.heavy
def test_a_thing_that_was_taken_for_another_is_one_when_the_program_runs() -> None:
    good = proven("placing")
    for kind, passes in (("cram:Product", True), ("cram:Jug", False)):
        things = tuple(replace(t, type=kind) if t.name == "block" else t for t in good.world.things)
        ran = replace(run(good, replaced(good), replace(good.world, things=things)), world=good.world)
        assert ("recognised" not in objections(ran)) is passes


def test_an_arm_that_is_led_by_its_tool_is_stretched_no_more_than_it_may_be() -> None:
    good = proven("placing")

    def keeping(distance: float) -> list[Finding]:
        """What is said where the arm must keep a distance from singularities."""
        return [f for f in findings(replace(good, robot=replace(good.robot, conditioning=distance))) if f.validator == "singularities"]

    assert keeping(0.0) == []  # an arm that is sent joint positions goes through
    (least,) = (f.value for f in keeping(1e-6))
    assert least is not None and [f.passed for f in keeping(least)] == [True] and [f.passed for f in keeping(2 * least)] == [False]


@pytest.mark.parametrize("name", ["joint_limits", "program_safety"])
def test_a_typed_program_is_refused_before_its_text_is_written(name: str) -> None:
    good = proven("placing")
    validator = next(v for v in engine().knowledge.validators if v.name == name)
    high = good.robot.limits[5][1]
    for value, passes in ((high - 0.001, True), (high + 0.001, False)):
        (first, *others), moves = [s for s in good.program.steps if isinstance(s, MoveJoints)], good.program.steps
        edited = replace(first, path=(*first.path[:-1], (*first.path[-1][:5], value)))
        steps = tuple(edited if s is first else s for s in moves)
        found = list(validator.check(replace(good, program=replace(good.program, steps=steps))))
        assert others and all(f.passed for f in found) is passes
        assert passes or "wrist_3" in next(f.reason for f in found if not f.passed)


@pytest.mark.heavy
def test_what_is_poured_beside_the_bowl_has_not_arrived_and_is_spilled() -> None:
    good = proven("pouring")
    assert good.code is not None
    (line,) = (t for t in good.code.text.splitlines() if "pouring_3_transfer_joints =" in t)
    names = [t.split(" =")[0].split()[-1] for t in good.code.text.splitlines() if "global pouring_3_" in t and "_joints" in t]
    assert line and names

    def turned(by: float) -> str:
        """The text, whose arm stands turned about its base by an angle while it pours [rad]."""
        text = good.code.text if good.code else ""
        for row in text.splitlines():
            if any(f"global {name} = [" in row for name in names):
                first = row.split("[")[1].split(",")[0]
                text = text.replace(row, row.replace(f"[{first}", f"[{float(first) + by:.6f}"))
        return text

    inside, outside = against(good, turned(0.01)), against(good, turned(0.3))
    assert not {"poured", "spilled"} & inside.keys()
    assert "0 of 12 grains of 'jug' are in 'bowl', 11 are wanted" in outside["poured"]
    assert "12 of 12 grains of 'jug' are beside all vessels" in outside["spilled"]


@pytest.mark.heavy
def test_a_drawers_contents_go_with_it() -> None:
    good = proven("from_drawer", folder="compound")
    (said,) = (f.reason for f in findings(good) if f.validator == "bystanders")
    assert "limit 5 mm by default" in said


def test_a_task_without_steps_says_that_nothing_was_left_to_do(tmp_path: Path) -> None:
    from cramlite import find_scenario, read_scenario

    path = tmp_path / "opened.yaml"
    path.write_text(find_scenario("place_on_shelf").read_text().replace("  - ParkArms\n", "  - ParkArms\n  - OpenGripperTask\n"))
    solution = next(engine().resolve(read_scenario(path)))
    said = [f.reason for f in solution.verdict.findings if f.origin == "5.OpenGripperTask" and f.validator == "task_rules"]
    assert said == ["5.OpenGripperTask: nothing was left to do, its program has no steps; afterwards: gripper_open()"]


def test_what_slips_is_one_grip_until_the_fingers_open() -> None:
    """Pads that carry 3 kg slide up a block of 4 kg and press it again higher up: it was not held all the way."""
    from cramlite import find_scenario, read_scenario

    scenario = read_scenario(find_scenario("picking_up_fails"))
    tried = [one for candidate in engine().candidates(scenario) for one in candidate.attempts()]
    assert tried and not any(one.verdict.passed for one in tried)
    assert any(f.validator == "grasp_slip" and "in the hand, limit 12 mm" in f.reason for f in tried[0].verdict.objections)


def test_a_grip_that_does_not_carry_the_weight_says_which_would() -> None:
    good = proven("placing")
    for friction, passes in ((0.1, True), (0.002, False)):
        things = tuple(replace(t, friction=friction) if t.name == "block" else t for t in good.world.things)
        said = against(good, replaced(good), replace(good.world, things=things))
        assert ("grip_strength" not in said) is passes
        assert passes or "N just carry it" in said["grip_strength"]
