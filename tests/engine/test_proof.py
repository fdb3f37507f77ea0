"""How a proof goes: who is asked when, what ends it, what becomes of a validator or a backend that breaks, and what is blamed."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from helpers.short_runs import good
from helpers.written_runs import Says, Writes, Written, grounded, knowing, planned, ran
from msgspec.structs import replace

from cramlite.engine.proof.proof import (
    allowances,
    assemble,
    conflict_of,
    findings_of,
    load_on_the_flange,
    prove,
    run_and_judge,
    text_that_runs,
)
from cramlite.model import Estimate, Finding, Held, JudgingLimits, Pose, Verdict
from cramlite.model.program.program import Code, LatePose
from cramlite.model.program.program_json import is_program_text
from cramlite.planning.refutation import AsItIs, InTask, Later
from cramlite.plugin import Candidate, UserError
from cramlite_plugins.robots.ur5e import UR5E


def proved(
    validators: list[Says], backend: Writes | None = None, simulator: Written | None = None, **changes: Any
) -> tuple[Candidate, Verdict]:
    """The proof of the hand-written candidate, as yet without code and run."""
    made = replace(good(), code=None, rollout=None, **changes)
    return prove(made, knowing(simulator or Written(), validators), backend or Writes(), seed=3)  # type: ignore[arg-type]


def words(verdict: Verdict) -> list[tuple[str, bool]]:
    return [(f.validator, f.passed) for f in verdict.findings]


# The course of a proof


def test_a_program_is_checked_then_written_then_run_then_judged() -> None:
    facts, run, simulator = Says("facts", cost="facts"), Says("run"), Written()
    candidate, verdict = proved([run, facts], simulator=simulator)
    assert verdict.passed and words(verdict) == [("facts", True), ("run", True)] and verdict.left_out == ("blocked",)
    assert [(text, mount, seed) for text, _, mount, seed in simulator.asked] == [("run", "arm", 3)]
    assert facts.asked[0].rollout is None and run.asked[0].rollout is not None and run.asked[0].episode is not None
    assert candidate.rollout is run.asked[0].rollout and candidate.code is not None and candidate.code.text == "run"
    assert run.asked[0].episode.extras["park"] == pytest.approx(UR5E.home)


def test_what_is_refused_as_it_is_planned_is_neither_written_nor_run() -> None:
    run, simulator = Says("run"), Written()
    candidate, verdict = proved([Says("facts", False, "facts"), run], simulator=simulator)
    assert not verdict.passed and candidate.code is None and candidate.rollout is None and simulator.asked == run.asked == []


def test_one_objection_to_the_run_refuses_the_program() -> None:
    _, verdict = proved([Says("one"), Says("other", False)])
    assert not verdict.passed and words(verdict) == [("one", True), ("other", False)]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (UserError("no such motion"), "backend 'writes': no such motion"),
        (ZeroDivisionError("by zero"), "backend 'writes' failed: ZeroDivisionError: by zero"),
        (SystemExit(0), "backend 'writes' failed: SystemExit"),
        (7, "backend 'writes' failed: emit gives Code, not 7"),
    ],
)
def test_a_backend_that_writes_nothing_refuses_it(text: Any, said: str) -> None:
    simulator = Written()
    candidate, verdict = proved([], Writes(text), simulator)
    assert not verdict.passed and candidate.code is None and simulator.asked == []
    assert verdict.findings[0].validator == "code" and verdict.findings[0].reason.startswith(said)


def test_a_text_that_does_not_run_here_is_not_judged_and_the_verdict_says_so() -> None:
    simulator, run = Written(), Says("run", False)
    candidate, verdict = proved([Says("facts", cost="facts"), run], Writes(executable=False), simulator)
    assert candidate.code is not None and simulator.asked == run.asked == [] and words(verdict) == [("facts", True), ("execution", True)]
    assert verdict.findings[1].reason == "text of backend 'writes' cannot be run here; its typed program was checked, its text did not run"
    _, verdict = proved([], Writes(executable=False, remark="no interpreter"))
    assert verdict.findings[0].reason == "no interpreter; its typed program was checked, its text did not run"


def test_the_typed_program_runs_in_its_place_where_the_backend_says_so() -> None:
    simulator = Written()
    candidate, verdict = proved([Says("run")], Writes(executable=False, typed_stands_in=True), simulator)
    assert verdict.findings[0].reason.endswith("cannot be run here; its typed program ran on the controller model instead")
    assert is_program_text(simulator.asked[0][0]) and words(verdict) == [("execution", True), ("run", True)]
    assert candidate.code is not None and candidate.code.text == "run"
    assert text_that_runs(replace(candidate, code=None), Writes(executable=False, typed_stands_in=True)) is None


def test_what_a_backend_remarks_is_said_of_a_text_that_runs_too() -> None:
    _, verdict = proved([], Writes(remark="speeds are those of its controller"))
    assert [f.reason for f in verdict.findings] == ["speeds are those of its controller"]


def test_validators_see_the_text_that_ran() -> None:
    run = Says("run")
    own = Code("written", "own text", {}, ".txt")
    candidate, _ = run_and_judge(good(), own, good().world, knowing(Written(), [run]), 0)
    assert run.asked[0].code == own and candidate.code == good().code


# Edges of late poses


def late(validators: list[Says], simulator: Written) -> Verdict:
    """The verdict of a program that asks for the pose of the block, which may be 10 mm and 0.2 rad off."""
    made = good().program
    pose = good().world.thing("block").pose
    return proved(validators, simulator=simulator, program=replace(made, late=(LatePose("block", pose, (0.01, 0.2)),)))[1]


def test_a_program_with_a_late_pose_must_come_to_the_same_end_at_all_four_edges() -> None:
    simulator = Written()
    verdict = late([Says("run")], simulator)
    assert verdict.passed and words(verdict) == [("run", True), *[("late_pose", True)] * 4]
    assert all(f.reason.endswith("it came to the same end") and f.origin == "" for f in verdict.findings[1:])
    places = [w.thing("block").pose for _, w, *_ in simulator.asked]
    assert len(places) == 5 and [p.distance(places[0]) for p in places[1:]] == [pytest.approx((0.01, 0.2), abs=1e-6)] * 4
    assert {seed for *_, seed in simulator.asked} == {3}


def test_one_that_fails_at_an_edge_is_refused_with_that_edge_and_the_others_are_not_tried() -> None:
    tasks = ("1.Grasping", "3.Placing")
    validator = Says("run", lambda c: [Finding("run", c.rollout.outcome == "finished", c.rollout.reason, origin=t) for t in tasks])
    simulator = Written(ran(), ran(), ran("halted"))
    verdict = late([validator], simulator)
    assert not verdict.passed and words(verdict) == [("run", True), ("run", True), ("late_pose", True), ("late_pose", False)]
    wrong = verdict.findings[-1]
    assert wrong.reason == "with 'block' +0, +10 mm and -11 deg from its planned pose: run: as written" and wrong.origin == "1.Grasping"
    assert len(simulator.asked) == 3
    assert validator.asked[-1].world.thing("block").pose != good().world.thing("block").pose  # what is believed there


def test_one_that_fails_where_it_was_planned_is_not_tried_at_the_edges() -> None:
    simulator = Written()
    assert words(late([Says("run", False)], simulator)) == [("run", False)] and len(simulator.asked) == 1


# Who is asked


def test_a_dearer_validator_is_not_asked_where_a_cheaper_one_objects() -> None:
    validators = [Says("path", cost="path"), Says("facts", cost="facts"), Says("ik", False, "ik"), Says("ik too", cost="ik"), Says("run")]
    found = findings_of(good(), knowing(Written(), validators), rollout=False)
    assert [f.validator for f in found] == ["facts", "ik", "ik too"]
    found = findings_of(good(), knowing(Written(), validators), rollout=True)
    assert [f.validator for f in found] == ["run"]


def test_those_are_asked_who_are_named() -> None:
    validators = [Says("one"), Says("other"), Says("facts", cost="facts")]
    found = findings_of(good(), knowing(Written(), validators), rollout=True, only=["other", "facts"])
    assert [f.validator for f in found] == ["other"]


@pytest.mark.parametrize(("named", "may", "advises"), [(True, True, True), (True, False, False), (False, True, False)])
def test_a_validator_that_may_advise_and_is_asked_to_objects_and_refuses_nothing(named: bool, may: bool, advises: bool) -> None:
    made = replace(good(), limits=JudgingLimits(advisory=("one",) if named else ()))
    validators = [Says("one", False, may_advise=may), Says("other", False, may_advise=True)]
    one, other = findings_of(made, knowing(Written(), validators), rollout=True)
    assert (one.passed, one.advice, other.passed, other.advice) == (advises, advises, False, False)


def test_a_validator_that_says_nothing_of_it_may_not_advise() -> None:
    silent = Says("one", False)
    del silent.may_advise
    (found,) = findings_of(replace(good(), limits=JudgingLimits(advisory=("one",))), knowing(Written(), [silent]), rollout=True)
    assert not found.passed and not found.advice


def broken(_: Candidate) -> Any:
    raise KeyError("block")


@pytest.mark.parametrize(
    ("answer", "said"),
    [
        (broken, "KeyError"),
        (lambda _: None, "check gives Findings, in a list or one after another with 'yield', not None"),
        (lambda _: [True], "check gives Findings, not True; write Finding(name, passed, reason)"),
        (lambda _: [Finding("one", "yes", "r")], "'passed' of a Finding is True or False, not 'yes'"),
        (lambda _: [Finding("one", True, "r"), None], "check gives Findings, not None"),
    ],
)
def test_a_validator_that_breaks_has_not_approved(answer: Any, said: str) -> None:
    (found,) = findings_of(good(), knowing(Written(), [Says("one", answer)]), rollout=True)
    assert not found.passed and found.reason.startswith("the validator itself failed: ") and said in found.reason
    advised = replace(good(), limits=JudgingLimits(advisory=("one",)))
    (found,) = findings_of(advised, knowing(Written(), [Says("one", answer, may_advise=True)]), rollout=True)
    assert not found.passed and not found.advice


@pytest.mark.parametrize("passed", [True, False, np.True_, np.False_])
def test_a_validator_may_answer_one_by_one_and_with_what_numpy_compares(passed: Any) -> None:
    (found,) = findings_of(good(), knowing(Written(), [Says("one", lambda _: iter([Finding("one", passed, "r")]))]), rollout=True)
    assert found.passed is passed


# What the typed program and its candidate are made of


def test_a_candidate_has_what_the_setting_and_the_plan_say() -> None:
    plan, end = planned(), grounded()
    candidate = assemble(plan.plan, end, plan.setting, plan.knowledge)
    program, gripper = candidate.program, candidate.robot.gripper
    assert (program.name, program.robot, program.robot_type, program.tcp) == (plan.setting.name, "arm", "ur5e", gripper.tcp)
    assert (program.mass, program.center) == (gripper.mass, (0.0, 0.0, gripper.tcp.position[2] / 2))
    assert program.steps == end.steps and program.sections == end.sections and program.start == plan.setting.belief().joints
    assert {s.thing: s.pose for s in program.snapshots} == {n: plan.setting.belief().pose(n) for n in ("block", "floor", "shelf")}
    assert (program.force_limit, program.force_limit_of) == (candidate.robot.force_limit, "robot")
    assert candidate.limits == plan.setting.limits and candidate.world == plan.setting.world
    assert candidate.allowances.keys() == {a.name for a in (*end.actions, *end.parts)}
    assert candidate.allowances == allowances((*end.actions, *end.parts), end.bindings, plan.knowledge)


def test_a_scenario_may_limit_the_force_and_have_any_name() -> None:
    plan = planned()
    setting = replace(plan.setting, force_limit=17.0, name="on a shelf-2")
    program = assemble(plan.plan, grounded(), setting, plan.knowledge).program
    assert (program.force_limit, program.force_limit_of, program.name) == (17.0, "scenario", "on_a_shelf_2")


# Blame


def blamed(*findings: Finding) -> frozenset[object]:
    return frozenset(conflict_of(Verdict(findings), grounded()))


GRASP, SHELF, LIFT, AWAY = "grasp(block)", "on(shelf)", "2.PickingUp/up", "3.Placing/Retracting/away"


def test_choices_up_to_the_task_that_failed_are_blamed_and_motions_are_not() -> None:
    found = blamed(Finding("a", False, "", origin="2.PickingUp/lift"))
    assert {GRASP, LIFT, InTask(2)} <= found and not {SHELF, AWAY} & found
    assert not grounded().motions & found and {"1.Grasping", "2.PickingUp"} & found
    third = blamed(Finding("a", False, "", origin="3.Placing"))
    assert {GRASP, LIFT, SHELF, AWAY, InTask(3)} <= third and "4.ParkingArms" not in third


def test_of_several_the_first_task_that_failed_counts() -> None:
    first, last = Finding("a", False, "", origin="1.Grasping"), Finding("b", False, "", origin="3.Placing")
    found = blamed(last, first)
    assert InTask(1) in found and GRASP in found and not {LIFT, SHELF} & found


def test_the_choice_of_a_task_that_was_reached_is_blamed_and_that_of_a_later_one_is_not() -> None:
    chosen = [name for name, _ in grounded().choices]
    assert {"1.Grasping", "2.PickingUp", "3.Placing", "4.ParkingArms"} <= set(chosen)
    assert "2.PickingUp" not in blamed(Finding("a", False, "", origin="1.Grasping"))


def test_where_the_last_task_failed_the_choices_of_all_are_blamed() -> None:
    assert {GRASP, LIFT, SHELF, AWAY, InTask(4)} <= blamed(Finding("a", False, "", origin="4.ParkingArms/park"))


def test_without_a_task_all_choices_are_blamed() -> None:
    assert {GRASP, LIFT, SHELF, AWAY, InTask(4)} <= blamed(Finding("a", False, ""))


def test_where_no_place_changes_it_only_tasks_and_things_are_blamed() -> None:
    anywhere = Finding("a", False, "", origin="2.PickingUp", places=False)
    found = blamed(anywhere, Finding("b", False, "", origin="1.Grasping"))
    assert InTask(2) in found and not {GRASP, LIFT} & found and "2.PickingUp" in found


def test_what_was_in_the_way_is_part_of_the_conflict() -> None:
    found = blamed(Finding("a", False, "", origin="1.Grasping", blocking=("cup",)))
    assert AsItIs(frozenset({"cup"})) in found
    assert not any(isinstance(part, AsItIs) for part in blamed(Finding("a", False, "", origin="1.Grasping", blocking=())))


def test_what_the_robot_did_before_the_plan_is_nobodys_choice() -> None:
    state = grounded()
    before = replace(state, actions=(replace(state.actions[0], name="0.Looking"), *state.actions))
    assert conflict_of(Verdict((Finding("a", False, "", origin="0.Looking"),)), before) == frozenset()


def test_places_that_the_arm_is_only_led_to_come_later_where_it_is_about_things() -> None:
    assert {Later(LIFT), GRASP} <= blamed(Finding("a", False, "", origin="2.PickingUp", things=True))
    both = blamed(Finding("a", False, "", things=True), Finding("b", False, "", origin=AWAY, blocking=("cup",)))
    assert AWAY in both and Later(AWAY) not in both and Later(LIFT) in both


# What the flange bears at the start


def on_the_flange(held: Held | None, mass: float = 1.0, own: float | None = 1.0) -> tuple[float, Any]:
    """Mass and centre, of a gripper 200 mm long and what it holds: the block, and a cup of 2 kg that goes along."""
    base = good().belief
    things = tuple(replace(t, mass={"block": own, "cup": 2.0}.get(t.name, t.mass)) for t in base.world.things)
    gripper = replace(UR5E.gripper, mass=mass, tcp=Pose((0.0, 0.0, 0.2)))
    found, centre = load_on_the_flange(replace(base, world=replace(base.world, things=things), held=held), gripper)
    return found, pytest.approx(centre)


def test_an_empty_gripper_has_its_mass_in_its_middle() -> None:
    assert on_the_flange(None) == (1.0, (0.0, 0.0, 0.1)) and on_the_flange(None, mass=0.0) == (0.0, (0.0, 0.0, 0.1))


def test_what_is_held_and_what_goes_along_is_borne_where_it_is() -> None:
    held = Held("block", Pose((0.1, 0.0, 0.1)), 0.05)
    assert on_the_flange(held) == (2.0, (0.05, 0.0, 0.2)) and on_the_flange(held, mass=0.0) == (1.0, (0.1, 0.0, 0.3))
    assert on_the_flange(held, own=None) == (1.0, (0.0, 0.0, 0.1)), "nobody knows its mass"
    along = replace(held, carries={"cup": Estimate(Pose((0.0, 0.4, 0.0)), 0.0, "predicted")})
    assert on_the_flange(along) == (4.0, (0.075, 0.2, 0.25))
