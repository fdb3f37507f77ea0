"""People with two hands: what one passes to the other both hold by contact alone, and reading makes one hand of them."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import pytest
from helpers.performances import performed
from msgspec.structs import replace

from cramlite import Engine, read_scenario
from cramlite.experiment.experiment_file import find_experiment
from cramlite.model import Episode, Rollout, World
from cramlite.scenario.worlds import build_world
from cramlite_plugins.episodes.detection.detect import detect
from cramlite_plugins.episodes.formats.neem import read_neem, write_neem
from cramlite_plugins.episodes.repair.two_hands import handovers, one_handed
from cramlite_plugins.person import variety
from cramlite_plugins.person.habits import Habits, habits
from cramlite_plugins.person.person import Person

ENGINE = Engine()
SCRIPTS = {"fetch_from_hanger": "take_off_hanger_distracted", "hang_onto_hanger": "hang_onto_hanger_distracted"}


@cache
def world(name: str) -> World:
    scenario = read_scenario(find_experiment(name).parent / "hard.yaml")
    assert scenario.spec.record is not None
    things, vary = scenario.spec.record.things, scenario.spec.record.vary
    return replace(build_world(scenario, things, vary, ENGINE.knowledge, 7)[0], robots=())


@cache
def shown(name: str, other_hand: str) -> Rollout:
    with pytest.MonkeyPatch.context() as patch:
        own = Habits(False, False, False, 0.0, other_hand=other_hand)
        patch.setattr(variety, "habits", lambda _rng, distracted: own)
        return performed(world(name), seed=7, script=SCRIPTS[name])


def grasps(episode: Episode) -> list[tuple[str, str]]:
    return [(e.roles["gripper"], e.roles["object"]) for e in episode.of("state", ["cram:GraspState"])]


@pytest.mark.heavy
@pytest.mark.parametrize(
    ("name", "order"), [("fetch_from_hanger", ("hand", "other_hand")), ("hang_onto_hanger", ("other_hand", "hand"))]
)
def test_a_thing_is_handed_over(name: str, order: tuple[str, str]) -> None:
    recorded = detect(shown(name, "hand_over"), "demo")
    (found,) = handovers(recorded)
    assert (found.given.roles["gripper"], found.taken.roles["gripper"]) == order and found.thing == "tea"
    one = one_handed(recorded)
    assert grasps(one) == [("hand", "tea")]
    (held,) = one.of("state", ["cram:GraspState"])
    assert (held.start, held.end) == (found.given.start, found.taken.end)
    before, after = found.time - 0.5, found.time + 0.5
    for time, who in ((before, order[0]), (after, order[1])):
        assert one.pose_at("hand", time) == recorded.pose_at(who, time)
        assert one.pose_at("hand/left", time) == recorded.pose_at(f"{who}/left", time)
    assert one.pose_at("other_hand", after) == recorded.pose_at(order[0], after)
    times, opening = one.extras["times"], one.extras["opening"]
    while_held = opening[(times > found.time - 0.05) & (times < found.taken.end - 0.05)]
    assert np.ptp(while_held) < 0.002  # fingers that take over do not open or close


def test_it_is_read_as_what_one_hand_does(tmp_path: Path) -> None:
    recorded = detect(shown("fetch_from_hanger", "hand_over"), "demo")
    write_neem(recorded, tmp_path / "demo")
    assert grasps(read_neem(tmp_path / "demo")) == [("hand", "tea"), ("other_hand", "tea")]  # type: ignore[arg-type]
    episode = ENGINE.read_episode(tmp_path / "demo")
    assert "read 'hand' and 'other_hand' as one hand" in [r.what for r in episode.repairs]
    tasks = [m.task for m in next(iter(ENGINE.interpret(episode).sequences())).matches]
    assert [t for t in tasks if t in ("soma:Grasping", "artm:ExtractHoleFromPeg", "artm:Ungrasping")] == [
        "soma:Grasping", "artm:ExtractHoleFromPeg", "artm:Ungrasping",
    ]  # fmt: skip


def test_a_hand_that_is_at_something_else_stays_another_hand() -> None:
    rollout = shown("fetch_from_hanger", "busy")
    recorded = detect(rollout, "demo")
    assert set(grasps(recorded)) == {("hand", "tea"), ("other_hand", "honey")}
    assert one_handed(recorded) is recorded
    height = rollout.poses["honey"][20:, 2]  # once it stands
    assert height.max() > height[0] + 0.02 and abs(height[-1] - height[0]) < 0.003  # up, and put back


def test_what_is_only_touched_by_the_other_is_not_handed_over() -> None:
    recorded = detect(shown("fetch_from_hanger", "hand_over"), "demo")
    given, taken = recorded.of("state", ["cram:GraspState"])
    short = replace(taken, end=given.end - 0.1)
    episode = replace(recorded, events=tuple(short if e == taken else e for e in recorded.events))
    assert not list(handovers(episode)) and one_handed(episode) is episode


def test_a_pinch_without_friction_takes_nothing_over() -> None:
    place = world("fetch_from_hanger")
    slippery = replace(place, physics=replace(place.physics, pad_friction=0.0))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(
            variety, "habits", lambda _rng, distracted: Habits(False, False, False, 0.0, other_hand="hand_over")
        )
        recorded = detect(performed(slippery, seed=7, script=SCRIPTS["fetch_from_hanger"]), "demo")
    assert not list(handovers(recorded))


def test_who_has_one_hand_cannot_change_hands() -> None:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(variety, "habits", lambda _rng, distracted: Habits(False, False, False, 0.0))
        patch.setattr(variety, "pull_off", lambda person, _scene: Person.change_hands(person))
        with pytest.raises(ValueError, match="one hand"):
            performed(world("fetch_from_hanger"), seed=7, script="take_off_hanger_varied")


def test_every_habit_of_both_hands_comes_up() -> None:
    drawn = [habits(np.random.default_rng(k), distracted=True).other_hand for k in range(60)]
    assert {"", "busy", "hand_over"} == set(drawn) and min(map(drawn.count, set(drawn))) > 9
    assert {habits(np.random.default_rng(k)).other_hand for k in range(60)} == {""}
