"""The force of a learned motion is that of the demonstrations' contact record; without a record there is none."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from cramlite import Engine
from cramlite.interpretation.timeline import Timeline
from cramlite.learning.shown_force import MARGIN, Pressed, ShownForce, shown_force
from cramlite.learning.span import Span
from cramlite.model import Entity, Episode, Event, Floats

TAXONOMY = Engine().knowledge.taxonomy
TIMES = np.arange(0.0, 8.0, 0.02)
WEIGHT, FRICTION, PEAK = 0.6, 0.5, 3.0


def wiped(press: float, *, free: bool = True, record: bool = True) -> Episode:
    """A sponge is in the hand from 1 s on, on the board from 3 to 7 s, pressed on with a friction along x and one short peak.

    Args:
        press: force on the board [N].
        free: whether the sponge touches nothing from 1 to 3 s.
        record: whether the hand's wrench is recorded.
    """
    wrench = np.zeros((len(TIMES), 6))
    held, down = TIMES >= 1.0, (TIMES >= 3.0) & (TIMES < 7.0)
    wrench[held, 2] = WEIGHT
    wrench[down, 0], wrench[down, 2] = -FRICTION * press, WEIGHT - press
    wrench[(TIMES >= 4.0) & (TIMES < 4.1), 2] -= PEAK
    events = (
        Event("held", "cram:GraspState", "state", 1.0, 8.0, {"gripper": "hand", "object": "sponge"}),
        Event("down", "soma:ContactState", "state", 3.0, 7.0, {"a": "sponge", "b": "board"}),
        *([] if free else [Event("beside", "soma:ContactState", "state", 0.0, 8.0, {"a": "wall", "b": "sponge"})]),
    )
    entities = tuple(Entity(n, (c,)) for n, c in (("hand", "soma:Hand"), ("sponge", "soma:Item"), ("board", "cram:Table"), ("wall", "")))
    return Episode("wiping", entities, events, {}, "hand", extras={"times": TIMES} | ({"wrench": wrench} if record else {}))


def found(*episodes: Episode, start: float = 2.0) -> ShownForce | None:
    return shown_force([Span(Timeline(e, TAXONOMY), start, 7.5) for e in episodes], [("sponge", "board")] * len(episodes))


def turned(episode: Episode, rotation: Floats) -> Episode:
    wrench = episode.extras["wrench"].copy()
    wrench[:, :3] = wrench[:, :3] @ rotation
    return replace(episode, extras={**episode.extras, "wrench": wrench})


@given(st.floats(1.0, 50.0))
def test_the_weight_is_none_of_it_and_a_peak_raises_only_the_limit(press: float) -> None:
    force = found(wiped(press))
    assert force is not None and force.press_n == pytest.approx(press, abs=0.06)
    peak = math.hypot(press + PEAK, FRICTION * press)
    assert force.examples[0].peak_n == pytest.approx(peak, abs=0.06) and force.limit_n == math.ceil(MARGIN * force.examples[0].peak_n)


def test_twice_the_force_is_twice_the_press() -> None:
    once, twice = found(wiped(10.0)), found(wiped(20.0))
    assert once is not None and twice is not None and twice.press_n == pytest.approx(2 * once.press_n)


def test_the_middle_one_counts_and_who_records_nothing_does_not() -> None:
    force = found(wiped(10.0), wiped(14.0), wiped(99.0, record=False), wiped(30.0))
    assert force is not None and force.press_n == 14.0 and [e.press_n for e in force.examples] == [10.0, 14.0, 30.0]
    assert force.spread_n == pytest.approx(8.6, abs=0.1)


@pytest.mark.parametrize(("episode", "why"), [
    (wiped(10.0, record=False), "nothing is recorded"),
    (wiped(10.0, free=False), "nothing says what the sponge weighs"),
    (turned(wiped(10.0), np.roll(np.eye(3), 1, axis=0)), "the axes are not the world's"),
    (turned(wiped(10.0), -np.eye(3)), "it is what acts on the hand"),
    (replace(wiped(10.0), extras={"times": TIMES, "wrench": np.full((len(TIMES), 6), np.nan)}), "the sensor failed"),
    (replace(wiped(10.0), extras={"times": TIMES, "wrench": np.zeros((3, 6))}), "the times are not those of the wrench"),
    (replace(wiped(10.0), effector=None), "nobody holds it"),
])  # fmt: skip
def test_without_a_record_that_can_be_read_there_is_no_force(episode: Episode, why: str) -> None:
    assert found(episode) is None, why


def test_what_is_pressed_outside_the_interval_does_not_count() -> None:
    assert found(wiped(10.0), start=7.2) is None


def test_a_force_has_examples() -> None:
    force = ShownForce((Pressed("one (1 to 2 s)", 12.0, 20.0),))
    assert (force.press_n, force.spread_n, force.limit_n) == (12.0, 0.0, 25.0)
