"""What an ablation takes away is really gone from the programs, and was there before."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from cramlite import Budget, CandidateSequence, Trace, find_scenario
from cramlite.experiment.demonstrations.bench import bench
from cramlite.experiment.experiment_file import find_experiment
from cramlite.model import MoveLinear, walk
from cramlite_plugins.motions.motion_kinds import KINDS

pytestmark = pytest.mark.heavy

FELT = {k.step for k in KINDS.values() if k.widens > 0}
"""Steps that feel: those in contact, after which less is known of what is held."""


def candidates(
    name: str, budget: Budget, trace: Trace, *, set_name: str = "main", without: str | None = None
) -> Iterator[CandidateSequence]:
    """Those of the shipped demonstration of a scenario, in the experiment's world."""
    place = bench(find_experiment(name), set_name, without)
    episode = find_scenario(name).parent / name / "demonstration"
    return place.engine.candidates(place.scenario.demonstrated_by(episode), budget=budget, trace=trace)


def steps(name: str, without: str | None) -> set[str]:
    """The kinds of steps of the first program."""
    first = next(candidates(name, Budget(proofs=1), Trace(), without=without))
    return {type(step).__name__ for step in walk(next(first.attempts()).program.steps)}


@pytest.mark.parametrize("name", ["fetch_from_hanger", "hang_onto_hanger"])
def test_without_force_control_nothing_is_felt(name: str) -> None:
    assert steps(name, None) & FELT and not steps(name, "force_control") & FELT


def test_without_search_only_the_search_is_gone() -> None:
    assert steps("hang_onto_hanger", None) & FELT - steps("hang_onto_hanger", "search") == {"SpiralSearch"}


def numbers(name: str, without: str | None) -> tuple[float, ...]:
    """Speeds of the straight motions of the first program."""
    first = next(candidates(name, Budget(proofs=1), Trace(), without=without))
    return tuple(step.speed for step in walk(next(first.attempts()).program.steps) if isinstance(step, MoveLinear))


def test_without_tuning_numbers_are_drawn_around_what_they_were() -> None:
    tuned, drawn = (numbers("fetch_from_hanger", without) for without in (None, "tuning"))
    assert len(drawn) == len(tuned)
    factors = [d / t for d, t in zip(drawn, tuned, strict=True)]
    assert all(1 / 3.01 < f < 3.01 for f in factors) and max(factors) / min(factors) > 1.2


def test_what_cannot_be_meant_is_given_up_at_once() -> None:
    """Another product hangs on another hanger. Whichever grasp it is, it cannot be lifted: no other grasp is tried."""
    trace = Trace()
    first = next(candidates("hang_onto_hanger", Budget(proofs=1, expansions=150), trace, set_name="hard"))
    assert "PickingUp" in str(first.plan)
    assert next(first.attempts()).code
    refused = [e for e in trace.entries if "constrains more than one degree of freedom" in e.reason]
    assert 1 <= len(refused) <= 4  # once for each choice of the other things
