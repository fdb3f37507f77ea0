"""What plugins are given and answer: tasks that are still to be done, and refusals."""

from __future__ import annotations

from helpers.placing import believed, context_of
from msgspec.structs import replace

from cramlite.model import Action, Location, Motion, Object, Stage
from cramlite.plugin import Refused

PLACING = Action("2.Placing", "soma:Placing", {"Locatum": Object("it", entity="tin"), "Relatum": Object("there", entity="shelf/top")})
CLOSING = Action("3.Closing", "soma:Closing", {"Patient": Object("door")})


def test_later_tasks_are_about_the_things_that_their_roles_are_bound_to() -> None:
    agenda = (Motion("1.Grasping/close", "gripper"), PLACING, Location("home", "home"), CLOSING)
    context = replace(context_of(believed()), agenda=agenda, bindings={"it": "cup"})
    placing, closing = context.later
    assert placing.action is PLACING and placing.entities == {"Locatum": "cup", "Relatum": "shelf/top"}
    assert placing.things == {"cup", "shelf"}
    assert closing.things == {""}, "nobody knows yet which door"


def test_a_refusal_of_an_alternative_keeps_its_reason() -> None:
    no = Refused("", "out of reach", numbers={"reach_m": 0.9}, blocking=("tin",), check="reachable", where=Stage.BEFORE)
    named = no.of("turned 30 deg", passed=2)
    assert (named.value, named.passed) == ("turned 30 deg", 2)
    assert replace(named, value="", passed=0) == no
