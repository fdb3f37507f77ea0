"""A text that may be anybody's: what its lines count to, who judges it, and what is said where something was not judged."""

from __future__ import annotations

from typing import Any

import pytest
from helpers.written_runs import Says, Written, grounded, intent, knowing, planned, ran, written
from msgspec.structs import replace

from cramlite.engine.proof.judging import JudgedRun, Purpose, judge_text
from cramlite.model import JudgingLimits, Pose, RobotMount
from cramlite.model.program.program_json import typed_code
from cramlite.plugin import UserError
from cramlite_plugins.robots.ur5e import UR5E

TEXT = intent().kept.text
WORLD = planned().setting.world
RUN = Purpose(intent())


class ByGoal(Says):
    by_goal = True


def judged(text: str, purpose: Purpose, *validators: Says, outcome: str = "finished") -> JudgedRun:
    simulator = Written(ran(outcome))
    found = judge_text(text, WORLD, purpose, knowing(simulator, validators), 5)
    ((asked, world, mount, seed),) = simulator.asked
    assert (asked, world, mount, seed) == (text, WORLD, "arm", 5)
    return found


def words(found: JudgedRun) -> list[tuple[str, bool]]:
    return [(f.validator, f.passed) for f in found.verdict.findings]


# Against the plan of a run


def test_the_text_as_it_was_proven_is_asked_of_all() -> None:
    facts, run = Says("facts", cost="facts"), Says("run")
    found = judged(TEXT, RUN, run, facts)
    assert found.verdict.passed and words(found) == [("facts", True), ("run", True)] and found.remarks == ()
    assert found.verdict.left_out == ("blocked",)
    seen, made = run.asked[0], written()
    assert seen.code is not None and seen.code.text == TEXT and dict(seen.code.origins) == dict(made.code.origins if made.code else {})
    assert (seen.plan, seen.actions, seen.parts, seen.world, seen.limits) == (made.plan, made.actions, made.parts, made.world, made.limits)
    assert seen.allowances == made.allowances and seen.program.steps == made.program.steps and seen.goal == made.goal
    assert seen.rollout is found.rollout and seen.episode is found.episode
    assert found.episode.extras["park"] == pytest.approx(UR5E.home)


def test_an_edited_one_is_no_typed_program_and_the_remark_says_who_was_not_asked() -> None:
    facts, run = Says("facts", False, "facts"), Says("run")
    found = judged(TEXT.replace("sleep(0.3)\n", "sleep(0.4)\n"), RUN, facts, run)
    assert found.verdict.passed and words(found) == [("run", True)] and facts.asked == []
    assert found.remarks == ("not judged: facts; they look at a typed program, and this text is none",)


def test_a_typed_one_is_judged_as_what_it_says() -> None:
    facts = Says("facts", lambda c: [replace(found_of(c), passed=c.program.force_limit > 60.0)], "facts")
    text = typed_code(replace(written().program, force_limit=61.0)).text
    assert words(judged(text, RUN, facts, Says("run"))) == [("facts", True), ("run", True)]
    assert words(judged(typed_code(written().program).text, RUN, facts, Says("run")))[0] == ("facts", False)


def joined(rows: list[str], pairs: int) -> str:
    """A typed program whose first steps share lines, two each."""
    steps = [k for k, row in enumerate(rows) if '"step":' in row]
    for k in range(pairs):
        rows[steps[2 * k]] += rows[steps[2 * k + 1]].strip()
        rows[steps[2 * k + 1]] = ""
    return "\n".join(row for row in rows if row)


@pytest.mark.parametrize(("pairs", "more"), [(1, ""), (6, ""), (7, ", ...")])
def test_a_typed_text_whose_steps_share_lines_runs_one_step_a_line_and_the_remark_says_which(pairs: int, more: str) -> None:
    plain, simulator = typed_code(written().program).text, Written()
    text = joined(plain.splitlines(), pairs)
    found = judge_text(text, WORLD, RUN, knowing(simulator, [Says("run")]), 5)
    assert found.verdict.passed and simulator.asked[0][0] == plain
    lines = [k for k, row in enumerate(text.splitlines(), 1) if row.count('"step":') == 2]
    news = [k for k, row in enumerate(plain.splitlines(), 1) if '"step":' in row]
    told = [f"line {k}: {news[2 * n]} to {news[2 * n + 1]}" for n, k in enumerate(lines)][:6]
    assert found.remarks[0].startswith("steps share a line of the text, so it ran written anew")
    assert found.remarks[0].endswith(f"({', '.join(told)}{more})")


def test_one_whose_steps_have_lines_of_their_own_runs_as_it_is() -> None:
    assert judged(typed_code(written().program).text, RUN, Says("run")).remarks == ()


def found_of(_: Any) -> Any:
    from cramlite.model import Finding

    return Finding("facts", True, "as the text says")


