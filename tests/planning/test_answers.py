"""Answers that are kept, and rounds that grow: with small plugins in files, what is asked of them and what is not."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, cast

import pytest
from msgspec.structs import replace
from test_search import Trial

from cramlite.model import Belief, Estimate, Location, Object, Pose, World
from cramlite.planning.refutation import Capped
from cramlite.planning.search.answers import Answers
from cramlite.planning.search.choice_point import CAPS, Nogoods
from cramlite.planning.search.search import Effort, Search
from cramlite.planning.search.state import State
from cramlite.planning.trace import KNOWN
from cramlite.plugin.grounding import Context, Grounding, Refused

Plugin = Callable[[str, str], Path]
BELIEF = Belief(World(()), {}, "arm", (), 0.0)
TWO = """
@hookimpl
def resolve_object(designator, belief, context):
    return [Grounding(f"{designator.name}{k}", "one", cost=k, key=f"{designator.name}{k}") for k in range(2)]
"""
PLACE = """
ASKED, GIVEN = [], []
@hookimpl
def resolve_location(location, belief, context):
    ASKED.append(location.name)
    def answers():
        for k in range(3):
            GIVEN.append(k)
            yield Grounding(Stand(Pose(), LOOK(k, context)), "fine", cost=k, key=f"{location.name}{k}")
    return answers()
