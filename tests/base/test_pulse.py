"""Long work ends when its caller wants that, and says what it is doing."""

from __future__ import annotations

import threading
import time
from concurrent.futures import Future, ThreadPoolExecutor

import pytest

from cramlite.base.errors import DEFECTS
from cramlite.base.pulse import ASKED, Stopped, Work, awaited, checkpoint, pulse, stop_asked, working


def test_work_without_a_pulse_goes_on() -> None:
    checkpoint()
    checkpoint(3.0)
    assert not stop_asked()


def test_work_ends_at_a_checkpoint_and_is_no_defect_of_a_plugin() -> None:
    asked = threading.Event()
    with pulse(asked.is_set):
        checkpoint()
        asked.set()
        assert stop_asked()
        time.sleep(2 * ASKED)
        with pytest.raises(Stopped) as stopped:
            checkpoint()
    assert not isinstance(stopped.value, DEFECTS)
    checkpoint()  # the pulse ends with its block


def test_a_checkpoint_asks_rarely() -> None:
    questions: list[float] = []

    def stop() -> bool:
        questions.append(time.monotonic())
        return False

    with pulse(stop):
        end = time.monotonic() + 4.5 * ASKED
        while time.monotonic() < end:
            checkpoint()
    assert 2 <= len(questions) <= 5


def test_the_end_of_the_work_around_is_the_end_of_both() -> None:
    with pytest.raises(Stopped), pulse(lambda: True), pulse(lambda: False):
        checkpoint()
    with pytest.raises(Stopped), pulse(lambda: False), pulse(lambda: True):
        checkpoint()


def test_threads_have_pulses_of_their_own() -> None:
    with pulse(lambda: True), ThreadPoolExecutor(1) as other:
        assert other.submit(checkpoint).result() is None


def test_waiting_for_others_ends() -> None:
    never, done = Future[int](), Future[int]()
    done.set_result(3)
    with pulse(lambda: False):
        assert awaited(done) == 3
    end = time.monotonic() + 2 * ASKED
    with pytest.raises(Stopped), pulse(lambda: time.monotonic() > end):
        awaited(never)
    assert never.cancelled()


def test_what_is_done_is_told_with_how_far_it_is() -> None:
    said: list[str] = []

    def tell(work: Work | None) -> None:
        said.append(str(work))

    with pulse(lambda: False, tell):
        checkpoint()
        with working("program 2 runs", 108.4):
            time.sleep(2 * ASKED)
            checkpoint(41.2)
            with working("program 2 runs with tea 5 mm off"):
                time.sleep(2 * ASKED)
                checkpoint(7.0)
            time.sleep(2 * ASKED)
            checkpoint(120.0)
    assert said == [
        "None", "program 2 runs, 41 of about 108 s", "program 2 runs with tea 5 mm off", "program 2 runs, 120 of about 120 s"
    ]  # fmt: skip
    assert str(Work("twin 3 of 8", ends=time.monotonic() + 90.2)) == "twin 3 of 8, about 90 s left"
    assert str(Work("twin 3 of 8", ends=time.monotonic() - 5.0)) == "twin 3 of 8, about 1 s left"
