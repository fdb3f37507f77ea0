"""A validator that a scenario lets advise only refuses nothing, and what it objects to is told all the same."""

from __future__ import annotations

from pathlib import Path

import pytest

from cramlite import Budget, Engine, Solution, Trace, UserError, find_scenario, read_scenario
from cramlite.cli.texts import _finding_lines

STRICT = "bystander_motion: 0 mm, bystander_tilt: 0 deg"
"""Whatever trembles has moved."""


def resolved(folder: Path, limits: str, twins: int = 0) -> tuple[Solution | None, Trace]:
    """A shipped scenario with other limits: the first program within one proof, and the trace."""
    path, trace, engine = folder / "limited.yaml", Trace(), Engine()
    path.write_text(find_scenario("place_on_shelf").read_text().replace("robot:", f"limits: {{{limits}}}\nrobot:", 1))
    scenario = read_scenario(path)
    setting = engine.setting(scenario, twins=twins)
    return next(engine.resolve(scenario, setting=setting, trace=trace, budget=Budget(proofs=1)), None), trace


def test_an_objection_refuses(tmp_path: Path) -> None:
    solution, trace = resolved(tmp_path, STRICT)
    assert solution is None and any("bystanders: " in e.reason for e in trace.entries if e.kind == "proof")


def test_advice_is_told_and_refuses_nothing(tmp_path: Path) -> None:
    solution, _ = resolved(tmp_path, f"{STRICT}, advisory: [bystanders]", twins=1)
    assert solution is not None and solution.verdict.passed and solution.verdict.twins is not None
    assert {f.validator for f in solution.verdict.advice} == {"bystanders"}
    said = solution.verdict.advice[0]
    assert said.passed and said.reason.startswith("advises only: ") and "limit 0 mm of the scenario" in said.reason
    assert any(line.startswith("    --  bystanders: advises only") for line in _finding_lines(solution.verdict))


def test_one_that_advises_spares_nobody_else(tmp_path: Path) -> None:
    solution, trace = resolved(tmp_path, f"{STRICT}, advisory: [goal]")
    assert solution is None and any("bystanders: " in e.reason for e in trace.entries if e.kind == "proof")


def test_a_validator_that_there_is_not_is_refused(tmp_path: Path) -> None:
    with pytest.raises(UserError, match=r"limited.yaml:\d+: no validator 'bystander'; did you mean 'bystanders'"):
        resolved(tmp_path, "advisory: [bystander]")
