"""People whom nobody asked: recordings of poses alone are read as a person who watches them would say."""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from helpers.recorded_people import (
    LEFT,
    RIGHT,
    START,
    Recording,
    carrying_a_tray,
    dropped,
    halved,
    noisy,
    pouring,
    pouring_twice,
    pouring_with_both_hands,
    pouring_with_either_hand,
    read,
    shaking,
    without,
)
from msgspec.structs import replace

from cramlite import Engine
from cramlite.model import Episode, Event
from cramlite.plugin import UserError

ENGINE = Engine()
REAL = Path(__file__).resolve().parents[3] / "shared" / "data" / "neem_real"
Said = list[tuple[str, ...]]


def best(episode: Episode) -> Said:
    """The tasks of the best sequence, each with the fillers of its roles; the hand is "hand"."""
    sequence = next(ENGINE.interpret(episode).sequences())
    hands = {episode.effector}
    return [(m.task.split(":")[1], *("hand" if f in hands else f for f in m.roles.values())) for m in sequence.matches]


def taken(thing: str, stood: str) -> Said:
    return [("Grasping", thing), ("PickingUp", thing, stood)]


def put_back(thing: str, stands: str) -> Said:
    return [("PuttingDown", thing, stands), ("Releasing", thing, stands), ("Retracting", thing, "hand")]


def poured(cup: str, bowl: str) -> Said:
    """What a person says who watches: she takes the cup, lifts it, carries it to the bowl, pours, and puts it back."""
    on = f"support({cup})"
    return [*taken(cup, on), ("Transporting", cup, bowl), ("Pouring", cup, bowl), *put_back(cup, on)]


def shaken(salt: str, plate: str) -> Said:
    """She takes the salt, lifts it, carries it to the plate, shakes it, and puts it back."""
    on = f"support({salt})"
    return [*taken(salt, on), ("Transporting", salt, plate), ("Shaking", salt), *put_back(salt, on)]


CASES: dict[str, tuple[Callable[[], Recording], Said]] = {
    "pouring": (pouring, poured("cup", "SM_TestBowl")),
    "twice": (pouring_twice, [*poured("cup_a", "SM_TestBowl"), *poured("cup_b", "SM_TestBowl")]),
    "either hand": (pouring_with_either_hand, [*poured("cup_a", "SM_TestBowl"), *poured("cup_b", "SM_TestBowl")]),
    "both hands": (pouring_with_both_hands, poured("cup", "SM_TestBowl")),
    "shaking": (shaking, shaken("salt_shaker", "test_plate")),
    "tray": (carrying_a_tray, [*taken("tray", "support(tray)"), *put_back("tray", "support(tray)_2")]),
}
recorded = cache(lambda name: CASES[name][0]())


@pytest.mark.parametrize("name", CASES)
def test_the_best_sequence_is_what_a_person_says(name: str) -> None:
    assert best(read(recorded(name))) == CASES[name][1]


@pytest.mark.parametrize("change", [dropped, noisy, halved])
@pytest.mark.parametrize("name", CASES)
@pytest.mark.parametrize("seed", range(2))
def test_the_best_sequence_survives_what_goes_wrong_with_recordings(
    name: str, change: Callable[[Recording, np.random.Generator], Recording], seed: int
) -> None:
    assert best(read(change(recorded(name), np.random.default_rng(seed)))) == CASES[name][1]


@pytest.mark.heavy
@pytest.mark.parametrize("change", [dropped, noisy, halved])
@pytest.mark.parametrize("name", CASES)
def test_in_19_of_20_draws(name: str, change: Callable[[Recording, np.random.Generator], Recording]) -> None:
    same = [best(read(change(recorded(name), np.random.default_rng(s)))) == CASES[name][1] for s in range(100, 120)]
    assert sum(same) >= 19


@pytest.mark.parametrize("hand", [RIGHT, LEFT])
@pytest.mark.parametrize("name", ["pouring", "twice", "both hands", "tray"])
def test_the_best_sequence_survives_a_missing_hand(name: str, hand: str) -> None:
    """Of the hand that acts as well: what rises and stays up is held by somebody."""
    found = read(without(hand)(recorded(name), np.random.default_rng(0)))
    assert best(found) == CASES[name][1]


def test_a_hand_of_which_there_is_not_even_a_name_is_added() -> None:
    found = read({n: r for n, r in recorded("pouring").items() if n != RIGHT})
    assert best(found) == CASES["pouring"][1] and found.effector == "unseen_hand"
    assert any("unseen_hand" in r.what for r in found.repairs)
    assert read(recorded("pouring")).known("unseen_hand") is None


# Each with a recording that looks alike and must not be read so


def test_a_cup_that_is_held_over_a_bowl_upright_is_not_poured() -> None:
    said = best(read(pouring(tilts=False)))
    assert "Pouring" not in [s[0] for s in said] and ("PickingUp", "cup", "support(cup)") in said


def test_a_cup_that_is_tilted_empty_is_not_known_to_be_poured_into_the_bowl() -> None:
    plain = pouring(count=0)
    assert ("Pouring", "cup", "SM_TestBowl") not in best(read(plain))


