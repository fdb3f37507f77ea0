"""Transporting what hangs: a demonstrated push along the peg may be read as carrying to the hanger."""

from __future__ import annotations

import pytest
from msgspec.structs import replace

from cramlite.model import Action, Held, Location, Object, Pose, World, initial_belief
from cramlite.plugin import Unresolvable
from cramlite_plugins.objects.products_and_fixtures import hanger
from cramlite_plugins.tasks.picking_up import PickingUp
from cramlite_plugins.tasks.releasing import Releasing
from cramlite_plugins.tasks.transporting import Transporting

HANGS = replace(
    initial_belief(World(()), "arm", (0.0,), 0.08, [("hangs_on", "coffee", "hook/peg")]),
    held=Held("coffee", Pose(), 0.05),
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


def test_it_leads_to_the_next_task_only_where_that_is_at_the_destination() -> None:
    carry, goal = carried_to("hook"), Location("there", "insert", "object_3")
    onto_peg = Action("2.InsertHoleOntoPeg", "", {"Relatum": Object("object_3", part_of="object_2")})
    into_basket = Action("2.Ungrasping", "", {"Relatum": Object("object_4")})
    assert Transporting().leads_to(carry, onto_peg, goal) == goal
    assert Transporting().leads_to(carry, into_basket, goal).name == "near(object_2)"
    assert Transporting().leads_to(replace(carry, roles={}), into_basket, goal) == goal


def test_nothing_is_let_go_of_on_a_peg_that_it_does_not_hang_on() -> None:
    def releasing(entity: str) -> Action:
        roles = {"Locatum": Object("object_1", entity="coffee"), "Relatum": Object("object_2", entity=entity)}
        return Action("2.Releasing", "soma:Releasing", roles)

    hooks = tuple(hanger(name, Pose()) for name in ("hook", "other"))
    belief = replace(HANGS, world=World(hooks))
    (way,) = Releasing().decompose(releasing("hook"), belief)
    assert "here" in way.reason
    with pytest.raises(Unresolvable, match="'coffee' does not hang on 'other'") as refused:
        list(Releasing().decompose(releasing("other"), belief))
    assert {"object_1", "object_2"} <= set(refused.value.because)


def test_lifting_what_hangs_depends_on_which_thing_it_is_and_on_no_path() -> None:
    action = Action("2.PickingUp", "soma:PickingUp", {"Locatum": Object("object_1", entity="coffee")})
    with pytest.raises(Unresolvable, match="more than one degree") as refused:
        list(PickingUp().decompose(action, HANGS))
    assert refused.value.because == ("object_1",) and refused.value.earlier_tasks
    other = Action("2.PickingUp", "soma:PickingUp", {"Locatum": Object("object_1", entity="tin")})
    with pytest.raises(Unresolvable) as refused:  # another designator said what to grasp: anything may have
        list(PickingUp().decompose(other, HANGS))
    assert refused.value.because == () and not refused.value.earlier_tasks
