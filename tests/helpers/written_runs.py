"""Proofs without physics: a plan that is grounded once, a simulator whose runs are written, and validators of one word."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from copy import copy
from functools import cache
from typing import Any

from conftest import ROOT
from msgspec import json
from msgspec.structs import replace

from cramlite import Trace, read_scenario
from cramlite.engine.candidates import CandidateSequence
from cramlite.engine.proof.intent import Intent, Kept, write_intent
from cramlite.engine.proof.proof import assemble
from cramlite.engine.search_in_setting import search_in
from cramlite.model import Code, Cost, Finding, Program, Robot, Rollout, World
from cramlite.planning.search.state import State
from cramlite.plugin import Candidate
from helpers.edited import engine
from helpers.short_runs import good


@cache
def planned() -> CandidateSequence:
    """Return the plan of placing a block on a shelf, with its setting."""
    scenario = read_scenario(ROOT / "scenarios" / "place_on_shelf.yaml")
    setting = engine().setting(scenario, twins=0)
    return next(iter(engine().candidates(scenario, setting=setting, trace=Trace())))


@cache
def grounded() -> State:
    """Return the first search state in which the whole plan is grounded: grasp, pick up, place, park."""
    plan = planned()
    search = search_in(plan.setting, plan.knowledge, plan.budget, plan.trace)
    return next(search.solve(plan.setting.start(plan.plan)))


def ran(outcome: str = "finished", world: World | None = None) -> Rollout:
    """Return the hand-written run of ``short_runs``, with a given outcome."""
    made = good(outcome=outcome, reason="as written").rollout
    assert made is not None
    return made if world is None else replace(made, world=world)


class Written:
    """Simulator that returns hand-written runs and records its calls."""

    name = "written"

    def __init__(self, *runs: Rollout, otherwise: Rollout | None = None) -> None:
        self.runs, self.otherwise = list(runs), otherwise or ran()
        self.asked: list[tuple[str, World, str, int]] = []

    def execute(self, text: str, world: World, robots: Mapping[str, Robot], *, mount: str, seed: int) -> Rollout:
        self.asked.append((text, world, mount, seed))
        return self.runs.pop(0) if self.runs else self.otherwise


class Says:
    """Validator that gives a fixed answer, or that of a function of the candidate."""

    def __init__(self, name: str, answer: Any = True, cost: Cost = "rollout", may_advise: bool = False) -> None:
        self.name, self.cost, self.answer, self.may_advise = name, cost, answer, may_advise
        self.asked: list[Candidate] = []

    def check(self, candidate: Candidate) -> Any:
        self.asked.append(candidate)
        if callable(self.answer):
            return self.answer(candidate)
        return [Finding(self.name, self.answer, f"{self.name} says so", origin="1.Grasping")]


class Writes:
    """Backend that writes given texts."""

    def __init__(self, text: Any = "run", executable: bool = True, **more: Any) -> None:
        self.name, self.executable, self.text = "writes", executable, text
        vars(self).update(more)

    def emit(self, program: Program, robot: Robot) -> Code:
        if isinstance(self.text, BaseException):
            raise self.text
        return Code("written", self.text, {}, ".txt") if isinstance(self.text, str) else self.text


def knowing(simulator: Written, validators: Iterable[Any]) -> Any:
    """Return the engine's knowledge with a test simulator and test validators in place of the shipped ones."""
    knowledge = copy(engine().knowledge)
    vars(knowledge).update(simulator=simulator, validators=tuple(validators), left_out=("blocked",))
    return knowledge


@cache
def written() -> Candidate:
    """Return the candidate of the grounded plan, with the text that the scenario's backend writes."""
    plan = planned()
    made = assemble(plan.plan, grounded(), plan.setting, plan.knowledge)
    return replace(made, code=plan.setting.backend.emit(made.program, made.robot))


@cache
def intent() -> Intent:
    """Return the intent of the written candidate, as its run directory stores it."""
    made = written()
    return Intent(json.decode(write_intent(made), type=Kept), made.program)
