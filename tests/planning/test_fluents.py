"""Fluents: what follows from facts and what ends with them, as predicates declare it; a new one is planned with."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from helpers.goal_plans import plans_in

from cramlite import Engine, Goal, PluginError, Trace, find_scenario, read_scenario
from cramlite.interpretation.fluents import Fluents, Pattern, fluents_of
from cramlite.plugin import Fact, Fluent, GoalCondition, GoalPhrase, UserError

SHIPPED = fluents_of({p.name: p.fluent for p in Engine().knowledge.predicates})
HANGS = SHIPPED.implied({("touches", "tea", "hook/peg")}, {"tea"})


def test_what_a_carried_thing_is_brought_to_touch_supports_it() -> None:
    assert {
        ("touches", "tea", "hook/peg"), ("touches", "hook/peg", "tea"), ("touches", "tea", "hook"),
        ("touches", "hook", "tea"), ("supports", "hook", "tea"),
    } == HANGS  # fmt: skip
    assert not any(f[0] == "supports" for f in SHIPPED.implied({("touches", "tea", "hook/peg")}, ()))


@pytest.mark.parametrize("lost", [("touches", "tea", "hook/peg"), ("supports", "hook", "tea"), ("supports", None, "tea")])
def test_support_and_contact_end_together(lost: Fact) -> None:
    assert SHIPPED.after(HANGS, frozenset(), [lost]) == frozenset()
    assert SHIPPED.after(HANGS, frozenset(), [("touches", "gripper", "tea")]) == HANGS


def test_contact_with_a_thing_lasts_as_long_as_with_some_part_of_it() -> None:
    both = SHIPPED.implied({*HANGS, ("touches", "tea", "hook/tip")}, {"tea"})
    left = SHIPPED.after(both, frozenset(), [("touches", "tea", "hook/peg")])
    assert left == both - {("touches", "tea", "hook/peg"), ("touches", "hook/peg", "tea")}
    assert SHIPPED.after(left, frozenset(), [("touches", "tea", "hook/tip")]) == frozenset()


@pytest.mark.parametrize("lost", [("supports", None, "tea"), ("touches", "tea", "hook/peg")])
def test_facts_about_a_predicate_change_as_among_all_facts(lost: Pattern) -> None:
    every = HANGS | {("faces", "tea", "hook"), ("stands_upright", "tea")}
    some = SHIPPED.about(every, {"supports"})
    assert {f[0] for f in some} == {"supports", "touches"}, "what a predicate implies belongs to it"
    assert SHIPPED.about(SHIPPED.after(every, frozenset(), [lost]), {"supports"}) == SHIPPED.after(some, frozenset(), [lost]) != some
    assert SHIPPED.about(every, {None}) == every


def test_nothing_follows_where_nothing_is_declared() -> None:
    assert Fluents().implied({("touches", "tea", "hook/peg")}, {"tea"}) == {("touches", "tea", "hook/peg")}
    assert Fluents().after(HANGS, frozenset(), [("supports", None, "tea")]) == HANGS - {("supports", "hook", "tea")}


def _nothing(*_things: object) -> GoalCondition:
    return GoalCondition()


@pytest.mark.parametrize(
    ("fluents", "says"),
    [
        ({"near_by": Fluent(implies=("neer_by",))},
         "'near_by' refers to a predicate 'neer_by', which no plugin declares; did you mean 'near_by'"),
        ({"a": Fluent(undoes=("b",))}, "'a' refers to a predicate 'b'"),
        (
            {n: Fluent(phrases=(GoalPhrase(f"{n.upper()} on PLACE", _nothing),)) for n in ("lid", "cup")},
            "'lid' and 'cup' both declare the goal phrase 'CUP on PLACE'",
        ),
    ],
)
def test_declarations_that_do_not_fit_each_other(fluents: dict[str, Fluent], says: str) -> None:
    with pytest.raises(PluginError, match=says):
        fluents_of(fluents)


LINKING = """
from pathlib import Path
from cramlite.plugin import Fluent, GoalCondition, GoalPhrase
from cramlite.plugin import Predicate

def linked(phase, a, b):
    return ()

def means(scene, a, b):
    return GoalCondition(needs=frozenset({{("linked", a, b)}}))

class Linking(TaskType):
    task = "cram:Linking"
    roles = (Role("Patient"), Role("Other"))
    summary = "link a held thing with another one"
    rule_file = Path(__file__).with_suffix(".yaml")
    def decompose(self, action, belief):
        yield Decomposition((), "nothing")

@hookimpl
def task_types():
    return [Linking()]

@hookimpl
def predicates():
    phrase = GoalPhrase("THING linked with THING", means, verbs=("is", "gets"))
    return [Predicate("linked", 2, linked, doc="Two things are linked.", fluent=Fluent(symmetric={symmetric}, phrases=(phrase,)))]
"""
RULE = """
task: cram:Linking
roles: {Patient: soma:Patient, Other: soma:Patient}
source: a test
pre: ["effector(Gripper)", "grasps(Gripper, Patient)", "thing(Other)"]
post: ["linked(Patient, Other)"]
explain: "{Patient} is linked with {Other}"
"""
Plugin = Callable[[str, str], Path]


def _plans(plugin: Plugin, symmetric: bool, goal: str) -> tuple[list[str], Trace]:
    file = plugin("linking", LINKING.format(symmetric=symmetric))
    file.with_suffix(".yaml").write_text(RULE)
    engine, trace = Engine(files=[str(file)]), Trace()
    setting = engine.setting(read_scenario(find_scenario("place_on_shelf")))
    return [str(p) for p in plans_in(setting, Goal((goal,)), engine.knowledge, trace)], trace


@pytest.mark.heavy
@pytest.mark.parametrize("goal", ["block linked with shelf", "shelf gets linked with block"])
def test_a_plugin_s_symmetric_predicate_with_a_goal_phrase_is_planned(goal: str, plugin: Plugin) -> None:
    plans, trace = _plans(plugin, True, goal)
    assert plans[0] == "Grasping -> Linking"
    assert "Linking(Patient=block, Other=shelf)" in [e.text for e in trace.entries]


@pytest.mark.heavy
def test_without_symmetry_nobody_links_what_cannot_be_grasped(plugin: Plugin) -> None:
    assert _plans(plugin, False, "block linked with shelf")[0][0] == "Grasping -> Linking"
    plans, trace = _plans(plugin, False, "shelf linked with block")
    assert plans == []
    assert "no task's rule makes linked(shelf, block) true" in trace.entries[-1].reason


def test_a_phrase_is_a_goal_only_where_its_plugin_is(plugin: Plugin) -> None:
    with pytest.raises(UserError, match=r"'block hangs linked with shelf' is no goal; say .*'THING linked with THING'"):
        _plans(plugin, True, "block hangs linked with shelf")
    setting = Engine().setting(read_scenario(find_scenario("place_on_shelf")))
    with pytest.raises(UserError, match="'block linked with shelf' is no goal") as refused:
        next(plans_in(setting, Goal(("block linked with shelf",)), Engine().knowledge, Trace()))
    assert "linked with THING" not in str(refused.value)
