"""What a task may touch and move, by what its type declares and by who fills its roles; its parameters and its names."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, ClassVar

import pytest

from cramlite.model import Action, Object
from cramlite.plugin import HAND, HELD, Decomposition, Parameter, Role, TaskType, UserError
from cramlite.plugin.task_type import FORCE_LIMIT, task_type


class Wiping(TaskType):
    """Task of three roles, one of which is the hand."""

    task = "x:Wiping"
    aliases = ("Dusting",)
    roles = (Role("Agent", effector=True), Role("Patient"), Role("Relatum"))

    def decompose(self, action: Action, belief: Any) -> Iterable[Any]:
        return ()


class Free(Wiping):
    task = "x:Free"
    aliases = ()
    touches = ()


class Careful(Wiping):
    task = "x:Careful"
    aliases = ()
    touches = ((HAND, "Patient"), (HELD, "Relatum"), ("Patient", "Tool"))
    moves: ClassVar[tuple[str, ...]] = ("Patient", "Tool")
    parameters = (Parameter(FORCE_LIMIT, 25.0, "a choice"), Parameter("speed_m_s", 0.1, "a choice"))


class Swift(Wiping):
    task = "swift"
    aliases = ()
    parameters = (Parameter("speed_m_s", 0.1, "a choice"),)


ROLES = {
    "Agent": Object("me"), "Patient": Object("it", entity="cup/rim"), "Relatum": Object("on", entity="table"), "Extra": Object("unbound"),
}  # fmt: skip
ACTION = Action("1.Wiping", "x:Wiping", ROLES)


def pairs(*those: tuple[str, str]) -> frozenset[frozenset[str]]:
    return frozenset(frozenset(pair) for pair in those)


def test_a_type_that_declares_nothing_lets_hand_held_and_roles_touch_one_another() -> None:
    found = Wiping().allowance(ACTION, {})
    everything = (HAND, HELD, "cup", "table")
    assert found.touches == pairs(*((a, b) for k, a in enumerate(everything) for b in everything[k:]))
    assert found.carries_on and found.moves == frozenset() and found.force is None


def test_a_free_motion_may_touch_nothing_and_not_even_what_the_held_thing_stood_on() -> None:
    found = Free().allowance(ACTION, {})
    assert found.touches == pairs((HAND, HELD)) and not found.carries_on


def test_what_a_type_declares_is_asked_of_those_who_fill_its_roles() -> None:
    found = Careful().allowance(ACTION, {})
    assert found.touches == pairs((HAND, "cup"), (HELD, "table"), (HAND, HELD)) and not found.carries_on
    assert found.moves == {"cup"} and found.force == 25.0


def test_what_is_picked_up_touches_what_it_stood_on_only_as_it_goes_on_standing_there() -> None:
    from cramlite import Engine

    roles = {"Locatum": Object("it", entity="cup"), "Relatum": Object("on", entity="table")}
    found = task_type(Engine().knowledge.tasks, "PickingUp").allowance(Action("1.x", "PickingUp", roles), {})
    assert found.touches == pairs((HAND, "cup"), (HAND, "table"), (HAND, HELD)) and found.carries_on


def test_an_action_may_lower_its_force() -> None:
    assert Careful().allowance(Action("1.Wiping", "x:Careful", ROLES, parameters={FORCE_LIMIT: 9}), {}).force == 9.0
    for free in (Wiping(), Swift()):
        assert free.allowance(Action("1.Wiping", free.task, ROLES, parameters={FORCE_LIMIT: 9}), {}).force is None


def test_what_a_type_does_not_declare_it_does_not_do() -> None:
    assert not any((Wiping.places, Wiping.looks, Wiping.leads_on)) and Wiping.slides and Decomposition((), "so").cost == 0.0
    assert Wiping().begins_at(ACTION) is None


@pytest.mark.parametrize("free", ["ParkingArms", "AssumingArmPose"])
def test_shipped_free_motions_carry_nothing_on(free: str) -> None:
    from cramlite import Engine

    tasks = Engine().knowledge.tasks
    assert not task_type(tasks, free).allowance(Action("1.x", free), {}).carries_on


def test_parameters_have_their_default_unless_the_action_says_it() -> None:
    assert Careful().parameter(ACTION, "speed_m_s") == 0.1
    assert Careful().parameter(Action("1.x", "x", parameters={"speed_m_s": 1}), "speed_m_s") == 1.0


def test_a_role_is_found_by_its_name() -> None:
    assert Wiping().role("Agent") == Role("Agent", effector=True) and Wiping().role("Nobody") is None


def test_a_role_adds_what_it_requires() -> None:
    role = Role("Patient", features=("vrps:Hole",), affords=("hang",), filled=True)
    found = role.constrain(Object("it", types=("x:Cup",)))
    assert (found.name, found.types, found.features, found.affords, found.filled) == ("it", ("x:Cup",), ("vrps:Hole",), ("hang",), True)
    assert role.required and not Role("other").filled and not Role("other").effector


@pytest.mark.parametrize("name", ["x:Wiping", "Wiping", "Dusting"])
def test_a_type_is_found_by_class_local_name_and_alias(name: str) -> None:
    wiping, free = Wiping(), Free()
    assert task_type({"x:Wiping": wiping, "x:Free": free, "swift": Swift()}, name) is wiping


@pytest.mark.parametrize(("name", "near"), [("x:Wipin", "'x:Wiping'"), ("Wipin", "'Wiping'")])
def test_a_type_that_there_is_not(name: str, near: str) -> None:
    with pytest.raises(UserError, match=f"There is no task type '{name}'; did you mean {near}"):
        task_type({"x:Wiping": Wiping()}, name)
