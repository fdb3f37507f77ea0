"""Goals: the tasks that achieve them are chosen by what their rules need and change, explained, and proven."""

from __future__ import annotations

import re
from collections.abc import Callable
from itertools import islice
from pathlib import Path

import pytest
from conftest import Run
from helpers.goal_plans import plans_in
from msgspec.structs import replace

from cramlite import Budget, Engine, Goal, Setting, Trace, find_scenario, read_scenario
from cramlite.interpretation.fluents import symbolic_world
from cramlite.model import Pose
from cramlite.planning.operators import Grounder
from cramlite.planning.symbolic.planning_problem import planning_problem
from cramlite.plugin import UserError

ENGINE = Engine()
SHELF = str(find_scenario("place_on_shelf"))


def _setting(name: str) -> Setting:
    return ENGINE.setting(read_scenario(find_scenario(name)))


def _plans(scenario: str, *says: str, most: int = 3) -> list[str]:
    return [str(plan) for plan in islice(plans_in(_setting(scenario), Goal(says), ENGINE.knowledge, Trace()), most)]


@pytest.mark.parametrize(
    ("scenario", "goal", "first"),
    [
        ("place_on_shelf", "block on shelf", "Grasping -> PickingUp -> Placing"),
        ("place_on_shelf", "block is held", "Grasping"),
        ("take_off_hanger_tasks", "tea in basket", "Grasping -> ExtractHoleFromPeg -> Ungrasping -> Retracting"),
        (
            "hang_onto_hanger",
            "coffee hangs on hook",
            "Grasping -> PickingUp -> InsertHoleOntoPeg -> Releasing -> Retracting",
        ),
        ("tasks/opening", "drawer open", "Opening"),
        ("tasks/closing", "door closed", "Closing"),
        ("tasks/pouring", "jug poured into bowl", "Grasping -> PickingUp -> Pouring"),
        ("take_off_hanger_tasks", "tea off hook", "Grasping -> ExtractHoleFromPeg"),
        ("hang_onto_hanger", "tin on counter near hook", "Grasping -> PickingUp -> Placing"),
    ],
)
def test_the_shortest_sequence_comes_first(scenario: str, goal: str, first: str) -> None:
    assert _plans(scenario, goal, most=1) == [first]


def test_the_same_plans_come_again() -> None:
    assert _plans("hang_onto_hanger", "tin on counter near hook") == _plans("hang_onto_hanger", "tin on counter near hook")


def test_every_task_is_applicable_where_it_stands() -> None:
    setting = _setting("hang_onto_hanger")
    scene = symbolic_world(setting.world, ENGINE.knowledge.taxonomy, setting.relations)
    grounder = Grounder(scene, ENGINE.knowledge.predicates)
    operators = {str(o): o for o in grounder.ground(ENGINE.knowledge.rules, ENGINE.knowledge.tasks)}
    facts = start = grounder.initial
    for name in ("Grasping(Patient=coffee)", "PickingUp(Locatum=coffee, Relatum=counter)"):
        assert operators[name].applies(facts)
        facts = operators[name].apply(facts)
    assert ("supports", "counter", "coffee") in start - facts
    assert ("supports", "counter", "tin") in start & facts  # all else stays
    assert not operators["Grasping(Patient=tin)"].applies(facts)  # the hand is full
    assert "Grasping(Patient=hook)" not in operators  # furniture cannot be in the hand
    assert not [o for o in operators if o.startswith("InsertHoleOntoPeg(Locatum=tin")]  # it has no hole


def test_why_each_task_is_there() -> None:
    trace = Trace()
    next(plans_in(_setting("place_on_shelf"), Goal(("block on shelf",)), ENGINE.knowledge, trace))
    reasons = [e.reason for e in trace.entries if e.outcome == "chosen"]
    assert "grasps(gripper, block), as PickingUp(Locatum=block, Relatum=floor) needs" in reasons[0]
    assert "as the goal needs" in reasons[-1]


