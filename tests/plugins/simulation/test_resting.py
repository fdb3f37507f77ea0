"""Where things come to rest on what is not level: in a trough and not on a roof, by their shape and not by friction."""

from __future__ import annotations

import math
from itertools import islice

import pytest
from msgspec.structs import replace

from cramlite.model import Pose, Thing
from cramlite_plugins.objects.products_and_fixtures import block, table
from cramlite_plugins.objects.rack import rack
from cramlite_plugins.objects.vessels import bottle
from cramlite_plugins.simulation.resting import resting_pose, rests

BOTTLE = bottle("bottle", Pose(), radius=0.026, height=0.1, neck_height=0.04, mass=0.3)
LYING = Pose.from_rotvec((0, 0, 0), (0, math.pi / 2, 0))
AT = Pose((0.4, 0.1, 0.3))


def _rest(start: Pose, below: Thing, aside: float = 0.0, thing: Thing = BOTTLE) -> Pose | None:
    return resting_pose(thing, Pose((AT.position[0], AT.position[1] + aside, 0.0), start.quaternion), below, AT)


@pytest.mark.parametrize("aside", [0.0, 0.02, -0.02])
def test_a_bottle_lies_in_the_trough_from_wherever_over_it_it_is_let_go(aside: float) -> None:
    found = _rest(LYING, rack("rack", Pose()), aside)
    assert found is not None
    x, y, z = AT.inverse().apply(found.position)
    assert abs(x) < 0.02 and abs(y) < 0.003
    assert z == pytest.approx(0.026 / math.cos(math.radians(35)), abs=0.002)  # a cylinder between two planes


def test_it_stays_neither_on_a_roof_nor_upright() -> None:
    assert _rest(LYING, rack("rack", Pose(), lean=-0.6)) is None
    assert _rest(Pose(), rack("rack", Pose())) is None


def test_what_only_friction_holds_does_not_rest() -> None:
    """A board of 20 deg, which holds a block by a friction of .95, and one of 5 deg, which does by .2."""
    box = replace(block("box", Pose(), (0.06, 0.06, 0.02)), friction=0.95)
    for lean, stays in ((20.0, False), (5.0, True)):
        turned = Pose.from_rotvec(AT.position, (math.radians(lean), 0, 0))
        board = replace(table("board", Pose(), (0.3, 0.3, 0.02)), friction=0.95)
        found = resting_pose(box, Pose(AT.position), board, turned)
        assert (found is not None) is stays


def test_where_it_rests_by_its_own_friction_is_told_first() -> None:
    """With little friction a bowl that slides down onto a plate was believed 12 to 30 mm from where it came to rest."""
    box = replace(block("box", Pose(), (0.06, 0.06, 0.02)), friction=0.95)
    board, turned = replace(table("board", Pose(), (0.3, 0.3, 0.02)), friction=0.95), Pose.from_rotvec(AT.position, (0.35, 0, 0))
    own, little = islice(rests(box, Pose(AT.position), board, turned, 0.005), 2)
    assert own is not None and math.dist(own.position[:2], AT.position[:2]) < 0.01 and little is None


def test_beside_it_nothing_is() -> None:
    assert _rest(LYING, rack("rack", Pose()), 0.5) is None
