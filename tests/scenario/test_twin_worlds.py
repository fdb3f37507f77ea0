"""Worlds of twins: each error is reached, kept within and told; a source changes what is its own, and nothing else."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from functools import cache

import numpy as np
import pytest
from msgspec.structs import replace

from cramlite.model import ErrorModel, Geom, Inertia, Pose, PoseError, RobotMount, SensorErrors, Thing, World
from cramlite.model.twins.error_model import NO_ERRORS, SOURCES
from cramlite.model.twins.twin_drawing import LEAST
from cramlite.plugin import UserError
from cramlite.scenario.twin import Twin, draw_twin
from cramlite.scenario.twin_places import INSIDE, Sight
from cramlite_plugins.objects.furniture import cabinet, door, drawer
from cramlite_plugins.objects.products_and_fixtures import block, hanger, hung, product, table
from cramlite_plugins.objects.vessels import jug
from cramlite_plugins.robots.ur5e import UR5E

SEEDS = range(60)
"""So many worlds that each end of an error is met: nine of them are expected in its last 15 %."""
ERRORS = ErrorModel(
    pose=PoseError(0.004, 0.03), things={"jug": PoseError(0.008, 0.06)}, friction=0.4, mass=0.3, gripper_force=0.15,
    sensor=SensorErrors(0.2, 2.0, 0.03), latency=(0.01, 0.03), kinematics=0.0006, calibration=0.001, backlash=0.0007,
    hand_eye=PoseError(0.003, 0.02), size=0.0, centre=0.0, lean=0.0,
)  # fmt: skip
"""Every source but those of shapes (``test_twin_shapes``), and no size of one that is the size of another."""
TURNED = Pose.from_rotvec((0, 0, 0), (0.0, 0.0, 0.7))
SIGHT = Sight(Pose((0.4, 0.0, 0.9), (0.0, 1.0, 0.0, 0.0)), frozenset({"block"}))
HELD_BY = (("hangs_on", "tea", "hook/peg"), ("on", "block", "floor"))


def believed() -> World:
    """What stands, hangs, is fixed and is mounted, each of them turned and away from the origin; the jug has content."""
    hook = hanger("hook", Pose((0.8, 0.3, 0.45)) * Pose((0, 0, 0), (0.0, 0.0, 0.0, 1.0)))
    tea = replace(product("tea", Pose()), pose=hung(product("tea", Pose()), hook, depth=0.07))
    rough = jug("jug", Pose((0.45, -0.35, 0.20)) * TURNED, grains=9)
    rough = replace(
        rough, geoms=(replace(rough.geoms[0], friction=0.3), *rough.geoms[1:]),
        inertia=Inertia((0.01, 0.0, -0.02), (3e-4, 4e-4, 5e-4, 1e-5, 2e-5, 3e-5)),
    )  # fmt: skip
    closed = Pose((0.7, -0.7, 0.12)) * TURNED
    things = (
        table("floor", Pose((0.4, 0, 0)), size=(1.6, 1.6, 0.02)), table("shelf", Pose((0.45, -0.35, 0.15)) * TURNED, size=(0.3, 0.3, 0.02)),
        hook, tea, rough, block("block", Pose((0.5, 0.2, 0.03)) * TURNED), cabinet("cabinet", closed),
        drawer("drawer", closed, "cabinet", opened=0.05), door("gate", Pose((0.6, 0.7, 0.2)), opened=0.2),
    )  # fmt: skip
    return World(things, (RobotMount("arm", "ur5e"),))


WORLD = believed()
STANDS, FIXED, MOUNTED = ("block", "jug"), ("floor", "shelf", "hook", "cabinet"), ("drawer",)


def draw(seed: int, errors: ErrorModel = ERRORS, sight: Sight | None = None, world: World = WORLD) -> Twin:
    return draw_twin(world, HELD_BY, UR5E, errors, seed, sight)


@cache
def worlds(seen: bool = False) -> tuple[World, ...]:
    return tuple(draw(seed, sight=SIGHT if seen else None).world for seed in SEEDS)


def shift(real: World, name: str) -> tuple[float, float, float]:
    """How far a thing was moved, along the world's axes [m]."""
    x, y, z = np.subtract(real.thing(name).pose.position, WORLD.thing(name).pose.position).tolist()
    return (x, y, z)


