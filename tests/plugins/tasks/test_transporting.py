"""Transporting what hangs: a demonstrated push along the peg may be read as carrying to the hanger."""

from __future__ import annotations

from dataclasses import replace

import pytest

from cramlite import Action, Held, Pose, Unresolvable, World, initial_belief
from cramlite.designators import Object
from cramlite.errors import EARLIER_TASKS
from cramlite_plugins.tasks.picking_up import PickingUp
from cramlite_plugins.tasks.transporting import Transporting

HANGS = replace(
    initial_belief(World(()), "arm", (0.0,), 0.08, [("hangs_on", "coffee", "hook/peg")]), held=Held("coffee", Pose(), 0.05)
)


def carried_to(entity: str) -> Action:
    roles = {"Patient": Object("object_1", entity="coffee"), "Destination": Object("object_2", entity=entity)}
    return Action("1.Transporting", "soma:Transporting", roles)


def test_what_hangs_at_its_destination_is_there() -> None:
    (way,) = Transporting().decompose(carried_to("hook"), HANGS)
    assert way.steps == () and "already" in way.reason


def test_what_hangs_elsewhere_must_be_pulled_off_first() -> None:
    with pytest.raises(Unresolvable, match="hangs on 'hook/peg' and must be pulled off"):
        list(Transporting().decompose(carried_to("basket"), HANGS))


def test_what_does_not_hang_is_carried() -> None:
    (way,) = Transporting().decompose(carried_to("hook"), HANGS.unrelated("hangs_on", "coffee"))
    assert len(way.steps) == 1


def test_lifting_what_hangs_depends_on_which_thing_it_is_and_on_no_path() -> None:
    action = Action("2.PickingUp", "soma:PickingUp", {"Locatum": Object("object_1", entity="coffee")})
    with pytest.raises(Unresolvable, match="more than one degree") as refused:
        list(PickingUp().decompose(action, HANGS))
    assert refused.value.because == (EARLIER_TASKS, "object_1")
    other = Action("2.PickingUp", "soma:PickingUp", {"Locatum": Object("object_1", entity="tin")})
    with pytest.raises(Unresolvable) as refused:  # another designator said what to grasp: anything may have
        list(PickingUp().decompose(other, HANGS))
    assert refused.value.because == ()
