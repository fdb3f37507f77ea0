"""Boxes turned as things are: distances, overlap and containment, and what they change in an annotated recording."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace
from test_from_motion import infer, lifted, poses, recording

from cramlite.model import Entity, Episode, Pose
from cramlite_plugins.episodes.detection.oriented_box import OrientedBox, box_of, is_inside_outline, over, separation
from cramlite_plugins.episodes.detection.standing import encloses

EPISODE = Episode("sample", (), ())


def turned(position: tuple[float, float, float], yaw: float, axis: int = 2) -> Pose:
    quaternion = [math.cos(yaw / 2), 0.0, 0.0, 0.0]
    quaternion[1 + axis] = math.sin(yaw / 2)
    return Pose(position, tuple(quaternion))  # type: ignore[arg-type]


def box(pose: Pose, *size: float) -> OrientedBox:
    entity = Entity("box", (), pose=pose, size=size)  # type: ignore[arg-type]
    found = box_of(replace(EPISODE, entities=(entity,)), entity, 0.0)
    assert found is not None
    return found


BOARD = (1.0, 0.1, 0.02)
DIAGONAL = turned((0, 0, 0), math.pi / 4)
IN_THE_CORNER = Pose((0.25, -0.25, 0.02))  # in the square around the turned board, 0.35 m from its middle line
ON_THE_BOARD = Pose((0.25, 0.25, 0.02))


@pytest.mark.parametrize(("pose", "on"), [(IN_THE_CORNER, False), (ON_THE_BOARD, True)])
def test_what_is_beside_a_turned_board_does_not_touch_it(pose: Pose, on: bool) -> None:
    cup = box(pose, 0.04, 0.04, 0.02)
    assert over(cup, box(DIAGONAL, *BOARD)) is on
    assert (separation(cup, box(DIAGONAL, *BOARD)) < 0.001) is on


def test_the_distance_is_exact_where_faces_look_at_corners() -> None:
    cup, board = box(IN_THE_CORNER, 0.04, 0.04, 0.02), box(DIAGONAL, *BOARD)
    assert separation(cup, board) == pytest.approx(math.hypot(0.25, 0.25) - math.hypot(0.02, 0.02) - 0.05)
    assert separation(box(Pose(), 1, 1, 1), box(Pose((2, 2, 2)), 1, 1, 1)) == pytest.approx(math.sqrt(3))


@pytest.mark.parametrize(("position", "inside"), [((0.3, 0.3, 0.05), True), ((0.3, 0.1, 0.05), False)])
def test_containment_follows_the_container(position: tuple[float, float, float], inside: bool) -> None:
    tray = box(DIAGONAL, 1.0, 0.2, 0.2)
    cup = box(turned(position, 0.3), 0.06, 0.06, 0.08)
    assert is_inside_outline(cup, tray, 0.0) is inside
    assert encloses(tray, cup) is inside


ANGLES = st.floats(-3, 3)
PLACES = st.tuples(*[st.floats(-1, 1)] * 3)


@given(PLACES, PLACES, ANGLES, ANGLES, st.integers(0, 2), PLACES)
def test_the_gap_is_a_lower_bound_and_turns_along(
    a: tuple[float, float, float], b: tuple[float, float, float], u: float, v: float, axis: int, size: tuple[float, ...]
) -> None:
    extents = tuple(0.1 + abs(s) for s in size)
    first, second = box(turned(a, u), 0.5, 0.3, 0.1), box(turned(b, v, axis), *extents)
    found = separation(first, second)
    share = np.random.default_rng(0).uniform(size=(40, 8))
    points = [(share / share.sum(axis=1, keepdims=True)) @ one.corners for one in (first, second)]
    apart = min(float(np.linalg.norm(p - q)) for p in points[0] for q in points[1])
    assert found <= apart + 1e-9
    assert separation(second, first) == pytest.approx(found, abs=1e-9)
    move = turned((0.3, 0.2, -0.1), 0.7, 1)
    moved = [box(move * pose, *s) for pose, s in ((turned(a, u), (0.5, 0.3, 0.1)), (turned(b, v, axis), extents))]
    assert separation(*moved) == pytest.approx(found, abs=1e-6)


@pytest.mark.parametrize(("yaw", "beside", "contained"), [(0.0, 0.0, True), (0.0, 0.12, False), (0.7, 0.12, False)])
def test_a_turned_tray_holds_only_what_is_in_it(yaw: float, beside: float, contained: bool) -> None:
    """A cup is put down in or beside a narrow tray. A box around the turned tray that is aligned with the world would
    hold it in all cases but the second."""
    moved = poses(lifted, lambda t: np.clip(t - 3, 0, 1))
    whole = recording(moved, moved)
    end = whole.tracks["cup"].poses[-1]
    tray = Entity("tray", (), pose=turned((end[0], end[1] + beside, 0.0), yaw), size=(0.6, 0.12, 0.15))
    entities = (whole.entities[0], Entity("cup", (), size=(0.06, 0.06, 0.1)), tray)
    found = infer(replace(whole, entities=entities)).of("state", ["soma:ContainmentState"])
    assert bool(found) is contained
