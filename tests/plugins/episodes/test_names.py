"""One namespace: a thing has one name however it is written; things that only look alike stay apart."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.recorded_people import RIGHT, pouring, read
from hypothesis import given
from hypothesis import strategies as st

from cramlite.model import Entity, Episode, Event, Track
from cramlite_plugins.episodes.repair.names import local, one_namespace

IRI = "http://knowrob.org/kb/map.owl#"
TRACK = Track(np.arange(3.0), np.tile([0.5, 0, 1, 1, 0, 0, 0.0], (3, 1)))


def recording(frame: str, **more: Track) -> Episode:
    """A map that calls a cup ``Cup_1``, an event about it, and a frame of another name."""
    entities = (Entity("Cup_1", ("soma:Cup",)), Entity(frame, ()), *(Entity(n, ()) for n in more))
    event = Event("e", "soma:Reaching", "action", 0, 1, {"object": "Cup_1"})
    return Episode("x", entities, (event,), {frame: TRACK, **more}, None)


@pytest.mark.parametrize("frame", [f"{IRI}Cup_1", f"<{IRI}Cup_1>", "map:Cup_1", "/Cup_1", "SM_Cup_1", "cup_1"])
def test_a_frame_is_the_thing_that_a_map_describes(frame: str) -> None:
    found = one_namespace(recording(frame))
    assert [e.name for e in found.entities] == ["Cup_1"] and found.entity("Cup_1").types == ("soma:Cup",)
    assert list(found.tracks) == ["Cup_1"]
    assert any(frame in r.what and "Cup_1" in r.what for r in found.repairs)


@pytest.mark.parametrize("frame", [f"{IRI}Cup_2", "SM_Cup_12", "Cup_1/handle", "Saucer_1"])
def test_another_name_is_another_thing(frame: str) -> None:
    assert set(one_namespace(recording(frame)).tracks) == {local(frame)}


def test_two_things_that_were_tracked_are_two() -> None:
    both = recording("SM_Cup_1", cup_1=TRACK)
    assert one_namespace(both) is both


def test_two_things_of_a_map_are_two() -> None:
    both = Episode("x", (Entity("SM_Cup", ("soma:Cup",)), Entity("cup", ("soma:Cup",))), ())
    assert one_namespace(both) is both


def test_an_iri_alone_is_shortened_for_its_slashes_would_make_it_a_part() -> None:
    alone = Episode("x", (Entity(f"{IRI}Cup_1", ()),), (), {f"{IRI}Cup_1": TRACK, f"{IRI}Jug": TRACK})
    assert set(one_namespace(alone).tracks) == {"Cup_1", "Jug"}


@pytest.mark.parametrize(("name", "part"), [("hand_tip", True), ("handThumb3", True), ("handle_tip", False), ("hand_bag", False)])
def test_what_is_named_after_a_hand_is_a_part_only_where_it_is_named_like_one(name: str, part: bool) -> None:
    found = one_namespace(Episode("x", (Entity("hand", ("soma:Hand",)), Entity(name, ())), (), {}, "hand"))
    assert (found.entity(name).part_of == "hand") == part


@given(st.text(st.characters(categories=("L", "N"), include_characters="_.- "), min_size=1, max_size=12))
def test_a_plain_name_is_its_own_local_name(name: str) -> None:
    assert local(name) == name
    assert local(IRI + name) == name


def test_a_finger_is_a_part_of_its_hand_and_nothing_to_reach_for() -> None:
    plain = pouring()
    finger = f"{RIGHT}_index_03"
    bent = plain[RIGHT].copy()
    bent[:, 1] += 0.1
    found = read({**plain, finger: bent})
    assert found.entity(finger).part_of == RIGHT
    assert finger not in {f for e in found.events for f in e.roles.values()}
