"""Long searches say what they do, end when their seconds are spent, and tell the nearest miss."""

from __future__ import annotations

import time

import pytest

from cramlite import Budget, Engine, Goal, Trace, find_scenario, how_it_ended, read_scenario
from cramlite.planning.budget import is_late, until_late
from cramlite.planning.heartbeat import heartbeat, interrupted_text, searching_text
from cramlite.plugin import UserError


def _trace() -> Trace:
    trace = Trace()
    trace.add(0, "grasp(tin)", "", "chosen", "grasps", "from above", kind="location")
    for _ in range(3):
        trace.add(1, "grasp(tin)", "", "refused", "grasps", "60 mm wide", kind="location")
    trace.add(1, "grasp(tin)", "", "refused", "reach", "out of reach", kind="location")
    return trace


def test_a_silent_search_says_what_it_does() -> None:
    lines: list[str] = []
    with heartbeat(_trace(), lines.append, every=0.1) as heard:
        heard("candidate 1")
        time.sleep(0.35)
    assert lines[0] == "candidate 1" and len(lines) >= 3
    assert lines[1] == (
        "searching: grasp(tin), tried 1 times in candidate 1; 5 decisions, 4 refused, most often (3): 60 mm wide [grasps]"
    )
    count = len(lines)
    time.sleep(0.2)
    assert len(lines) == count  # it ends with the search


def test_a_search_that_speaks_is_not_interrupted_by_lines() -> None:
    lines: list[str] = []
    with heartbeat(_trace(), lines.append, every=0.3) as heard:
        for _ in range(6):
            heard("trying")
            time.sleep(0.05)
    assert set(lines) == {"trying"}


def test_what_is_said_of_a_search_that_has_not_begun_or_was_interrupted() -> None:
    assert "no question" in searching_text(Trace())
    assert "nothing was refused yet" in interrupted_text(Trace())
    assert "nearest miss: candidate 1, grasp(tin)" in interrupted_text(_trace())


def test_seconds_end_a_search_and_it_says_so() -> None:
    trace, late = Trace(), Budget(seconds=1)
    stop = until_late(late, trace, lambda: False)
    assert not stop() and not is_late(trace)
    time.sleep(1.05)
    assert stop() and stop()
    assert [e.numbers for e in trace.entries] == [{"seconds": 1}]
    assert "budget seconds = 1" in how_it_ended(trace.entries)
    assert until_late(Budget(), trace, lambda: True)()


def test_a_resolution_ends_when_its_seconds_are_spent() -> None:
    engine, trace = Engine(), Trace()
    setting = engine.setting(read_scenario(find_scenario("hang_onto_hanger")))
    began = time.monotonic()
    list(engine.resolve(Goal(("coffee on hook",)), setting=setting, trace=trace, budget=Budget(seconds=1)))
    assert is_late(trace) and time.monotonic() - began < 30
    assert "seconds = 1" in how_it_ended(trace.entries)


def test_seconds_are_whole_and_positive() -> None:
    with pytest.raises(UserError, match="whole number of at least 1"):
        Budget(seconds=-1)
