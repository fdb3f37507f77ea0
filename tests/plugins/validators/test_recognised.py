"""Was each thing what it was taken for: judged against the world that the program ran in."""

from __future__ import annotations

import pytest
from helpers.short_runs import good, said
from msgspec.structs import replace

from cramlite.model import Thing
from cramlite.plugin import Candidate
from cramlite_plugins.validators.recognition import Recognised, validators


def really(*, without: str = "", **types: str) -> Candidate:
    """The run, in a world in which things are of another class, or are not there."""
    candidate = good()
    assert candidate.rollout is not None
    things = tuple(replace(t, type=types.get(t.name, t.type)) for t in candidate.world.things if t.name != without)
    return replace(candidate, rollout=replace(candidate.rollout, world=replace(candidate.world, things=things)))


def test_it_is_asked() -> None:
    assert [v.name for v in validators()] == ["recognised"]


def test_things_that_are_what_they_were_taken_for_pass() -> None:
    assert said(Recognised(), good()) == [] and list(Recognised().check(good())) == []


@pytest.mark.parametrize(
    ("of", "says"),
    [
        (really(block="cram:Jug"), "'block', which was taken for a cram:Product, is a cram:Jug"),
        (really(without="block"), "'block', which was taken for a cram:Product, is not there"),
        (really(shelf="cram:Basket"), "'shelf', which was taken for a cram:Table, is a cram:Basket"),
    ],
)
def test_one_that_is_not_is_an_objection_to_its_task(of: Candidate, says: str) -> None:
    (found,) = Recognised().check(of)
    assert (found.passed, found.reason) == (False, says)
    assert found.origin == "3.Placing"


def test_what_plays_no_role_is_not_asked_for() -> None:
    assert said(Recognised(), really(cup="cram:Jug")) == [] and said(Recognised(), really(without="cup")) == []


def test_what_is_no_thing_of_the_world_is_not_asked_for() -> None:
    unknown: tuple[Thing, ...] = tuple(t for t in good().world.things if t.name != "block")
    blind = replace(good(), world=replace(good().world, things=unknown))
    assert said(Recognised(), blind) == []
