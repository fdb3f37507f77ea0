"""A scripted person, real contacts: what physics makes of it."""

from __future__ import annotations

import math

import numpy as np
import pytest
from helpers.performances import performed
from msgspec.structs import replace

from cramlite.model import Episode, Physics, Pose, Rollout, World
from cramlite.plugin import UserError
from cramlite_plugins.episodes.detection.detect import detect
from cramlite_plugins.objects import products_and_fixtures as models

SIZES = ((0.04, 0.025, 0.15), (0.06, 0.05, 0.10), (0.08, 0.02, 0.12))


def shelf(seed: int, **physics: float) -> World:
    """A hanger within 50 mm and 20 degrees of its place, one of three products on it, a basket, a table."""
    rng = np.random.default_rng(seed)
    half = (math.pi + math.radians(rng.uniform(-20, 20))) / 2
    place = np.array([0.86, 0.0, 0.45]) + rng.uniform(-0.05, 0.05, 3)
    hanger = models.hanger("hanger", Pose(tuple(place), (math.cos(half), 0, 0, math.sin(half))))
    product = models.product("product", Pose(), SIZES[seed % 3], rng.uniform(0.1, 0.6))
    product = replace(product, pose=models.hung(product, hanger, rng.uniform(0.04, 0.10)))
    basket, table = models.basket("basket", Pose((0.45, -0.42, 0.0))), models.table("table", Pose((0.5, 0, 0)))
    return World((hanger, product, basket, table), physics=Physics(**physics))  # type: ignore[arg-type]


def in_basket(recorded: Rollout) -> bool:
    x, y, z = recorded.world.thing("basket").pose.inverse().apply(recorded.poses["product"][-1, :3])
    still = np.linalg.norm(recorded.poses["product"][-1, :3] - recorded.poses["product"][-10, :3]) < 1e-3
    return bool(abs(x) < 0.19 and abs(y) < 0.14 and z < 0.15 and still)


def spans(episode: Episode, type_: str, *fillers: str) -> list[tuple[float, float]]:
    return [(e.start, e.end) for e in episode.of("state", [type_]) if tuple(e.roles.values()) == fillers]


@pytest.mark.heavy
@pytest.mark.parametrize("seed", range(5))
def test_the_product_ends_in_the_basket(seed: int) -> None:
    recorded = performed(shelf(seed), seed=seed)
    found = detect(recorded, "demo")
    assert in_basket(recorded)
    (grasp,) = spans(found, "cram:GraspState", "hand", "product")
    peg = spans(found, "soma:ContactState", "hanger/peg", "product/hole")
    support = spans(found, "soma:SupportState", "basket/floor", "product")
    assert peg[0][0] == 0.0
    assert grasp[0] < peg[-1][1] < grasp[1], "it left the peg in the hand"
    assert support[-1][0] >= grasp[1] - 0.1, "the hand let go, then the basket carried it"
    at = found.pose_at("product", grasp[1])
    assert at is not None
    x, y, _ = recorded.world.thing("basket").pose.inverse().apply(at.position)
    assert abs(x) < 0.2
    assert abs(y) < 0.15


@pytest.mark.heavy
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_without_friction_the_same_script_grasps_nothing(seed: int) -> None:
    recorded = performed(shelf(seed, pad_friction=0.0), seed=seed)
    found = detect(recorded, "demo")
    assert not in_basket(recorded)
    assert found.of("state", ["cram:GraspState"]) == ()
    assert spans(found, "soma:ContactState", "hand", "product"), "it was pinched all the same"
    last = recorded.times[-1]
    assert spans(found, "soma:SupportState", "hanger/peg", "product")[-1][1] > last, "it hangs where it hung"


@pytest.mark.heavy
def test_the_seed_is_the_only_variety() -> None:
    one, two, other = (performed(shelf(7), seed=s) for s in (7, 7, 8))
    assert np.array_equal(one.poses["effector"], two.poses["effector"])
    assert one.touches == two.touches
    assert not np.array_equal(one.poses["effector"][:100], other.poses["effector"][:100])


@pytest.mark.heavy
def test_the_hand_trembles_but_does_not_jump() -> None:
    recorded = performed(shelf(3), seed=3)
    step = np.linalg.norm(np.diff(recorded.poses["effector"][:, :3], axis=0), axis=1) / np.diff(recorded.times)
    assert step.max() < 1.5
    assert np.count_nonzero(step) == len(step)


def test_what_is_missing_is_named() -> None:
    world = shelf(0)
    with pytest.raises(UserError, match="Cavity"):
        performed(World(world.things[:2]), seed=0)
    with pytest.raises(UserError, match="mm off the peg"):
        performed(world.moved({"product": Pose((0.2, 0.2, 0.2))}), seed=0)