"""


def trial(plugin: Plugin, look: str) -> Trial:
    return Trial(plugin("my_objects", TWO), plugin("my_places", f"LOOK = lambda k, context: {look}\n{PLACE}"))


def found(one: Trial, *agenda: Object | Location) -> list[tuple[str, str]]:
    return [(b["w"], b["place"].thing) for b in one.bindings(*agenda)]


def test_what_a_plugin_does_not_look_at_makes_no_other_question(plugin: Plugin) -> None:
    one = trial(plugin, "'there'")
    assert len(found(one, Object("w"), Location("place", "at"))) == 6
    assert one.module("my_places").ASKED == ["place"] and one.module("my_places").GIVEN == [0, 1, 2]
    said = [e.reason for e in one.trace.entries if (e.designator, e.outcome) == ("place", "asked")]
    assert said == ["", KNOWN]


def test_what_it_looks_at_does(plugin: Plugin) -> None:
    one = trial(plugin, "context.bindings['w']")
    assert found(one, Object("w"), Location("place", "at")) == [("w0", "w0")] * 3 + [("w1", "w1")] * 3
    assert one.module("my_places").ASKED == ["place"] * 2


def test_what_it_looks_at_late_is_what_is_bound_then(plugin: Plugin) -> None:
    """The first answer is the same for both; only the second is known to depend on the object."""
    one = trial(plugin, "context.bindings['w'] if k else 'there'")
    names = [("w0", "there"), ("w0", "w0"), ("w0", "w0"), ("w1", "there"), ("w1", "w1"), ("w1", "w1")]
    assert found(one, Object("w"), Location("place", "at")) == names


def test_a_name_that_is_not_bound_is_looked_at_too(plugin: Plugin) -> None:
    look = "'seen' if 'w' in context.bindings else 'not yet'"
    one = trial(plugin, look)
    assert [b["place"].thing for b in one.bindings(Location("place", "at"))] == ["not yet"] * 3
    assert {n for _, n in found(another(one, Effort()), Object("w"), Location("place", "at"))} == {"seen"}


def test_the_agenda_matters_to_those_who_look_ahead(plugin: Plugin) -> None:
    for look, asked in (("'there'", 1), ("str(len(context.agenda))", 2)):
        one = trial(plugin, look)
        one.bindings(Location("place", "at"))
        another(one, Effort()).bindings(Location("place", "at"), Object("w"))
        assert one.module("my_places").ASKED.count("place") == asked


def another(one: Trial, effort: Effort) -> Trial:
    """The same trial with a further search, to which what was answered is known."""
    search = one.search
    one.search = Search(
        search.registry, search.tasks, search.owners, search.context, search.trace, answers=search.answers, effort=effort
    )
    return one


def many(plugin: Plugin, right: int) -> Trial:
    """Objects of which only one, by its number, goes with the place."""
    body = TWO.replace("range(2)", "range(40)")
    check = f"if context.bindings['w'] != 'w{right}': raise Unresolvable('it does not go', because=('w',), blocking=())"
    return Trial(plugin("my_objects", body), plugin("my_places", PLACE.replace("    def answers", f"    {check}\n    def answers")
                                                 .replace("LOOK(k, context)", "'there'")))  # fmt: skip


def wider(one: Trial) -> list[str]:
    """What the next round finds."""
    another(one, one.search.effort.widened())
    return [str(b["w"]) for b in one.bindings(Object("w"), Location("place", "at"))]


def test_a_wider_round_goes_on_where_the_first_left_off(plugin: Plugin) -> None:
    first = CAPS[Object]
    one = many(plugin, right=3 * first - 1)
    assert one.bindings(Object("w"), Location("place", "at")) == [] and one.search.effort.capped
    assert wider(one)[:1] == [f"w{3 * first - 1}"], "twice as many again: those that are known to fail do not count"
    asked = one.module("my_places").ASKED
    assert len(asked) == 3 * first, "each object once, in both rounds together"


def test_what_is_beyond_a_round_is_not_found_in_it(plugin: Plugin) -> None:
    one = many(plugin, right=3 * CAPS[Object])
    assert one.bindings(Object("w"), Location("place", "at")) == [] and wider(one) == []
    assert wider(one)[:1] == [f"w{3 * CAPS[Object]}"]


def test_where_nothing_was_left_out_there_is_no_wider_round(plugin: Plugin) -> None:
    one = trial(plugin, "'there'")
    one.bindings(Object("w"), Location("place", "at"))
    assert not one.search.effort.capped


def test_what_a_round_has_found_the_next_does_not_find_again(plugin: Plugin) -> None:
    one = Trial(plugin("my_objects", TWO.replace("range(2)", f"range({CAPS[Object] + 3})")))
    states = list(one.search.solve(State((Object("w"),), BELIEF)))
    assert len(states) == CAPS[Object]
    another(one, one.search.effort.widened())
    assert [b["w"] for b in one.bindings(Object("w"))] == [f"w{CAPS[Object] + k}" for k in range(3)]


def test_no_goods_of_a_round_that_left_something_out_end_with_it() -> None:
    nogoods, made = Nogoods(), (("a", "a0"), ("b", "b0"))
    nogoods.remember(frozenset({"a", Capped()}), made)
    nogoods.remember(frozenset({"b"}), made)
    left = nogoods.lasting()
    assert left.made_again(made) == {"b"} and left.made_again(made[:1]) is None and nogoods.made_again(made[:1]) is not None


NEAR_IT = Refused("here", "no room", blocking=("mug",))


@pytest.mark.parametrize(
    ("answers", "moved", "of", "asked"),
    [
        ([NEAR_IT, NEAR_IT], 0.0, "w", 1), ([NEAR_IT], 1e-9, "w", 1), ([NEAR_IT], 0.0, None, 2), ([NEAR_IT], 0.01, "w", 2),
        ([NEAR_IT, Grounding("there", "fine")], 0.0, "w", 2), ([Refused("here", "who knows")], 0.0, "w", 2), ([], 0.0, "w", 2),
    ],
)  # fmt: skip
def test_places_that_are_refused_for_what_is_around_them_are_so_wherever_the_arm_is(
    answers: list[Any], moved: float, of: str | None, asked: int
) -> None:
    """The second time the arm is elsewhere, and a cup has moved so far. Those at no thing are where the hand is."""
    kept, questions, nobody = Answers(), list[Context](), cast("Any", None)

    def ask(context: Context) -> list[tuple[str, list[Any]]]:
        questions.append(context)
        return [("places", answers)]

    for joints, x in (((0.0,), 0.0), ((1.0,), moved)):
        belief = replace(BELIEF, joints=joints, poses={"cup": Estimate(Pose((x, 0.0, 0.0)))})
        context = Context(nobody, nobody, {}, nobody)
        assert [list(told) for _, told in kept.of(Location("place", "at", of=of), belief, context, ask)[1]] == [answers]
    assert len(questions) == asked
