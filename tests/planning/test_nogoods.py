"""No-goods: a combination of choices that failed is known again when its last choice is made, and at no other time."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

import pytest
from helpers.properties import examples
from hypothesis import given
from hypothesis import strategies as st
from test_search import FINE, TASK, Trial

from cramlite import Budget, Trace
from cramlite.model import (
    Action,
    Belief,
    Compound,
    Joint,
    Location,
    Motion,
    Object,
    Place,
    Pose,
    RobotMount,
    Thing,
    World,
)
from cramlite.planning.search.choice_point import CAPS, ChoicePoint, Nogoods, key_of
from cramlite.planning.search.state import Effect, State

Plugin = Callable[[str, str], Path]
NAMES = ("a", "b", "c", "d")

TABLE = """
ASKED = []
@hookimpl
def resolve_object(designator, belief, context):
    return [Grounding(f"{designator.name}{k}", "one", cost=k, key=f"{designator.name}{k}") for k in range(COUNTS[designator.name])]
@hookimpl
def resolve_location(location, belief, context):
    made = tuple(context.bindings[n] for n in NAMES)
    ASKED.append(made)
    because = WHY(*made)
    if because:
        raise Unresolvable("it does not go", because=because)
    return [Grounding(Stand(Pose(), "there"), "fine", key="there")]
