"""Nothing is tried twice: over the task sequences of a goal, and over wider rounds, no question to plugins comes a second time."""

from __future__ import annotations

from typing import Any

import pytest
from msgspec.structs import replace

from cramlite import Budget, Engine, Trace, find_scenario, read_scenario
from cramlite.model import Location, Motion
from cramlite.planning.search import choice_point
from cramlite.planning.search.answers import Answers, same_belief
from cramlite.planning.trace import KNOWN

Asked = list[tuple[str, Any, Any, dict[str, Any]]]
BUDGET = Budget(expansions=40, samples=400, sequences=2)
"""Sequences take and lift the tin, and put it down in one of two ways. Between the walls only its top can be gripped, and so it does
not fit under the roof."""


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> tuple[Engine, Asked]:
    """An engine of few alternatives in the first round, and the questions about places and motions that reach its plugins."""
    engine, found = Engine(), Asked()
    ask = engine.registry.alternatives

    def recorded(hook: str, designator: Any, **arguments: Any) -> Any:
        if isinstance(designator, Location | Motion):
            bound = arguments["context"].bindings
            found.append((hook, designator, arguments["belief"], dict(getattr(bound, "now", bound))))
        return ask(hook, designator, **arguments)

    monkeypatch.setattr(engine.registry, "alternatives", recorded)
    for kind in (Location, Motion):
        monkeypatch.setitem(choice_point.CAPS, kind, 1)
    return engine, found


def tried(engine: Engine, keeps: bool) -> Trace:
    """Try all sequences in all rounds; without what is kept, each asks for itself."""
    scenario, trace = read_scenario(find_scenario("kitchen/regrasp")), Trace()
    setting = engine.setting(scenario, twins=0)
    for candidate in engine.candidates(scenario, setting=setting, budget=BUDGET, trace=trace):
        own = candidate if keeps else replace(candidate, answers=Answers())
        assert not any(attempt.verdict.passed for attempt in own.attempts())
    return trace


def repeated(asked: Asked) -> list[str]:
    """Questions that were asked before: the same designator, belief and bindings."""
    return [
        one[1].name
        for k, one in enumerate(asked)
        if any(o[:2] == one[:2] and same_belief(o[2], one[2]) and o[3] == one[3] for o in asked[:k])
    ]


@pytest.mark.heavy
def test_no_question_comes_twice(asked: tuple[Engine, Asked]) -> None:
    engine, questions = asked
    trace = tried(engine, keeps=True)
    assert {e.candidate for e in trace.entries if e.kind == "location"} == {1, 2}
    assert any((e.kind, e.outcome) == ("location", "capped") for e in trace.entries), "there are wider rounds"
    assert questions and repeated(questions) == []
    known = [e for e in trace.entries if e.outcome == "asked" and e.kind in ("location", "motion") and e.reason == KNOWN]
    assert known, "what comes up again is answered without asking"


@pytest.mark.heavy
def test_without_what_is_kept_they_do(asked: tuple[Engine, Asked]) -> None:
    engine, questions = asked
    tried(engine, keeps=False)
    assert repeated(questions)