def test_three_swings_are_no_shaking() -> None:
    assert "Shaking" not in [s[0] for s in best(read(shaking(swings=1)))]


def test_contents_are_one_entity_that_is_counted_and_never_handled() -> None:
    found = read(pouring(spilled=2))
    assert found.entity("contents(cup)").properties["count"] == 6
    assert not any(e.name.startswith("particle") for e in found.entities)
    counts = {v: found.extras[f"count:contents(cup):{v}"] for v in ("cup", "SM_TestBowl")}
    assert (counts["cup"][0], counts["SM_TestBowl"][0]) == (6, 0)
    assert (counts["cup"][-1], counts["SM_TestBowl"][-1]) == (0, 4)
    assert any("2 are beside all vessels" in r.why for r in found.repairs)
    handled = {f for a in ENGINE.interpret(found).actions for m in a.matches for f in m.roles.values()}
    assert not [f for f in handled if "contents" in f or "particle" in f]


def test_two_things_alike_that_stand_still_are_two_things() -> None:
    plain = recorded("pouring")
    found = read({n: r for n, r in plain.items() if n not in ("particle22", "particle23")})
    assert found.known("contents(SM_Dish)") is None and found.known("particle20") is not None
    assert read(plain).known("contents(SM_Dish)") is not None


def test_two_things_that_a_cup_carries_are_its_contents() -> None:
    found = read(pouring(count=2))
    assert found.entity("contents(cup)").properties["count"] == 2
    assert found.extras["count:contents(cup):SM_TestBowl"][-1] == 2
    assert best(found) == poured("cup", "SM_TestBowl")


def test_what_is_taken_out_of_a_vessel_is_a_thing_of_its_own() -> None:
    """Three balls lie in a dish; the hand takes one out."""
    cup = recorded("pouring")["cup"].copy()
    low = {f"ball{k}": np.add(cup[:1], [0, 0.03 * k, 0, 0, 0, 0, 0, 0]) for k in (2, 3)}
    dish = cup[:1]
    taken_out = {**recorded("pouring"), "ball1": cup, **low, "SM_Box": dish}
    only = {k: v for k, v in taken_out.items() if not k.startswith("particle") and k != "cup"}
    assert ("Grasping", "ball1") in best(read(only))


def stuck(count: int = 6, plate: bool = True) -> Recording:
    """A cup is poured; first one grain goes along with the hand, and falls on the table on the way."""
    recording = pouring(count=count)
    hand = recording[RIGHT]
    grain = hand.copy()
    grain[hand[:, 0] > START + 2.0, 1:] = grain[hand[:, 0] <= START + 2.0][-1, 1:]
    grain[hand[:, 0] > START + 2.2, 3] = 0.9
    home = hand[:1].copy()
    beside = {f"particle{k}": np.add(home, [0, 0.01 * k - 0.3, 0, 0, 0, 0, 0, 0]) for k in (31, 32, 33)} if plate else {}
    return {**recording, "particle30": grain, **beside, **({"SM_Plate": home} if plate else {})}


@pytest.mark.parametrize("plate", [True, False])
def test_a_grain_that_sticks_to_a_hand_is_contents(plate: bool) -> None:
    found = read(stuck(plate=plate))
    assert found.known("particle30") is None and found.known("contents(SM_Plate)" if plate else "contents(cup)") is not None
    assert best(found) == poured("cup", "SM_TestBowl")


def test_a_thing_that_a_hand_takes_where_no_others_of_its_kind_are_carried_is_its_own() -> None:
    found = read(stuck(count=0))
    assert any(e.type == "cram:GraspState" and e.roles["object"] == "particle30" for e in found.events)


def test_vessels_of_which_there_are_many_alike_are_no_contents() -> None:
    recording = recorded("pouring")
    more = {f"bowl{k}": np.add(recording["SM_TestBowl"], [0, 0, 0.5 + k, 0, 0, 0, 0, 0]) for k in (2, 3, 4)}
    names = {"SM_TestBowl": "bowl1", "cup": "bowl5"}
    found = read({**{names.get(n, n): r for n, r in recording.items()}, **more})
    assert found.known("bowl3") is not None and found.entity("contents(bowl5)").properties["count"] == 6
    assert best(found) == poured("bowl5", "bowl1")


def test_what_only_steadies_is_said_to_be_left_out() -> None:
    found = read(recorded("both hands"))
    (left,) = [r for r in found.repairs if "left out that" in r.what]
    assert LEFT in left.what and "cup" in left.what and "steadies" in left.why and left.removed
    assert not any("left out that" in r.what for r in read(recorded("pouring")).repairs)


def test_hands_that_take_turns_are_said_to_be_read_as_one() -> None:
    said = [r.what for r in read(recorded("either hand")).repairs if "as one hand" in r.what]
    assert len(said) == 1 and LEFT in said[0] and RIGHT in said[0]
    assert not any("as one hand" in r.what for r in read(recorded("twice")).repairs)


