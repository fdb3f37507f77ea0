"""Room for what else goes into a container: corners, what is left, and whom later tasks bring there."""

from __future__ import annotations

import numpy as np
import pytest
import shapely
from helpers.placing import TIN, believed, context_of, placed
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from cramlite.model import Action, Feature, Location, Object, Pose
from cramlite.plugin import Grounding
from cramlite_plugins.locations.kinds import ground
from cramlite_plugins.locations.later import puts_into
from cramlite_plugins.locations.placing.positions import corner, roomiest
from cramlite_plugins.objects.products_and_fixtures import basket, block, table

LEFT_AND_RIGHT = (("left", 0.1), ("right", -0.1))
SQUARE = shapely.box(-0.1, -0.1, 0.1, 0.1)
sides = st.floats(0.03, 0.1)


@given(sides, sides)
def test_the_first_of_several_is_put_against_two_walls(x: float, y: float) -> None:
    at = corner(SQUARE, SQUARE, (x, y), (-1.0, -1.0))
    assert sorted(abs(v) for v in at) == pytest.approx(sorted((0.1 - x / 2, 0.1 - y / 2)), abs=1e-4)
    assert at[0] < 0 and at[1] < 0  # of corners alike the one near the robot


def test_it_is_not_put_where_something_lies() -> None:
    left = SQUARE.difference(shapely.box(-0.1, -0.1, 0.0, 0.1))
    assert corner(SQUARE, left, (0.06, 0.06), (-1.0, -1.0))[0] >= 0.03


def test_what_fits_nowhere_is_put_amid_what_is_left() -> None:
    assert corner(SQUARE, SQUARE, (0.3, 0.3), (0.0, 0.0)) == pytest.approx(roomiest(SQUARE), abs=1e-3)


def test_the_last_is_put_amid_the_largest_part_that_is_left() -> None:
    x, y = roomiest(SQUARE.difference(shapely.box(-0.1, -0.1, 0.02, 0.1)))
    assert x == pytest.approx(0.06, abs=0.002) and abs(y) <= 0.061


def named(task: str, **roles: str) -> Action:
    return Action(task, task, {k: Object(v, entity=v) for k, v in roles.items()})


@pytest.mark.parametrize(
    ("later", "names"),
    [
        (named("artm:Ungrasping", Locatum="tin", Relatum="box"), ("tin",)),
        (named("artm:Ungrasping", Locatum="tin", Relatum="shelf"), ()),  # not into it
        (named("soma:Retracting", Relatum="box"), ()),  # brings nothing
        (named("artm:Ungrasping", Locatum="ball", Relatum="box"), ()),  # nobody knows where that is
    ],
)
def test_what_later_tasks_bring_there(later: Action, names: tuple[str, ...]) -> None:
    box, tin = basket("box", Pose((0.4, -0.4, 0.0)), (0.2, 0.3, 0.1)), block("tin", Pose((0.45, 0.35, 0.19)), (0.05, 0.05, 0.08))
    belief = believed(box, tin)
    assert puts_into("box", belief, replace(context_of(belief), agenda=(later, later))) == names
    assert puts_into("box", belief, replace(context_of(belief), agenda=(later,)), "left") == ()  # not into that region
    inside = belief.related(("in", "tin", "box"))
    assert puts_into("box", inside, replace(context_of(belief), agenda=(later,))) == ()


@pytest.mark.parametrize(("region", "apart"), [("left", True), ("right", False)])
def test_the_first_of_several_in_a_region_of_a_surface_is_put_into_its_farthest_corner(region: str, apart: bool) -> None:
    """Amid a region of 100 mm a mug leaves no room for another one."""
    spots = {name: Feature(name, "vrps:SurfaceFeature", Pose((0.0, y, 0.01)), {"width": 0.1, "depth": 0.1}) for name, y in LEFT_AND_RIGHT}
    board = table("box", Pose((0.5, 0.3, 0.1)), (0.4, 0.4, 0.02))
    belief = believed(TIN, replace(board, features=(*board.features, *spots.values())))
    later = replace(named("artm:Placing", Locatum="tin", Relatum="box"), parameters={"where": {"region": region}})
    location = Location("on(box)", "on", "box", {"region": "left"})
    found = next(a for a in ground(location, belief, replace(context_of(belief), agenda=(later,))) if isinstance(a, Grounding))
    x, y, _ = np.subtract(placed(found).position, belief.pose("box").apply(spots["left"].pose.position))
    assert (x > 0.03 and abs(y) > 0.03) if apart else np.hypot(x, y) < 0.001
