"""Conditions are true, false or not known; what is not known does not refuse what the recording names, and is said."""

from __future__ import annotations

import itertools

import pytest
from helpers.interpretation_reading import BOX, TABLE, TAXONOMY, at, read
from helpers.interpretation_samples import action, episode, state, track

from cramlite.interpretation.conditions import And, Atom, Condition, Not, Or
from cramlite.interpretation.three_values import evaluate
from cramlite.interpretation.timeline import Phase, Timeline
from cramlite.model import Entity
from cramlite.plugin import Predicate

VALUES = ("true", "false", "unknown")


def atom(value: str) -> Atom:
    rows = [()] if value == "true" else []
    reason = (lambda _phase: "nobody saw") if value == "unknown" else None
    return Atom(Predicate(f"is_{value}", 0, lambda _phase: rows, unknown=reason), ())


def value_of(condition: Condition) -> str:
    phase = Phase(Timeline(episode([], []), TAXONOMY), 0.0, 0.0)
    found = list(evaluate(condition, phase, {}))
    return "false" if not found else "true" if any(not f.unknown for f in found) else "unknown"


@pytest.mark.parametrize(("one", "other"), list(itertools.product(VALUES, VALUES)))
def test_connectives_are_kleenes(one: str, other: str) -> None:
    order = ("false", "unknown", "true")
    low, high = sorted((one, other), key=order.index)
    assert value_of(And((atom(one), atom(other)))) == low
    assert value_of(Or((atom(one), atom(other)))) == high


@pytest.mark.parametrize(("value", "negated"), [("true", "false"), ("false", "true"), ("unknown", "unknown")])
def test_what_is_not_known_is_not_known_to_be_false(value: str, negated: str) -> None:
    assert value_of(Not(atom(value))) == negated


CUP = Entity("cup", ("soma:Cup",))  # without a pose


def test_what_the_recording_calls_an_action_is_a_candidate_where_poses_are_missing() -> None:
    found = read(episode([CUP], [action("soma:Reaching", 1, 2, object="cup")]))
    (match,) = at(found, 1.5).named("soma:Reaching")
    assert match.roles == {"Goal": "cup"}
    assert any("no pose of" in u for u in match.unknown)
    assert [m.task for m in next(found.sequences()).matches] == ["soma:Reaching"]


def test_what_the_recording_calls_an_action_is_none_where_poses_refute_it() -> None:
    away = {"hand": track((0, 0.4, 0, 0), (1, 0.4, 0, 0), (2, -1, 0, 0)), "box": track((0, 0.45, 0, 0), (2, 0.45, 0, 0))}
    for label, wanted in (("soma:PickingUp", False), ("soma:Grasping", False)):
        found = read(episode([BOX, TABLE], [action(label, 1, 2, object="box"), state("contact", "table", "box", 0, 2)], away))
        assert bool(at(found, 1.5).named(label)) == wanted


def test_an_action_that_nobody_names_is_read_by_what_is_known() -> None:
    found = read(episode([CUP], [action("soma:PhysicalAction", 1, 2, object="cup")]))
    assert not any(m.unknown for a in found.actions for m in a.matches)


def test_what_is_not_known_is_in_the_json_data() -> None:
    data = read(episode([CUP], [action("soma:Reaching", 1, 2, object="cup")])).to_json()
    named = [t for a in data["actions"] for t in a["tasks"] if t["task"] == "soma:Reaching"]
    assert named and named[0]["not_known"]
    assert data["candidates"][0]["tasks"][0]["not_known"] == named[0]["not_known"]