@pytest.mark.parametrize(
    ("goal", "says"),
    [
        ("block flies", "'block flies' is no goal; say 'THING on PLACE'"),
        ("block on", "is no goal"),
        ("block open shelf", "is no goal"),
        ("block on shelv", "names 'shelv'; did you mean 'shelf'?"),
        ("block on floor", "holds already in this world"),
        ("block off shelf", "holds already in this world"),
        ("block off", "is no goal; say .*'THING off PLACE'"),
        ("block poured into shelf", "'block' holds nothing that could be poured"),
        ("block on shelf near shelv", "names 'shelv'; did you mean 'shelf'?"),
        ("block on shelf near block", "must be followed by another thing than 'block' and 'shelf'"),
        ("block on shelf/tops", "names 'shelf/tops'; did you mean 'shelf/top'?"),
        ("block on shelf/top near block", "must be followed by another thing"),
        ("block off shelf/top", "'off' needs a whole thing, not a part: 'shelf'"), ("shelf/top held", "is no goal"),
        ("block off shelf near floor", "'near' chooses a spot on a surface or in a container"),
        ("block on shelf above floor", "may be followed by one of 'near', 'left of', 'right of', 'in front of', 'behind' and a THING"),
    ],
)
def test_goals_that_cannot_be_used(goal: str, says: str) -> None:
    with pytest.raises(UserError, match=says):
        _plans("place_on_shelf", goal)


@pytest.mark.heavy
@pytest.mark.parametrize(
    ("goal", "says"),
    [
        ("shelf on floor", r"no task's rule makes supports\(floor, shelf\) true .*: 'shelf' is fixed, since it has no mass"),
        ("block open", r"joint_open\(block\)|no sequence"),
        ("jug poured into counter", r"no task's rule makes contains\(counter, jug/contents\) true"),
    ],
)
def test_goals_that_no_tasks_achieve(goal: str, says: str) -> None:
    trace = Trace()
    setting = _setting("tasks/pouring" if "jug" in goal else "place_on_shelf")
    assert list(ENGINE.resolve(Goal((goal,)), setting=setting, trace=trace)) == []
    (refused,) = [e for e in trace.entries if e.outcome == "refused"]
    assert re.search(says, refused.reason), refused.reason


def test_a_goal_beside_something_becomes_the_place_of_the_task_that_chooses_it() -> None:
    setting, trace = _setting("hang_onto_hanger"), Trace()
    plan = next(plans_in(setting, Goal(("tin on counter right of coffee",)), ENGINE.knowledge, trace))
    wheres = {a.task: a.parameters["where"] for a in plan.actions if "where" in a.parameters}
    assert [(t, w["right_of"]) for t, w in wheres.items()] == [("soma:Placing", "coffee")]
    with pytest.raises(UserError, match="holds already"):  # it stands there: without a side there is nothing to do
        next(plans_in(setting, Goal(("tin on counter",)), ENGINE.knowledge, Trace()))


def test_a_region_becomes_the_place_of_the_task_that_chooses_it() -> None:
    plan = next(plans_in(_setting("place_on_shelf"), Goal(("block on shelf/top",)), ENGINE.knowledge, Trace()))
    wheres = {a.task: a.parameters["where"] for a in plan.actions if "where" in a.parameters}
    assert [(t, w["region"]) for t, w in wheres.items()] == [("soma:Placing", "top")]


def test_a_goal_beside_something_far_away_is_refused_with_the_distance() -> None:
    setting, trace = _setting("place_on_shelf"), Trace()
    far = setting.world.thing("block")
    goal, away = Goal(("block on shelf near post",)), replace(far, name="post", pose=Pose((0.45, 0.6, 0.051)))
    world = replace(setting.world, things=(*setting.world.things, away))
    assert (
        next(
            ENGINE.resolve(
                goal, setting=replace(setting, world=world), trace=trace, budget=Budget(proofs=1, sequences=1)
            ),
            None,
        )
        is None
    )
    assert any("'post'" in e.reason and "up to 200 mm are near" in e.reason for e in trace.entries), {
        e.reason for e in trace.entries
    }