def turn(real: World, name: str) -> tuple[float, float, float]:
    """How a thing was turned, about the world's axes [rad]."""
    was = Pose((0, 0, 0), WORLD.thing(name).pose.quaternion)
    return (Pose((0, 0, 0), real.thing(name).pose.quaternion) * was.inverse()).rotvec


def ratio(of: Callable[[Thing], float | None], name: str) -> Callable[[World], float]:
    """How many times as much of something a thing has."""
    return lambda real: (of(real.thing(name)) or 0.0) / (of(WORLD.thing(name)) or 1.0)


def spread(of: Callable[[World], float], real: Iterable[World]) -> tuple[float, float]:
    values = [of(world) for world in real]
    return min(values), max(values)


def reaches(found: tuple[float, float], low: float, high: float, share: float = 0.15) -> None:
    """The least and the largest are those, or inside of them by no more than a share of what lies between."""
    off, rounding = share * (high - low), 1e-9
    assert low - rounding <= found[0] <= low + off, f"at least {found[0]}, and {low} could have been"
    assert high - off <= found[1] <= high + rounding, f"at most {found[1]}, and {high} could have been"


NUMBERS: dict[str, tuple[Callable[[World], float], float, float]] = {
    **{f"{n}: friction": (ratio(lambda t: t.friction, n), 0.6, 1.4) for n in ("floor", "hook", "tea", "block", "drawer")},
    "jug: its own shape's friction": (ratio(lambda t: t.geoms[0].friction, "jug"), 0.6, 1.4),
    "jug: grains' friction": (ratio(lambda t: t.filling.friction if t.filling else 0.0, "jug"), 0.6, 1.4),
    "pads": (lambda w: w.physics.pad_friction / WORLD.physics.pad_friction, 0.6, 1.4),
    **{f"{n}: mass": (ratio(lambda t: t.mass, n), 0.7, 1.3) for n in ("tea", "jug", "block", "drawer")},
    "jug: grains' mass": (ratio(lambda t: t.filling.mass if t.filling else 0.0, "jug"), 0.7, 1.3),
    **{f"jug: moment {k}": (ratio(lambda t, k=k: t.inertia.moments[k] if t.inertia else 0.0, "jug"), 0.7, 1.3) for k in range(6)},  # type: ignore[misc]
    "grip force": (lambda w: w.disturbance.gripper_force, 0.85, 1.15),
    "latency": (lambda w: w.disturbance.latency, 0.01, 0.03),
    **{f"zero of joint {k}": (lambda w, k=k: w.disturbance.joint_zeros[k], -0.001, 0.001) for k in range(6)},  # type: ignore[misc]
    **{f"{n}: turned": (lambda w, n=n: turn(w, n)[2], -0.03, 0.03) for n in ("shelf", "hook", "block", "cabinet", "gate")},  # type: ignore[misc]
    "jug: turned": (lambda w: turn(w, "jug")[2], -0.06, 0.06),
}


@pytest.mark.parametrize("name", NUMBERS)
def test_a_number_comes_near_both_of_its_ends_and_goes_beyond_neither(name: str) -> None:
    number, low, high = NUMBERS[name]
    reaches(spread(number, worlds()), low, high)


BALLS: dict[str, tuple[Callable[[World], tuple[float, float, float]], float]] = {
    **{f"{n}: shifted": (lambda w, n=n: shift(w, n), 0.004) for n in FIXED},  # type: ignore[misc]
    "sensor: zero": (lambda w: w.disturbance.force_bias, 2.0),
    "sensor: as if weight": (lambda w: w.disturbance.force_turning, 2.0),
    "sensor: drift": (lambda w: w.disturbance.force_drift, 0.03),
}


