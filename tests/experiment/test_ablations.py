"""What an ablation takes away is really gone from the programs, and was there before."""

from __future__ import annotations

import pytest

from cramlite import Budget, Trace, find_scenario
from cramlite.engine.candidates import attempts
from cramlite.experiment.bench import bench
from cramlite.experiment.spec import find_experiment
from cramlite.interpretation.coherence import candidates
from cramlite.model import walk
from cramlite.planning.plan import TaskCall, plan_from_episode
from cramlite_plugins.motions.motion_kinds import KINDS

FELT = {k.step for k in KINDS.values() if k.widens > 0}
"""Steps that feel: those in contact, after which less is known of what is held."""


def steps(name: str, without: str | None) -> set[str]:
    """The kinds of steps of the first program for the shipped demonstration of a scenario, in the experiment's world."""
    place = bench(find_experiment(name), "main", without)
    engine = place.engine
    episode = engine.read_episode(find_scenario(name).parent / name / "demonstration")
    sequence = next(candidates(engine.interpret(episode), engine.knowledge.rules))
    calls = [TaskCall(engine.knowledge.tasks[m.task], m.roles) for m in sequence.matches]
    setting = engine.setting(place.scenario, seed=0)
    found = attempts(plan_from_episode(setting.name, calls, episode), setting, engine.knowledge, Budget(proofs=1), Trace())
    return {type(step).__name__ for step in walk(next(found)[0].program.steps)}


@pytest.mark.parametrize("name", ["fetch_from_hanger", "hang_onto_hanger"])
def test_without_force_control_nothing_is_felt(name: str) -> None:
    assert steps(name, None) & FELT and not steps(name, "force_control") & FELT


def test_without_search_only_the_search_is_gone() -> None:
    assert steps("hang_onto_hanger", None) & FELT - steps("hang_onto_hanger", "search") == {"SpiralSearch"}


def test_what_cannot_be_meant_is_given_up_at_once() -> None:
    """Another product hangs on another hanger. Whichever grasp it is, it cannot be lifted: no other grasp is tried."""
    place = bench(find_experiment("hang_onto_hanger"), "hard", None)
    engine, trace = place.engine, Trace()
    episode = engine.read_episode(find_scenario("hang_onto_hanger").parent / "hang_onto_hanger" / "demonstration")
    sequence = next(candidates(engine.interpret(episode), engine.knowledge.rules))
    assert "soma:PickingUp" in {m.task for m in sequence.matches}
    calls = [TaskCall(engine.knowledge.tasks[m.task], m.roles) for m in sequence.matches]
    setting = engine.setting(place.scenario, seed=0)
    found = attempts(plan_from_episode(setting.name, calls, episode), setting, engine.knowledge, Budget(proofs=1, asks=150), trace)
    assert next(found)[0].code is not None
    refused = [e for e in trace.entries if "constrains more than one degree of freedom" in e.reason]
    assert 1 <= len(refused) <= 4  # once for each choice of the other things