def test_an_objection_to_the_run_refuses_it() -> None:
    found = judged(TEXT, RUN, Says("run", False), Says("other"))
    assert not found.verdict.passed and words(found) == [("run", False), ("other", True)]


@pytest.mark.parametrize(("count", "more"), [(2, ""), (6, ""), (7, ", ..."), (8, ", ...")])
def test_lines_that_nothing_says_a_task_of_are_told(count: int, more: str) -> None:
    lift, own = "  movel(picking_up_2_lift_pose, a=0.5, v=0.1)\n", "".join(f"  zz_{k} = {k}\n" for k in range(count))
    text = TEXT.replace(lift, lift + own)
    lines = [k for k, line in enumerate(text.splitlines(), 1) if line.startswith("  zz_")]
    listed = ", ".join(map(str, lines[:6])) + more
    assert judged(text, RUN, Says("run")).remarks[0].startswith(f"nothing says which task line {listed} belongs to; each is judged")


# Against a list of tasks


def test_a_plan_without_a_run_is_judged_by_what_lines_name() -> None:
    run, facts = Says("run"), Says("facts", cost="facts")
    limits = JudgingLimits(brush=7.0)
    purpose = Purpose(plan=planned().plan, actions=grounded().actions, limits=limits)
    found = judged(TEXT, purpose, run, facts)
    seen = run.asked[0]
    assert seen.code is not None and set(seen.code.origins.values()) == {a.name for a in grounded().actions}
    assert seen.plan == planned().plan and seen.limits == limits and seen.parts == () and seen.world == WORLD
    assert (seen.program.name, seen.program.robot, seen.program.force_limit) == ("text", "arm", UR5E.force_limit)
    assert (seen.belief.joints, seen.belief.poses.keys()) == (UR5E.start(WORLD.robots[0])[0], {t.name for t in WORLD.things})
    assert facts.asked == [] and words(found) == [("run", True)]
    assert found.remarks[-2].startswith("no run directory says where the plan's things should end")
    assert found.remarks[-1].startswith("not judged: facts")


def test_it_is_the_first_robot_that_acts() -> None:
    """Another one beside it has other joints, another mount and another opening."""
    arm = replace(WORLD.robots[0], joints=(0.1, -1.2, 1.3, -1.4, -1.5, 0.6), opening=0.03)
    world = replace(WORLD, robots=(arm, RobotMount("other", "ur10e", Pose((1.0, 1.0, 0.0)))))
    run, simulator = Says("run"), Written()
    judge_text(TEXT, world, Purpose(plan=planned().plan, actions=grounded().actions), knowing(simulator, [run]), 5)
    seen = run.asked[0]
    assert simulator.asked[0][2] == seen.program.robot == seen.belief.robot == "arm"
    assert seen.robot == UR5E and (seen.program.robot_type, seen.program.tcp) == ("ur5e", UR5E.gripper.tcp)
    assert (seen.program.start, seen.belief.joints, seen.belief.opening) == (arm.joints, arm.joints, 0.03)


def test_a_text_that_names_no_task_cannot_be_held_against_a_plan() -> None:
    with pytest.raises(UserError, match=r"No line of the text leads to a task .* such as '# 1.Grasping'"):
        judged("def p():\n  sleep(1.0)\nend\n", Purpose(plan=planned().plan, actions=grounded().actions))


# By its goal alone


def test_without_a_plan_those_judge_who_judge_by_the_goal() -> None:
    run, goal = Says("run", False), ByGoal("goal")
    found = judged("def p():\nend\n", Purpose(goal=("block on shelf",)), run, goal)
    assert found.verdict.passed and words(found) == [("goal", True)] and run.asked == [] and found.remarks == ()
    assert [literal.says for literal in goal.asked[0].goal] == ["block on shelf"]
    assert not judged("def p():\nend\n", Purpose(goal=("block on shelf",)), ByGoal("goal", False)).verdict.passed


def test_without_a_plan_one_that_did_not_end_failed() -> None:
    found = judged("def p():\nend\n", Purpose(goal=("block on shelf",)), ByGoal("goal"), outcome="halted")
    assert words(found) == [("execution", False), ("goal", True)]
    assert found.verdict.objections[0].reason == "the text ended by halted: as written" and found.verdict.objections[0].stopped


def test_without_anybody_who_judges_it_nothing_passes() -> None:
    assert not judged("def p():\nend\n", Purpose(goal=("block on shelf",)), Says("run")).verdict.passed


def test_the_goal_in_words_is_asked_beside_that_of_the_plan() -> None:
    run = Says("run")
    judged(TEXT, Purpose(intent(), goal=("block on shelf",)), run)
    assert [literal.says for literal in run.asked[0].goal] == [*(g.says for g in written().goal), "block on shelf"]