@pytest.mark.parametrize("name", BALLS)
def test_a_vector_comes_near_the_surface_of_its_ball_on_every_side(name: str) -> None:
    vector, radius = BALLS[name]
    found = np.array([vector(world) for world in worlds()])
    far = np.linalg.norm(found, axis=1)
    assert 0.9 * radius <= far.max() <= radius + 1e-9
    assert ((far / radius) ** 3).mean() == pytest.approx(0.5, abs=0.06)
    for low, high in zip(found.min(axis=0), found.max(axis=0), strict=True):
        reaches((low, high), -radius, radius, 0.25)


def test_of_many_vectors_as_many_are_in_one_part_of_their_ball_as_in_any_other() -> None:
    shares = [np.linalg.norm(vector(world)) / radius for vector, radius in BALLS.values() for world in worlds()]
    assert np.mean(np.array(shares) ** 3) == pytest.approx(0.5, abs=0.03) and len(shares) == len(BALLS) * len(SEEDS)


@pytest.mark.parametrize(("name", "radius"), [("block", 0.004), ("jug", 0.008)])
def test_what_stands_is_shifted_where_it_stands(name: str, radius: float) -> None:
    found = np.array([shift(world, name)[:2] for world in worlds()])
    assert np.linalg.norm(found, axis=1).max() <= radius
    for low, high in zip(found.min(axis=0), found.max(axis=0), strict=True):
        reaches((low, high), -radius, radius, 0.25)


@pytest.mark.parametrize(("name", "under"), [("block", "floor"), ("jug", "shelf")])
def test_what_stands_goes_up_and_down_with_its_own_support(name: str, under: str) -> None:
    for real in worlds():
        assert shift(real, name)[2] == pytest.approx(shift(real, under)[2], abs=1e-12) != 0.0


@pytest.mark.parametrize("name", [*STANDS, *FIXED, "gate", "tea"])
def test_things_turn_about_the_vertical_alone(name: str) -> None:
    assert max(abs(v) for real in worlds() for v in turn(real, name)[:2]) < 1e-9


def test_what_is_mounted_is_where_its_carrier_has_it() -> None:
    before = WORLD.thing("cabinet").pose.inverse() * WORLD.thing("drawer").pose
    for real in worlds():
        after = real.thing("cabinet").pose.inverse() * real.thing("drawer").pose
        assert max(before.distance(after)) < 1e-6 and real.thing("drawer").joint == WORLD.thing("drawer").joint


def test_what_hangs_goes_with_its_peg_along_it_and_about_the_vertical_through_it() -> None:
    hole, peg = WORLD.thing("tea").feature("vrps:Hole"), WORLD.thing("hook").feature("vrps:Peg")
    assert hole is not None and peg is not None
    places, turns = [], []
    for real in worlds():
        on_peg = (real.thing("hook").pose * peg.pose).inverse() * real.thing("tea").pose * hole.pose
        was = (WORLD.thing("hook").pose * peg.pose).inverse() * WORLD.thing("tea").pose * hole.pose
        places.append(np.subtract(on_peg.position, was.position))
        turns.append(turn(real, "tea")[2] - turn(real, "hook")[2])
    aside = np.abs(places)[:, :2]
    assert aside.max() < 1e-9
    reaches((np.min(places), np.max(places)), -0.004, 0.004, 0.25)
    reaches((min(turns), max(turns)), -0.03, 0.03)


def test_links_are_off_in_every_direction_and_by_as_much_as_the_flange_may_be() -> None:
    links = np.array([world.disturbance.links for world in worlds()])
    assert np.linalg.norm(links, axis=2) == pytest.approx(np.full((len(SEEDS), 6), 0.0006 / math.sqrt(6)))
    for low, high in zip(links.min(axis=(0, 1)), links.max(axis=(0, 1)), strict=True):
        reaches((low * math.sqrt(6), high * math.sqrt(6)), -0.0006, 0.0006)


@pytest.mark.parametrize("joints", [0, 1, 2])
def test_few_links_are_off_by_as_much_together(joints: int) -> None:
    links = draw_twin(WORLD, (), replace(UR5E, joints=UR5E.joints[:joints]), ERRORS, 1).world.disturbance.links
    assert len(links) == joints and np.linalg.norm(links) == pytest.approx(0.0006 if joints else 0.0)


