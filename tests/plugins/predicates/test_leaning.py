"""What carries a thing that leans on another, and stands on no surface."""

from __future__ import annotations

import math

import pytest

from cramlite import Engine
from cramlite.model import Geom, Pose, Thing, World
from cramlite.plugin import SymbolicWorld
from cramlite_plugins.objects.products_and_fixtures import table
from cramlite_plugins.predicates.fluents import _supporting, room_under

POST = Thing("post", "cram:Product", Pose((0.0, 0.0, 0.04)), (Geom("box", (0.01, 0.01, 0.03)),), mass=0.2)
"""Its top is 70 mm high, on a table whose top is 10 mm high; what has its edge there cannot stand on so little."""


def carrier(at: Pose) -> str:
    board = Thing("board", "cram:Product", at, (Geom("box", (0.08, 0.03, 0.002)),), mass=0.1)
    world = World((table("table", Pose(), (1.0, 1.0, 0.02)), POST, board), ())
    found = {thing: below for below, thing in _supporting(SymbolicWorld(world, Engine().knowledge.taxonomy, (), {}))}
    return found["board"]


def test_what_leans_on_a_post_is_carried_by_it() -> None:
    """Leant by 20 deg, over the middle of the post, whose upper edge it meets: 70 mm, 2 mm of thickness, 10 mm aside."""
    leant = Pose.from_rotvec((0.0, 0.0, 0.0758), (0.0, 0.35, 0.0))
    assert carrier(leant) == "post"


OVER, BESIDE = Pose.from_rotvec((0.0, 0.0, 0.15), (0.0, 0.35, 0.0)), Pose((0.2, 0.0, 0.012))


@pytest.mark.parametrize("at", [OVER, BESIDE], ids=["over it", "beside it"])
def test_what_is_over_or_beside_it_is_not(at: Pose) -> None:
    assert carrier(at) == "table"


@pytest.mark.parametrize(("lift", "below"), [(0.0034, "block"), (0.0, "table")])
def test_what_hardly_misses_the_table_is_carried_by_what_it_touches(lift: float, below: str) -> None:
    """A board on a block, whose lower edge is 3.4 mm over the table; with that edge on the table it is the table that carries it."""
    at = Pose.from_rotvec((0.0, 0.0, 0.08 * math.sin(0.2) + 0.002 * math.cos(0.2) + lift), (0.0, -0.2, 0.0))
    board = Thing("board", "cram:Product", at, (Geom("box", (0.08, 0.03, 0.002)),), mass=0.1)
    block = _high(0.02)
    block = _high(0.02 + room_under(board, at, block, block.pose) - 0.0002)
    world = World((table("table", Pose(), (1.0, 1.0, 0.02)), block, board), ())
    found = {name: carrier for carrier, name in _supporting(SymbolicWorld(world, Engine().knowledge.taxonomy, (), {}))}
    assert found["board"] == below


def _high(height: float) -> Thing:
    """Block on the table under the higher half of the board."""
    return Thing("block", "cram:Product", Pose((0.05, 0.0, height / 2)), (Geom("box", (0.02, 0.03, height / 2)),), mass=0.2)


def test_what_is_upright_on_one_edge_is_carried_by_what_is_under_its_middle() -> None:
    """A cup that was put onto the rim of a bowl: it stands upright, on no surface of either."""
    bowl = Thing("bowl", "cram:Product", Pose((0.0, 0.0, 0.01)), _rim(0.05, 0.04), mass=0.2)
    cup = Thing("cup", "cram:Product", Pose((0.03, 0.0, 0.05)), (Geom("box", (0.02, 0.02, 0.03), Pose((0.0, 0.0, 0.03))),), mass=0.1)
    beside = cup.moved_to(Pose((0.06, 0.0, 0.05)))
    for thing, below in ((cup, "bowl"), (beside, "table")):
        world = World((table("table", Pose(), (1.0, 1.0, 0.02)), bowl, thing), ())
        found = {name: carrier for carrier, name in _supporting(SymbolicWorld(world, Engine().knowledge.taxonomy, (), {}))}
        assert found["cup"] == below


def _rim(radius: float, height: float) -> tuple[Geom, ...]:
    """Four walls around a hollow; one is as high as stated, the others lower by 10 mm."""
    lower = (height - 0.01) / 2
    return (
        Geom("box", (0.004, radius, height / 2), Pose((radius, 0.0, height / 2))),
        Geom("box", (0.004, radius, lower), Pose((-radius, 0.0, lower))),
        Geom("box", (radius, 0.004, lower), Pose((0.0, radius, lower))),
        Geom("box", (radius, 0.004, lower), Pose((0.0, -radius, lower))),
    )
