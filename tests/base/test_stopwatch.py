"""The stopwatch: times of stages are kept apart, also where one stage lies inside another."""

from __future__ import annotations

import time
from collections.abc import Iterator

from cramlite.base.stopwatch import Stopwatch


def busy(seconds: float) -> None:
    """Use so much CPU time."""
    end = time.thread_time() + seconds
    while time.thread_time() < end:
        pass


def test_a_stage_inside_another_is_counted_once() -> None:
    watch = Stopwatch()
    with watch("outer"):
        busy(0.02)
        with watch("inner"):
            busy(0.04)
    found = watch.read()
    assert 0.04 <= found["inner"] < 0.08 and 0.02 <= found["outer"] < 0.06


def test_what_items_take_is_counted_and_not_what_is_done_with_them() -> None:
    def items() -> Iterator[int]:
        for k in range(2):
            busy(0.02)
            yield k

    watch, seen = Stopwatch(), list[int]()
    for k in watch.over("items", items()):
        seen.append(k)
        busy(0.05)
    assert seen == [0, 1] and 0.04 <= watch.read()["items"] < 0.08
