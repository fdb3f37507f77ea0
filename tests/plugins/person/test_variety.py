"""Habits of people: they show in the recording, the task still comes off, and the same seed gives the same person."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from helpers.performances import performed
from msgspec.structs import replace

from cramlite import Engine, read_scenario
from cramlite.experiment.experiment_file import find_experiment
from cramlite.model import Rollout, World
from cramlite.scenario.worlds import build_world
from cramlite_plugins.episodes.detection.detect import detect
from cramlite_plugins.person import habits as people
from cramlite_plugins.person.habits import Habits, habits, with_tracking_loss

ENGINE = Engine()
FETCH, HANG = "take_off_hanger_varied", "hang_onto_hanger_varied"


@cache
def world(name: str, seed: int = 5) -> World:
    scenario = read_scenario(find_experiment(name).parent / "scenario.yaml")
    assert scenario.spec.record is not None
    built, _ = build_world(
        scenario, scenario.spec.record.things, scenario.spec.record.vary, ENGINE.knowledge, seed
    )
    return replace(built, robots=())


@cache
def shown(name: str, script: str, seed: int) -> Rollout:
    return performed(world(name), seed=seed, script=script)


def grasps(recorded: Rollout) -> int:
    return len(list(detect(recorded, "demo").of("state", ["cram:GraspState"])))


@pytest.mark.parametrize(("name", "script", "seed"), [("fetch_from_hanger", FETCH, 3), ("hang_onto_hanger", HANG, 4)])
def test_it_comes_off(name: str, script: str, seed: int) -> None:
    recorded = shown(name, script, seed)
    end, before = (recorded.poses["tea"][k, :3] for k in (-1, -10))
    assert np.linalg.norm(end - before) < 2e-3
    touching = {frozenset((t.a.split("/")[0], t.b.split("/")[0])) for t in recorded.touches[-1]}
    assert frozenset(("tea", "shopping_basket" if script == FETCH else "shop_hanger")) in touching


def test_a_seed_is_one_person_and_another_another() -> None:
    again = performed(world("fetch_from_hanger"), seed=3, script=FETCH)
    assert np.array_equal(again.poses["effector"], shown("fetch_from_hanger", FETCH, 3).poses["effector"])
    assert habits(np.random.default_rng(1)) == habits(np.random.default_rng(1))
    assert len({habits(np.random.default_rng(k)) for k in range(60)}) == 8  # every combination of three habits
    assert any(habits(np.random.default_rng(k), distracted=True).interrupted for k in range(9))
    assert not any(habits(np.random.default_rng(k)).interrupted for k in range(60))


@pytest.mark.heavy
@pytest.mark.parametrize(("own", "held"), [(Habits(False, False, False, 0.0), 1), (Habits(True, True, True, 0.0), 3)])
def test_taking_again_and_putting_down_are_seen(own: Habits, held: int, monkeypatch: pytest.MonkeyPatch) -> None:
    from cramlite_plugins.person import variety

    monkeypatch.setattr(variety, "habits", lambda _rng, distracted: own)
    recorded = performed(world("hang_onto_hanger"), seed=11, script=HANG)
    assert grasps(recorded) == held


def test_a_glitch_hides_the_thing_while_it_is_held_and_nothing_else() -> None:
    clean = replace(shown("fetch_from_hanger", FETCH, 3))
    odd = with_tracking_loss(clean, "tea", np.random.default_rng(0))
    lost = np.flatnonzero((odd.poses["tea"] != clean.poses["tea"]).any(axis=1))
    assert 1 < len(lost) <= people.BLIND[1] * 50 + 1 and np.all(np.diff(lost) == 1)
    assert all(not any("tea" in t.a + t.b for t in odd.touches[k]) for k in lost)
    assert all(odd.touches[k] == clean.touches[k] for k in range(len(clean.times)) if k not in set(lost))
    assert np.array_equal(odd.poses["effector"], clean.poses["effector"])
    nothing = replace(clean, touches=tuple(() for _ in clean.touches))
    assert with_tracking_loss(nothing, "tea", np.random.default_rng(0)) is nothing


def test_a_recording_that_went_wrong_is_kept() -> None:
    place = world("fetch_from_hanger")
    slippery = replace(place, physics=replace(place.physics, pad_friction=0.0))
    recorded = performed(slippery, seed=3, script=FETCH)
    assert (recorded.outcome, recorded.reason) == ("failed", "'tea' is not in 'shopping_basket' at the end")
    assert (shown("fetch_from_hanger", FETCH, 3).outcome, shown("fetch_from_hanger", FETCH, 3).reason) == ("finished", "")
    first = shown("fetch_from_hanger", FETCH, 3).poses["effector"][:50]
    assert np.array_equal(recorded.poses["effector"][:50], first)  # the first try, no other