def test_what_is_the_same_in_every_twin() -> None:
    assert {w.disturbance.force_noise for w in worlds()} == {0.2} and {w.disturbance.backlash for w in worlds()} == {0.0007}


def test_what_was_seen_is_off_as_the_camera_is() -> None:
    """Shifted by its ball and by what its turn makes of the distance; turned about the vertical; what was not seen is not."""
    alone = replace(ERRORS.only("hand-eye"), hand_eye=PoseError(0.003, 0.0))
    found = np.array([shift(draw(seed, alone, SIGHT).world, "block") for seed in SEEDS])
    assert 0.9 * 0.003 <= np.linalg.norm(found[:, :2], axis=1).max() <= 0.003 and not found[:, 2].any()
    turning = [draw(seed, replace(alone, hand_eye=PoseError(0.0, 0.02)), SIGHT).world for seed in SEEDS]
    turns = [turn(real, "block")[2] for real in turning]
    told = draw(0, replace(alone, hand_eye=PoseError(0.0, 0.02)), SIGHT).draws[2]
    assert told.name == "camera: turned about z" and -math.radians(told.value) == pytest.approx(turns[0], rel=0.01)  # it looks down
    reaches((min(turns), max(turns)), -0.02, 0.02, 0.25)
    away = math.dist(SIGHT.camera.position, WORLD.thing("block").pose.position)
    far = [math.hypot(*shift(real, "block")[:2]) for real in turning]
    assert 0.85 * 0.02 * away <= max(far) <= 0.02 * away
    assert all(real.thing(n).pose == WORLD.thing(n).pose for real in turning for n in (*FIXED, "jug", "gate"))


def test_the_cameras_error_comes_before_the_things_own() -> None:
    own, both = worlds()[0], worlds(True)[0]
    assert shift(both, "jug") == shift(own, "jug") and shift(both, "block") != shift(own, "block")
    only = draw(0, ERRORS.only("hand-eye"), SIGHT).world
    assert turn(both, "block")[2] == pytest.approx(turn(own, "block")[2] + turn(only, "block")[2])


OWN: dict[str, set[str]] = {
    "poses": {"pose"}, "friction": {"friction", "shapes", "grains' friction", "pads"}, "arm": {"links", "zeros", "backlash"},
    "force sensor": {"noise", "bias", "turning", "drift"}, "latency": {"latency"}, "mass": {"mass", "inertia", "grains' mass"},
    "gripper force": {"grip"}, "hand-eye": {"pose"}, "size": {"sizes", "features", "pose", "inertia"}, "centre": {"centres"},
    "lean": {"pose"},
}  # fmt: skip
"""Source -> what of a world it changes."""


def aspects(world: World) -> dict[str, object]:
    """Everything of a world that an error can change, by its name; and what remains."""
    things, d = world.things, world.disturbance
    bare = [replace(t, pose=Pose(), geoms=(), features=(), friction=0.0, mass=t.mass and 1.0, inertia=None, filling=None) for t in things]
    return {
        "pose": [t.pose for t in things], "friction": [t.friction for t in things], "mass": [t.mass for t in things],
        "shapes": [[g.friction for g in t.geoms] for t in things], "inertia": [t.inertia for t in things],
        "grains' friction": [t.filling and t.filling.friction for t in things],
        "grains' mass": [t.filling and t.filling.mass for t in things], "pads": world.physics.pad_friction, "links": d.links,
        "zeros": d.joint_zeros, "backlash": d.backlash, "noise": d.force_noise, "bias": d.force_bias, "turning": d.force_turning,
        "sizes": [[replace(g, friction=None) for g in t.geoms] for t in things], "features": [t.features for t in things],
        "centres": dict(d.centres), "drift": d.force_drift, "latency": d.latency, "grip": d.gripper_force,
        "rest": (bare, [t.filling and t.filling.count for t in things],
                 replace(world.physics, pad_friction=0.0), world.robots),
    }  # fmt: skip


