"""Size, centre of mass and lean of twins: reached, kept within, told; what stands, hangs and is mounted goes along."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
import pytest
from msgspec.structs import replace
from test_twin_worlds import FIXED, HELD_BY, SIGHT, WORLD, draw, reaches, shift, turn

from cramlite.model import Geom, MeshFile, Pose, PoseError, RobotMount, Thing, World
from cramlite.model.twins.error_model import NO_ERRORS
from cramlite.model.world.thing_boxes import boxes, extents
from cramlite.scenario.scaled_thing import scaled
from cramlite.scenario.twin import draw_twin
from cramlite_plugins.objects.products_and_fixtures import block, table
from cramlite_plugins.objects.vessels import bowl, lid
from cramlite_plugins.robots.ur5e import UR5E
from cramlite_plugins.robots.ur5e_mobile import UR5E_MOBILE
from cramlite_plugins.simulation.model.centres import of_shape
from cramlite_plugins.simulation.model.compile import compile_world

SEEDS = range(60)
SIZE, CENTRE, LEAN = replace(NO_ERRORS, size=0.02), replace(NO_ERRORS, centre=0.05), replace(NO_ERRORS, lean=0.03)
FREE = ("tea", "jug", "block")
SHELF = table("shelf", Pose((0.4, 0.1, 0.3)), size=(0.4, 0.4, 0.02))
STACK = World(
    (SHELF, block("low", Pose((0.5, 0.2, 0.33))), block("high", Pose((0.5, 0.2, 0.39)))),
    (RobotMount("arm", "ur5e"),),
)


@cache
def worlds(source: str) -> tuple[World, ...]:
    errors = {"size": SIZE, "centre": CENTRE, "lean": LEAN}[source]
    return tuple(draw(seed, errors).world for seed in SEEDS)


def bottom(thing: Thing) -> float:
    """The height of the lowest point of a thing with geoms [m]."""
    return min(low[2] for low, _ in boxes(thing))


def factor(real: World, name: str) -> float:
    return extents(real.thing(name))[0] / extents(WORLD.thing(name))[0]


# Size


@pytest.mark.parametrize("name", FREE)
def test_what_is_free_comes_near_both_ends_of_its_size(name: str) -> None:
    found = [factor(real, name) for real in worlds("size")]
    reaches((min(found), max(found)), 0.98, 1.02)


@pytest.mark.parametrize("name", [*FIXED, "drawer", "gate"])
def test_furniture_keeps_its_size(name: str) -> None:
    assert all(real.thing(name) == WORLD.thing(name) for real in worlds("size"))


@pytest.mark.parametrize("name", ["jug", "block"])
def test_the_base_of_what_stands_stays_and_its_middle_is_over_the_same_place(name: str) -> None:
    for real in worlds("size"):
        assert bottom(real.thing(name)) == pytest.approx(bottom(WORLD.thing(name)), abs=1e-9)
        assert shift(real, name)[:2] == (0.0, 0.0) and turn(real, name) == (0.0, 0.0, 0.0)


def test_the_hole_of_what_hangs_rests_on_the_peg_where_it_did() -> None:
    was = WORLD.thing("tea").feature("vrps:Hole")
    assert was is not None
    top = (WORLD.thing("tea").pose * was.pose).position[2] + was.size["diameter"] / 2
    for real in worlds("size"):
        tea = real.thing("tea")
        hole = tea.feature("vrps:Hole")
        assert hole is not None and hole.size["diameter"] == pytest.approx(was.size["diameter"] * factor(real, "tea"))
        at = (tea.pose * hole.pose).position
        assert at[2] + hole.size["diameter"] / 2 == pytest.approx(top, abs=1e-9)
        assert at[:2] == pytest.approx((WORLD.thing("tea").pose * was.pose).position[:2], abs=1e-9)


def hanging(**changes: object) -> World:
    """The world, whose thing that hangs is another."""
    return replace(WORLD, things=tuple(replace(t, **changes) if t.name == "tea" else t for t in WORLD.things))


@pytest.mark.parametrize("changes", [{"mass": None}, {"features": ()}])
def test_what_hangs_and_is_fixed_or_shows_no_hole_goes_with_its_hanger(changes: dict[str, object]) -> None:
    world = hanging(**changes)
    before = world.thing("hook").pose.inverse() * world.thing("tea").pose
    for errors in (SIZE, LEAN) if "mass" in changes else (replace(NO_ERRORS, pose=PoseError(0.004, 0.03)), LEAN):
        real = draw(2, errors, world=world).world
        after = real.thing("hook").pose.inverse() * real.thing("tea").pose
        assert max(before.distance(after)) < 1e-6


def test_a_hole_of_no_stated_diameter_is_a_point() -> None:
    hole = replace(WORLD.thing("tea").features[0], size={})
    world = hanging(features=(hole,))
    for seed in SEEDS[:5]:
        real = draw(seed, SIZE, world=world).world
        tea = real.thing("tea")
        was = world.thing("tea").pose * hole.pose
        assert (tea.pose * tea.features[0].pose).position == pytest.approx(was.position, abs=1e-9)


def test_what_stands_on_what_is_larger_stands_higher() -> None:
    for seed in SEEDS:
        real = draw_twin(STACK, (), UR5E, SIZE, seed).world
        top = max(high[2] for _, high in boxes(real.thing("low")))
        assert bottom(real.thing("high")) == pytest.approx(top, abs=1e-8)
        assert top != pytest.approx(0.36, abs=1e-9)


def test_all_lengths_of_a_scaled_thing_are_and_its_mass_and_joint_are_not() -> None:
    hull = Geom("convex", (0.1, 0.2, 0.3), Pose((0.1, 0.2, 0.3)), corners=((0.1, 0.2, 0.3), (-0.1, 0.2, 0.3)))
    thing = replace(WORLD.thing("jug"), geoms=(*WORLD.thing("jug").geoms, hull), mesh=MeshFile("jug.stl", 0.5))
    large = scaled(thing, 2.0)
    for old, new in zip(thing.geoms, large.geoms, strict=True):
        assert new.size == pytest.approx([2 * s for s in old.size])
        assert new.pose.position == pytest.approx([2 * p for p in old.pose.position])
        assert np.array(new.corners) == pytest.approx(2 * np.array(old.corners)) and new.pose.quaternion == old.pose.quaternion
        assert new.half_extents == pytest.approx([2 * h for h in old.half_extents])
    for was, now in zip(thing.features, large.features, strict=True):
        assert now.size == pytest.approx({k: 2 * v for k, v in was.size.items()}) and now.type == was.type
        assert now.pose.position == pytest.approx([2 * p for p in was.pose.position])
    assert large.inertia is not None and thing.inertia is not None and large.mesh == MeshFile("jug.stl", 1.0)
    assert large.inertia.centre == pytest.approx([2 * c for c in thing.inertia.centre])
    assert large.inertia.moments == pytest.approx([4 * m for m in thing.inertia.moments])
    assert (large.pose, large.mass, large.filling, large.friction) == (thing.pose, thing.mass, thing.filling, thing.friction)
    drawer = WORLD.thing("drawer")
    assert scaled(drawer, 2.0).joint == drawer.joint and scaled(drawer, 1.0) == drawer


# Centre of mass


@pytest.mark.parametrize("name", FREE)
@pytest.mark.parametrize("axis", [0, 1, 2])
def test_a_centre_of_mass_comes_near_both_ends_of_its_share_of_each_side(name: str, axis: int) -> None:
    found = [real.disturbance.centres[name][axis] for real in worlds("centre")]
    far = 0.05 * extents(WORLD.thing(name))[axis]
    reaches((min(found), max(found)), -far, far)


def test_nothing_else_has_one_and_no_thing_is_changed() -> None:
    for real in worlds("centre"):
        assert real.disturbance.centres.keys() == set(FREE) and real.things == WORLD.things


@pytest.mark.parametrize("name", ["block", "jug"])
def test_the_simulator_has_it_where_the_twin_says(name: str) -> None:
    """The moments about it, the mass, and the centres of all others are as they were."""
    real = draw(3, CENTRE).world
    old, new = (compile_world(w, {"ur5e": UR5E}) for w in (WORLD, real))
    one, other = (c.model.body(name) for c in (old, new))
    by = other.ipos - one.ipos
    assert by == pytest.approx(real.disturbance.centres[name], abs=1e-9) and np.abs(by).max() > 1e-4
    assert other.mass == pytest.approx(one.mass) and sorted(other.inertia) == pytest.approx(sorted(one.inertia), rel=1e-6)
    assert old.model.body("floor").ipos == pytest.approx(new.model.body("floor").ipos)
    assert old.model.body("drawer").ipos == pytest.approx(new.model.body("drawer").ipos)


def test_the_inertia_of_a_box_is_that_of_a_box() -> None:
    box = Thing("box", "cram:Product", Pose((1, 2, 3)), (Geom("box", (0.1, 0.2, 0.3), Pose((0.05, 0.0, 0.0))),), mass=1.2)
    found = of_shape(box)
    assert found.centre == pytest.approx((0.05, 0.0, 0.0))
    assert found.moments == pytest.approx([0.4 * (0.04 + 0.09), 0.4 * (0.01 + 0.09), 0.4 * (0.01 + 0.04), 0, 0, 0], abs=1e-9)


# Lean


@pytest.mark.parametrize("name", FIXED)
def test_what_is_fixed_leans_to_every_side_about_its_base_and_does_not_turn(name: str) -> None:
    turns = np.array([turn(real, name) for real in worlds("lean")])
    far = np.linalg.norm(turns, axis=1)
    assert np.abs(turns[:, 2]).max() < 1e-9 and 0.9 * 0.03 <= far.max() <= 0.03 + 1e-9
    assert ((far / 0.03) ** 2).mean() == pytest.approx(0.5, abs=0.1)
    for axis in (0, 1):
        reaches((turns[:, axis].min(), turns[:, axis].max()), -0.03, 0.03, 0.25)
    x, y, _ = WORLD.thing(name).pose.position
    base = (x, y, bottom(WORLD.thing(name)))
    for real in worlds("lean"):
        assert real.thing(name).pose.apply(WORLD.thing(name).pose.inverse().apply(base)) == pytest.approx(base, abs=1e-9)


def test_no_side_is_leant_to_more_often_than_another() -> None:
    ways = [math.atan2(*turn(real, name)[1::-1]) for real in worlds("lean") for name in FIXED]
    for begin in (-1.0, 0.0):
        assert np.mean([begin <= way < begin + 1.0 for way in ways]) == pytest.approx(1.0 / math.tau, abs=0.06)


@pytest.mark.parametrize(("name", "under"), [("block", "floor"), ("jug", "shelf")])
def test_what_stands_leans_with_its_support_and_touches_it_as_before(name: str, under: str) -> None:
    x, y, _ = WORLD.thing(name).pose.position
    foot = (x, y, bottom(WORLD.thing(name)))
    for real in worlds("lean"):
        assert turn(real, name) == pytest.approx(turn(real, under), abs=1e-9)
        at = real.thing(name).pose.apply(WORLD.thing(name).pose.inverse().apply(foot))
        before = WORLD.thing(under).pose.inverse().apply(foot)
        assert real.thing(under).pose.inverse().apply(at)[2] == pytest.approx(before[2], abs=2e-4)
        assert at[:2] == pytest.approx(foot[:2], abs=1e-9)


@pytest.mark.parametrize("over", [0.0, 0.011, 0.1])
def test_what_comes_down_on_a_support_when_the_world_settles_goes_along_with_it(over: float) -> None:
    """However far it is over it, and however far from where the support turns: else it would fall farther, or start inside of it."""
    floor = table("floor", Pose((0.0, 0.0, 0.0)), size=(6.0, 6.0, 0.02))
    far = World((floor, block("far", Pose((0.0, -1.9, 0.03 + over)))), (RobotMount("arm", "ur5e"),))
    for seed in SEEDS[:20]:
        real = draw_twin(far, (), UR5E, LEAN, seed).world
        foot = real.thing("far").pose.apply((0.0, 0.0, -0.03))
        assert real.thing("floor").pose.inverse().apply(foot)[2] == pytest.approx(over, abs=2e-3 * (1 + over))


def test_the_floor_that_a_platform_drives_on_is_level_with_its_robot() -> None:
    """What else stands there leans, and the floor below an arm that is bolted down, too."""
    things = (table("floor", Pose((1.5, 0.0, -0.005)), size=(6.0, 6.0, 0.02)), table("bench", Pose((2.0, 0.0, 0.4)), size=(0.6, 0.6, 0.02)))
    for robot, leaning in ((UR5E_MOBILE, {"bench"}), (UR5E, {"floor", "bench"})):
        world = World(things, (RobotMount("arm", robot.type),))
        for seed in SEEDS[:5]:
            real = draw_twin(world, (), robot, LEAN, seed).world
            assert {t.name for t in real.things if t.pose.quaternion[0] < 1.0} == leaning


def test_a_stack_leans_as_a_whole() -> None:
    for seed in SEEDS[:20]:
        real = draw_twin(STACK, (), UR5E, LEAN, seed).world
        leans = [real.thing(n).pose.quaternion for n in ("shelf", "low", "high")]
        assert leans[1] == pytest.approx(leans[0]) and leans[2] == pytest.approx(leans[0]) and leans[0][0] < 1.0
        down = real.thing("low").pose.inverse().apply(real.thing("high").pose.apply((0.0, 0.0, -0.03)))
        assert down[2] == pytest.approx(0.03, abs=1e-4)


@pytest.mark.parametrize(("name", "carrier"), [("drawer", "cabinet"), ("tea", "hook")])
def test_what_is_mounted_or_hangs_leans_with_its_carrier(name: str, carrier: str) -> None:
    before = WORLD.thing(carrier).pose.inverse() * WORLD.thing(name).pose
    for real in worlds("lean"):
        assert max(before.distance(real.thing(carrier).pose.inverse() * real.thing(name).pose)) < 1e-6


POT = bowl("pot", Pose((0.45, -0.3, 0.046)), radius=0.08, height=0.09)
LID = lid("lid", Pose((0.45, -0.3, 0.094)), radius=0.085)
RING = replace(POT, geoms=POT.geoms[1:])


def covered(*things: Thing) -> World:
    return World((table("floor", Pose((0.2, 0.0, -0.009)), size=(1.6, 1.6, 0.02)), *things), (RobotMount("arm", "ur5e"),))


def gap(real: World) -> float:
    """How far the lid is above the rim, across it [m]."""
    pot, top = real.thing("pot"), real.thing("lid")
    foot = pot.pose.inverse().apply(top.pose.apply((0.0, 0.0, -top.geoms[0].half_extents[2])))
    return float(foot[2]) - max(g.pose.position[2] + g.half_extents[2] for g in pot.geoms)


@pytest.mark.parametrize("things", [(POT, LID), (LID, POT), (RING, LID), (LID, RING)])
def test_a_lid_goes_with_the_rim_that_it_lies_on(things: tuple[Thing, ...]) -> None:
    """Whichever of them is named first, and whether or not there is something below the middle of the lid."""
    errors = replace(NO_ERRORS, size=0.02, lean=0.03, pose=PoseError(0.004, 0.0))
    for seed in SEEDS[:20]:
        real = draw_twin(covered(*things), (), UR5E, errors, seed).world
        assert real.thing("lid").pose.quaternion == pytest.approx(real.thing("pot").pose.quaternion)
        assert real.thing("lid").pose.quaternion == pytest.approx(real.thing("floor").pose.quaternion) != POT.pose.quaternion
        assert gap(real) == pytest.approx(0.0, abs=5e-4)


@pytest.mark.parametrize(("x", "y"), [(0.079, 0.0), (-0.079, 0.0), (0.0, 0.079), (0.0, -0.079)])
@pytest.mark.parametrize(("far", "goes"), [(0.0, True), (1.0, True), (1.03, False)])
def test_what_lies_across_a_gap_goes_with_its_edges_while_its_middle_is_between_them(x: float, y: float, far: float, goes: bool) -> None:
    plate = replace(LID, pose=Pose((0.45 + far * x, -0.3 + far * y, 0.094)))
    gaps = [gap(draw_twin(covered(RING, plate), (), UR5E, SIZE, seed).world) for seed in SEEDS[:10]]
    assert (max(map(abs, gaps)) < 1e-6) is goes


def test_a_low_and_a_high_edge_carry_nothing_together() -> None:
    """What lies on the high one alone would fall off it."""
    low, high = (Geom("box", (0.01, 0.1, h), Pose((x, 0.0, h))) for x, h in ((-0.06, 0.02), (0.06, 0.045)))
    steps = Thing("pot", "soma:Bowl", Pose((0.45, -0.3, 0.001)), (low, high), mass=0.1)
    gaps = [gap(draw_twin(covered(steps, LID), (), UR5E, SIZE, seed).world) for seed in SEEDS[:10]]
    assert max(map(abs, gaps)) > 2e-4


# All of them


@pytest.mark.parametrize(("source", "names"), [("size", FREE), ("centre", FREE), ("lean", FIXED)])
def test_what_of_them_was_drawn_is_told(source: str, names: tuple[str, ...]) -> None:
    errors = {"size": SIZE, "centre": CENTRE, "lean": LEAN}[source]
    for seed in SEEDS[:5]:
        twin = draw(seed, errors)
        told = {d.name: d.value for d in twin.draws}
        for name in names:
            if source == "size":
                assert told.pop(f"{name}: size") == pytest.approx(100 * factor(twin.world, name) - 100, abs=2e-6)
            elif source == "centre":
                made = [1000 * v for v in twin.world.disturbance.centres[name]]
                assert [told.pop(f"{name}: centre of mass {a}") for a in "xyz"] == pytest.approx(made, abs=2e-6)
            else:
                made = [math.degrees(v) for v in turn(twin.world, name)[:2]]
                assert [told.pop(f"{name}: leans about {a}") for a in "xy"] == pytest.approx(made, abs=2e-6)
        assert not told and {d.source for d in twin.draws} == {source}


@pytest.mark.parametrize("errors", [SIZE, CENTRE, LEAN])
def test_twice_the_scale_is_twice_as_far(errors: object) -> None:
    one, more = draw(7, errors), draw(7, errors.scaled(2.0))  # type: ignore[arg-type, attr-defined]
    assert [d.value for d in more.draws] == pytest.approx([2 * d.value for d in one.draws], abs=1e-5) and one.draws


def test_all_together_what_stands_still_stands_on_what_carries_it() -> None:
    errors = replace(NO_ERRORS, size=0.02, lean=0.03, pose=PoseError(0.004, 0.03))
    for seed in SEEDS[:40]:
        real = draw_twin(WORLD, HELD_BY, UR5E, errors, seed, SIGHT).world
        for name, under in (("block", "floor"), ("jug", "shelf")):
            x, y, _ = WORLD.thing(name).pose.position
            foot = WORLD.thing(name).pose.inverse().apply((x, y, bottom(WORLD.thing(name)))) * factor(real, name)
            at = real.thing(under).pose.inverse().apply(real.thing(name).pose.apply(foot))
            assert at[2] == pytest.approx(0.0, abs=3e-4), name