def test_what_is_not_known_is_said_and_costs() -> None:
    """No bowl has a shape, so nobody knows whether the cup was over it."""
    found = ENGINE.interpret(read(recorded("pouring")))
    (match,) = [m for a in found.actions for m in a.named("soma:Pouring")]
    assert match.unknown == ("no shape of 'SM_TestBowl'",)
    assert "not known 1.0" in next(found.sequences()).reason


def test_candidates_are_few_and_fast() -> None:
    found = ENGINE.interpret(read(recorded("twice")))
    start = time.process_time()
    listed = list(found.sequences())
    assert 1 < len(listed) <= 256
    assert (time.process_time() - start) / len(listed) < 0.1


def test_stamps_are_those_of_the_recording() -> None:
    assert read(recorded("pouring")).span[0] == START


# The real recordings, as docs/explanation/interpretation.md says them


@pytest.mark.skipif(not REAL.exists(), reason="the real recordings are not here")
@pytest.mark.parametrize(
    ("name", "said"),
    [("KitchenLabNEEM", poured("cup", "SM_BigBowl")), ("ShakingMotionNEEM", shaken("salt_container", "breakfast_plate"))],
)
def test_a_real_recording_is_what_a_person_says(name: str, said: Said) -> None:
    start = time.process_time()
    assert best(ENGINE.read_episode(REAL / name)) == said
    assert time.process_time() - start < 3


def again(recording: Recording, after: float) -> Recording:
    """Everything done a second time, from where the things stood at first."""
    later = np.array([after, 0, 0, 0, 0, 0, 0, 0])
    return {name: np.concatenate([rows, rows + later]) for name, rows in recording.items()}


@pytest.mark.parametrize("make", [shaking, pouring])
def test_what_is_done_twice_is_read_twice(make: Callable[[], Recording]) -> None:
    once = best(read(make()))
    assert best(read(again(make(), 25.0))) == once * 2
    assert once[1][0] == "PickingUp" and "PuttingDown" in [s[0] for s in once]


@pytest.mark.parametrize(("unit", "speed"), [(100.0, "m/s"), (1000.0, "m/s")])
def test_lengths_in_another_unit_are_refused(unit: float, speed: str) -> None:
    wide = {name: rows * [1, unit, unit, unit, 1, 1, 1, 1] for name, rows in shaking().items()}
    with pytest.raises(UserError, match=f"{speed}; lengths are metres: if these are millimetres or centimetres, convert them"):
        ENGINE.interpret(read(wide))


def action(type_: str, start: float = 0.0, end: float = 14.0) -> Event:
    return Event(f"{type_}_{start:g}", type_, "action", START + start, START + end, {"object": "salt_shaker"})


@pytest.mark.parametrize("type_", ["soma:PhysicalAction", "cram:Shaking"])
def test_an_action_without_steps_is_read_from_motion(type_: str) -> None:
    episode = read(shaking(), events=(action(type_),))
    assert best(episode) == best(read(shaking()))
    assert any(r.what == f"left out 1 action ({type_})" and r.removed for r in episode.repairs)


def test_an_action_that_motion_says_nothing_of_stays() -> None:
    still = {name: rows[:1] for name, rows in shaking().items()}
    assert [e.type for e in read(still, events=(action("cram:Shaking"),)).events] == ["cram:Shaking"]


def test_actions_with_their_steps_stay_as_they_were_written_down() -> None:
    steps = (action("soma:Grasping", 2.2, 3.0), action("soma:PickingUp", 3.0, 3.6))
    assert read(shaking(), events=steps).events == steps


def without_grasps(recording: Recording) -> tuple[Event, ...]:
    return tuple(e for e in read(recording).events if e.kind == "state" and e.type != "cram:GraspState")


def test_grasps_that_nobody_recorded_are_inferred_beside_other_states() -> None:
    known = without_grasps(shaking())
    episode = read(shaking(), events=known)
    assert best(episode)[:2] == best(read(shaking()))[:2]
    assert [e.roles["object"] for e in episode.of("state", ["cram:GraspState"])] == ["salt_shaker"]
    assert any(r.what == "inferred 1 grasps" for r in episode.repairs)


def test_a_hand_that_holds_nothing_gets_no_grasp() -> None:
    known = without_grasps(shaking())
    away = {RIGHT: shaking()[RIGHT] + [0, 2.0, 0, 0, 0, 0, 0, 0], "salt_shaker": shaking()["salt_shaker"][:1]}
    assert read(away, events=known).events == known


def test_events_that_count_from_the_start_are_dated() -> None:
    steps = (action("soma:Grasping", 2.2, 3.0), action("soma:PickingUp", 3.0, 3.6))
    counted = tuple(replace(e, start=e.start - START, end=e.end - START) for e in steps)
    episode = read(shaking(), events=counted)
    assert [e.start for e in episode.events] == pytest.approx([e.start for e in steps], abs=1e-3)
    assert any(r.what == "dated 2 events" for r in episode.repairs)
    late = tuple(replace(e, start=e.start + 500.0, end=e.end + 500.0) for e in counted)
    assert read(shaking(), events=late).events == late