SHAPED = replace(ERRORS, size=0.02, centre=0.04, lean=0.03)
"""With errors of shape as well, which move what the others are measured by."""


@pytest.mark.parametrize("source", SOURCES)
def test_a_source_changes_what_is_its_own_and_nothing_else(source: str) -> None:
    before = aspects(WORLD)
    for seed in (1, 2, 3):
        after = aspects(draw(seed, SHAPED.only(source), SIGHT).world)
        assert {name for name, value in after.items() if value != before[name]} == OWN[source]


@pytest.mark.parametrize("source", SOURCES)
def test_without_a_source_all_that_is_its_own_is_as_it_was_believed(source: str) -> None:
    without = replace(SHAPED, **{name: getattr(NO_ERRORS, name) for name in SOURCES[source]})
    all_, some = (draw(4, errors, SIGHT) for errors in (SHAPED, without))
    assert [d for d in all_.draws if d.source != source] == list(some.draws)
    after, before, full = aspects(some.world), aspects(WORLD), aspects(all_.world)
    others = set().union(*(own for name, own in OWN.items() if name != source))  # several move things
    assert all(after[name] == before[name] for name in OWN[source] - others)
    assert all(after[name] == full[name] for name in after.keys() - OWN[source])


def test_errors_of_a_thing_that_there_is_not() -> None:
    with pytest.raises(UserError, match="about 'jog', which is no thing of this world; did you mean 'jug'"):
        draw(1, replace(ERRORS, things={"jog": PoseError(0.1)}))


def test_each_thing_draws_its_own() -> None:
    real = worlds()[0]
    assert len({round(t.friction / WORLD.thing(t.name).friction, 6) for t in real.things}) == len(real.things)
    heavy = [(t.mass or 0) / (WORLD.thing(t.name).mass or 1) for t in real.things if t.movable]
    assert len({round(h, 6) for h in heavy}) == len(heavy) > 3
    assert len({shift(real, name)[0] for name in FIXED}) == len(FIXED) and len(set(real.disturbance.joint_zeros)) == 6


def test_a_things_shapes_and_its_content_rub_as_it_does_and_weigh_as_it_does() -> None:
    for real in worlds():
        rub, heavy = NUMBERS["jug: its own shape's friction"][0](real), NUMBERS["jug: mass"][0](real)
        assert NUMBERS["jug: grains' friction"][0](real) == pytest.approx(rub) == ratio(lambda t: t.friction, "jug")(real)
        assert NUMBERS["jug: grains' mass"][0](real) == pytest.approx(heavy) == NUMBERS["jug: moment 3"][0](real)


def test_what_is_told_is_what_was_made() -> None:
    for seed in SEEDS[:5]:
        twin = draw(seed)
        assert all((d.value, d.size) == (round(d.value, 6), round(d.size, 6)) for d in twin.draws)
        told, real = {d.name: (d.value, d.size, d.unit) for d in twin.draws}, twin.world
        jug_, zeros = real.thing("jug"), real.disturbance.joint_zeros
        made = {
            "pads: friction": (100 * NUMBERS["pads"][0](real) - 100, 40, "%"),
            "jug: friction": (100 * jug_.friction / WORLD.thing("jug").friction - 100, 40, "%"),
            "block: mass": (100 * NUMBERS["block: mass"][0](real) - 100, 30, "%"),
            "grip force": (100 * real.disturbance.gripper_force - 100, 15, "%"),
            "latency": (1000 * real.disturbance.latency, 30, "ms"),
            "jug: turned": (math.degrees(turn(real, "jug")[2]), math.degrees(0.06), "deg"),
            **{f"shelf: {a}": (1000 * v, 4, "mm") for a, v in zip("xyz", shift(real, "shelf"), strict=True)},
            **{f"{j}: zero": (math.degrees(v), math.degrees(0.001), "deg") for j, v in zip(UR5E.joints, zeros, strict=True)},
            **{f"drift: {a}": (v, 0.03, "N/s") for a, v in zip("xyz", real.disturbance.force_drift, strict=True)},
            **{f"zero: {a}": (v, 2, "N") for a, v in zip("xyz", real.disturbance.force_bias, strict=True)},
            **{f"as if weight: {a}": (v, 2, "N") for a, v in zip("xyz", real.disturbance.force_turning, strict=True)},
        }
        for name, (value, size, unit) in made.items():
            assert told[name][:2] == pytest.approx((value, size), abs=2e-6) and told[name][2] == unit, name


