"""Several demonstrations become one procedure, and another demonstration is compared with it."""

from __future__ import annotations

import numpy as np
import pytest
import yaml
from procedures import blamed, drawn, exchanged, f1, learned, missed, named, run

from cramlite import task_entry
from cramlite.learning.procedure import Step, deviations, plan_text, procedure
from cramlite.plugin import UserError

A, B, C, D = (Step(f"soma:{name}") for name in ("Grasping", "PickingUp", "Pouring", "Placing"))


JOBS = [(seed, *drawn(np.random.default_rng(seed))) for seed in range(10)]


@pytest.mark.parametrize(("seed", "steps", "above"), JOBS)
def test_the_order_of_a_drawn_job_is_found(seed: int, steps: list[Step], above: set[tuple[int, int]]) -> None:
    assert f1(learned(seed, steps, above), steps, above) >= 0.95


@pytest.mark.parametrize(("seed", "steps", "above"), JOBS)
def test_correct_runs_are_not_blamed_and_mistakes_are_named(seed: int, steps: list[Step], above: set[tuple[int, int]]) -> None:
    known, rng = learned(seed, steps, above), np.random.default_rng([seed, 2])
    for _ in range(10):
        good = run(steps, above, rng)
        assert not blamed(known, good)
        assert named(known, missed(good, rng))
        assert not above or named(known, exchanged(good, steps, above, rng))


def test_an_order_that_was_seen_too_rarely_is_a_notice() -> None:
    (found,) = deviations(procedure([[A, B], [A, B]]), [B, A])
    assert str(found) == "order not seen otherwise: PickingUp, then Grasping" and not found.mistake


def test_what_was_left_out_once_is_optional_and_who_is_done_instead_an_alternative() -> None:
    known = procedure([[A, B, D], [A, C, D], [A, B, D]])
    assert known.optional == {B, C} and known.alternatives == {(B, C)}
    assert [str(d) for d in deviations(known, [A, D])] == ["step missing: PickingUp"]
    assert [d.what for d in deviations(known, [A, B, C, D])] == ["both alternatives"]


def test_repetitions_are_counted() -> None:
    known = procedure([[A, C, C, D], [A, C, C, C, D]])
    assert known.repeated() == {("soma:Pouring", ()): (2, 3)}
    assert not list(deviations(known, [A, C, C, D]))
    assert [d.what for d in deviations(known, [A, C, D])] == ["step missing"]
    assert [d.what for d in deviations(known, [A, C, C, C, C, D])] == ["unknown step"]


def test_it_is_printed_in_the_plan_language() -> None:
    text = plan_text(procedure([[A, B, C, C, D], [B, A, C, C], [A, B, C, C]]))
    entries = yaml.safe_load(text)["tasks"]
    assert [next(iter(e)) for e in entries] == ["choose", "repeat"] and "# optional: Placing" in text
    assert [task_entry(e).rule for e in entries] == ["choose", "repeat"]


def test_nothing_shown_is_refused() -> None:
    with pytest.raises(UserError, match="at least one step"):
        procedure([[A], []])
