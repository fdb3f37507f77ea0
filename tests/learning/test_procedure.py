"""Several demonstrations become one procedure, and another demonstration is compared with it."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

import numpy as np
import pytest
import yaml

from cramlite import task_entry
from cramlite.learning.procedure import Procedure, Step, deviations, plan_text, procedure
from cramlite.plugin import UserError

A, B, C, D = (Step(f"soma:{name}") for name in ("Grasping", "PickingUp", "Pouring", "Placing"))


def drawn(rng: np.random.Generator) -> tuple[list[Step], set[tuple[int, int]]]:
    """Steps of a job, and a partial order of them, closed under transitivity."""
    count = int(rng.integers(5, 10))
    above = {(i, j) for i, j in combinations(range(count), 2) if rng.random() < 0.35}
    for k in range(count):
        above |= {(i, j) for i in range(count) for j in range(count) if (i, k) in above and (k, j) in above}
    return [Step("soma:Placing", (("Locatum", f"thing_{k}"),)) for k in range(count)], above


def run(steps: Sequence[Step], above: set[tuple[int, int]], rng: np.random.Generator, first: Sequence[int] = ()) -> list[Step]:
    """An order of the steps that the partial order allows, drawn; those of ``first`` and what they need as early as can be."""
    left, found = list(range(len(steps))), list[int]()
    early = {j for j in left if j in first or any((j, i) in above for i in first)}
    while left:
        ready = [j for j in left if not any((i, j) in above for i in left)]
        ready = [j for j in ready if j in early] or ready
        found.append(ready[int(rng.integers(len(ready)))])
        left.remove(found[-1])
    return [steps[k] for k in found]


def shown(steps: Sequence[Step], above: set[tuple[int, int]], rng: np.random.Generator) -> list[list[Step]]:
    """Demonstrations in which each exchangeable pair occurs both ways, and at least five."""
    free = [(i, j) for i, j in combinations(range(len(steps)), 2) if (i, j) not in above]
    found = [run(steps, above, rng) for _ in range(5)]
    for i, j in free:
        found += [run(steps, above, rng, (i,)), run(steps, above, rng, (j,))]
    return found


JOBS = [(seed, *drawn(np.random.default_rng(seed))) for seed in range(10)]


def learned(seed: int, steps: Sequence[Step], above: set[tuple[int, int]]) -> Procedure:
    return procedure(shown(steps, above, np.random.default_rng([seed, 1])))


@pytest.mark.parametrize(("seed", "steps", "above"), JOBS)
def test_the_order_of_a_drawn_job_is_found(seed: int, steps: list[Step], above: set[tuple[int, int]]) -> None:
    true = {(steps[i], steps[j]) for i, j in above}
    found = learned(seed, steps, above).order
    assert 2 * len(true & found) / max(len(true) + len(found), 1) >= 0.95 or not true | set(found)


@pytest.mark.parametrize(("seed", "steps", "above"), JOBS)
def test_correct_runs_are_not_blamed_and_mistakes_are_named(seed: int, steps: list[Step], above: set[tuple[int, int]]) -> None:
    known, rng = learned(seed, steps, above), np.random.default_rng([seed, 2])
    for _ in range(10):
        good = run(steps, above, rng)
        assert not [d for d in deviations(known, good) if d.mistake]
        gone = int(rng.integers(len(good)))
        assert ("step missing", (good[gone],)) in [(d.what, d.steps) for d in deviations(known, good[:gone] + good[gone + 1 :])]
        if above:
            i, j = sorted(above)[int(rng.integers(len(above)))]
            bad = [steps[j] if s == steps[i] else steps[i] if s == steps[j] else s for s in good]
            assert ("wrong order", (steps[j], steps[i])) in [(d.what, d.steps) for d in deviations(known, bad)]


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
