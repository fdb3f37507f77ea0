"""Rounded corners: shape, law, and which ones are allowed."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from helpers import coal_check
from helpers.properties import examples
from helpers.scenes import TABLE, box, down, make, stance
from hypothesis import given
from hypothesis import strategies as st

from cramlite.model import Floats
from cramlite_plugins.kinematics.blends import rounded, zone
from cramlite_plugins.kinematics.forward import forward
from cramlite_plugins.kinematics.inverse import nearest_branch
from cramlite_plugins.kinematics.timing import duration
from cramlite_plugins.motion_planning.round_off import blend_radii
from cramlite_plugins.robots.ur5e import UR5E

SPEED, ACCELERATION = 1.5, 3.0
PIECE = 1e-3  # step of the numerical derivatives [s]
Points = list[tuple[float, ...]]
points_of_paths = st.lists(st.tuples(*[st.floats(-2, 2)] * 3), min_size=3, max_size=6, unique=True)


def sampled(points: Points, zones: list[tuple[float, float]], step: float = PIECE) -> Floats:
    rows = []
    for section in rounded(points, zones, [(SPEED, ACCELERATION)] * (len(points) - 1)):
        count = max(2, math.ceil(section.length / step))
        rows += [section.at(section.length * k / count) for k in range(count)]
    return np.array([*rows, points[-1]])


@examples(60)
@given(points_of_paths, st.floats(0.01, 0.5))
def test_speed_and_acceleration_of_every_joint_stay_within_the_limits(points: Points, share: float) -> None:
    sections = rounded(points, [(share, share)] * (len(points) - 2), [(SPEED, ACCELERATION)] * (len(points) - 1))
    before: tuple[Floats, Floats] | None = None
    for section in sections:
        if section.length < 1e-4:
            continue
        h = min(PIECE, section.length / 8)
        for t in np.linspace(h, section.length - h, 12):
            a, b, c = section.at(t - h), section.at(t), section.at(t + h)
            assert np.abs(c - a).max() / (2 * h) <= SPEED * 1.001 + 1e-6
            assert np.abs(a - 2 * b + c).max() / h**2 <= ACCELERATION * 1.01 + 1e-4
        begin, end = section.at(0.0), section.at(section.length)
        if before is not None:
            assert begin == pytest.approx(before[0], abs=1e-6)  # no jump, and no sudden change of speed
            assert (section.at(1e-6) - begin) / 1e-6 == pytest.approx(before[1], abs=0.02)
        before = end, (end - section.at(section.length - 1e-6)) / 1e-6
    assert sections[-1].at(sections[-1].length) == pytest.approx(points[-1])


@given(points_of_paths)
def test_without_zones_it_stops_at_every_corner(points: Points) -> None:
    sections = rounded(points, [(0.0, 0.0)] * (len(points) - 2), [(SPEED, ACCELERATION)] * (len(points) - 1))
    assert sum(s.length for s in sections) == pytest.approx(duration(points, SPEED, ACCELERATION))
    assert [s.rate(0.0) for s in sections] == [0.0] * len(sections)


def test_a_zone_ends_a_radius_from_the_corner_and_never_beyond_the_middle() -> None:
    q, far = UR5E.home, (UR5E.home[0] + 1.0, *UR5E.home[1:])

    def tcp(joints: Floats) -> Floats:
        return np.array(forward(UR5E, joints.tolist()).position)

    part = zone(tcp, q, far, 0.1)
    assert part is not None
    reached = forward(UR5E, [a + part * (b - a) for a, b in zip(q, far, strict=True)])
    assert reached.distance(forward(UR5E, q))[0] == pytest.approx(0.1, abs=1e-5)
    assert zone(tcp, q, far, 0.9) is None


def corner() -> Points:
    """The hand goes aside, then down."""
    first, last = (stance(make(TABLE), down(0.5, -0.2, z)) for z in (0.5, 0.1))
    return [first, (first[0] + 1.0, *first[1:]), (first[0] + 1.0, *last[1:])]


def test_a_free_corner_is_rounded_and_that_is_quicker() -> None:
    radii, seconds = blend_radii(make(TABLE), corner(), SPEED, ACCELERATION)
    assert radii[0] > 0.05
    assert seconds < duration(corner(), SPEED, ACCELERATION) - 0.2


def test_a_corner_whose_blend_would_cut_into_something_is_rounded_less() -> None:
    """A peg stands in the corner: both lines are free, the largest blend is not."""
    points = corner()
    large = blend_radii(make(TABLE), points, SPEED, ACCELERATION)[0][0]
    tips = [np.array(forward(UR5E, q).position) for q in points]
    x, y, z = tips[1] + 0.3 * ((tips[0] + tips[2]) / 2 - tips[1])
    place = make(TABLE, box("peg", (0.01, 0.01, 0.01), (float(x) + 0.1, float(y), float(z))))
    assert all(place.line_free(a, b) for a, b in itertools.pairwise(points))
    assert not all(place.free(q) for q in rounded_off(points, (large,)))
    radii, _ = blend_radii(place, points, SPEED, ACCELERATION)
    assert radii[0] < large
    solids, checked = coal_check.shapes(place), coal_check.pairs(place)
    for q in rounded_off(points, radii):
        assert min(coal_check.distances(place, q, solids, checked).values()) > 0


def rounded_off(points: Points, radii: tuple[float, ...]) -> Floats:
    """Joint positions of the path as it is executed."""
    if radii == (0.0,):
        return sampled(points, [(0.0, 0.0)], 0.02)
    tcp = make().tip
    into, out = (zone(tcp, points[1], other, radii[0]) for other in (points[0], points[2]))
    assert into is not None
    assert out is not None
    return sampled(points, [(into, out)], 0.02)


def test_a_start_that_is_15_mm_elsewhere_still_takes_the_blends() -> None:
    """After a search by touch the arm does not begin where the path was planned from."""
    scene = make(TABLE)
    q: Points = [stance(scene, down(0.45, -0.1, 0.3))]
    for pose in (down(0.45, 0.0, 0.3), down(0.45, 0.2, 0.4)):
        q.append(nearest_branch(UR5E, pose, q[-1]) or ())
    radius = blend_radii(scene, q, SPEED, ACCELERATION)[0][0]
    nearer = nearest_branch(UR5E, down(0.45, -0.085, 0.3), q[0])
    assert nearer is not None
    assert radius > 0.02
    assert zone(scene.tip, np.array(q[1]), np.array(nearer), radius) is not None
    half = math.dist(scene.tip(np.array(q[0])), scene.tip(np.array(q[1]))) / 2
    assert zone(scene.tip, np.array(q[1]), np.array(nearer), half) is None  # what was planned with before
