"""Twins: as far off as was asked for, never further, the same for the same seed; what hangs goes on to hang, what stands to stand."""

from __future__ import annotations

import math

import numpy as np
import pytest
from helpers.properties import examples
from hypothesis import given
from hypothesis import strategies as st
from msgspec import json
from msgspec.structs import replace

from cramlite import Engine, find_scenario, read_scenario
from cramlite.experiment.demonstrations.spec import read_experiment
from cramlite.experiment.experiment_file import find_experiment
from cramlite.model import ErrorModel, Pose, PoseError, SensorErrors, World
from cramlite.model.twins.error_model import NO_ERRORS, SOURCES
from cramlite.model.twins.twin_drawing import LEAST
from cramlite.plugin import UserError
from cramlite.scenario.twin import Twin, draw_twin
from cramlite.scenario.twin_places import Sight

EXPERIMENT = read_experiment(find_experiment("fetch_from_hanger"))
ENGINE = Engine()
SETTING = ENGINE.setting(read_scenario(EXPERIMENT.beside(EXPERIMENT.spec.scenario)))
WORLD, ROBOT = SETTING.world, SETTING.robot
PUBLISHED = EXPERIMENT.spec.twin.errors(NO_ERRORS, ROBOT.sensor_errors)
STANDING = ENGINE.setting(read_scenario(find_scenario("compound/pick_and_place"))).world
DRAWER = ENGINE.setting(read_scenario(find_scenario("compound/from_drawer"))).world


def twin(seed: int, errors: ErrorModel = PUBLISHED, world: World = WORLD, sight: Sight | None = None) -> Twin:
    relations = SETTING.relations if world is WORLD else ()
    return draw_twin(world, relations, ROBOT, errors, seed, sight)


def drawn(seed: int, errors: ErrorModel = PUBLISHED, world: World = WORLD) -> World:
    return twin(seed, errors, world).world


@examples(40)
@given(st.integers(0, 2**31 - 1))
def test_a_twin_is_as_far_off_as_was_asked_for(seed: int) -> None:
    real = drawn(seed)
    hook, before = real.thing("hook"), WORLD.thing("hook")
    metres, radians = hook.pose.distance(before.pose)
    assert metres <= 0.002 and radians <= math.radians(1) + 1e-9
    for thing in real.things:
        believed = WORLD.thing(thing.name)
        assert 0.9 <= thing.friction / believed.friction <= 1.1
        assert thing.mass is None or 0.9 <= thing.mass / (believed.mass or 1) <= 1.1
    assert real.thing("basket").pose == WORLD.thing("basket").pose
    assert len(real.disturbance.links) == 6
    assert np.linalg.norm(real.disturbance.force_drift) <= 0.02
    assert abs(float(np.sum(np.square(real.disturbance.links))) - 0.0003**2) < 1e-12
    assert real.disturbance.latency == real.disturbance.backlash == 0 and not any(real.disturbance.joint_zeros)


@examples(40)
@given(st.integers(0, 2**31 - 1), st.floats(0.1, 4.0))
def test_the_scale_multiplies_every_number(seed: int, scale: float) -> None:
    one, more = twin(seed, ErrorModel()), twin(seed, ErrorModel().scaled(scale))
    for a, b in zip(one.draws, more.draws, strict=True):
        assert b.size == pytest.approx(scale * a.size, abs=2e-6) and b.value == pytest.approx(scale * a.value, abs=1e-5)
    here, there = one.world.disturbance, more.world.disturbance
    assert there.force_noise == pytest.approx(scale * here.force_noise)
    assert there.backlash == pytest.approx(scale * here.backlash)
    assert all(abs(d.share) <= 1 + 1e-6 for d in more.draws)
    assert all(t.friction >= LEAST * WORLD.thing(t.name).friction for t in more.world.things)


@examples(40)
@given(st.integers(0, 2**31 - 1))
def test_what_hangs_goes_on_to_hang(seed: int) -> None:
    real = drawn(seed)
    product, hanger = real.thing("coffee"), real.thing("hook")
    hole, peg = product.feature("vrps:Hole"), hanger.feature("vrps:Peg")
    assert hole is not None and peg is not None
    x, y, depth = (hanger.pose * peg.pose).inverse().apply(product.pose.apply(hole.pose.position))
    assert math.hypot(x, y) == pytest.approx(hole.size["diameter"] / 2 - peg.size["radius"], abs=1e-4)
    assert abs(depth - 0.08) <= 0.003 + 1e-6


