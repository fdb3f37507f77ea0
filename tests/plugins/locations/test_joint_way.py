"""The way of a drawer: what it meets there is said before any hand is tried."""

from __future__ import annotations

import pytest
from msgspec.structs import replace

from cramlite import Engine
from cramlite.model import Belief, Location, Place, Pose, RobotMount, Thing, World, initial_belief
from cramlite.plugin import Context, Unresolvable
from cramlite_plugins.locations import handles, push
from cramlite_plugins.robots.ur5e import UR5E
from cramlite_plugins.simulation.objects.furniture import cabinet, drawer
from cramlite_plugins.simulation.objects.products_and_fixtures import block, table

MOUNT, AT = RobotMount("arm", "ur5e"), Pose((0.75, 0.1, 0.1), (0.0, 0.0, 0.0, 1.0))


def asked(*things: Thing) -> tuple[Belief, Context]:
    """A drawer of 200 mm whose front is at 0.73 m when it is closed and opens towards the robot."""
    kitchen = (table("floor", Pose((0.2, 0.0, -0.015)), (1.6, 1.6, 0.02)), cabinet("cabinet", AT), drawer("drawer", AT, parent="cabinet"))
    belief = initial_belief(World((*kitchen, *things), (MOUNT,)), "arm", UR5E.home, 0.085)
    return belief, Context(UR5E, MOUNT, {"drawer": "drawer"}, Engine().knowledge.taxonomy)


def place(relation: str, least: float | None) -> Location:
    return Location("it", relation, "drawer", {} if least is None else {"least": least})


def standing(metres: float) -> Thing:
    """A block that the front of the drawer meets when it is open so far, aside of the handle."""
    return block("it", Pose((0.73 - 0.02 - metres, 0.2, 0.03)), (0.04, 0.04, 0.06))


@pytest.mark.parametrize("relation", ["handle", "atop"])
def test_what_stands_in_the_way_of_a_drawer_is_named_before_any_hand_is_tried(relation: str) -> None:
    resolve = handles.resolve_location if relation == "handle" else push.resolve_location
    with pytest.raises(Unresolvable, match=r"after 1[0-9][0-9] mm of its own way 'drawer' is .* mm inside 'it'") as ended:
        list(resolve(place(relation, 0.8), *asked(standing(0.13))) or ())
    assert ended.value.blocking == (("it",),) and ended.value.because == ("drawer",)


@pytest.mark.parametrize(("metres", "least"), [(0.19, 0.8), (0.13, None), (0.13, 0.5)])
def test_what_it_does_not_come_to_is_not_in_its_way(metres: float, least: float | None) -> None:
    assert list(handles.resolve_location(place("handle", least), *asked(standing(metres))) or ())


def test_all_that_stands_in_its_way_is_named_at_once() -> None:
    """To put aside what it comes to first would be no help."""
    behind = block("behind", Pose((0.73 - 0.02 - 0.15, 0.0, 0.03)), (0.04, 0.04, 0.06))
    with pytest.raises(Unresolvable, match=r"after 1[0-9][0-9] mm .* inside 'it'") as ended:
        list(handles.resolve_location(place("handle", 0.9), *asked(standing(0.13), behind)) or ())
    assert ended.value.blocking == (("behind", "it"),)
    screwed = table("screwed", behind.pose, (0.04, 0.04, 0.06))
    with pytest.raises(Unresolvable) as ended:
        list(handles.resolve_location(place("handle", 0.9), *asked(standing(0.13), screwed)) or ())
    assert ended.value.blocking == ()


def test_another_place_of_what_was_put_in_its_way_may_do() -> None:
    belief, context = asked(standing(0.13))
    put, held = (Place(Pose(), Pose(), thing="it", values=v) for v in ({"height_m": 0.01}, {"width_m": 0.04}))
    context = replace(context, bindings={**context.bindings, "spot": put, "grasp": held})
    with pytest.raises(Unresolvable) as ended:
        list(handles.resolve_location(place("handle", 0.8), belief, context) or ())
    assert ended.value.because == ("drawer", "spot")


def test_what_lies_in_it_comes_along() -> None:
    """Its back would else run against it."""
    inside = block("it", Pose((0.88, 0.1, 0.1 - 0.082 + 0.016 + 0.03)), (0.04, 0.04, 0.06))
    assert list(handles.resolve_location(place("handle", 0.8), *asked(inside)) or ())
