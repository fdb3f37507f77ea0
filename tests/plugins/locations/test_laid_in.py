"""What would stand in the way of a drawer that a later task opens or closes is laid on its side in its container."""

from __future__ import annotations

from itertools import islice

import numpy as np
import pytest
import shapely

from cramlite import Engine
from cramlite.model import (
    Action,
    Belief,
    Estimate,
    GripFacts,
    Held,
    Location,
    Object,
    Place,
    Pose,
    RobotMount,
    World,
    initial_belief,
)
from cramlite.plugin import Context, Grounding, Refused, Unresolvable
from cramlite_plugins.kinematics.inverse import inverse
from cramlite_plugins.locations.jointed.room_to_close import first_met, opens_beside
from cramlite_plugins.locations.kinds import ground
from cramlite_plugins.locations.placing.query import queries
from cramlite_plugins.locations.placing.ways_out import along_sides, prepared
from cramlite_plugins.objects.furniture import cabinet, drawer
from cramlite_plugins.objects.products_and_fixtures import block
from cramlite_plugins.robots.fr3 import FR3
from cramlite_plugins.shapes.surfaces import footprint

MOUNT = RobotMount("arm", "fr3")
LOW, HIGH = (Pose.from_rotvec((0.65, 0.0, z), (0.0, 0.0, np.pi)) for z in (0.14, 0.24))  # their fronts look to the robot
INTO = Location("in(drawer)", "in", "drawer", {})
LEVEL, DOWN = (1.0, 0.0, 0.0), (0.0, 0.0, -1.0)


def _about(task: str, name: str, **roles: str) -> Action:
    return Action(name, task, {role: Object(thing, entity=thing) for role, thing in roles.items()})


UNGRASPING = _about("artm:Ungrasping", "3.Ungrasping", Locatum="it", Relatum="drawer")
RETRACTING = _about("soma:Retracting", "3b.Retracting", Relatum="it")
OPENING = _about("soma:Opening", "4.Opening", Patient="upper_drawer")
CLOSING = _about("soma:Closing", "4.Closing", Patient="drawer")


def _asked(*agenda: Action, thick: float = 0.04, wide: float = 0.04, ahead: tuple[float, float, float] = LEVEL) -> tuple[Belief, Context]:
    """A standing block, 140 mm high, in the hand of an arm before an open drawer, 70 mm deep, under a shut one."""
    size, inner = (0.3, 0.3, 0.1), (0.25, 0.264, 0.07)
    lower = (cabinet("cabinet", LOW, size), drawer("drawer", LOW, "cabinet", inner, 0.24, opened=0.24))
    upper = (cabinet("upper", HIGH, size), drawer("upper_drawer", HIGH, "upper", inner))
    it = block("it", Pose((0.4, -0.3, 0.4)), (thick, wide, 0.14))
    hand = Pose.from_axes((0.4, -0.3, 0.4), ahead, (0.0, 0.0, 1.0) if ahead == LEVEL else (1.0, 0.0, 0.0))
    start = initial_belief(World((*lower, *upper, it), (MOUNT,)), "arm", FR3.home, 0.04)
    belief = start.grasped(Held("it", hand.inverse() * it.pose, 0.04)).moved(inverse(FR3, hand, seed=FR3.home)[0])
    named = {name: name for name in ("drawer", "it", "upper_drawer")}
    bindings = {**named, "grasp(it)": Place(hand, hand, thing="it", grip=GripFacts(0.04))}
    return belief, Context(FR3, MOUNT, bindings, Engine().knowledge.taxonomy, agenda)


def _first(*agenda: Action, **asked: float) -> tuple[Grounding | None, list[Refused]]:
    """The first place, or None among the first twenty answers, and what was refused before it."""
    belief, context = _asked(*agenda, **asked)  # type: ignore[arg-type]
    refused = list[Refused]()
    for answer in islice(ground(INTO, belief, context), 20):
        if isinstance(answer, Grounding):
            return answer, refused
        refused.append(answer)
    return None, refused


def _up(place: Grounding, belief: Belief) -> float:
    """How far the block's long side points upwards at its release, from -1 to 1."""
    return float((place.value.pose * belief.payload.tcp_to_thing).rotate((0.0, 0.0, 1.0))[2])


@pytest.mark.parametrize("later", [OPENING, CLOSING])
def test_what_would_stop_a_drawer_later_is_laid_down(later: Action) -> None:
    found, _ = _first(UNGRASPING, RETRACTING, later)
    assert found is not None and found.key.startswith("laid on side 1") and found.value.reorients
    assert _up(found, _asked()[0]) == pytest.approx(0.0, abs=1e-6)


def test_where_nothing_is_moved_later_it_stands() -> None:
    found, _ = _first(UNGRASPING)
    assert found is not None and _up(found, _asked()[0]) == pytest.approx(1.0, abs=1e-6)


@pytest.mark.parametrize(("wide", "is_long"), [(0.04, False), (0.1, True)])
def test_a_long_thing_is_first_tried_along_the_sides_of_a_drawer_that_is_partly_covered(wide: float, is_long: bool) -> None:
    """A disc in its outline would be small, and its ends under what covers the drawer."""
    query = prepared(queries(INTO, *_asked(UNGRASPING, wide=wide)))[-1]
    found = next(along_sides(query, query.now), None)
    assert query.covers and (found is not None) is is_long
    if found is not None:
        seen = footprint(query.thing, query.target.pose.inverse() * found.thing)
        assert seen.area == pytest.approx(shapely.box(*seen.bounds).area, rel=0.01)
        assert query.target.area.covers(seen) and not any(seen.intersects(o.area) for o in query.covers)


@pytest.mark.parametrize("asked", [{"thick": 0.12}, {"ahead": DOWN}])
def test_what_lies_too_high_or_under_a_level_hand_alone_has_no_place_and_the_grasp_is_not_to_blame(asked: dict[str, float]) -> None:
    """Grasps that let it lie would have been preferred."""
    with pytest.raises(Unresolvable, match="not out of the way: with 'upper_drawer', which a later task opens") as no:
        _first(UNGRASPING, RETRACTING, OPENING, **asked)
    assert "laid on side" not in no.value.reason and "grasp(it)" not in no.value.because


@pytest.mark.parametrize(("aside", "near"), [(0.1, True), (0.2, False)])
def test_beside_a_drawer_that_opens_later_a_hand_needs_room_to_take_a_thing_again(aside: float, near: bool) -> None:
    belief, context = _asked(UNGRASPING, RETRACTING, OPENING)
    after = belief.released(Estimate(Pose((0.4, aside, 0.24)), 0.0, "let go there"), 0.04)
    assert first_met("it", after, context, 0.005) is None
    assert (opens_beside("it", after, context) is not None) == near
    assert opens_beside("it", after, _asked(UNGRASPING, RETRACTING)[1]) is None
