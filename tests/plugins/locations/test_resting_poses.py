"""Where something is let go of over what is not level: the hand never under it, the least turn first, over the region that is meant."""

from __future__ import annotations

import itertools
import math

import pytest
import shapely
from helpers.placing import believed, query_on
from msgspec.structs import replace

from cramlite import Engine
from cramlite.model import Belief, Feature, Held, Location, Pose, RobotMount, Thing, World, initial_belief
from cramlite.plugin import Context, Grounding, Unresolvable
from cramlite_plugins.locations.kinds import ground
from cramlite_plugins.locations.parameters import Where
from cramlite_plugins.locations.placing.checks import shapes
from cramlite_plugins.locations.placing.query import Placement
from cramlite_plugins.objects.products_and_fixtures import table
from cramlite_plugins.objects.rack import rack
from cramlite_plugins.objects.vessels import bottle
from cramlite_plugins.robots.ur5e import UR5E
from cramlite_plugins.shapes.surfaces import Surface

MOUNT = RobotMount("arm", "ur5e")
AT = Pose.from_rotvec((0.45, -0.3, 0.125), (0, 0, math.pi / 2))
FROM_ABOVE = Held("bottle", Pose.from_rotvec((0, 0, 0.04), (math.pi, 0, 0)), 0.03)


def _answers(below: Thing, region: str = "", count: int = 2) -> list[Grounding]:
    it = bottle("bottle", Pose((0.5, 0.2, 0.06)), radius=0.026, height=0.1, neck_height=0.04, mass=0.3)
    world = World((table("floor", Pose((0.2, 0, -0.005)), (1.6, 1.6, 0.02)), below, it), (MOUNT,))
    belief: Belief = initial_belief(world, "arm", UR5E.home, 0.085).grasped(FROM_ABOVE)
    context = Context(UR5E, MOUNT, {"rack": f"rack/{region}" if region else "rack"}, Engine().knowledge.taxonomy)
    found = ground(Location("on(rack)", "on", "rack", {"region": region} if region else {}), belief, context)
    assert found is not None
    return list(itertools.islice((a for a in found if isinstance(a, Grounding)), count))


def _bottle(found: Grounding) -> Pose:
    return AT.inverse() * found.value.pose * FROM_ABOVE.tcp_to_thing  # type: ignore[union-attr]


def test_it_is_laid_down_with_the_hand_beside_or_over_it() -> None:
    found = _answers(rack("rack", AT))
    assert found
    for one in found:
        there = _bottle(one)
        assert abs(there.rotate((0, 0, 1))[2]) < math.sin(math.radians(10)), one.key  # in the trough, or across it
        assert one.value.pose.rotate((0, 0, 1))[2] < math.sin(math.radians(20)) + 0.01  # type: ignore[union-attr]


def test_on_a_roof_there_is_no_place_for_it() -> None:
    with pytest.raises(Unresolvable, match="not at rest: it would slide or fall off 'rack'"):
        _answers(rack("rack", AT, lean=-0.6))


@pytest.mark.parametrize(("x", "reached"), [(0.0, True), (0.3, False)])
def test_a_region_that_leans_is_where_its_origin_comes_to_rest(x: float, reached: bool) -> None:
    below = rack("rack", AT)
    lean = Pose.from_rotvec((x, 0.0, 0.01), (0.5, 0, 0))
    below = replace(below, features=(*below.features, Feature("left", "vrps:SurfaceFeature", lean, {"width": 0.1, "depth": 0.06})))
    if reached:
        one = next(iter(_answers(below, "left", 1)))
        assert abs(_bottle(one).position[0]) < 0.05
    else:
        with pytest.raises(Unresolvable):
            assert not _answers(below, "left")


@pytest.mark.parametrize(("y", "beside"), [(0.0, ""), (0.02, "5 mm beside 'left'"), (-0.02, "5 mm beside 'left'")])
def test_over_a_region_that_leans_it_is_where_it_rests_and_not_where_it_is_let_go(y: float, beside: str) -> None:
    """20 mm above, a region of 60 deg would be passed by 17 mm."""
    lean = Pose.from_rotvec((0.45, -0.3, 0.2), (math.radians(60), 0, 0))
    there = lean * Pose((0.0, y, 0.01))
    lifted = Pose((there.position[0], there.position[1], there.position[2] + 0.02))
    wanted = replace(query_on(believed()), target=Surface(lean, shapely.box(-0.1, -0.015, 0.1, 0.015)), where=Where(region="left"))
    said = shapes.over_region(Placement("here", lifted, lifted, lifted, 0.02), wanted)
    assert beside in said and bool(said) is bool(beside)
