"""When the code of each task ran: lines of the run, and what they came from."""

from __future__ import annotations

import numpy as np
import pytest
from helpers.properties import examples
from helpers.short_runs import COUNT, ORIGINS, STEP, good
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from cramlite_plugins.validators.task_times import Span, inner_tasks, origins, span, task_at


def test_each_sample_has_the_origin_of_the_line_that_ran() -> None:
    expected = [""] * 2 + [ORIGINS[1]] * 23 + [ORIGINS[3]] * 25 + [ORIGINS[5]] * 20 + [ORIGINS[7]] * 10 + [ORIGINS[9]] * 20
    assert origins(good()) == expected  # what comes after the last line is the last one's


def test_lines_between_belong_to_the_step_before_them() -> None:
    lines = np.full(COUNT, 6.0)
    assert set(origins(good(lines=lines))) == {ORIGINS[5]}
    assert set(origins(good(lines=lines - 3.5))) == {ORIGINS[1]}


def test_a_program_that_never_ran_has_no_origins() -> None:
    assert set(origins(good(lines=np.zeros(COUNT)))) == {""}
    early = replace(good(lines=np.full(COUNT, 2.0)), code=replace(good().code, origins={5: "3.Placing/x"}))  # type: ignore[type-var]
    assert set(origins(early)) == {""}


def test_one_sample_that_runs_at_the_start_lasts() -> None:
    lines = np.zeros(COUNT)
    lines[0] = 3.0
    assert set(origins(good(lines=lines))) == {ORIGINS[3]}


def test_a_pause_in_between_is_no_task() -> None:
    base = good().rollout
    assert base is not None
    lines = base.lines.copy()
    lines[30:35] = 0.0
    found = origins(good(lines=lines))
    assert found[30:35] == [""] * 5 and found[35] == ORIGINS[3]


def test_the_innermost_known_action_is_the_task() -> None:
    found = inner_tasks(good())
    assert [found[k] for k in (0, 2, 25, 50, 70, 80, 99)] == [
        "", "1.Grasping", "2.PickingUp", "3.Placing/PuttingDown", "3.Placing/Releasing", "4.ParkingArms", "4.ParkingArms",
    ]  # fmt: skip
    assert inner_tasks(replace(good(), parts=()))[50] == "3.Placing"
    assert inner_tasks(replace(good(), parts=(), actions=()))[50] == ""


@pytest.mark.parametrize(
    ("task", "first", "last"),
    [("1.Grasping", 2, 24), ("2.PickingUp", 25, 49), ("3.Placing", 50, 79), ("3.Placing/Releasing", 70, 79), ("4.ParkingArms", 80, 89)],
)
def test_a_span_is_from_the_first_to_the_last_sample_of_a_task(task: str, first: int, last: int) -> None:
    assert span(good(), task) == Span(pytest.approx(first * STEP), pytest.approx(last * STEP))


def test_what_has_no_code_or_never_ran_has_no_span() -> None:
    assert span(good(), "9.Nothing") is None and span(good(), "3.Plac") is None
    assert span(good(lines=np.zeros(COUNT)), "1.Grasping") is None


@pytest.mark.parametrize(("samples", "known"), [(1, False), (2, True)])
def test_one_sample_is_no_span(samples: int, known: bool) -> None:
    lines = np.full(COUNT, 3.0)
    lines[40 : 40 + samples] = 5.0
    assert (span(good(lines=lines), "3.Placing") is not None) is known


def test_before_the_first_step_there_is_none() -> None:
    late = replace(good(), code=replace(good().code, origins={k + 4: o for k, o in ORIGINS.items()}))  # type: ignore[type-var]
    found = span(late, "4.ParkingArms")
    assert found is None and span(late, "1.Grasping") == Span(pytest.approx(50 * STEP), pytest.approx(69 * STEP))


@given(line=st.integers(0, 12))
@examples(13)
def test_the_task_at_a_line_is_that_of_the_last_step_before_it(line: int) -> None:
    before = [o for k, o in ORIGINS.items() if k <= line]
    found = task_at(good(lines=np.full(COUNT, float(line))), 50)
    assert found == (before[-1].split("/")[0] if before else "")
