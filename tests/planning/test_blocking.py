"""Blockings: what a refusal rules out of symbolic plans, and that it rules out no more."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import pytest
from helpers.properties import examples
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from cramlite import Budget, Engine, Goal, Trace, find_scenario, planning_problem, read_scenario
from cramlite.planning.refutation import InTask, Part, Refutation, Unfit, as_they_are, refutation
from cramlite.planning.symbolic.blocking import Blocking
from cramlite.planning.symbolic.handling import Done, Handling, Stage, Track
from cramlite.planning.symbolic.plan_stream import few_things, task_plans
from cramlite.planning.symbolic.planning_problem import PlanningProblem, Scope

ENGINE = Engine()
SCENE = """
scenario: blocks
goal: [prize on tray]
robot: {type: ur5e}
things:
  - {name: floor, model: table, at: {position: [0.2, 0, -5 mm]}, with: {size: [1.6 m, 1.6 m, 20 mm]}}
  - {name: tray, model: table, at: {position: [0.45, -0.35, 0.15]}, with: {size: [0.25 m, 0.25 m, 20 mm]}}
  - {name: prize, model: block, at: {position: [0.5, 0.15, 31 mm]}}
  - {name: other, model: block, at: {position: [0.5, 0.23, 31 mm]}}
"""


BOWL = """
scenario: bowl
goal: [tin in bowl]
robot: {type: ur5e}
things:
  - {name: floor, model: table, at: {position: [0.2, 0, -5 mm]}, with: {size: [1.6 m, 1.6 m, 20 mm]}}
  - {name: cabinet, model: cabinet, at: {position: [0.65, 0.1, 0.35], yaw: 180 deg}}
  - {name: drawer, model: drawer, at: {position: [0.65, 0.1, 0.35], yaw: 180 deg}, with: {parent: cabinet}}
  - {name: bowl, model: bowl, at: {position: [0.75, 0.1, 0.309]}, with: {height: 50 mm}}
  - {name: tray, model: table, at: {position: [0.45, -0.35, 0.15]}, with: {size: [0.3 m, 0.3 m, 20 mm]}}
  - {name: tin, model: block, at: {position: [0.45, -0.35, 0.181]}, with: {size: [40 mm, 40 mm, 60 mm]}}
"""


BOARD = """
scenario: board
goal: [drawer open]
robot: {{type: ur5e}}
things:
  - {{name: floor, model: table, at: {{position: [0.2, 0, -5 mm]}}, with: {{size: [1.6 m, 1.6 m, 20 mm]}}}}
  - {{name: cabinet, model: cabinet, at: {{position: [0.75, 0.1, 0.1], yaw: 180 deg}}}}
  - {{name: drawer, model: drawer, at: {{position: [0.75, 0.1, 0.1], yaw: 180 deg}}, with: {{parent: cabinet}}}}
  - {{name: board, model: block, at: {{position: [0.56, 0.1, 50 mm]}}, with: {{size: [120 mm, 120 mm, {height} mm]}}}}
"""


DRAWERS = """
scenario: drawers
goal: [right open, left closed]
robot: {type: ur5e}
things:
  - {name: floor, model: table, at: {position: [0.2, 0, -5 mm]}, with: {size: [1.6 m, 1.6 m, 20 mm]}}
  - {name: cabinet, model: cabinet, at: {position: [0.75, 0.4, 0.35], yaw: 180 deg}}
  - {name: left, model: drawer, at: {position: [0.75, 0.4, 0.35], yaw: 180 deg}, with: {parent: cabinet, opened: 150 mm}}
  - {name: other, model: cabinet, at: {position: [0.75, -0.1, 0.35], yaw: 180 deg}}
  - {name: right, model: drawer, at: {position: [0.75, -0.1, 0.35], yaw: 180 deg}, with: {parent: other}}
  - {name: third, model: cabinet, at: {position: [0.75, -0.6, 0.35], yaw: 180 deg}}
  - {name: far, model: drawer, at: {position: [0.75, -0.6, 0.35], yaw: 180 deg}, with: {parent: third, opened: FAR mm}}
  - {name: tin, model: block, at: {position: [0.45, 0.35, 46 mm]}, with: {size: [50 mm, 50 mm, 80 mm]}}
