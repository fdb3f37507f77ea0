"""Candidates: sequences that agree with themselves; the others are left out, for the reason that they contradict."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import pytest

from cramlite import Engine, Interpretation
from cramlite.interpretation.coherence import Claims, claims, coherent, demands, explains_ends, same
from cramlite.interpretation.matching import Match

SHIPPED = Path(__file__).parents[2] / "scenarios"
ENGINE = Engine()


@cache
def found(name: str) -> Interpretation:
    return ENGINE.interpret(ENGINE.read_episode(SHIPPED / name / "demonstration"))


def names(name: str) -> list[list[str]]:
    listed = found(name).sequences()
    return [[m.task.split(":")[-1] for m in sequence.matches] for sequence in listed]


@pytest.mark.parametrize("name", ["fetch_from_hanger", "hang_onto_hanger"])
def test_candidates_are_few_of_many(name: str) -> None:
    assert 1 < len(names(name)) < found(name).count()


@pytest.mark.parametrize(
    ("name", "best"),
    [
        ("fetch_from_hanger", ["Grasping", "ExtractHoleFromPeg", "Ungrasping"]),
        ("hang_onto_hanger", ["Grasping", "PickingUp", "InsertHoleOntoPeg", "Releasing", "Retracting"]),
    ],
)
def test_the_best_candidate_explains_all_that_changed_and_nothing_else(name: str, best: list[str]) -> None:
    assert names(name)[0] == best
    assert "unexplained 0.0" in next(found(name).sequences()).reason


def test_no_candidate_carries_what_was_never_grasped() -> None:
    readings = {m.task.split(":")[-1] for a in found("fetch_from_hanger").actions for m in a.matches}
    assert {"Reaching", "Grasping", "Transporting"} <= readings
    for tasks in names("fetch_from_hanger"):
        assert tasks[0] == "Grasping"  # by another reading of the first action, nothing would be held
        assert "ExtractHoleFromPeg" in tasks and "Ungrasping" in tasks


def test_a_thing_may_hang_without_having_been_said_to_be_lifted_first() -> None:
    listed = names("hang_onto_hanger")
    assert {tuple(t) for t in listed} >= {
        ("Grasping", "PickingUp", "InsertHoleOntoPeg", "Releasing"),
        ("Grasping", "Holding", "InsertHoleOntoPeg", "Releasing"),
    }
    assert all("InsertHoleOntoPeg" in t and "Releasing" in t for t in listed)


NOTHING: frozenset[tuple[str, ...]] = frozenset()
HELD, FREE = frozenset({("grasps", "_", "box")}), frozenset({("grasps", "_", "_")})
TAKE = Claims(NOTHING, FREE, HELD, NOTHING, False)
CARRY = Claims(HELD, NOTHING, NOTHING, NOTHING, False)
LEAVE = Claims(HELD, NOTHING, NOTHING, HELD, False)
MOVE = Claims(NOTHING, NOTHING, NOTHING, NOTHING, False)
REST = Claims(NOTHING, NOTHING, NOTHING, NOTHING, True)


def agrees(chosen: list[Claims], readings: list[list[Claims]]) -> bool:
    """By all four conditions."""
    numbers = [said.index(one) for one, said in zip(chosen, readings, strict=True)]
    return coherent(numbers, demands(readings)) and all(map(explains_ends, chosen, readings))


@pytest.mark.parametrize(
    ("chosen", "good"),
    [
        ([TAKE, CARRY, LEAVE], True),
        ([TAKE, MOVE, LEAVE], True),
        ([MOVE, MOVE, MOVE], False),  # 4: the last one moves, and says nothing of the end that it sees
        ([MOVE, MOVE, REST], True),
        ([MOVE, CARRY, LEAVE], False),  # 1: nobody took it
        ([TAKE, CARRY, MOVE], False),  # 4
        ([TAKE, CARRY, REST], False),  # 3: it would still be held
    ],
)
def test_what_a_sequence_must_explain(chosen: list[Claims], good: bool) -> None:
    readings = [[TAKE, MOVE], [CARRY, MOVE], [LEAVE, MOVE, REST]]
    assert agrees(chosen, readings) is good


def test_what_lasts_must_have_been_begun() -> None:
    hung = Claims(NOTHING, NOTHING, frozenset({("touches", "box", "hook/peg")}), NOTHING, False)
    assert agrees([hung], [[hung, MOVE]])
    assert not agrees([MOVE], [[hung, MOVE]])


def test_facts_about_parts_are_about_their_wholes() -> None:
    assert same(("touches", "box", "hook"), ("touches", "box", "hook/peg"))
    assert same(("grasps", "_", "box"), ("grasps", "hand", "_"))
    assert not same(("touches", "box", "hook"), ("touches", "box", "table"))
    assert not same(("touches", "box", "hook"), ("supports", "box", "hook"))


def test_what_excludes_another_ends_it() -> None:
    """A drawer that is open is no longer closed, so whoever only carried it has not explained that."""
    rule = ENGINE.knowledge.rules["soma:Opening"] if isinstance(ENGINE.knowledge.rules, dict) else next(
        r for r in ENGINE.knowledge.rules if r.task == "soma:Opening"
    )
    changes = claims(rule, Match("soma:Opening", {"Patient": "drawer"}, "")).changes
    assert {("joint_closed", "drawer"), ("joint_open", "drawer")} <= changes