@pytest.mark.parametrize(
    ("aside", "side", "holds"), [(0.15, "near", True), (0.25, "near", False), (0.15, "right of", True), (-0.15, "right of", False)]
)
def test_a_side_of_a_thing_holds_where_the_thing_is_already(aside: float, side: str, holds: bool) -> None:
    setting = _setting("place_on_shelf")
    block = setting.world.thing("block")
    x, y, z = block.pose.position
    world = replace(setting.world, things=(*setting.world.things, replace(block, name="post", pose=Pose((x, y + aside, z)))))
    scene = symbolic_world(world, ENGINE.knowledge.taxonomy, ())
    problem = planning_problem(Goal((f"block on floor {side} post",)), scene, ENGINE.knowledge)
    assert problem.reached is holds
    assert not problem.wanted.met(problem.facts), "before a run it is to be put there"


def test_a_goal_is_proven(tmp_path: Path, run: Run) -> None:
    ran = run("resolve", "hang_up_a_product", "--no-report", "--out", tmp_path / "run")
    assert ran.code == 0, ran.err
    assert "ok  end_state: 'coffee' hangs on 'hook'" in ran.out
    assert "InsertHoleOntoPeg(Locatum=coffee, Relatum=hook/peg)" in run("explain", tmp_path / "run", "goal").out


def test_scenario_goals_are_checked_with_file_and_line(tmp_path: Path, run: Run) -> None:
    path = tmp_path / "bad.yaml"
    text = find_scenario("hang_up_a_product").read_text()
    path.write_text(text.replace("[product on hook]", "[product on hok]"))
    ran = run("check", path)
    assert ran.code == 2
    line = path.read_text().splitlines().index("goal: [product on hok]") + 1
    assert f"bad.yaml:{line}: the goal 'coffee on hok' names 'hok'; did you mean 'hook'?" in ran.err
    path.write_text(text.replace("\ngoal:", "\ntasks: [ParkingArms]\ngoal:"))
    assert "exactly one of" in run("check", path).err


STAMPING = """
from pathlib import Path
class Stamping(TaskType):
    task = "cram:Stamping"
    roles = (Role("Instrument"), Role("Patient"))
    summary = "press a held thing onto another one, and leave it"
    rule_file = Path(__file__).with_suffix(".yaml")
    def decompose(self, action, belief):
        yield Decomposition((), "nothing")
@hookimpl
def task_types():
    return [Stamping()]
"""
RULE = """
task: cram:Stamping
roles: {Instrument: soma:CausativeRole, Patient: soma:Patient}
source: a test
pre: ["effector(Gripper)", "grasps(Gripper, Instrument)", "touches(Instrument, Patient)"]
post: ["not touches(Instrument, Patient)"]
explain: "{Instrument} is pressed onto {Patient}"
"""


def test_a_further_plugin_does_not_change_what_goals_do(plugin: Callable[[str, str], Path]) -> None:
    file = plugin("stamping", STAMPING)
    file.with_suffix(".yaml").write_text(RULE)
    engine, goal = Engine(files=[str(file)]), Goal(("block on shelf",))
    setting = engine.setting(read_scenario(SHELF))
    plans = [str(p) for p in plans_in(setting, goal, engine.knowledge, Trace())]
    assert plans[0] == "Grasping -> PickingUp -> Placing"
    assert any("Stamping" in p for p in plans)  # it is a way, but not before one that is shipped


@pytest.mark.parametrize(
    ("goal", "says"),
    [
        ("block on shelf", "one or more sentences"),
        ((), "one or more sentences"),
    ],
)
def test_goals_in_python_that_cannot_be_used(goal: object, says: str) -> None:
    with pytest.raises(UserError, match=says):
        Goal(goal)  # type: ignore[arg-type]


def test_text_is_no_goal() -> None:
    with pytest.raises(UserError, match=r"'room\.yaml' is text: pass read_scenario"):
        next(ENGINE.resolve("room.yaml"))  # type: ignore[arg-type]