"""

TIN = "  - {{name: tin{0}, model: block, at: {{position: [0.35, {0}.0, 46 mm]}}, with: {{size: [50 mm, 50 mm, 80 mm]}}}}\n"


@pytest.fixture(scope="module")
def problem(tmp_path_factory: pytest.TempPathFactory) -> PlanningProblem:
    path = tmp_path_factory.mktemp("blocks") / "blocks.yaml"
    path.write_text(SCENE)
    setting = ENGINE.setting(read_scenario(path))
    return planning_problem(Goal(("prize on tray",)), setting.symbolic(ENGINE.knowledge.taxonomy), ENGINE.knowledge)


def replanned(problem: PlanningProblem, *refuted: Refutation) -> tuple[list[str], Trace]:
    """The plans that come one after another if each is refuted in turn, as texts."""
    trace, found = Trace(), list[str]()
    for number, plan in enumerate(task_plans(problem, trace=trace), 1):
        found.append(" ".join(map(str, plan.steps)))
        if number > len(refuted):
            break
        trace.candidate = number
        trace.refuted("", refuted[number - 1])
    return found, trace


def test_what_is_in_the_way_is_moved_and_put_down_elsewhere_first(problem: PlanningProblem) -> None:
    (first, second), trace = replanned(problem, Refutation((1,), (("other",),)))
    assert first.startswith("Grasping(Patient=prize)")
    assert second.startswith("Grasping(Patient=other) PickingUp(Locatum=other, Relatum=floor) Placing(Locatum=other")
    assert second.endswith(first)
    said = [e.reason for e in trace.entries if e.kind == "goal" and e.outcome == "refused"]
    assert said == ["no Grasping(prize) with 'other' as it was and 'prize' as it was"]


@pytest.mark.parametrize(("model", "clears"), [("knob", False), ("switch", True)])
def test_a_knob_takes_the_same_room_however_it_is_turned(model: str, clears: bool, tmp_path: Path) -> None:
    """So nothing is turned on to make room; a lever that is thrown stands elsewhere."""
    path = tmp_path / "stove.yaml"
    path.write_text(SCENE.replace("name: other, model: block", f"name: other, model: {model}"))
    setting = ENGINE.setting(read_scenario(path), twins=0)
    with_it = planning_problem(Goal(("prize on tray",)), setting.symbolic(ENGINE.knowledge.taxonomy), ENGINE.knowledge)
    plans, trace = replanned(with_it, Refutation((1,), (("other",),)))
    (said,) = [e.reason for e in trace.entries if e.kind == "goal" and e.outcome == "refused"]
    assert ("'other' as it was" in said) == clears and (len(plans) == 2 and "TurningOn" in plans[1]) == clears
    own, trace = replanned(planning_problem(Goal(("other turned on",)), setting.symbolic(ENGINE.knowledge.taxonomy), ENGINE.knowledge),
                           Refutation((1,), (("prize",),)))  # fmt: skip
    assert "'other' as it was" in next(e.reason for e in trace.entries if e.outcome == "refused"), own


def test_a_grasp_that_ends_where_it_began_moves_nothing(problem: PlanningProblem) -> None:
    (_, second), _ = replanned(problem, Refutation((1,), (("other",),)))
    assert "Releasing" not in second


def test_what_does_not_fit_as_it_is_held_is_set_down_and_taken_again(problem: PlanningProblem) -> None:
    plans, _ = replanned(problem, Refutation((1, 3), ()), Refutation((1, 3), ()))
    assert "Placing(Locatum=prize, Relatum=tray)" not in plans[1]  # another task for the same, with the same grasp
    assert plans[2].count("Grasping(Patient=prize)") == 2 and plans[2].endswith("Placing(Locatum=prize, Relatum=tray)")


PUT_DOWN = ("soma:PuttingDown", (("Locatum", "prize"), ("Relatum", "tray")))
"""A part of placing, and a task of its own."""


def test_what_was_refused_in_one_part_alone_is_refused_where_that_is_a_task_of_its_own(problem: PlanningProblem) -> None:
    """Else it would be tried in vain once more; but not where the task was refused in another part, too."""
    plans, trace = replanned(problem, Refutation((1, 3), (), part=PUT_DOWN))
    assert plans[1].count("Grasping(Patient=prize)") == 2 and "PuttingDown(Locatum=prize, Relatum=tray)" not in plans[1]
    said = [e.reason.split(" with ")[0] for e in trace.entries if e.kind == "goal" and e.outcome == "refused"]
    assert said == ["no Placing(prize, tray)", "no PuttingDown(prize, tray)"]
    plans, _ = replanned(problem, Refutation((1, 3), ()))
    assert "PuttingDown(Locatum=prize, Relatum=tray)" in plans[1]


def test_a_part_that_no_plan_has_as_a_task_rules_out_no_more(problem: PlanningProblem) -> None:
    steps = next(task_plans(problem)).steps
    for part in (("soma:Dreaming", (("Locatum", "prize"),)), ("soma:PuttingDown", (("Witness", "prize"),))):
        assert len(problem.blockings(steps, Refutation((1, 3), (), part=part))) == 1


def test_the_part_is_that_of_the_last_refused_task_if_there_is_but_one() -> None:
    releasing = ("soma:Releasing", PUT_DOWN[1])
    assert refutation({InTask(3, PUT_DOWN), InTask(3, None), InTask(1)}).part == PUT_DOWN
    for other in (InTask(3, releasing), InTask(3), InTask(4), InTask(4, None)):
        assert refutation({InTask(3, PUT_DOWN), other}).part is None


@pytest.mark.heavy
@pytest.mark.parametrize(("size", "part"), [(0.25, None), (0.01, PUT_DOWN)])
def test_the_search_tells_in_which_part_a_task_was_refused(tmp_path: Path, size: float, part: Part | None) -> None:
    """In putting down, on a tray that is too small; of a thing that is too wide for the hand, in none."""
    wide = "" if part else ", with: {size: [0.2 m, 0.2 m, 60 mm]}"
    scene = SCENE.replace("size: [0.25 m, 0.25 m", f"size: [{size} m, {size} m").replace("0.23", "0.4")  # the other one is out of the way
    (tmp_path / "blocks.yaml").write_text(scene.replace("[0.5, 0.15, 31 mm]}", f"[0.5, 0.15, 31 mm]}}{wide}"))
    trace = Trace()
    assert next(ENGINE.resolve(read_scenario(tmp_path / "blocks.yaml"), budget=Budget(sequences=1), trace=trace), None) is None
    trace.candidate = 1
    assert trace.refutation is not None and trace.refutation.part == part


@pytest.mark.heavy
@pytest.mark.parametrize(
    ("in_the_way", "moved"),
    [
        ((("before", "behind"), ("left", "right")), [{"before", "behind"}, {"left", "right"}]),
        ((("before",), ("left", "right")), [{"before"}, {"left", "right"}]),
        ((("before", "behind", "left", "right"),), [{"before", "behind", "left", "right"}]),
    ],
)
def test_all_of_one_set_are_put_aside(in_the_way: tuple[tuple[str, ...], ...], moved: list[set[str]]) -> None:
    """One refutation is enough to see which things have to be moved together."""
    scenario = read_scenario(find_scenario("kitchen/boxed_in"))
    scene = ENGINE.setting(scenario).symbolic(ENGINE.knowledge.taxonomy)
    plans, _ = replanned(planning_problem(Goal(("prize on tray",)), scene, ENGINE.knowledge), Refutation((1,), in_the_way))
    assert {n for n in ("before", "behind", "left", "right") if f"Grasping(Patient={n})" in plans[1]} in moved


@pytest.mark.heavy
def test_what_stands_in_a_closed_drawer_is_reached_by_opening_that(tmp_path: Path) -> None:
    """No rule asks for it, as the goal is about the bowl alone; and not where the drawer is not what is in the way."""
    path = tmp_path / "bowl.yaml"
    path.write_text(BOWL)
    scene = ENGINE.setting(read_scenario(path)).symbolic(ENGINE.knowledge.taxonomy)
    inside = planning_problem(Goal(("tin in bowl",)), scene, ENGINE.knowledge)
    (first, second), _ = replanned(inside, Refutation((3,), (("bowl",), ("cabinet",), ("drawer",))))
    assert "Opening" not in first and second == f"Opening(Patient=drawer) {first}"
    others, _ = replanned(inside, Refutation((1,), ()), Refutation((1,), ()))
    assert not any("Opening" in plan for plan in others)


def _drawers(folder: Path, far: int = 0, more: str = "") -> PlanningProblem:
    path = folder / "drawers.yaml"
    path.write_text(DRAWERS.replace("FAR", str(far)) + more)
    scene = ENGINE.setting(read_scenario(path)).symbolic(ENGINE.knowledge.taxonomy)
    return planning_problem(Goal(("right open", "left closed")), scene, ENGINE.knowledge)


def test_what_is_opened_is_opened_behind_what_is_shut(tmp_path: Path) -> None:
    """In whatever order the planner has them; not where that is no plan, as what is shut must be open before."""
    given = _drawers(tmp_path)
    shutting, opening = next(task_plans(given)).steps
    assert [str(s) for s in (shutting, opening)] == ["Closing(Patient=left)", "Opening(Patient=right)"]
    assert given.shut_first((opening, shutting)) == (shutting, opening)
    same = replace(shutting, needs=frozenset({("joint_open", "right")}))
    assert given.shut_first((opening, same)) == (opening, same)


@pytest.mark.parametrize(("tins", "few"), [(3, True), (4, False)])
def test_three_drawers_count_as_one_thing_that_is_carried(tmp_path: Path, tins: int, few: bool) -> None:
    """Of few things the shortest plan is searched; a drawer is open or shut, and stands nowhere else."""
    more = "".join(TIN.format(n) for n in range(1, tins))
    given = _drawers(tmp_path, more=more)
    assert few_things(given, Scope(frozenset(given.grounder.things))) is few


@pytest.mark.heavy
def test_a_closed_drawer_in_the_way_of_another_is_opened_last_of_all(tmp_path: Path) -> None:
    """Open it takes more room: what is loose is carried away, and where nothing is, one that is open is shut; else it is tried."""
    given = _drawers(tmp_path)
    loose, _ = replanned(given, Refutation((1,), (("far",), ("right",), ("tin",))))
    assert loose[1].startswith("Grasping(Patient=tin)") and loose[1].endswith("Closing(Patient=left) Opening(Patient=right)")
    assert "far" not in loose[1]
    alone, _ = replanned(given, Refutation((1,), (("far",),)))
    assert alone[1].startswith("Opening(Patient=far)")
    ajar, _ = replanned(_drawers(tmp_path, 150), Refutation((1,), (("far",), ("right",))))
    assert ajar[1] == "Closing(Patient=far) Closing(Patient=left) Opening(Patient=right)"


@pytest.mark.heavy
@pytest.mark.parametrize(("opened", "farther"), [(100, True), (195, False)])
def test_a_drawer_in_the_way_is_opened_farther_unless_it_is_wide_open(tmp_path: Path, opened: int, farther: bool) -> None:
    path = tmp_path / "bowl.yaml"
    text = BOWL.replace("parent: cabinet", f"parent: cabinet, opened: {opened} mm")
    path.write_text(text.replace("[0.75, 0.1, 0.309]", f"[{0.75 - opened / 1000:.3f}, 0.1, 0.309]"))
    scene = ENGINE.setting(read_scenario(path)).symbolic(ENGINE.knowledge.taxonomy)
    inside = planning_problem(Goal(("tin in bowl",)), scene, ENGINE.knowledge)
    in_the_way = Refutation((3,), (("bowl",), ("drawer",)))
    plans, _ = replanned(inside, in_the_way, *[Refutation((1,), ())] * 3)
    assert "Opening" not in plans[0] and any(p == f"Opening(Patient=drawer) {plans[0]}" for p in plans[1:]) == farther
    assert farther or not any("Opening(Patient=drawer)" in p.partition("Closing")[0] for p in plans)


def test_a_drawer_in_the_way_is_moved_for_a_goal_about_which_no_rule_asks_of_joints(tmp_path: Path) -> None:
    """Only what the goal and its rules ask about is planned with, until something of it was refused."""
    path = tmp_path / "bowl.yaml"
    path.write_text(BOWL)
    scene = ENGINE.setting(read_scenario(path)).symbolic(ENGINE.knowledge.taxonomy)
    whole = planning_problem(Goal(("tin in bowl",)), scene, ENGINE.knowledge)
    seen = whole.alone("cabinet seen", replace(whole.wanted, needs=frozenset({("in_view", "cabinet")}), without=frozenset()))
    plans, _ = replanned(seen, Refutation((1,), (("drawer",),)))
    assert plans[0] == "LookingAt(Patient=cabinet)"
    assert plans[1].endswith("(Patient=drawer) LookingAt(Patient=cabinet)")


@pytest.mark.heavy
@pytest.mark.parametrize(("height", "pushed"), [(16, True), (60, False)])
def test_what_is_flat_and_no_hand_takes_hold_of_is_pushed_aside(tmp_path: Path, height: int, pushed: bool) -> None:
    """After it could not be carried; what is higher is only carried."""
    path = tmp_path / "board.yaml"
    path.write_text(BOARD.format(height=height))
    scene = ENGINE.setting(read_scenario(path)).symbolic(ENGINE.knowledge.taxonomy)
    given = planning_problem(Goal(("drawer open",)), scene, ENGINE.knowledge)
    plans, _ = replanned(given, Refutation((1,), (("board",),)), Refutation((1,), ()))
    assert plans[0] == "Opening(Patient=drawer)" and plans[1].startswith("Grasping(Patient=board)")
    assert any("Pushing(Patient=board)" in p for p in plans) == pushed
    assert plans[2:] == ["Pushing(Patient=board) Retracting(Relatum=board) Opening(Patient=drawer)"] if pushed else True


def test_with_one_that_stays_in_each_set_nothing_helps(problem: PlanningProblem) -> None:
    steps = next(task_plans(problem)).steps
    stays, goes = (problem.blocking(steps, Refutation((1,), (any_of,))) for any_of in (("other", "tray"), ("other",)))
    assert stays is not None and [str(t) for t in stays.tracks] == ["'prize' as it was"]
    assert goes is not None and [str(t) for t in goes.tracks] == ["'other' as it was", "'prize' as it was"]


def test_what_fails_whatever_is_moved_leaves_no_plan(problem: PlanningProblem) -> None:
    plans, _ = replanned(problem, Refutation((1,), ()), *[Refutation((1,), ())] * 9)
    assert len(plans) == 1 or all("prize" in p for p in plans)
    assert not any(p.startswith("Grasping(Patient=prize)") for p in plans[1:])


def test_where_nobody_says_what_it_depends_on_anything_may_help(problem: PlanningProblem) -> None:
    steps = next(task_plans(problem)).steps
    known, unknown = (problem.blocking(steps, Refutation((1,), things)) for things in ((("other",),), None))
    assert known is not None and known == unknown
    assert problem.blocking(steps, Refutation((), None)) is None  # no task was refused


def test_a_blocking_bars_a_task_only_while_its_things_are_as_they_were(problem: PlanningProblem) -> None:
    steps = next(task_plans(problem)).steps
    blocking = problem.blocking(steps, Refutation((1, 3), ()))
    assert blocking is not None and blocking.task[0] == "soma:Placing"
    grasp, lift, place = steps
    assert blocking.bars((grasp, lift), place) and blocking.bars((grasp,), place)  # how the arm moved makes no difference
    assert not blocking.bars((grasp, lift, place, grasp, lift), place)
    assert not blocking.bars((grasp, lift), lift)


@pytest.mark.parametrize(("unfit", "more"), [("tray", False), ("prize", False), ("other", True)])
def test_a_goal_about_what_can_play_no_role_is_given_up(problem: PlanningProblem, unfit: str, more: bool) -> None:
    trace = Trace()
    plans = task_plans(problem, trace=trace)
    first = next(plans)
    trace.candidate = 1
    trace.refuted("first", refutation({Unfit(unfit)}))
    assert (next(plans, None) is not None) is more and "soma:Placing" in [s.task for s in first.steps]


def test_a_thing_out_of_reach_ends_the_search_for_other_tasks(tmp_path: Path) -> None:
    (tmp_path / "far.yaml").write_text(SCENE.replace("[0.45, -0.35, 0.15]", "[0.45, -1.35, 0.15]"))
    trace = Trace()
    assert list(ENGINE.resolve(read_scenario(tmp_path / "far.yaml"), trace=trace)) == []
    assert {e.candidate for e in trace.entries if e.designator == "tray"} == {1}
    assert trace.refutation is not None and trace.refutation.unfit == ("tray",)


def test_a_thing_whose_features_do_not_suit_the_tasks_may_suit_others(tmp_path: Path) -> None:
    """What is asked of it comes from the roles that it has in one sequence."""
    trace, scene = Trace(), SCENE.replace("goal: [prize on tray]", "tasks: [{task: Hang, Locatum: prize, Relatum: tray}]")
    (tmp_path / "no_peg.yaml").write_text(scene.replace("Hang", "InsertHoleOntoPeg"))
    assert list(ENGINE.resolve(read_scenario(tmp_path / "no_peg.yaml"), trace=trace)) == []
    assert "without the" in " ".join(e.reason for e in trace.entries) and trace.refutation is not None and not trace.refutation.unfit


def test_a_conflict_set_says_tasks_and_things() -> None:
    assert refutation({"grasp(x)", InTask(3), InTask(1), *as_they_are(("b", "a"))}) == Refutation((1, 3), (("a",), ("b",)))
    assert refutation({InTask(1), *as_they_are(("a",)), *as_they_are(None)}).things is None


def test_of_several_sets_of_things_the_least_say_the_most() -> None:
    sets = as_they_are((("left", "right"), ("left", "behind", "right"), ("before", "behind")))
    assert refutation({InTask(1), *sets}).things == (("before", "behind"), ("left", "right"))


# The track of a thing in PDDL is at its end exactly if its history is that of the track

TASKS: dict[str, Handling] = {
    "take": Handling(takes=True, lets_go=False, displaces=False, holds=True),
    "lift": Handling(takes=False, lets_go=False, displaces=True, holds=True),
    "drop": Handling(takes=False, lets_go=True, displaces=False, holds=True),
    "place a": Handling(takes=False, lets_go=True, displaces=True, holds=True),
    "place b": Handling(takes=False, lets_go=True, displaces=True, holds=True),
    "push": Handling(takes=False, lets_go=False, displaces=True, holds=False),
    "open": Handling(takes=False, lets_go=False, displaces=True, holds=False, settles=True),
    "shut": Handling(takes=False, lets_go=False, displaces=True, holds=False, settles=True),
}


def legal(names: Sequence[str]) -> list[str]:
    """The tasks that can follow one another: what is held is not taken, and what is not held is not let go of."""
    held, found = False, []
    for name in names:
        how = TASKS[name]
        if held == (how.holds and not how.takes):
            found.append(name)
            held = (held or how.takes) and not how.lets_go
    return found


def past_of(names: Sequence[str]) -> tuple[Done, ...]:
    """The history, told as the rule is written down: what was taken counts once it is moved, or while it is in the hand."""
    past, taken = list[str](), ""
    for name in names:
        how = TASKS[name]
        if how.takes:
            taken = name
        if how.settles:
            past, taken = [name], ""
        elif how.displaces:
            past += [taken] if taken else [] if how.holds else [name]
            taken = ""
        if how.lets_go:
            past += [] if taken else [name]
            taken = ""
    return tuple((name, ()) for name in (*past, *([taken] if taken else [])))


@given(st.lists(st.sampled_from(sorted(TASKS)), max_size=9), st.lists(st.sampled_from(sorted(TASKS)), max_size=9))
@examples(400)
def test_a_track_ends_where_the_history_is_its_own(one: list[str], other: list[str]) -> None:
    track = Track("thing", past_of(legal(one)))
    for names in (legal(one), legal(other)):
        stage = (0, "")
        for name in names:
            stage = track.after(stage, TASKS[name], (name, ()))  # type: ignore[assignment,arg-type]
        assert (stage in track.at_its_end()) == (past_of(names) == track.past)


def test_of_what_moved_a_joint_the_last_task_counts_alone() -> None:
    """Closing, opening and closing anew makes no other place of what is closed."""
    stage: Stage | None = (0, "")
    shut = Track("door", past_of(["shut"]))
    for name, same in (("shut", True), ("open", False), ("shut", True), ("open", False)):
        stage = shut.after(stage, TASKS[name], (name, ()))
        assert (stage in shut.at_its_end()) == same
    assert past_of(["shut", "open", "shut"]) == shut.past


def test_a_blocking_is_said_with_what_was_done() -> None:
    done: Done = ("soma:Grasping", (("Patient", "tin"),))
    tin, cup, lid = Track("tin", (done,)), Track("cup", ()), Track("lid", ())
    said = str(Blocking(("soma:Placing", (("Locatum", "tin"), ("Relatum", "shelf"))), (((tin,),), ((cup,), (lid, tin)))))
    assert said == (
        "no Placing(tin, shelf) with 'tin' after Grasping(tin) and any of 'cup' as it was, 'lid' as it was with 'tin' after Grasping(tin)"
    )


TABLE = """<mujoco><worldbody>
<body name="table" pos=".5 0 .2"><geom type="box" size=".3 .4 .02"/>
<site name="table_left_region" type="box" size=".03 .03 .005" pos="0 .2 .02"/>
<site name="table_right_region" type="box" size=".03 .03 .005" pos="0 -.2 .02"/></body>
{}</worldbody></mujoco>"""
LOOSE = '<body name="{0}" pos="{1} {2} .25"><freejoint/><geom type="box" size=".03 .03 .03" mass=".1"/></body>'


def _table(folder: Path, goal: tuple[str, ...], more: int = 0) -> PlanningProblem:
    """Two things, each where a goal may want the other, and further ones behind."""
    places = [("one", 0.5, 0.2), ("two", 0.5, -0.2), *((f"other{k}", 0.7, -0.3 + 0.1 * k) for k in range(more))]
    (folder / "scene.xml").write_text(TABLE.format("".join(LOOSE.format(*p) for p in places)))
    path = folder / "table.yaml"
    path.write_text("scenario: table\nrobot: {type: ur5e}\nworld: {file: scene.xml}\ntasks: []\n")
    scene = ENGINE.setting(read_scenario(path)).symbolic(ENGINE.knowledge.taxonomy)
    return planning_problem(Goal(goal), scene, ENGINE.knowledge)


def _met(number: int, thing: str, other: str) -> Refutation:
    """What is put down as a task of a plan meets another thing."""
    part = ("soma:PuttingDown", (("Locatum", thing), ("Relatum", "table")))
    return Refutation((number,), ((other,),), "", part)


@pytest.mark.parametrize("more", [0, 4])
def test_what_is_in_the_way_is_moved_and_not_what_meets_it_brought_from_elsewhere(tmp_path: Path, more: int) -> None:
    """With any number of things the plan has no detour: three tasks more than before, all about what was in the way."""
    plans, _ = replanned(_table(tmp_path, ("one on table/right_region",), more), _met(3, "one", "two"))
    first, second = (p.split(") ") for p in plans)
    assert len(second) == len(first) + 3 and sum("one" in step for step in second) == len(first)
    assert sum("two" in step for step in second) == 3


def test_what_is_in_the_way_and_stays_is_met_from_elsewhere_at_last(tmp_path: Path) -> None:
    """That nothing else can be moved leaves what else can be done with the task's own thing."""
    given = _table(tmp_path, ("one on table/right_region",))
    blocking = given.blocking(next(task_plans(given)).steps, Refutation((3,), (("two",),)))
    assert blocking is not None and {t[0][0].thing for t in blocking.sets} == {"one", "two"}
    assert [t[0][0].thing for t in blocking.while_others_stay().sets] == ["two"]
    alone = replace(blocking, sets=blocking.sets[:1])
    assert alone.while_others_stay() == alone
    scopes = list(replace(given, blocked=(blocking,)).scopes())
    assert [s.others_moved for s in scopes][:2] == [True, False] and not any(s.others_moved for s in given.scopes())


def test_two_things_that_change_places_need_a_third(tmp_path: Path) -> None:
    """Each is refused where the other stands; one is put down where the goal does not ask for it, and brought to its place in the end."""
    given = _table(tmp_path, ("one on table/right_region", "two on table/left_region"))
    plans, _ = replanned(given, _met(3, "one", "two"), _met(3, "two", "one"))
    assert not any("elsewhere" in p for p in plans[:2]) and plans[2].count("Placing elsewhere(") == 1