@pytest.mark.parametrize("scale", [0.5, 2.0])
def test_a_scaled_world_is_off_by_so_many_times_as_much(scale: float) -> None:
    one, more = draw(7).world, draw(7, ERRORS.scaled(scale)).world
    for n in FIXED:
        assert shift(more, n) == pytest.approx(np.multiply(scale, shift(one, n)), abs=1e-12)
    for name, (number, *_) in NUMBERS.items():
        nought = number(WORLD) if "zero of" not in name else 0.0
        assert number(more) - nought == pytest.approx(scale * (number(one) - nought), abs=1e-9), name
    for name, (vector, _) in BALLS.items():
        assert vector(more) == pytest.approx(np.multiply(scale, vector(one)), abs=1e-9), name
    assert np.array(more.disturbance.links) == pytest.approx(scale * np.array(one.disturbance.links))
    assert (more.disturbance.force_noise, more.disturbance.backlash) == pytest.approx((0.2 * scale, 0.0007 * scale))


def test_a_share_is_never_less_than_the_least() -> None:
    far = [draw(seed, replace(ERRORS, friction=0.9, mass=0.9, gripper_force=0.9).scaled(2.0)).world for seed in SEEDS]
    for name in ("pads", "block: friction", "block: mass", "grip force"):
        low, high = spread(NUMBERS[name][0], far)
        assert low == pytest.approx(LEAST) and 2.6 < high <= 2.8


def test_friction_that_a_shape_has_not_of_its_own_stays_the_things() -> None:
    assert all(g.friction is None for real in worlds() for g in real.thing("jug").geoms[1:])


@pytest.mark.parametrize(("gap", "lifted"), [(0.009, True), (-0.009, True), (0.011, True), (0.3, True), (-0.011, False)])
def test_what_is_above_its_support_or_a_little_inside_stands_on_it(gap: float, lifted: bool) -> None:
    above = replace(WORLD, things=tuple(
        replace(t, pose=Pose((*t.pose.position[:2], t.pose.position[2] + gap), t.pose.quaternion)) if t.name == "block" else t
        for t in WORLD.things
    ))  # fmt: skip
    real = draw(1, world=above).world
    moved = real.thing("block").pose.position[2] - above.thing("block").pose.position[2]
    assert moved == pytest.approx(shift(real, "floor")[2] if lifted else 0.0, abs=1e-12)


def test_of_two_that_lie_under_it_the_higher_one_carries() -> None:
    sheet = table("sheet", Pose((0.5, 0.2, 0.002)), size=(0.2, 0.2, 0.002))
    beside = table("beside", Pose((0.5, 0.35, 0.003)), size=(0.2, 0.2, 0.002))  # ends 20 mm off the middle of what stands
    covered = replace(WORLD, things=(*WORLD.things[:1], sheet, beside, *WORLD.things[1:]))
    real = draw(1, world=covered).world
    assert shift(real, "block")[2] == pytest.approx(real.thing("sheet").pose.position[2] - 0.002, abs=1e-12)


EDGES = [((x, y), True) for x in (-0.5, 0.5) for y in (-0.25, 0.25)]
BESIDE = [((x, y), False) for x, y in ((0.51, 0.0), (-0.51, 0.0), (0.0, 0.26), (0.0, -0.26))]


@pytest.mark.parametrize("over", [-INSIDE, 0.2])
@pytest.mark.parametrize(("at", "stands"), [*EDGES, *BESIDE])
def test_up_to_its_edges_a_support_carries_what_is_over_it_or_a_little_inside(
    at: tuple[float, float], stands: bool, over: float
) -> None:
    plate = Thing("plate", "cram:Table", Pose((0.0, 0.0, -over)), (Geom("box", (0.5, 0.25, 0.0)),))
    post = Thing("post", "cram:Product", Pose((*at, 0.25)), (Geom("box", (0.1, 0.1, 0.25)),), mass=0.1)
    real = draw(1, replace(ERRORS, things={}), world=World((plate, post), WORLD.robots)).world
    lifted = real.thing("plate").pose.position[2] + over
    assert real.thing("post").pose.position[2] - 0.25 == pytest.approx(lifted if stands else 0.0, abs=1e-12)