@examples(40)
@given(st.integers(0, 2**31 - 1))
def test_what_stands_goes_up_and_down_with_what_it_stands_on(seed: int) -> None:
    real = drawn(seed, replace(ErrorModel(), size=0.0, lean=0.0), STANDING)
    lifted = {n: real.thing(n).pose.position[2] - STANDING.thing(n).pose.position[2] for n in ("floor", "block", "shelf")}
    assert lifted["block"] == pytest.approx(lifted["floor"]) and lifted["floor"] != lifted["shelf"]


@examples(40)
@given(st.integers(0, 2**31 - 1))
def test_what_is_mounted_moves_with_what_carries_it(seed: int) -> None:
    _stays_mounted(DRAWER, seed)


def test_so_it_does_where_a_file_lists_it_first() -> None:
    reversed_things = replace(DRAWER, things=tuple(reversed(DRAWER.things)))
    assert drawn(1, ErrorModel(), reversed_things).things[0].pose != reversed_things.things[0].pose
    _stays_mounted(reversed_things, 1)


def _stays_mounted(world: World, seed: int) -> None:
    real = drawn(seed, ErrorModel(), world)
    assert any(t.joint is not None and t.joint.parent for t in world.things)
    for thing in world.things:
        if thing.joint is not None and thing.joint.parent:
            before = world.thing(thing.joint.parent).pose.inverse() * thing.pose
            after = real.thing(thing.joint.parent).pose.inverse() * real.thing(thing.name).pose
            assert max(before.distance(after)) < 1e-6


def test_a_camera_that_is_mounted_askew_moves_all_that_it_saw_together() -> None:
    sight = Sight(Pose((0.3, 0.1, 0.9), (0.0, 1.0, 0.0, 0.0)), frozenset({"block"}))
    errors = ErrorModel().only("hand-eye")
    blind, seen = twin(3, errors, STANDING), twin(3, errors, STANDING, sight)
    assert blind.world.thing("block").pose == STANDING.thing("block").pose and not blind.draws
    metres, radians = seen.world.thing("block").pose.distance(STANDING.thing("block").pose)
    assert 0 < metres < 0.003 + 0.9 * math.radians(0.5) and radians < math.radians(0.5) + 1e-9
    assert seen.world.thing("shelf").pose == STANDING.thing("shelf").pose


@pytest.mark.parametrize("source", SOURCES)
def test_a_source_draws_the_same_with_and_without_the_others(source: str) -> None:
    both = [d for d in twin(5, ErrorModel()).draws if d.source == source]
    assert list(twin(5, ErrorModel().only(source)).draws) == both


def test_the_same_seed_draws_the_same_twin_and_another_seed_another() -> None:
    assert drawn(5) == drawn(5) != drawn(6)


def test_nothing_asked_for_nothing_off() -> None:
    for world in (WORLD, STANDING, DRAWER):
        still = twin(3, NO_ERRORS, world)
        assert not still.draws and still.world == world


def test_the_sensor_is_that_of_the_robot_unless_the_model_says_it() -> None:
    axia = replace(ROBOT, sensor_errors=SensorErrors(noise=0.1, precision=0.0))
    assert draw_twin(WORLD, (), axia, ErrorModel(), 1).world.disturbance.force_noise == 0.1
    said = replace(ErrorModel(), sensor=SensorErrors(noise=2.0))
    assert draw_twin(WORLD, (), axia, said, 1).world.disturbance.force_noise == 2.0


def test_a_twin_of_a_thing_that_there_is_not() -> None:
    with pytest.raises(UserError, match=r"about 'hok'.*did you mean 'hook'"):
        drawn(1, replace(NO_ERRORS, things={"hok": PoseError(0.1)}))


def test_a_twin_survives_its_file() -> None:
    assert json.decode(json.encode(drawn(8)), type=World) == drawn(8)
