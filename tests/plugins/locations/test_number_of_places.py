"""How many places are looked at: few where nothing constrains them, one in a container, many where a scenario says where."""

from __future__ import annotations

import math
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace
from properties import examples
from test_places import _belief, _context, _wanted

from cramlite.model import Belief, Location, Pose
from cramlite.plugin import Grounding, Refused
from cramlite_plugins.locations.set_down import FEW, GRID, POSITIONS, _offsets, resolve_location
from cramlite_plugins.simulation.objects.products_and_fixtures import basket, table

SMALL, LARGE = table("box", Pose((0.45, 0.35, 0.15)), (0.3, 0.3, 0.02)), table("box", Pose((0.45, 0.35, 0.15)), (1.2, 1.2, 0.02))


def places(belief: Belief, relation: str, **where: Any) -> list[str]:
    """Names of the positions that are looked at, in order."""
    found = list(resolve_location(Location("l", relation, "box", where), belief, _context(belief)) or ())
    names = [a.key if isinstance(a, Grounding) else a.value.removeprefix("at ") for a in found if isinstance(a, Grounding | Refused)]
    return list(dict.fromkeys(n.split(",")[0] if n.startswith("(") else "middle" for n in names))


def test_on_a_surface_a_few_are_looked_at() -> None:
    assert FEW == 9 and len(places(_belief(LARGE), "on")) == FEW


def test_in_a_container_one_is() -> None:
    box = basket("box", Pose((0.45, 0.35, 0.15)), size=(0.4, 0.3, 0.2))
    assert len(places(_belief(box), "in")) == 1


@pytest.mark.parametrize(("surface", "count"), [(SMALL, 25), (LARGE, POSITIONS)])
def test_where_a_scenario_says_where_all_are_up_to_eighty(surface: Any, count: int) -> None:
    belief = _belief(surface)
    assert POSITIONS == 80 and len(_offsets(_wanted(belief, "box", {"near": "shelf"}), FEW)) == count
    assert len(_offsets(_wanted(belief, "box"), FEW)) == FEW


@given(near=st.tuples(st.floats(-0.5, 0.5), st.floats(-0.5, 0.5)))
@examples(20)
def test_they_are_on_a_grid_inside_the_edge_and_the_nearest_come_first(near: tuple[float, float]) -> None:
    belief = _belief(LARGE)
    there = replace(belief.poses["shelf"], pose=Pose((0.45 + near[0], 0.35 + near[1], 0.15)))
    other = replace(belief, poses={**belief.poses, "shelf": there})
    wanted = _wanted(other, "box", {"near": "shelf"})
    at = wanted.target.inverse().apply(other.pose("shelf").position)[:2]
    found = _offsets(wanted, FEW)
    ways = [math.dist(o, at) for o in found]
    assert ways == sorted(ways) or max(b - a for a, b in zip(ways[1:], ways[:-1], strict=True)) < 1e-3
    assert all(abs(v / GRID - round(v / GRID)) < 1e-6 and abs(v) <= 0.6 - 0.005 for o in found for v in o)
    assert len(set(found)) == len(found) == POSITIONS