"""


def tried(plugin: Plugin, counts: Mapping[str, int], why: str) -> Trial:
    """A search over objects of some counts, and a place that says with which of them it does not go."""
    names = tuple(counts)
    return Trial(plugin("table", f"COUNTS, NAMES = {dict(counts)}, {names}\nWHY = lambda {', '.join(names)}: {why}\n{TABLE}"))


def agenda(counts: Mapping[str, int]) -> tuple[Object | Location, ...]:
    return (*map(Object, counts), Location("place", "at"))


# In a search


def test_a_combination_that_failed_is_not_asked_about_again(plugin: Plugin) -> None:
    counts = {"w": 2, "x": 1, "y": 2}
    trial = tried(plugin, counts, "('x', 'y') if y == 'y0' else ('w',) if w == 'w0' else ()")
    (found,) = [{k: b[k] for k in counts} for b in trial.bindings(*agenda(counts))]
    assert found == {"w": "w1", "x": "x0", "y": "y1"}
    asked = trial.module("table").ASKED
    assert asked == [("w0", "x0", "y0"), ("w0", "x0", "y1"), ("w1", "x0", "y1")], "('w1', 'x0', 'y0') is known"
    assert trial.outcomes("y", "nogood") == ["y0"]


def test_what_another_value_might_cure_is_asked_about_again(plugin: Plugin) -> None:
    counts = {"w": 2, "x": 1, "y": 2}
    trial = tried(plugin, counts, "('w', 'x', 'y') if y == 'y0' else ('w',) if w == 'w0' else ()")
    assert len(trial.bindings(*agenda(counts))) == 1
    assert ("w1", "x0", "y0") in trial.module("table").ASKED and trial.outcomes("y", "nogood") == []


def test_what_a_no_good_is_about_is_gone_back_to(plugin: Plugin) -> None:
    """With w1, y0 is known not to go with x0 and y1 goes with nothing: that it depends on x is what is known of y0."""
    counts = {"w": 2, "x": 2, "y": 2}
    why = "('x', 'y') if (x, y) == ('x0', 'y0') else ('w', 'y') if w == 'w0' else ('y',) if y == 'y1' else ()"
    trial = tried(plugin, counts, why)
    (found,) = [{k: b[k] for k in counts} for b in trial.bindings(*agenda(counts))]
    assert found == {"w": "w1", "x": "x1", "y": "y0"}
    assert "y0" in trial.outcomes("y", "nogood")


def test_what_depends_on_nothing_more_is_known_one_choice_earlier(plugin: Plugin) -> None:
    counts = {"w": 2, "x": 2, "y": 1}
    trial = tried(plugin, counts, "('x', 'y') if x == 'x0' else ('w',) if w == 'w0' else ()")
    assert len(trial.bindings(*agenda(counts))) == 1
    assert trial.outcomes("x", "nogood") == ["x0"] and trial.outcomes("y", "nogood") == []


def test_each_solution_is_found_once_and_none_is_lost(plugin: Plugin) -> None:
    counts = {"w": 3, "x": 3, "y": 3}
    trial = tried(plugin, counts, "('w', 'y') if int(w[1]) == int(y[1]) else ('x', 'y') if int(x[1]) + int(y[1]) == 3 else ()")
    found = [(b["w"], b["x"], b["y"]) for b in trial.bindings(*agenda(counts))]
    right = [(f"w{w}", f"x{x}", f"y{y}") for w in range(3) for x in range(3) for y in range(3) if w != y and x + y != 3]
    assert found == right


def test_alternatives_that_are_known_to_fail_are_none_of_those_that_are_capped(plugin: Plugin) -> None:
    most = CAPS[Object]
    counts = {"w": 2, "y": most + 1}
    trial = tried(plugin, counts, f"('w', 'y') if y == 'y0' else ('y',) if y != 'y{most}' else ()")
    (found,) = trial.bindings(*agenda(counts))
    assert (found["w"], found["y"]) == ("w1", f"y{most}")
    assert len(trial.outcomes("y", "nogood")) == most - 1 and len(trial.outcomes("y", "capped")) == 1


# By themselves


def made(*choices: str) -> tuple[tuple[str, str], ...]:
    return tuple((c[0], c) for c in choices)


def test_a_no_good_is_known_again_by_its_last_choice_alone() -> None:
    nogoods = Nogoods()
    assert nogoods.made_again(made("a0")) is None
    nogoods.remember(frozenset("ac"), made("a0", "b0", "c0"))
    assert nogoods.made_again(made("a0", "c0")) == {"a", "c"}, "it is all that was chosen"
    assert nogoods.made_again(made("a0", "b1", "c0")) == {"a", "c"}
    assert nogoods.made_again(made("c0", "b1", "a0")) == {"a", "c"}
    assert nogoods.made_again(made("a0", "c1")) is None and nogoods.made_again(made("a1", "c0")) is None
    assert nogoods.made_again(made("a0", "c0", "b0")) is None, "b has no part in it"


def test_a_failure_that_depends_on_nothing_is_remembered_as_nothing() -> None:
    nogoods = Nogoods()
    nogoods.remember(frozenset(), made("a0"))
    nogoods.remember(frozenset("z"), made("a0"))
    assert nogoods.known == {} and nogoods.made_again(made("a0")) is None


@given(
    known=st.lists(st.tuples(st.frozensets(st.sampled_from(NAMES)), st.lists(st.integers(0, 1), min_size=4, max_size=4)), max_size=5),
    now=st.lists(st.integers(0, 1), min_size=1, max_size=4),
)
@examples(200)
def test_it_is_known_exactly_if_all_of_it_was_chosen(known: list[tuple[frozenset[str], list[int]]], now: list[int]) -> None:
    nogoods = Nogoods()
    for conflict, values in known:
        nogoods.remember(conflict, tuple((n, str(v)) for n, v in zip(NAMES, values, strict=True)))
    choices = tuple((n, str(v)) for n, v in zip(NAMES, now, strict=False))
    last = choices[-1][0]
    chosen = dict(choices)
    pairs = [(c, dict(zip(NAMES, map(str, values), strict=True))) for c, values in known]
    matching = [c for c, values in pairs if last in c and all(chosen.get(n) == values[n] for n in c)]
    found = nogoods.made_again(choices)
    assert (found in matching) if matching else found is None


# Choice points


def point(item: Action | Object | Location | Motion | Compound, *chosen: str, **state: object) -> ChoicePoint:
    belief = Belief(World((), (RobotMount("arm", "none"),)), {}, "arm", (), 0.0)
    return ChoicePoint(item, State((), belief, choices=tuple((c, "x") for c in chosen), **state), Trace(), 0)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("item", "domain"),
    [
        (Object("o"), set()),
        (Object("o", part_of="tea"), {"tea"}),
        (Object("o", part_of="nobody"), set()),
        (Action("2.X", "x:X", {"Patient": Object("tea")}), {"tea"}),
        (Location("l", "at"), {"tea", "1.X"}),
        (Motion("2.X/go", "free"), {"tea", "1.X", "1.X/go"}),
    ],
)
def test_what_alternatives_depend_on(item: Action | Object | Location | Motion, domain: set[str]) -> None:
    assert point(item, "tea", "1.X", "1.X/go", motions=frozenset({"1.X/go"})).domain == domain


@pytest.mark.parametrize(
    ("item", "task", "joint", "about"),
    [
        (Location("grasp", "grasp", "tea"), "2.Grasping", True, {"opened"}),
        (Location("away", "retreat"), "1.Opening", True, {"handle", "opened"}),
        (Motion("2.Grasping/go", "free"), "2.Grasping", True, {"handle", "opened"}),
        (Location("grasp", "grasp", "tea"), "2.Grasping", False, {"handle", "opened"}),
    ],
)
def test_how_a_drawer_was_held_does_not_say_where_it_is(item: Location | Motion, task: str, joint: bool, about: set[str]) -> None:
    """Once that is done: what says how far it was opened does. What is on no joint is where the hand that held it was."""
    slide = Joint("slide", Pose(), 0.0, 0.2) if joint else None
    world = World((Thing("drawer", "soma:Drawer", Pose(), (), joint=slide),), (RobotMount("arm", "none"),))
    belief = Belief(world, {}, "arm", (), 0.0)
    bindings = {"handle": Place(Pose(), Pose(), thing="drawer"), "opened": Place(Pose(), Pose(), thing="drawer", path=(Pose(),))}
    made = ("1.Opening", "handle", "opened", *(("2.Grasping",) if task == "2.Grasping" else ()))
    choices, agenda = tuple((name, "x") for name in made), (Effect(Action(task, f"soma:{task[2:]}")),)
    asked = ChoicePoint(item, State(agenda, belief, choices=choices, bindings=bindings), Trace(), 0)
    assert asked.about(["drawer"]) & {"handle", "opened"} == about


def test_how_many_alternatives_are_tried() -> None:
    """As the architecture page says; ``Late`` is an object that is found when the program runs."""
    assert {kind.__name__: most for kind, most in CAPS.items()} == {"Action": 6, "Object": 8, "Late": 8, "Location": 12, "Motion": 4}
    assert [point(i).cap for i in (Object("o"), Location("l", "at"), Motion("m", "free"), Action("1.X", "x:X"))] == [8, 12, 4, 6]


def test_what_a_designator_is_part_of() -> None:
    assert point(Motion("1.X/Y/go", "free"), "1.X", "1.X/Y", "2.X", "1").asked_by == {"1.X", "1.X/Y"}


def test_where_the_robot_stands_is_in_every_conflict() -> None:
    assert point(Object("o")).conflict == set() and point(Object("o"), stand="there").conflict == {"there"}


def test_an_exhausted_one_says_what_it_depends_on() -> None:
    for tries, said in ((1, "1 alternative failed"), (0, "0 alternatives failed"), (2, "2 alternatives failed")):
        one = point(Object("o"))
        one.exhausted(tries)
        assert one.trace.entries[-1].reason == f"{said}; it depends on nothing before it"
        assert one.trace.entries[-1].numbers == {"tried": tries}


@pytest.mark.parametrize(("length", "hashed"), [(60, False), (61, True)])
def test_a_key_is_the_text_or_of_a_long_one_twelve_digits(length: int, hashed: bool) -> None:
    text = "x" * length
    assert (key_of(text) == text) is not hashed
    assert not hashed or (len(key_of(text)) == 12 and key_of(text) != key_of(text + "y"))


# What the search counts


@pytest.mark.parametrize(("asked", "solved"), [(3, 1), (4, 0)])
def test_a_budget_is_so_many_designators_and_no_more(asked: int, solved: int, plugin: Plugin) -> None:
    counts = {f"o{k}": 1 for k in range(asked)}
    trial = Trial(plugin("table", f"COUNTS, NAMES, WHY = {counts}, (), None\n{TABLE}"), budget=Budget(expansions=3))
    assert len(trial.bindings(*map(Object, counts))) == solved


def test_the_first_question_hangs_on_nothing_and_what_was_chosen_passed_nothing(plugin: Plugin) -> None:
    trial = tried(plugin, {"w": 1}, "()")
    assert len(trial.bindings(*agenda({"w": 1}))) == 1
    first = trial.trace.entries[0]
    assert (first.designator, first.outcome, first.parent) == ("w", "asked", 0)
    assert {e.passed for e in trial.trace.entries} == {0}


def test_each_task_of_a_plan_is_counted_from_the_first(plugin: Plugin) -> None:
    trial = Trial(plugin("task", TASK.format(**FINE)))
    assert len(trial.bindings(*(Action(f"{k}.Task", "x:Task") for k in (1, 2, 3)))) == 1
    assert [e.numbers for e in trial.trace.entries if e.outcome == "asked"] == [{"task": k, "depth": 0} for k in (1, 2, 3)]
