"""Places of the hand at no thing: what refuses a lift goes back to where the arm was led before; oblique ways."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cramlite import Engine
from cramlite.model import Geom, Held, Location, Place, Pose, RobotMount, Thing, World, initial_belief
from cramlite.plugin import Context, Grounding, Refused
from cramlite_plugins.kinematics.inverse import inverse
from cramlite_plugins.locations.kinds import ground
from cramlite_plugins.locations.places import slants
from cramlite_plugins.objects.products_and_fixtures import block
from cramlite_plugins.robots.ur5e import UR5E

MOUNT = RobotMount("arm", "ur5e")


def test_a_lift_that_is_out_of_reach_blames_the_places_that_led_there() -> None:
    belief = initial_belief(World((), (MOUNT,)), "arm", UR5E.home, 0.085)
    bindings = {"tea": "tea", "grasp(tea)": Place(Pose(), Pose(), thing="tea")}
    context = Context(UR5E, MOUNT, bindings, Engine().knowledge.taxonomy, seed=0)
    answers = {h: list(ground(Location("up", "lift", None, {"height_m": h}), belief, context)) for h in (0.02, 2.0)}
    assert all(isinstance(a, Grounding) for a in answers[0.02])
    assert answers[2.0] and all(isinstance(a, Refused) and a.because == ("grasp(tea)",) for a in answers[2.0])


def _asides(*around: Thing) -> list[str]:
    """The lifts that lead aside of a block of 120 mm that is held at its middle, the hand down."""
    it = block("it", Pose((0.45, -0.3, 0.37)), (0.12, 0.04, 0.03))
    down = Pose.from_axes((0.45, -0.3, 0.4), (0, 0, -1), (1, 0, 0))
    start = initial_belief(World((*around, it), (MOUNT,)), "arm", UR5E.home, 0.085)
    hold = Held("it", down.inverse() * it.pose, 0.04)
    context = Context(UR5E, MOUNT, {"it": "it"}, Engine().knowledge.taxonomy, seed=0)
    belief = start.grasped(hold).moved(inverse(UR5E, down, seed=UR5E.home)[0])
    found = list(ground(Location("up", "lift", None, {"height_m": 0.1}), belief, context))
    assert [f.key for f in found if isinstance(f, Grounding)][:2] == ["100 mm up", "60 mm up"]  # their ends are free
    return [f.key for f in found if isinstance(f, Grounding) and "aside" in f.key]


def test_out_from_under_what_hangs_over_a_thing_lifts_lead_away_from_that() -> None:
    roof = Thing("roof", "soma:DesignedFurniture", Pose((0.6, -0.3, 0.399)), (Geom("box", (0.096, 0.15, 0.002)),))
    found = _asides(roof)  # 12 mm over the block's end, and 6 mm of it
    assert found and all(name.endswith("180 deg") for name in found)
    assert found[0] == "100 mm up, and 100 mm aside at 180 deg"  # which keeps the distance of paths
    assert len(found) > 1
    free = _asides()  # straight up is free: one to each side
    assert free == [f"100 mm up, and 100 mm aside at {a} deg" for a in (180, 90, -90, 0)]


@given(st.floats(0.01, 0.5))
def test_each_way_leads_up_by_the_rise_and_as_far_aside(rise: float) -> None:
    for _, way in slants(rise):
        assert way[2] == pytest.approx(rise)
        assert math.hypot(way[0], way[1]) == pytest.approx(rise)


def test_four_sides_the_robots_own_first() -> None:
    ways = [tuple(way.round(9)[:2]) for _, way in slants(0.1)]
    assert ways[0] == (-0.1, 0.0)
    assert set(ways) == {(-0.1, 0.0), (0.1, 0.0), (0.0, 0.1), (0.0, -0.1)}
    assert next(said for said, _ in slants(0.1)) == "aside at 180 deg"
