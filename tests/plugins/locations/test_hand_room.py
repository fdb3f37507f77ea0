"""Many lines, boxes and grasps at once: the same answers as one by one, and what is in the way is last."""

from __future__ import annotations

import itertools
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest
from helpers.properties import examples
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from cramlite import Engine
from cramlite.model import Belief, Geom, HandFile, Location, Pose, RobotMount, Stated, Thing, World, initial_belief
from cramlite.plugin import Context, Grounding, Refused, Unresolvable
from cramlite_plugins.imports.robots.robot_file import read_robot
from cramlite_plugins.kinematics.forward import forward
from cramlite_plugins.locations import grasps
from cramlite_plugins.locations.kinds import ground
from cramlite_plugins.objects.products_and_fixtures import block, table
from cramlite_plugins.robots.fr3 import FR3
from cramlite_plugins.shapes import ray_casting as rays
from cramlite_plugins.shapes.box_overlaps import overlaps
from cramlite_plugins.simulation.model.compile import compile_world

FILES = Path(__file__).parents[1] / "imports" / "robots_data"
MOUNT = RobotMount("arm", "fr3")
TABLE = table("table", Pose((0.5, 0.0, 0.0)))
coordinate = st.floats(-0.15, 0.15)
poses = st.builds(
    Pose.from_rotvec, st.tuples(coordinate, coordinate, coordinate), st.tuples(*[st.floats(-2.0, 2.0)] * 3)
)
sizes = st.tuples(*[st.floats(0.01, 0.08)] * 3)


@examples(60)
@given(poses, sizes, poses, sizes)
def test_boxes_overlap_where_mujoco_finds_them_in_one_another(a: Pose, one: Any, b: Pose, other: Any) -> None:
    shape = rays.body([Geom("box", other, b)])
    got = overlaps(shape, np.array([a.position]), a.rotation[None], np.array(one))[0, 0]
    things = (Thing("a", "cram:Product", a, (Geom("box", one),)), Thing("b", "cram:Product", b, (Geom("box", other),), mass=1.0))
    compiled = compile_world(World(things), {})
    data = compiled.data()
    mujoco.mj_forward(compiled.model, data)
    depth = min((c.dist for c in data.contact), default=1.0)
    assert got == (depth < 0) or abs(depth) < 3e-4, depth


def test_parallel_boxes_that_touch_do_not_overlap_and_deeper_ones_do() -> None:
    shape = rays.body([Geom("box", (0.1, 0.1, 0.1))])
    centres = np.array([(0.0, 0.0, 0.15), (0.0, 0.0, 0.149), (0.14, 0.14, 0.14), (0.16, 0.0, 0.0)])
    got = overlaps(shape, centres, np.tile(np.eye(3), (4, 1, 1)), np.full(3, 0.05))
    assert got[:, 0].tolist() == [False, True, True, False]


def _inside(geom: Geom, p: Any) -> Any:
    """Whether points (n, 3) of the first octant are in a geom."""
    if geom.shape == "box":
        return (p < geom.size).all(axis=1)
    if geom.shape == "sphere":
        return np.linalg.norm(p, axis=1) < geom.size[0]
    radial, over = np.hypot(p[:, 0], p[:, 1]), np.maximum(p[:, 2] - geom.size[1], 0.0)
    return np.hypot(radial, over) < geom.size[0] if geom.shape == "capsule" else (radial < geom.size[0]) & (over == 0)


@pytest.mark.parametrize("geom", [
    Geom("box", (0.05, 0.08, 0.1)), Geom("sphere", (0.09,)), Geom("cylinder", (0.06, 0.1)), Geom("capsule", (0.05, 0.07)),
])  # fmt: skip
def test_a_line_is_in_a_geom_where_its_points_are(geom: Geom) -> None:
    rng = np.random.default_rng(0)
    points, ways = rng.uniform(-0.12, 0.12, (60, 3)), rng.normal(size=(60, 3))
    ways[:3] = np.eye(3)  # along its axes, too
    ways /= np.linalg.norm(ways, axis=1)[:, None]
    low, high = rays.intervals(rays.body([geom]), points, ways)
    for t in np.linspace(-0.3, 0.3, 41):
        inside = _inside(geom, np.abs(points + t * ways))
        within = (low[:, 0] < t) & (t < high[:, 0])
        edge = np.minimum(np.abs(low[:, 0] - t), np.abs(high[:, 0] - t)) < 1e-6
        assert ((inside == within) | edge).all()
    assert np.isinf(low[low >= high]).all()


def _asked(*things: Thing, most: int = 3) -> list[Grounding | Refused]:
    world = World((TABLE, *things), (MOUNT,))
    belief: Belief = initial_belief(world, "arm", FR3.home, 0.08)
    context = Context(FR3, MOUNT, {"it": "it"}, Engine().knowledge.taxonomy)
    found = ground(Location("grasp(it)", "grasp", "it"), belief, context)
    assert found is not None
    return list(itertools.islice(found, most))