def bridge(axis: int, over: float = 0.0, lower: float = 0.0, far: float = 1.0, thick: float = 0.0) -> bool:
    """Whether what stands between two rails, a plate of it over both, is carried by them.

    Args:
        over: how high its plate is above its foot; lower: how much lower one rail is than the other; far: where they are;
            thick: half of the plate's thickness [m].
    """
    along = (lambda x, y, z: (x, y, z)) if axis == 0 else (lambda x, y, z: (y, x, z))
    rails = tuple(Geom("box", along(0.25, 0.2, 0.0), Pose(along(x, 0.0, z))) for x, z in ((far, 0.0), (-far, -lower)))
    post = (Geom("box", (0.1, 0.1, 0.25), Pose((0.0, 0.0, 0.25))), Geom("box", along(0.75, 0.1, thick), Pose((0.0, 0.0, over + thick))))
    things = (Thing("rails", "cram:Table", Pose(), rails), Thing("post", "cram:Product", Pose(), post, mass=0.1))
    real = draw(1, replace(ERRORS, things={}), world=World(things, WORLD.robots)).world
    lifted = real.thing("rails").pose.position[2]
    assert lifted != 0.0 and real.thing("post").pose.position[2] in (lifted, 0.0)
    return real.thing("post").pose.position[2] == lifted


@pytest.mark.parametrize("axis", [0, 1])
def test_what_bridges_a_gap_is_carried_from_edge_to_edge(axis: int) -> None:
    assert bridge(axis) and bridge(axis, far=0.9) and not bridge(axis, far=1.001)
    assert bridge(axis, over=INSIDE) and not bridge(axis, over=INSIDE + 0.001), "what of it is low lies on them"
    assert bridge(axis, thick=0.0625), "however thick it is"
    assert bridge(axis, lower=INSIDE) and not bridge(axis, lower=INSIDE + 0.001), "on one alone it would fall"


def test_what_is_farther_inside_of_something_does_not_stand_on_it() -> None:
    plate = Thing("plate", "cram:Table", Pose((0.0, 0.0, INSIDE + 0.001)), (Geom("box", (0.5, 0.25, 0.0)),))
    post = Thing("post", "cram:Product", Pose((0.0, 0.0, 0.25)), (Geom("box", (0.1, 0.1, 0.25)),), mass=0.1)
    real = draw(1, replace(ERRORS, things={}), world=World((plate, post), WORLD.robots)).world
    assert real.thing("plate").pose.position[2] != plate.pose.position[2] and real.thing("post").pose.position[2] == 0.25


def test_what_has_no_shape_stands_on_nothing() -> None:
    ghost = Thing("ghost", "cram:Product", Pose((0.5, 0.2, 0.0)), (), mass=0.1)
    assert draw(1, replace(ERRORS, things={}), world=World((WORLD.things[0], ghost))).world.thing("ghost").pose.position[2] == 0.0


LYING = Geom("box", (0.03, 0.03, 0.05), Pose.from_rotvec((0, 0, 0), (math.pi / 2, 0, 0)))


@pytest.mark.parametrize("geom", [LYING, Geom("sphere", (0.03,))])
def test_how_deep_a_shape_reaches_is_asked_of_it_as_it_lies(geom: Geom) -> None:
    lying = Thing("lying", "cram:Product", Pose((0.5, 0.2, 0.03)), (geom,), mass=0.1)
    real = draw(1, world=World((WORLD.things[0], lying), WORLD.robots), errors=replace(ERRORS, things={})).world
    assert real.thing("lying").pose.position[2] - 0.03 == pytest.approx(shift(real, "floor")[2], abs=1e-12)
