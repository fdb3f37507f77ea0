"""Co-motion on a grid: what keeps its place in what moves is carried; what only moves alike, or near, is not."""

from __future__ import annotations

import numpy as np
import pytest

from cramlite.model import Floats, Track
from cramlite_plugins.episodes.detection.co_motion import Grid, carried_spans, grid_of
from cramlite_plugins.episodes.detection.loose_things import alike

TIMES = np.arange(0, 6, 0.05)


def track(positions: Floats) -> Track:
    poses = np.zeros((len(positions), 7))
    poses[:, :3], poses[:, 3] = positions, 1.0
    return Track(TIMES[: len(positions)], poses)


def way(start: float, end: float, to: tuple[float, float, float]) -> Floats:
    share = np.clip((TIMES - start) / (end - start), 0, 1)
    return share[:, None] * np.array(to)


def grid(thing: Floats) -> Grid:
    return grid_of({"hand": track(way(2, 4, (0.4, 0, 0.2))), "thing": track(thing + np.array([0.1, 0, 0]))})


def test_what_keeps_its_place_is_carried_while_it_moves() -> None:
    ((start, end),) = carried_spans(grid(way(2, 4, (0.4, 0, 0.2))), "thing", "hand")
    found = grid(way(2, 4, (0.4, 0, 0.2)))
    assert (found.time(start), found.time(end)) == pytest.approx((2.0, 4.0), abs=0.2)


@pytest.mark.parametrize(
    "thing",
    [way(2, 4, (0, 0, 0)), way(2, 4, (-0.4, 0, 0.2)), way(0, 1.5, (0.4, 0, 0.2)), way(2, 4, (0.03, 0, 0))],
    ids=["at rest", "the other way", "before", "nudged"],
)
def test_what_does_not_is_not(thing: Floats) -> None:
    assert carried_spans(grid(thing), "thing", "hand") == []


def sampled(*rows: tuple[float, float]) -> dict[float, float]:
    """The x of a frame recorded at some times, on the grid."""
    times, xs = np.array([t for t, _ in rows]), [x for _, x in rows]
    found = grid_of({"a": Track(times, np.array([[x, 0, 0, 1, 0, 0, 0] for x in xs]))})
    return {round(float(t), 2): float(p[0]) for t, p in zip(found.times, found.poses["a"], strict=True)}


def test_short_gaps_are_interpolated_and_what_rested_in_long_ones_is_held() -> None:
    at = sampled((0.0, 0.0), (0.4, 0.4), (2.4, 0.42))
    assert at[0.2] == pytest.approx(0.2, abs=0.01)
    assert at[1.4] == pytest.approx(0.4, abs=0.001)


def test_what_is_elsewhere_after_a_gap_moved_in_it_unless_that_was_long() -> None:
    assert sampled((0.0, 0.0), (0.4, 0.4), (2.4, 2.4))[1.4] == pytest.approx(1.4, abs=0.01)
    assert sampled((0.0, 0.0), (0.4, 0.4), (9.4, 2.4))[1.4] == pytest.approx(0.4, abs=0.01)


@pytest.mark.parametrize(
    ("name", "common"), [("particle12", "particle"), ("Particle_C_3", "Particle_C"), ("cup", "cup"), ("b2b", "b2b"), ("7", "")]
)
def test_things_alike_differ_by_a_number_at_the_end(name: str, common: str) -> None:
    assert alike(name) == common