def test_the_first_grasp_of_a_box_on_a_table_needs_no_second() -> None:
    found = _asked(block("it", Pose((0.5, 0.1, 0.03)), (0.05, 0.09, 0.06)), most=1)
    assert isinstance(found[0], Grounding)
    assert found[0].value.approach[2] < -0.9, "from above"
    assert found[0].value.opening > 0.07, "as wide as nothing forbids"


def test_neighbours_leave_a_narrow_opening_or_another_side() -> None:
    it = block("it", Pose((0.5, 0.1, 0.04)), (0.04, 0.06, 0.08))
    wall = Geom("box", (0.02, 0.06, 0.05))
    beside = [Thing(f"wall{s}", "cram:Product", Pose((0.5 + 0.062 * s, 0.1, 0.05)), (wall,)) for s in (1, -1)]
    first = _asked(it, *beside, most=1)[0]
    assert isinstance(first, Grounding)
    assert abs(first.value.pose.rotate((0, 1, 0))[1]) > 0.9, "across the other way, where fingers have room"


@pytest.mark.heavy
def test_a_box_under_a_roof_has_no_grasp_with_room() -> None:
    it = block("it", Pose((0.5, 0.1, 0.03)), (0.05, 0.05, 0.06))
    roof = Thing("roof", "cram:Product", Pose((0.5, 0.1, 0.075)), (Geom("box", (0.3, 0.3, 0.005)),))
    assert not any(isinstance(f, Grounding) for f in _asked(it, roof, most=400))


WEDGE = '<asset><mesh name="wedge" vertex="{}"/></asset>'
FLAT = [(x, y, z) for x in (-0.008, 0.008) for y, z in ((-0.013, 0.0), (-0.013, 0.06), (0.022, 0.0))]
"""A finger whose flat side is 2 mm behind the pad, in the finger's frame [m]: its axes of inertia are askew to that side."""


def _grasps_with(corners: list[tuple[float, float, float]], tmp_path: Path) -> list[Grounding | Refused]:
    """Grasps by a hand from a file, both of whose fingers have such a mesh behind their pads."""
    text, where = (FILES / "linked_hand.xml").read_text(), tmp_path / "hand.xml"
    text = text.replace("<default>", WEDGE.format(" ".join(f"{v}" for c in corners for v in c)) + "<default>", 1)
    for side, turn in (("left", "1 0 0 0"), ("right", "0 0 0 1")):
        finger, tip = f'<geom type="mesh" mesh="wedge" quat="{turn}" mass="0.01"/>', f'<geom name="{side}_tip"'
        text = text.replace(tip, finger + tip)
    where.write_text(text)
    pads = ("left_tip", "right_tip")
    home = (0.0, 0.3, 1.6, 0.0, 1.24, 0.0)
    robot = read_robot(FILES / "six.urdf", "mine", Stated(4.0, sensor="flange", home=home, gripper=HandFile(str(where), pads=pads))).robot
    world = World((TABLE, block("it", Pose((0.5, 0.1, 0.05)), (0.04, 0.04, 0.1))), (mount := RobotMount("arm", "mine"),))
    context = Context(robot, mount, {"it": "it"}, Engine().knowledge.taxonomy)
    found = ground(Location("grasp(it)", "grasp", "it"), initial_belief(world, "arm", robot.home, 0.08), context)
    assert found is not None
    return list(itertools.islice(found, 5))


def test_fingers_of_meshes_that_lie_askew_leave_the_gap_free(tmp_path: Path) -> None:
    assert any(isinstance(f, Grounding) for f in _grasps_with(FLAT, tmp_path))


def test_a_finger_that_reaches_into_the_gap_is_said_to_be_in_the_way(tmp_path: Path) -> None:
    with pytest.raises(Unresolvable, match="the hand would be inside it"):
        _grasps_with([(x, y - 0.02, z) for x, y, z in FLAT], tmp_path)


def test_of_the_two_ways_round_the_nearer_one_comes_first() -> None:
    for yaw in (0.3, 2.0, 3.0, -2.0):
        box = block("it", Pose.from_rotvec((0.45, 0.0, 0.04), (0, 0, yaw)), (0.04, 0.07, 0.08))
        first = next(f for f in _asked(box, most=5) if isinstance(f, Grounding))
        here, turned = forward(FR3, FR3.home), first.value.pose * grasps.HALF_TURN
        assert here.distance(first.value.pose)[1] <= here.distance(turned)[1] + 1e-6


def test_what_turns_in_the_pads_is_gripped_nearer_to_its_centre() -> None:
    bar = Thing("it", "cram:Product", Pose((0.5, 0.0, 0.02)), (Geom("box", (0.15, 0.015, 0.02)),), mass=0.5)
    found = [f for f in _asked(bar, most=8) if isinstance(f, Grounding)]
    shares = [float(f.reason.split(" % of the grip force")[0].rsplit(" ", 1)[1]) for f in found]
    assert shares[0] == min(shares) < 100
    with pytest.raises(Unresolvable, match=r"no face pair of 'it' .* fits the gripper's 76 mm"):
        _asked(replace(bar, geoms=(Geom("box", (0.15, 0.05, 0.05)),)))
