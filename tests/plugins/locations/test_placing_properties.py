"""Places in drawn worlds: each that is offered passes all checks again, touches nothing in physics, and is the same when it is asked for
again."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from typing import Any

import mujoco
import numpy as np
import pytest
from helpers.placing import believed, context_of, into, on, placed
from helpers.properties import examples
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from cramlite.model import Belief, Location, Place, Pose, Thing
from cramlite.plugin import Grounding, Refused, Unresolvable
from cramlite_plugins.locations.kinds import ground
from cramlite_plugins.locations.placing.checks.order import first_objection
from cramlite_plugins.locations.placing.driver import CHECKS
from cramlite_plugins.locations.placing.query import Placement, queries
from cramlite_plugins.locations.placing.ways_out import prepared
from cramlite_plugins.objects.products_and_fixtures import basket, block
from cramlite_plugins.simulation.model.compile import compile_world

MOST, SAMPLES = 4, 400
"""Places that are checked of a query, and its samples."""
SHELF = ((0.45, -0.35), 0.16)
"""Middle of the shelf and the height of its upper side [m]."""
seeds = st.integers(0, 2**32 - 1)


def on_shelf(seed: int) -> tuple[Location, Belief]:
    """A shelf with up to four blocks, and what is asked of a place on it."""
    rng = np.random.default_rng(seed)
    things = list[Thing]()
    for k in range(rng.integers(0, 5)):
        size = tuple(float(v) for v in rng.uniform(0.02, 0.09, 3))
        x, y = np.asarray(SHELF[0]) + rng.uniform(-0.13, 0.13, 2)
        at = Pose.from_rotvec((float(x), float(y), SHELF[1] + size[2] / 2), (0.0, 0.0, float(rng.uniform(0, np.pi))))
        things.append(block(f"block_{k}", at, size))
    asked: list[dict[str, Any]] = [{}]
    if things:
        asked += [{"near": "block_0", "within": 0.15}, {"left_of": "block_0"}, {"in_front_of": "block_0", "near": "block_0"}]
    return on("shelf", **asked[rng.integers(len(asked))]), believed(*things)


def into_box(seed: int) -> tuple[Location, Belief]:
    """A basket of any size with up to two blocks in it."""
    rng = np.random.default_rng(seed)
    width, depth, high = (float(v) for v in rng.uniform((0.1, 0.1, 0.05), (0.3, 0.3, 0.15)))
    box = basket("box", Pose((0.4, 0.35, 0.0)), (width, depth, high))
    lying = [
        block(f"block_{k}", Pose((0.4 + s * width / 4, 0.35 + s * depth / 4, 0.04)), (0.03, 0.03, 0.05))
        for k, s in enumerate((1, -1)[: rng.integers(0, 3)])
    ]
    return into("box"), believed(box, *lying)


def offered(location: Location, belief: Belief) -> list[Grounding]:
    """The first places of a query; none where none is left."""
    found = ground(location, belief, replace(context_of(belief), samples=SAMPLES))
    return list(itertools.islice(_places(iter(found)), MOST))


def _places(found: Iterator[Grounding | Refused]) -> Iterator[Grounding]:
    try:
        yield from (a for a in found if isinstance(a, Grounding))
    except Unresolvable:
        return


def objections(place: Place, location: Location, belief: Belief) -> list[str]:
    """What the checks of a relation say, asked anew; nothing if one of the targets has none."""
    asked, filters = queries(location, belief, context_of(belief)), CHECKS[location.relation]
    spot = Placement("again", _thing(place, belief), place.pose, place.before, place.release.height_m)
    said = [first_objection(spot, target, filters) for target in prepared(asked)]
    return [] if None in said else [no.reason for no in said if no is not None]


def _thing(place: Place, belief: Belief) -> Pose:
    assert belief.held is not None
    return place.pose * belief.held.tcp_to_thing


def touching(pose: Pose, belief: Belief) -> set[str]:
    """What physics finds in contact with the block at a pose, without the robot."""
    things = tuple(replace(t, pose=pose) if t.name == "it" else t for t in belief.world.things)
    compiled = compile_world(replace(belief.world, things=things, robots=()), {})
    data = compiled.data()
    mujoco.mj_forward(compiled.model, data)
    bodies = [{compiled.model.body(compiled.model.geom_bodyid[g]).name for g in c.geom} for c in data.contact]
    return {name for pair in bodies if "it" in pair for name in pair - {"it"}}


@pytest.mark.parametrize("drawn", [on_shelf, into_box], ids=["on", "in"])
@examples(40)
@given(seed=seeds)
def test_every_place_passes_all_checks_again_and_touches_nothing(drawn: Any, seed: int) -> None:
    location, belief = drawn(seed)
    for answer in offered(location, belief):
        assert isinstance(answer.value, Place)
        assert objections(answer.value, location, belief) == [], answer.key
        assert touching(placed(answer), belief) == set(), answer.key


@pytest.mark.parametrize("drawn", [on_shelf, into_box], ids=["on", "in"])
@examples(8)
@given(seed=seeds)
def test_the_same_query_offers_the_same_places(drawn: Any, seed: int) -> None:
    location, belief = drawn(seed)
    assert [(a.key, a.cost, a.value) for a in offered(location, belief)] == [(a.key, a.cost, a.value) for a in offered(*drawn(seed))]


@pytest.mark.parametrize(("drawn", "said"), [(on_shelf, "not supported"), (into_box, "not inside")])
def test_a_place_beside_its_target_does_not_pass_again(drawn: Any, said: str) -> None:
    location, belief, (answer, *_) = next(f for f in ((*drawn(seed), offered(*drawn(seed))) for seed in range(20)) if f[2])
    assert isinstance(answer.value, Place)
    aside = Pose((0.3, 0.0, 0.0))
    beside = replace(answer.value, pose=aside * answer.value.pose, before=aside * answer.value.before)
    against = objections(beside, location, belief)
    assert against and all(said in no for no in against)


def test_a_block_inside_another_is_seen_to_touch_it() -> None:
    _, belief = on_shelf(1)
    inside = believed(block("tin", Pose((0.45, -0.35, 0.2)), (0.05, 0.05, 0.08)))
    assert "tin" in touching(Pose((0.46, -0.34, 0.22)), inside)
    assert touching(Pose((0.45, -0.35, 0.6)), belief) == set()


@pytest.mark.heavy
def test_most_drawn_worlds_have_places() -> None:
    """Else nothing would be checked."""
    for drawn in (on_shelf, into_box):
        assert sum(bool(offered(*drawn(seed))) for seed in range(8)) >= 4
