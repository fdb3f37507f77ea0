"""Debouncing: flicker goes, everything else stays, and every repair can be undone."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cramlite.model import Episode, Event
from cramlite_plugins.episodes.repair.flicker import debounce, undo


def contact(start: float, end: float, a: str = "hand", b: str = "cup") -> Event:
    return Event(f"{a}_{b}_{start}", "soma:ContactState", "state", start, end, {"a": a, "b": b})


def recorded(*events: Event) -> Episode:
    frame = (Event("all", "soma:PhysicalAction", "action", 0.0, 20.0),)
    return Episode("x", (), tuple(sorted((*frame, *events), key=lambda e: (e.start, e.end, e.id))))


def states(episode: Episode) -> list[tuple[float, float]]:
    return [(e.start, e.end) for e in episode.of("state")]


def test_flicker_becomes_one_state_and_is_reported() -> None:
    flicker = [contact(1 + 0.1 * k, 1.03 + 0.1 * k) for k in range(30)]
    smooth = debounce(recorded(*flicker))
    assert np.allclose(states(smooth), [(1.0, 3.93)])
    (repair,) = smooth.repairs
    assert "30 x soma:ContactState of hand and cup" in repair.what
    assert len(repair.removed) == 30


def test_the_order_of_contact_partners_does_not_matter_but_that_of_support_does() -> None:
    assert len(states(debounce(recorded(contact(1, 2), contact(2.1, 3, "cup", "hand"))))) == 1
    support = [
        Event(f"s{k}", "soma:SupportState", "state", 1.0 + k, 1.9 + k, roles)
        for k, roles in enumerate([{"supporter": "a", "supportee": "b"}, {"supporter": "b", "supportee": "a"}])
    ]
    assert len(states(debounce(recorded(*support)))) == 2


def test_noise_is_dropped_but_a_touch_is_kept() -> None:
    assert states(debounce(recorded(contact(5, 5.02)))) == []
    assert states(debounce(recorded(contact(5, 5.2)))) == [(5, 5.2)]


def test_a_real_interruption_stays() -> None:
    assert states(debounce(recorded(contact(1, 2), contact(2.5, 3)))) == [(1, 2), (2.5, 3)]


def test_states_that_the_recording_cuts_off_are_kept() -> None:
    assert states(debounce(recorded(contact(0, 0.02), contact(19.99, 20.0)))) == [(0, 0.02), (19.99, 20.0)]


def test_an_object_that_vanishes_for_a_moment_stays_grasped() -> None:
    grasps = [
        Event(f"g{k}", "cram:GraspState", "state", a, b, {"gripper": "hand", "object": "cup"})
        for k, (a, b) in enumerate([(1.0, 4.0), (4.2, 8.0)])
    ]
    assert states(debounce(recorded(*grasps))) == [(1.0, 8.0)]


def test_settings_must_make_sense() -> None:
    with pytest.raises(ValueError, match="must not be negative"):
        debounce(recorded(), gap=-1)


TIMES = st.lists(st.tuples(st.integers(0, 1000), st.integers(1, 60)), max_size=12, unique_by=lambda t: t[0])


@given(TIMES)
def test_repairs_are_reversible_and_nothing_that_is_left_flickers(times: list[tuple[int, int]]) -> None:
    before = recorded(*(contact(a / 100, (a + d) / 100) for a, d in times))
    after = debounce(before)
    assert debounce(after).events == after.events
    for one, two in itertools.pairwise(states(after)):
        assert two[0] - one[1] > 0.3
    for repair in reversed(after.repairs):
        after = undo(after, repair)
    assert after.events == before.events
    assert after.repairs == ()


def test_only_repairs_of_the_episode_can_be_undone() -> None:
    smooth = debounce(recorded(contact(5, 5.02)))
    with pytest.raises(ValueError, match="cannot be undone"):
        undo(recorded(), smooth.repairs[0])
