"""The static safety check as a validator: each rule's breach is an objection of its step, and says whether a place might cure it."""

from __future__ import annotations

import pytest
from helpers.short_runs import good, only
from msgspec.structs import replace

from cramlite.model import PROGRAM_RULES, STEP_RULES, AnyStep, MoveUntilContact, SetPayload, Wait
from cramlite.plugin import Candidate
from cramlite_plugins.validators.safety import ProgramSafety, validators

FEEL = MoveUntilContact((0, 0, -1), 0.01, 3.0, 0.05, 10.0, origin="1.A/feel")


def having(*steps: AnyStep) -> Candidate:
    return replace(good(), program=replace(good().program, steps=steps))


def test_it_is_asked_and_counts_its_rules() -> None:
    assert [v.name for v in validators()] == ["program_safety"]
    found = only(ProgramSafety(), having(Wait(1.0), FEEL))
    rules = len({*PROGRAM_RULES, *STEP_RULES})
    assert (found.passed, found.reason) == (True, f"2 steps keep {rules} safety rules")


@pytest.mark.parametrize(
    ("step", "says", "places"),
    [
        (replace(FEEL, force=60.0), "forces: it presses with 60 N", False),
        (SetPayload(5.001, (0, 0, 0.1), origin="1.A/feel"), "payload: payload 5.001 kg", False),
        (replace(FEEL, speed=0.2501, timeout=1.0), "speed: TCP speed 0.2501 m/s", True),
        (replace(FEEL, timeout=600.1), "time-outs: timeout 600.1 s", True),
    ],
)
def test_what_breaks_a_rule_is_an_objection(step: AnyStep, says: str, places: bool) -> None:
    found = only(ProgramSafety(), having(Wait(1.0), step))
    assert (found.passed, found.origin, found.places) == (False, "1.A/feel", places) and says in found.reason


@pytest.mark.parametrize(
    "step", [replace(FEEL, force=59.9), SetPayload(5.0, (0, 0, 0.1)), replace(FEEL, speed=0.25), replace(FEEL, timeout=600.0)]
)
def test_just_inside_is_none(step: AnyStep) -> None:
    assert only(ProgramSafety(), having(step)).passed


def test_all_breaches_are_said() -> None:
    assert len(list(ProgramSafety().check(having(replace(FEEL, force=60.0), replace(FEEL, timeout=600.1))))) == 2
