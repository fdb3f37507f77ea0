"""Support, boxes, corners and volumes of primitives: compared with trimesh's primitives and with points on them."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
import pytest
import trimesh
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from cramlite.model import Geom, Pose, Thing
from cramlite_plugins.shapes.bounds import bounds, box_around, corners, extents, lowest, support, volume

LENGTH = st.floats(0.005, 0.5)
NUMBER = st.floats(-1.0, 1.0)


@st.composite
def poses(draw: st.DrawFn) -> Pose:
    turn = draw(st.tuples(*[NUMBER] * 4).filter(lambda q: math.hypot(*q) > 0.1))
    return Pose(draw(st.tuples(NUMBER, NUMBER, NUMBER)), turn)


@st.composite
def hulls(draw: st.DrawFn) -> Geom:
    """A box with corners cut off: always a hull with room in it."""
    half = np.array(draw(st.tuples(LENGTH, LENGTH, LENGTH)))
    signs = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=float)
    points = signs * half * np.array(draw(st.lists(st.floats(0.3, 1.0), min_size=8, max_size=8)))[:, None]
    size = np.ptp(points, axis=0) / 2
    points = points - (points.max(axis=0) + points.min(axis=0)) / 2
    return Geom("convex", tuple(size), corners=tuple(map(tuple, points.tolist())))


GEOMS = st.builds(
    replace,
    st.one_of(
        st.builds(lambda s: Geom("box", s), st.tuples(LENGTH, LENGTH, LENGTH)),
        st.builds(lambda s: Geom("cylinder", s), st.tuples(LENGTH, LENGTH)),
        st.builds(lambda s: Geom("capsule", s), st.tuples(LENGTH, LENGTH)),
        st.builds(lambda s: Geom("sphere", s), st.tuples(LENGTH)),
        hulls(),
    ),
    pose=poses(),
)


@cache
def _ball() -> np.ndarray:
    return np.asarray(trimesh.creation.icosphere(subdivisions=3).vertices)


@cache
def _can() -> np.ndarray:
    return np.asarray(trimesh.creation.cylinder(1.0, 2.0, sections=64).vertices)


def points(geom: Geom) -> np.ndarray:
    """Vertices (n, 3) of trimesh's primitives, in the thing's frame; a capsule is a cylinder between two balls."""
    radius, half = geom.size[0], geom.size[-1]
    ball, can = radius * _ball(), _can() * (radius, radius, half)
    found = {
        "box": lambda: np.asarray(trimesh.creation.box(extents=2 * np.array(geom.size)).vertices),
        "sphere": lambda: ball,
        "cylinder": lambda: can,
        "capsule": lambda: np.concatenate([can, ball + np.array((0, 0, half)), ball - np.array((0, 0, half))]),
        "convex": lambda: np.asarray(trimesh.convex.convex_hull(geom.corners).vertices),
    }
    return geom.pose.apply(found[geom.shape]())


def room(geom: Geom) -> float:
    """Volume by trimesh, whose primitives know it exactly."""
    if geom.shape == "convex":
        return float(trimesh.convex.convex_hull(geom.corners).volume)
    if geom.shape == "box":
        return float(trimesh.primitives.Box(extents=2 * np.array(geom.size)).volume)
    ball = trimesh.primitives.Sphere(radius=geom.size[0]).volume
    can = trimesh.primitives.Cylinder(radius=geom.size[0], height=2 * geom.size[-1]).volume
    return float({"sphere": ball, "cylinder": can, "capsule": ball + can}[geom.shape])


def thing(*geoms: Geom) -> Thing:
    return Thing("thing", "cram:Product", Pose(), geoms)


def direction(draw: tuple[float, float, float]) -> np.ndarray:
    return np.array(draw) / math.hypot(*draw)


WAYS = st.tuples(NUMBER, NUMBER, NUMBER).filter(lambda v: math.hypot(*v) > 0.1).map(direction)
COARSE = 6e-3
"""What the triangles of a round primitive leave of its radius, as a share of it."""


@given(GEOMS)
def test_volume(geom: Geom) -> None:
    assert volume(geom) == pytest.approx(room(geom), rel=1e-6)


@given(GEOMS, poses(), WAYS)
def test_support_is_as_far_as_the_farthest_point(geom: Geom, pose: Pose, way: np.ndarray) -> None:
    farthest = float((pose.apply(points(geom)) @ way).max())
    slack = 0.0 if geom.shape in ("box", "convex") else COARSE * geom.size[0]
    assert farthest - 1e-9 <= support(thing(geom), pose, way) <= farthest + slack + 1e-9


@given(GEOMS, poses())
def test_bounds_are_supports_along_the_axes(geom: Geom, pose: Pose) -> None:
    low, high = bounds(geom)
    for axis, way in enumerate(np.eye(3)):
        assert high[axis] == pytest.approx(support(thing(geom), Pose(), way), abs=1e-12)
        assert low[axis] == pytest.approx(-support(thing(geom), Pose(), -way), abs=1e-12)
    up = Pose((0.0, 0.0, 0.0), pose.quaternion)
    assert lowest(thing(geom), pose) == pytest.approx(-support(thing(geom), up, (0, 0, -1)), abs=1e-12)


@given(GEOMS)
def test_bounds_hold_what_trimesh_has(geom: Geom) -> None:
    low, high = bounds(geom)
    vertices = points(geom)
    slack = 0.0 if geom.shape in ("box", "convex") else COARSE * geom.size[0]
    assert (low - 1e-9 <= vertices.min(axis=0)).all() and (vertices.min(axis=0) <= low + slack + 1e-9).all()
    assert (vertices.max(axis=0) <= high + 1e-9).all() and (high - slack - 1e-9 <= vertices.max(axis=0)).all()


@given(GEOMS)
def test_the_box_along_its_own_axes(geom: Geom) -> None:
    upright = replace(geom, pose=Pose())
    assert np.allclose(bounds(upright)[1], geom.half_extents, atol=1e-12)
    assert np.allclose(bounds(upright)[0], -np.array(geom.half_extents), atol=1e-12)


@given(GEOMS)
def test_the_ball_around_it_is_touched_from_inside(geom: Geom) -> None:
    away = np.linalg.norm(points(replace(geom, pose=Pose())), axis=1).max()
    slack = 0.0 if geom.shape in ("box", "convex") else COARSE * geom.size[0]
    assert away - 1e-9 <= geom.bounding_radius <= away + slack + 1e-9


@given(st.lists(GEOMS, min_size=1, max_size=4), poses(), WAYS)
def test_many_reach_as_far_as_the_one_that_reaches_farthest(geoms: list[Geom], pose: Pose, way: np.ndarray) -> None:
    each = [support(thing(g), pose, way) for g in geoms]
    assert support(thing(*geoms), pose, way) == max(each)
    assert float((corners(thing(*geoms), pose) @ way).max()) >= max(each) - 1e-9
    low, high = box_around(geoms)
    assert np.allclose(extents(geoms), high - low)
    assert all((low <= bounds(g)[0]).all() and (bounds(g)[1] <= high).all() for g in geoms)


def test_a_cylinder_that_stands_reaches_as_high_as_it_is_long() -> None:
    can = thing(Geom("cylinder", (0.03, 0.06)))
    assert support(can, Pose(), (0, 0, 1)) == pytest.approx(0.06)
    assert support(can, Pose(), (1, 0, 0)) == pytest.approx(0.03)
    leaning = Pose.from_rotvec((0, 0, 0), (math.pi / 4, 0, 0))
    assert lowest(can, leaning) == pytest.approx(-(0.03 + 0.06) / math.sqrt(2))


def test_nothing_has_no_box() -> None:
    with pytest.raises(ValueError, match="unpack"):
        box_around([])
