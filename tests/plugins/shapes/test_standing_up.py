"""What leans is stood up onto the face that it would stand on."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from cramlite.model import Geom, Pose, Thing
from cramlite_plugins.shapes.standing_up import MOST, stood_up
from cramlite_plugins.shapes.surfaces import LEVEL

BLOCK = Thing("block", "", Pose(), (Geom("box", (0.03, 0.04, 0.05)),))


def leaning(angle: float, about: float, spin: float = 0.0) -> Pose:
    """Turned about the vertical, then leant by an angle about a level axis [rad]."""
    axis = angle * np.array([math.cos(about), math.sin(about), 0.0])
    return Pose.from_rotvec((0.1, 0.2, 0.3), (axis[0], axis[1], 0.0)) * Pose.from_rotvec((0, 0, 0), (0, 0, spin))


@given(st.floats(LEVEL + 0.01, MOST - 0.01), st.floats(-3, 3), st.floats(-3, 3))
def test_a_leaning_block_is_stood_up_the_shortest_way(angle: float, about: float, spin: float) -> None:
    pose = leaning(angle, about, spin)
    found = stood_up(BLOCK, pose)
    assert found.rotate((0, 0, 1))[2] == pytest.approx(1.0) and found.position == pose.position
    assert pose.distance(found)[1] == pytest.approx(angle, abs=1e-6)


@given(st.floats(0.0, LEVEL - 0.001), st.floats(-3, 3))
def test_what_stands_is_left_as_it_is(angle: float, about: float) -> None:
    assert stood_up(BLOCK, leaning(angle, about)) == leaning(angle, about)


def test_a_face_that_would_not_carry_it_is_none_to_stand_on() -> None:
    """A bar that sticks out over the foot: it is left as it leans."""
    foot = Geom("box", (0.01, 0.01, 0.01), Pose((0.0, 0.0, -0.02)))
    crooked = replace(BLOCK, geoms=(foot, Geom("box", (0.2, 0.01, 0.01), Pose((0.18, 0.0, 0.0)))))
    pose = leaning(-0.3, math.pi / 2)
    stood = stood_up(crooked, pose)
    assert stood.rotate((0, 0, 1))[2] < 0.999


def test_between_two_faces_neither_is_meant() -> None:
    assert stood_up(BLOCK, leaning(math.pi / 4, 0.0)) == leaning(math.pi / 4, 0.0)
