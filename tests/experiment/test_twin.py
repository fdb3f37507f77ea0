"""Twins: as far off as was asked for, never further, the same for the same seed, and what hangs goes on to hang."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec import json
from properties import examples

from cramlite import Engine, read_scenario
from cramlite.experiment.spec import find_experiment, read_experiment
from cramlite.experiment.twin import OffSpec, TwinSpec, twin
from cramlite.model import World
from cramlite.plugin import UserError

EXPERIMENT = read_experiment(find_experiment("fetch_from_hanger"))
SCENARIO = read_scenario(EXPERIMENT.beside(EXPERIMENT.spec.scenario))
ENGINE = Engine()
WORLD = ENGINE.setting(SCENARIO).world


def drawn(seed: int, spec: TwinSpec = EXPERIMENT.spec.twin) -> World:
    return twin(SCENARIO, WORLD, spec, ENGINE.knowledge.models, seed, 6)


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


def test_the_same_seed_draws_the_same_twin_and_another_seed_another() -> None:
    assert drawn(5) == drawn(5) != drawn(6)


def test_nothing_asked_for_nothing_off() -> None:
    still = drawn(3, TwinSpec())
    assert [t.friction for t in still.things] == [t.friction for t in WORLD.things]
    assert all(
        np.allclose(a.pose.position, b.pose.position, atol=1e-9)
        for a, b in zip(still.things, WORLD.things, strict=True)
    )
    assert still.disturbance.force_noise == 0 and not np.any(still.disturbance.links)


def test_a_twin_of_a_thing_that_there_is_not() -> None:
    with pytest.raises(UserError, match=r"displaces 'hok'.*did you mean 'hook'"):
        drawn(1, TwinSpec(things=(OffSpec(thing="hok", position=0.1, angle=0.0),)))


def test_a_twin_survives_its_file() -> None:
    assert json.decode(json.encode(drawn(8)), type=World) == drawn(8)
