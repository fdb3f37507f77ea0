"""A verdict: somebody looked and nobody objects; what advises only is told, and refuses nothing."""

from __future__ import annotations

import pytest
from msgspec.structs import replace

from cramlite.model import Finding, Verdict
from cramlite.model.remedy import Remedy

GOOD = Finding("one", True, "0.1 m, limit 0.2 m", 0.1, 0.2, "m")
BAD = Finding("slip", False, "0.3 m, limit 0.2 m", 0.3, 0.2, "m", "1.Grasping")
OTHER = Finding("force", False, "61 N", 61.0, unit="N m/s")


@pytest.mark.parametrize(
    ("findings", "passes"),
    [((GOOD,), True), ((GOOD, GOOD), True), ((BAD,), False), ((GOOD, BAD), False), ((BAD, GOOD), False), ((BAD, OTHER), False)],
)
def test_one_objection_refuses(findings: tuple[Finding, ...], passes: bool) -> None:
    assert Verdict(findings).passed is passes


def test_a_finding_is_about_a_place_that_might_change_it_unless_it_says_else() -> None:
    assert Finding("a", True, "r") == Finding("a", True, "r", None, None, "", "", True, False, None, False, False)


def test_no_finding_is_no_success() -> None:
    assert Verdict(()).passed is False and Verdict((), ("one",)).passed is False


def test_what_objects_is_told_in_the_order_of_tasks_and_then_of_validators() -> None:
    later, tenth = replace(BAD, origin="2.Placing/lower"), replace(BAD, origin="10.Grasping")
    found = Verdict((OTHER, tenth, later, GOOD, BAD, GOOD, replace(OTHER, validator="last")))
    assert found.objections == (BAD, later, tenth, OTHER, replace(OTHER, validator="last"))
    assert Verdict((OTHER, GOOD, BAD)).reason == "slip: 0.3 m, limit 0.2 m; force: 61 N"
    assert Verdict((GOOD,)).objections == () and Verdict((GOOD,)).reason == "passed"


def test_what_stopped_the_run_is_told_first() -> None:
    """Whatever order validators were asked in: a goal that is not reached may follow from it."""
    halted = Finding("execution", False, "halted at line 3", stopped=True)
    found = Verdict((OTHER, GOOD, halted, BAD))
    assert found.objections == (halted, BAD, OTHER) and found.reason.startswith("execution: halted at line 3; slip: ")


def test_advice_refuses_nothing_and_is_told() -> None:
    advice = BAD.as_advice()
    assert (advice.passed, advice.advice, advice.reason) == (True, True, "advises only: 0.3 m, limit 0.2 m")
    assert (advice.value, advice.limit, advice.origin) == (BAD.value, BAD.limit, BAD.origin)
    found = Verdict((GOOD, advice))
    assert found.passed and found.advice == (advice,) and found.objections == ()
    assert GOOD.as_advice() == GOOD and Verdict((GOOD, BAD)).advice == ()


def test_measured_values_are_named_with_their_units() -> None:
    plain = Finding("count", False, "3", 3.0, 5.0)
    assert Verdict((GOOD, BAD, OTHER, plain)).measured == {
        "slip_m": 0.3, "slip_limit_m": 0.2, "force_N_m_s": 61.0, "count": 3.0, "count_limit": 5.0,
    }  # fmt: skip


def test_who_was_not_asked_is_named() -> None:
    assert Verdict((GOOD,), ("goal", "collision")).not_judged == "not judged, since blocked: goal, collision"
    assert Verdict((GOOD,)).not_judged == ""


def test_what_to_try_is_that_of_the_first_objection() -> None:
    """Others may follow from it, so that what would help against them is not told."""
    nearer, wider = Remedy("far", "put it nearer"), Remedy("narrow", "open wider")
    first, second = replace(BAD, remedy=nearer), replace(OTHER, remedy=wider)
    assert Verdict((replace(GOOD, remedy=wider), first, second)).remedy is nearer
    assert Verdict((BAD, second)).remedy is None and Verdict((GOOD,)).remedy is None
