"""Paths that were shown: how often something went through them, and in whose frame they are told."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from helpers.properties import examples
from hypothesis import given
from hypothesis import strategies as st

from cramlite.model import Anchor, Geom, Pose, ShownPath, foot
from cramlite.model.shown_path import passes

RADIUS = 0.04
RING = ShownPath(
    tuple((RADIUS * np.cos(a), RADIUS * np.sin(a), 0.0) for a in np.linspace(0, 2 * np.pi, 24, endpoint=False)),
    Anchor(), times=3, least=2.0, tolerance=0.01, closed=True,
)  # fmt: skip
CORNERS = ((0.0, 0.0, 0.0), (0.1, 0.0, 0.0), (0.1, 0.05, 0.0), (0.0, 0.05, 0.0))
LINE = ShownPath(CORNERS, Anchor(), times=1, least=0.85, tolerance=0.01, touching=True)


def circle(turns: float, begin: float = 0.0, radius: float = RADIUS, height: float = 0.0) -> np.ndarray:
    angles = begin + np.linspace(0, 2 * np.pi * turns, max(int(60 * abs(turns)), 2))
    return np.stack([radius * np.cos(angles), radius * np.sin(angles), np.full(len(angles), height)], axis=1)


def counted(path: ShownPath, points: np.ndarray) -> float:
    return passes(path, points, np.ones(len(points), dtype=bool))


@given(st.floats(0.3, 6.0), st.floats(0.0, 6.2), st.floats(0.034, 0.046))
@examples(40)
def test_rounds_are_counted_from_wherever_they_begin(turns: float, begin: float, radius: float) -> None:
    assert counted(RING, circle(turns, begin, radius)) == pytest.approx(turns, abs=0.08)


@given(st.floats(0.5, 4.0))
@examples(20)
def test_the_other_way_round_counts_where_it_was_shown(turns: float) -> None:
    from msgspec.structs import replace

    assert counted(RING, circle(-turns)) < 0.15 * turns + 0.1, "it is met once in each round"
    assert counted(replace(RING, either=True), circle(-turns)) == pytest.approx(turns, abs=0.08)


def test_what_is_off_the_path_does_not_count() -> None:
    assert counted(RING, circle(3, height=0.02)) == 0.0
    assert counted(RING, circle(3, radius=0.02)) == 0.0
    assert counted(RING, circle(3, radius=0.0)) == 0.0


def test_going_to_and_fro_on_it_is_no_round() -> None:
    back_and_forth = np.concatenate([circle(0.2), circle(0.2)[::-1]] * 10)
    assert counted(RING, back_and_forth) < 1.0


def between(corners: tuple[tuple[float, float, float], ...]) -> np.ndarray:
    return np.concatenate([np.linspace(a, b, 30) for a, b in pairwise(corners)])


def test_an_open_path_counts_as_far_as_it_was_gone() -> None:
    assert counted(LINE, between(CORNERS)) == pytest.approx(1.0, abs=0.02)
    assert counted(LINE, between(CORNERS[:2])) == pytest.approx(0.4, abs=0.06)
    assert counted(LINE, between(CORNERS[::-1])) < 0.3, "from its beginning, not from its end"


def test_only_what_may_count_counts() -> None:
    points = between(CORNERS)
    lifted = np.arange(len(points)) < len(points) // 2
    assert passes(LINE, points, lifted) < 0.6
    assert passes(LINE, points, np.zeros(len(points), dtype=bool)) == 0.0


def test_a_frame_is_of_the_part_that_looks_up() -> None:
    below = ("a:Face", Pose.from_axes((0, 0, -0.1), (0, 0, -1), (1, 0, 0)), {})
    parts = [below, ("a:Face", Pose((0, 0, 0.1)), {"width": 0.2, "height": 0.05})]
    assert Anchor("a:Face").frame(parts) == (Pose((0, 0, 0.1)), 1.0)
    deep = Anchor("a:Face", deep=True, scaled=True).frame(parts)
    assert deep is not None and deep[0].position[2] == pytest.approx(0.05) and deep[1] == pytest.approx(0.1)
    assert Anchor("a:Hole").frame(parts) is None
    assert Anchor("a:Face", deep=True).frame(parts[:1]) is None


def test_the_foot_is_the_middle_of_the_lower_face() -> None:
    leg = Geom("box", (0.01, 0.01, 0.05), Pose((0.02, 0.0, -0.05)))
    assert foot([leg]) == pytest.approx((0.02, 0.0, -0.1))
    assert foot([], (0.1, 0.1, 0.3)) == (0.0, 0.0, -0.15)
