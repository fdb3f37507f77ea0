"""A plate is laid onto a stove: its turn in the hand is judged by what the program declares, and refused without that."""

from __future__ import annotations

import pytest
from helpers.task_scenarios import attempted
from msgspec.structs import replace

from cramlite.model import MoveLinear
from cramlite.plugin import Candidate
from cramlite_plugins.validators.physics import GraspSlip


def _declaring(candidate: Candidate, name: str) -> Candidate:
    """The candidate whose program declares the turns of the motions of this name alone."""

    def kept(step: object) -> object:
        hidden = isinstance(step, MoveLinear) and not step.origin.endswith(name)
        return replace(step, swing=None) if hidden else step

    return replace(candidate, program=replace(candidate.program, steps=tuple(map(kept, candidate.program.steps))))  # type: ignore[arg-type]


@pytest.mark.heavy
def test_the_declared_turn_is_no_slip_and_one_that_is_not_declared_is() -> None:
    candidate, verdict, reasons = attempted("laying_down")
    assert candidate is not None and verdict is not None and verdict.passed, reasons
    assert [f.passed for f in GraspSlip().check(candidate)] == [True]
    for declared in ("nothing", "lift", "lower"):
        (found,) = GraspSlip().check(_declaring(candidate, declared))
        assert not found.passed and found.value is not None and found.value > 0.03, declared
