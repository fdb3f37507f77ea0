"""Friction of pairs against experiments: a block on an incline, a block between two pads; and who is a pair at all."""

from __future__ import annotations

import math
import random

import mujoco
import pytest
from helpers.standard import ROBOTS, standard_world, standing_world
from msgspec.structs import replace

from cramlite.model import Physics, Pose, Thing, World, pair_friction
from cramlite_plugins.objects.furniture import cabinet, drawer
from cramlite_plugins.objects.products_and_fixtures import block, table
from cramlite_plugins.simulation.model.compile import Compiled, compile_world

G = 9.81
SIDE = (0.05, 0.05, 0.05)


def slid(on: float, of: float, tilt: float) -> float:
    """How far a block of friction ``of`` slides down a plane of friction ``on``, tilted by ``tilt`` [rad], in 0.5 s [m]."""
    incline = Pose.from_rotvec((0, 0, 0), (0, tilt, 0))
    plane = replace(table("plane", Pose(), size=(2.0, 2.0, 0.02), friction=on), pose=incline)
    top = plane.features[0].pose.position[2]
    item = block("block", incline * Pose((0, 0, top + SIDE[2] / 2)), size=SIDE, friction=of)
    compiled = compile_world(World((plane, item)), {})
    data = compiled.data()
    for _ in range(250):
        mujoco.mj_step(compiled.model, data)
    return item.pose.distance(compiled.pose(data, "block"))[0]


@pytest.mark.parametrize(("on", "of"), [(0.3, 0.3), (0.8, 0.2), (0.2, 0.8), (1.0, 0.05), (0.4, 0.6)])
def test_a_block_slides_from_the_friction_angle_on(on: float, of: float) -> None:
    angle = math.atan(pair_friction(on, of))
    assert slid(on, of, 0.95 * angle) < 0.001
    steeper = 1.1 * angle
    expected = 0.5 * G * (math.sin(steeper) - pair_friction(on, of) * math.cos(steeper)) * 0.5**2
    assert slid(on, of, steeper) == pytest.approx(expected, rel=0.15, abs=0.003)


def sank(pad: float, of: float, mass: float, force: float) -> float:
    """How far a block slips down between two pads that press with ``force`` [N] each, in 0.5 s [m]."""
    item = block("block", Pose((0.4, 0.0, 0.5)), size=SIDE, mass=mass, friction=of)
    compiled = compile_world(World((item,), (), Physics(pad_friction=pad)), {}, hand=True)
    data, hand, model = compiled.data(), compiled.hand, compiled.model
    assert hand is not None
    hand.teleport(model, data, Pose(item.pose.position, hand.rest.quaternion), opening=SIDE[1] + 0.002)
    hand.set_target(data, Pose(item.pose.position, hand.rest.quaternion), opening=0.0)
    model.actuator_forcerange[hand.gripper] = (-2 * force, 2 * force)
    model.opt.gravity[:] = 0
    for _ in range(250):
        mujoco.mj_step(model, data)
    model.opt.gravity[2] = -G
    before = hand.pose(data).inverse() * compiled.pose(data, "block")
    for _ in range(250):
        mujoco.mj_step(model, data)
    return before.distance(hand.pose(data).inverse() * compiled.pose(data, "block"))[0]


@pytest.mark.parametrize(("pad", "of", "force"), [(0.9, 0.6, 20.0), (0.9, 0.05, 40.0), (0.1, 0.6, 30.0), (0.5, 0.5, 10.0)])
def test_two_pads_hold_what_weighs_less_than_their_friction(pad: float, of: float, force: float) -> None:
    most = 2 * pair_friction(pad, of) * force / G
    assert sank(pad, of, 0.88 * most, force) < 0.002
    assert sank(pad, of, 1.1 * most, force) > 0.01


@pytest.mark.parametrize("seed", range(6))
def test_twins_of_the_friction_of_either_differ_in_what_they_hold(seed: int) -> None:
    """Drawn as a twin draws them, half as much or more: each holds what its own pair carries, whatever was believed."""
    rng = random.Random(seed)
    pad, of, force = 0.9 * rng.uniform(0.5, 1.5), 0.6 * rng.uniform(0.5, 1.5), 15.0
    believed = 2 * pair_friction(0.9, 0.6) * force / G
    carries = pair_friction(pad, of) / pair_friction(0.9, 0.6)
    for share in (0.6, 0.8, 1.0, 1.2):
        if not 0.88 < share / carries < 1.1:
            assert (sank(pad, of, share * believed, force) < 0.005) == (share < carries)


@pytest.mark.parametrize(("pad", "of"), [(0.9, 0.0), (0.0, 0.9)])
def test_without_friction_of_either_nothing_is_held(pad: float, of: float) -> None:
    assert sank(pad, of, 0.1, 100.0) > 0.05


def pairs(compiled: Compiled) -> dict[frozenset[str], int]:
    """The explicit pairs, by their geoms."""
    model = compiled.model
    names = [(model.geom(int(model.pair_geom1[p])).name, model.geom(int(model.pair_geom2[p])).name) for p in range(model.npair)]
    return {frozenset(n): p for p, n in enumerate(names)}


def test_a_pair_with_a_pad_keeps_what_holds_a_grasp() -> None:
    compiled = compile_world(standing_world(), ROBOTS)
    found, model = pairs(compiled), compiled.model
    for pad in ("arm/left_pad1", "arm/right_pad2"):
        pair = found[frozenset((pad, "product/body/0"))]
        assert model.pair_dim[pair] == 4
        assert tuple(model.pair_solref[pair]) == (0.004, 1.0)
        assert tuple(model.pair_friction[pair]) == pytest.approx((0.72, 0.72, 0.005, 0.0001, 0.0001))
        assert model.pair_margin[pair] == model.pair_gap[pair] == 0.0
        assert tuple(model.pair_solimp[pair]) == tuple(model.geom(pad).solimp)


def test_things_of_one_friction_need_no_pair_and_others_do() -> None:
    found = pairs(compile_world(standard_world(), ROBOTS))
    assert frozenset(("hanger/peg/0", "product/hole/1")) in found or any("hanger/peg" in " ".join(k) for k in found)
    assert not any({n.split("/")[0] for n in k} == {"table", "product"} for k in found)


def test_who_cannot_meet_is_no_pair() -> None:
    at = Pose((0.75, 0.1, 0.35))
    things: tuple[Thing, ...] = (table("table", Pose()), cabinet("cabinet", at), drawer("drawer", at, "cabinet"))
    owners = {frozenset(n.split("/")[0] for n in k) for k in pairs(compile_world(replace(standing_world(), things=things), ROBOTS))}
    assert frozenset(("drawer", "cabinet")) not in owners, "what is mounted does not rub on what carries it"
    assert frozenset(("table", "cabinet")) not in owners, "furniture meets no furniture"
    assert frozenset(("arm", "drawer")) in owners
    assert not any(len(o) == 1 for o in owners)


def test_a_planning_model_has_no_pairs() -> None:
    assert compile_world(standing_world(), ROBOTS, planning=True).model.npair == 0


def test_links_and_finger_backs_take_the_friction_of_what_they_touch() -> None:
    model = compile_world(standing_world(), ROBOTS).model
    assert {float(model.geom(n).friction[0]) for n in ("arm/gripper/0", "arm/left_finger/0")} == {0.0}
