"""Long searches say what they do, end when their seconds are spent, and tell the nearest miss."""

from __future__ import annotations

import time
from collections.abc import Iterator

import pytest

from cramlite import Budget, Engine, Goal, Trace, find_scenario, how_it_ended, read_scenario
from cramlite.base.pulse import ASKED, checkpoint, working
from cramlite.planning.heartbeat import Heartbeat, NowDone, interrupted_text, searching_text
from cramlite.planning.search.budget import is_late, until_late
from cramlite.plugin import UserError


def _trace() -> Trace:
    trace = Trace()
    trace.add(0, "grasp(tin)", "", "chosen", "grasps", "from above", kind="location")
    for _ in range(3):
        trace.add(1, "grasp(tin)", "", "refused", "grasps", "60 mm wide", kind="location")
    trace.add(1, "grasp(tin)", "", "refused", "reach", "out of reach", kind="location")
    return trace


def _beaten(beat: Heartbeat, seconds: float) -> None:
    end = time.monotonic() + seconds
    with beat():
        while time.monotonic() < end:
            checkpoint()


def test_a_search_says_every_few_seconds_what_it_does() -> None:
    lines: list[str] = []
    _beaten(Heartbeat(_trace(), lines.append, lambda: False, every=0.15), 0.5)
    assert 2 <= len(lines) <= 3 and all(isinstance(line, NowDone) for line in lines)
    assert lines[0] == "searching: grasp(tin), candidate 1; 5 decisions; refused 4 times, most often (3): 60 mm wide [grasps]"


def test_work_that_has_a_name_is_told_instead() -> None:
    lines: list[str] = []
    with working("nobody hears this"):
        checkpoint()
    beat = Heartbeat(_trace(), lines.append, lambda: False, every=0.0)
    with beat(), working("program 1 runs", 30.0):
        checkpoint(12.0)
    assert lines == ["program 1 runs, 12 of about 30 s"]


def test_a_stop_ends_the_items_and_the_trace_says_so() -> None:
    trace, asked = Trace(), list[bool]()

    def numbers() -> Iterator[int]:
        yield 1
        asked.append(True)
        time.sleep(0.1)
        checkpoint()
        yield 2

    assert list(Heartbeat(trace, print, lambda: bool(asked)).over(numbers())) == [1]
    assert [(e.kind, e.outcome) for e in trace.entries] == [("stop", "capped")]
    assert list(Heartbeat(trace, print, lambda: False).over([1, 2])) == [1, 2]
    assert list(Heartbeat(trace, print, lambda: True).over([1, 2])) == []


def test_of_refusals_those_count_that_came_after_the_last_program() -> None:
    trace = _trace()
    trace.add(0, "proof", "plan", "failed", "urscript", "it fell", kind="proof")
    assert searching_text(trace) == "searching: what to do otherwise after the last program"
    trace.add(0, "2.Placing", "", "asked", "engine", "", kind="action", numbers={"task": 2, "depth": 0})
    trace.add(0, "on(tray)", "", "refused", "places", "too near", kind="location")
    said = searching_text(trace, tasks=3)
    assert said == "searching: on(tray), task 2 of 3, candidate 1; 8 decisions; refused 1 times, most often (1): too near [places]"


def test_what_followed_from_refusals_is_no_reason() -> None:
    trace = _trace()
    trace.add(0, "grasp(tin)", "", "failed", "engine", "2 alternatives failed; it depends on 1.Grasping", kind="location")
    assert "alternatives failed" not in searching_text(trace)
    trace.add(0, "sequence", "plan", "failed", "engine", "it depends on tasks 1", kind="sequence")
    assert searching_text(trace) == "searching: another sequence of tasks"


def test_what_is_said_of_a_search_that_has_not_begun_or_was_interrupted() -> None:
    assert "no question" in searching_text(Trace())
    assert "nothing was refused yet" in interrupted_text(Trace())
    assert "nearest miss: candidate 1, grasp(tin)" in interrupted_text(_trace())


def test_a_search_that_is_interrupted_while_a_program_runs_tells_how_much_was_refused_on_the_way_and_calls_none_a_miss() -> None:
    asked: list[bool] = []
    trace = _trace()

    def numbers() -> Iterator[int]:
        with working("twin 3 of 8"):
            asked.append(True)
            time.sleep(2 * ASKED)
            checkpoint()
            yield 1

    assert list(Heartbeat(trace, print, lambda: bool(asked), tasks=3).over(numbers())) == []
    said = interrupted_text(trace)
    assert "decisions (twin 3 of 8); no program was refused yet; " in said and "nearest miss" not in said
    refused = sum(e.outcome in ("refused", "impossible") for e in trace.entries)
    assert f"{refused} alternatives were refused before it ran, most often (" in said
    first = Trace()
    first.stopped("program 1 runs")
    assert interrupted_text(first).endswith("(program 1 runs); no program was refused yet")
    earlier = _trace()
    earlier.add(0, "proof", "plan", "failed", "collision", "'mug' hit 'tin' with 3 N", kind="proof")
    earlier.stopped("program 2 runs")
    assert "(program 2 runs); nearest miss: candidate 1, proof: 'mug' hit 'tin' with 3 N" in interrupted_text(earlier)


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
