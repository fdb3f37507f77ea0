"""The goal language: alternatives, denials, attitudes, amounts, controls; what each means to planning, and an answer for each part."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from helpers.goal_plans import plans_in
from helpers.properties import examples
from hypothesis import given
from hypothesis import strategies as st

from cramlite import Engine, Goal, Setting, Trace, read_scenario
from cramlite.planning.goal_parts import goal_answers
from cramlite.plugin import UserError

ENGINE = Engine()
ROOM = {
    "scenario": "room",
    "goal": ["drawer open"],
    "robot": {"type": "ur5e"},
    "things": [
        {"name": "floor", "model": "table", "at": {"position": [0.2, 0, "-5 mm"]}, "with": {"size": ["1.6 m", "1.6 m", "20 mm"]}},
        {"name": "cabinet", "model": "cabinet", "at": {"position": [0.75, 0.1, 0.35], "yaw": "180 deg"}},
        {"name": "drawer", "model": "drawer", "at": {"position": [0.75, 0.1, 0.35], "yaw": "180 deg"}, "with": {"parent": "cabinet"}},
        {"name": "tray", "model": "table", "at": {"position": [0.45, -0.35, 0.15]}, "with": {"size": ["0.3 m", "0.3 m", "20 mm"]}},
        {"name": "lying", "model": "bottle", "at": {"position": [0.45, 0.2, "40 mm"], "pitch": "90 deg"}},
        {"name": "standing", "model": "bottle", "at": {"position": [0.35, 0.35, "81 mm"]}},
        {"name": "mug", "model": "mug", "at": {"position": [0.5, 0.0, "53 mm"]}},
        {"name": "knob", "model": "knob", "at": {"position": [0.75, 0.4, 0.35], "yaw": "180 deg"}},
    ],
}
SETTING: Setting = ENGINE.setting(read_scenario(ROOM))
PUT = ["Grasping", "PickingUp", "Placing"]


def first(*says: str) -> tuple[list[str], list[dict[str, object]]]:
    plan = next(plans_in(SETTING, Goal(says), ENGINE.knowledge, Trace()))
    return [a.task.split(":")[-1] for a in plan.actions], [dict(a.parameters) for a in plan.actions]


@pytest.mark.heavy
@pytest.mark.parametrize(
    ("goal", "tasks", "told"),
    [
        ("lying upright", PUT, {"where": {"attitude": "upright"}}),
        ("standing is upside down", PUT, {"where": {"attitude": "upside down"}}),
        ("mug facing tray", PUT, {"where": {"facing": "tray"}}),
        ("mug on tray within 30 mm", PUT, {"where": {"near": "tray"}}),
        ("drawer open by 120 mm", ["Opening"], {"share": 0.6}),
        ("not drawer closed", ["Opening"], {}),
        ("knob turned on", ["TurningOn"], {}),
        ("lying on tray or drawer open", ["Opening"], {}),
    ],
)
def test_what_a_goal_asks_of_the_tasks(goal: str, tasks: list[str], told: dict[str, object]) -> None:
    names, parameters = first(goal)
    if " or " in goal:
        assert names in (tasks, PUT)
    else:
        assert names == tasks
        where = {k: v for k, v in parameters[-1].items() if k != "where" or v}
        where["where"] = {k: v for k, v in where.get("where", {}).items() if v and k != "within"}  # type: ignore[attr-defined]
        assert where.get("where") == told.get("where", {}) and where.get("share") == told.get("share")


@pytest.mark.parametrize(
    ("goal", "says"),
    [
        ("standing upright", "holds already"),
        ("knob turned off", "holds already"),
        ("not drawer open", "holds already"),
        ("lying upright or standing upright", "holds already"),
        ("any bottle upright", "names the class"),
        ("not 2 of Cup on tray", "denies a number"),
        ("not lying on tray near mug", "more than one relation"),
        ("drawer open by 300 mm", "opens by 200 mm at most"),
        ("drawer open by 30 mm", "open from 40 mm on"),
        ("drawer open by 30 deg", "not a unit of length"),
        ("mug on tray within 30 deg", "not a unit of length"),
        ("mug on tray/top within 30 mm", "needs a whole thing, not a part: 'tray'"),
        ("drawer turned on", "no knob and no switch"),
        ("cabinet upright", "cannot be moved"),
        ("mug facing mug", "cannot face itself"),
    ],
)
def test_what_makes_no_sense_is_refused_before_planning(goal: str, says: str) -> None:
    with pytest.raises(UserError, match=says):
        first(goal)


@pytest.mark.parametrize(
    ("one", "other"),
    [
        ("mug upright", "mug upside down"), ("drawer open by 100 mm", "drawer open by 150 mm"), ("knob turned on", "knob turned off"),
        ("mug facing tray", "mug facing drawer"), ("mug on tray", "not mug on tray"), ("drawer open by 100 mm", "drawer closed"),
    ],
)  # fmt: skip
def test_contradictions_are_refused(one: str, other: str) -> None:
    with pytest.raises(UserError, match="contradict"):
        first(one, other)


def test_an_attitude_is_asked_of_the_task_that_puts_the_thing_there() -> None:
    names, parameters = first("standing on tray", "standing upright")  # it stands: it shall do so there, too
    assert names == PUT and parameters[-1]["where"]["attitude"] == "upright"  # type: ignore[index]


def test_each_part_has_its_answer() -> None:
    trace = Trace()
    next(plans_in(SETTING, Goal(("drawer open", "mug on tray", "standing upright")), ENGINE.knowledge, trace))
    opened, mug, stands = goal_answers(trace, proven=1)
    assert (opened.answer, mug.answer, stands.answer) == ("achieved", "achieved", "holds")
    assert opened.tasks is not None and opened.tasks[0] == opened.tasks[1] and mug.tasks is not None
    assert mug.tasks[1] - mug.tasks[0] == 2 and stands.tasks is None


@pytest.mark.heavy
def test_where_no_plan_is_each_part_says_why() -> None:
    trace = Trace()
    assert next(plans_in(SETTING, Goal(("mug in tray", "drawer open")), ENGINE.knowledge, trace), None) is None
    answers = goal_answers(trace)
    assert [a.answer for a in answers] == ["missed", "missed"]
    told = r"no task's rule makes in_or_above\(mug, tray\) .*: only '.*' can be in the place of 'tray'"
    assert re.search(told, answers[0].reason), answers[0].reason
    assert "Opening would achieve this part of the goal alone" in answers[1].reason


@pytest.mark.parametrize(
    ("data", "text"),
    [
        ({"goal": "on", "things": ["tin", "tray"]}, "tin on tray"),
        ({"goal": "on", "things": [{"each": "Cup"}, "tray"], "left_of": "jug"}, "each Cup on tray left of jug"),
        ({"goal": "open by", "things": ["drawer"], "amount": "120 mm"}, "drawer open by 120 mm"),
        ({"not": {"goal": "open", "things": ["drawer"]}}, "not drawer open"),
        (
            {"or": [{"goal": "held", "things": ["tin"]}, {"not": {"goal": "held", "things": [{"any": "Cup"}]}}]},
            "tin held or not any Cup held",
        ),
        ({"goal": "in", "things": [{"count": 2, "of": "Cup"}, "basket"]}, "2 of Cup in basket"),
        ("tin on tray", "tin on tray"),
    ],
)
def test_goals_as_data_are_goals_in_words(data: object, text: str) -> None:
    assert Goal.from_json([data]).says == (text,)


@given(st.recursive(st.none() | st.booleans() | st.integers() | st.text(max_size=5), lambda x: st.lists(x, max_size=3)
                    | st.dictionaries(st.sampled_from(["goal", "things", "not", "or", "each", "x"]), x, max_size=3)))  # fmt: skip
@examples(60)
def test_data_that_is_no_goal_is_refused_in_words(data: object) -> None:
    said = ""
    try:
        assert all(isinstance(says, str) for says in Goal.from_json([data]).says)
    except UserError as error:
        said = str(error)
    assert not said or said.endswith("].")


def test_a_scenario_with_data_for_a_goal(tmp_path: Path) -> None:
    scenario = read_scenario({**ROOM, "goal": [{"goal": "open", "things": ["drawer"]}]})
    assert scenario.spec.goal == ("drawer open",)
    assert scenario.with_goal(["mug on tray"]).spec.goal == ("mug on tray",)
    with pytest.raises(UserError, match="a goal as data is"):
        read_scenario({**ROOM, "goal": [{"things": ["drawer"]}]})
