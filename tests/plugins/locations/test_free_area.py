"""Free area and positions in it: endless, none twice, ever finer, nothing outside."""

from __future__ import annotations

import itertools
import subprocess
import sys

import numpy as np
import shapely
from helpers.properties import examples
from hypothesis import given
from hypothesis import strategies as st

from cramlite_plugins.locations.placing.positions import around, beside, free_area, inwards, positions

SHELF = shapely.box(-0.15, -0.1, 0.15, 0.1)


@examples(20)
@given(st.floats(-0.2, 0.2), st.floats(-0.2, 0.2), st.floats(0.0, 0.05))
def test_positions_are_free_endless_and_nowhere_twice(x: float, y: float, radius: float) -> None:
    standing = shapely.box(-0.05, -0.05, 0.05, 0.05)
    free = free_area(SHELF, [standing], radius)
    found = list(itertools.islice(positions(free, (x, y)), 400))
    assert len(found) == 400
    assert len(set(found)) >= 396, "rounded to a tenth of a millimetre, a few of the finest may meet"
    assert all(free.distance(shapely.Point(p)) < 1.5e-4 for p in found)
    assert all(standing.distance(shapely.Point(p)) >= radius - 1.5e-4 for p in found)


def test_the_first_is_nearest_to_what_is_wanted_and_gaps_get_smaller() -> None:
    assert next(positions(SHELF, (0.0, 0.0))) == (0.0, 0.0)
    assert next(positions(SHELF, (0.3, 0.0))) == (0.15, 0.0)
    gaps = []
    for count in (20, 100, 500):
        points = np.array(list(itertools.islice(positions(SHELF, (0.0, 0.0)), count)))
        grid = np.stack(np.meshgrid(np.linspace(-0.15, 0.15, 31), np.linspace(-0.1, 0.1, 21)), axis=-1).reshape(-1, 2)
        gaps.append(float(np.linalg.norm(grid[:, None] - points[None], axis=2).min(axis=1).max()))
    assert gaps[0] > gaps[1] > gaps[2] and gaps[2] < 0.03


def test_nothing_free_has_no_positions_and_a_sliver_has_one() -> None:
    assert not list(positions(free_area(SHELF, [SHELF], 0.01), (0.0, 0.0)))
    assert len(list(positions(shapely.box(0, 0, 0.1, 1e-6), (0.0, 0.0)))) <= 2


def test_one_side_of_a_line() -> None:
    half = beside(SHELF, (0.0, 2.0), 0.1)
    assert half.bounds[1] == 0.05 and half.area == shapely.box(-0.15, 0.05, 0.15, 0.1).area


def test_inwards_a_place_has_more_room_the_farther_it_is_from_the_anchor() -> None:
    area = shapely.box(0.0, 0.0, 0.4, 0.2).union(shapely.box(1.0, 0.0, 1.2, 0.2))
    found = list(inwards(area, (0.9, 0.1)))
    assert found == [(1.0, 0.1), (1.025, 0.1), (1.05, 0.1), (1.075, 0.1)]
    assert list(inwards(shapely.Polygon(), (0.0, 0.0))) == []
    bent = shapely.box(0.0, 0.0, 0.4, 0.1).union(shapely.box(0.0, 0.0, 0.1, 0.4)).union(shapely.Point(0.05, 0.05).buffer(0.09))
    assert all(bent.covers(shapely.Point(p)) for p in inwards(bent, (0.4, 0.4)))


def test_around_a_point_the_side_of_another_one_is_first_and_what_is_not_free_is_left_out() -> None:
    found = list(around(SHELF, (0.0, 0.0), 0.08, (0.0, -1.0)))
    assert found[0] == (0.0, -0.08) and found[-1] == (0.0, 0.08) and len(found) == 8
    assert all(np.isclose(np.hypot(*p), 0.08, atol=2e-4) for p in found)
    assert [p[1] for p in around(SHELF, (0.0, 0.0), 0.12, (1.0, 0.0))] == [0.0, 0.0849, -0.0849, 0.0849, -0.0849, 0.0]


def test_points_are_those_of_scipys_sequence_and_its_slow_package_is_not_imported() -> None:
    from scipy.stats import qmc

    from cramlite_plugins.locations.placing.positions import halton

    assert (halton(0, 5000) == qmc.Halton(2, scramble=False).random(5000)).all()
    code = "import sys, cramlite_plugins.locations.placing.driver; print('scipy.stats' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout == "False\n"
