"""A validator in advisory mode refuses nothing, and its findings are printed all the same."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from msgspec.structs import replace

from cramlite import Budget, Engine, Finished, Solution, Trace, UserError, find_scenario, read_scenario
from cramlite.base.run_directory import RunDirectory
from cramlite.cli.run_files import solution_summary
from cramlite.cli.serving.answers import solution_answer
from cramlite.cli.texts import _finding_lines, findings_text, solution_text
from cramlite.engine.proof.proof import findings_of
from cramlite.model import JudgingLimits
from cramlite_plugins.reports import summary

STRICT = "may_push: true"
"""The drawer drives a board before it, by 100 mm."""


def resolved(folder: Path, limits: str, twins: int = 0) -> tuple[Solution | None, Trace]:
    """A shipped scenario with other limits: the first program within one proof, and the trace."""
    path, trace, engine = folder / "limited.yaml", Trace(), Engine()
    text = find_scenario("kitchen/board_driven_along").read_text()
    path.write_text(re.sub(r"^limits: .*$", f"limits: {{{limits}}}", text, count=1, flags=re.MULTILINE))
    scenario = read_scenario(path)
    setting = engine.setting(scenario, twins=twins)
    return next(engine.resolve(scenario, setting=setting, trace=trace, budget=Budget(proofs=1)), None), trace


@pytest.mark.heavy
def test_an_objection_refuses(tmp_path: Path) -> None:
    solution, trace = resolved(tmp_path, STRICT)
    assert solution is None and any("bystanders: " in e.reason for e in trace.entries if e.kind == "proof")


@pytest.mark.heavy
def test_advice_is_told_and_refuses_nothing(tmp_path: Path) -> None:
    solution, _ = resolved(tmp_path, f"{STRICT}, advisory: [bystanders]", twins=1)
    assert solution is not None and solution.verdict.passed and solution.verdict.twins is not None
    assert {f.validator for f in solution.verdict.advice} == {"bystanders"}
    said = solution.verdict.advice[0]
    assert said.passed and said.reason.startswith("advises only: ") and "limit 5 mm by default" in said.reason
    assert any(line.startswith("    --  bystanders: advises only") for line in _finding_lines(solution.verdict))


@pytest.mark.heavy
def test_whoever_says_whether_a_program_does_what_it_is_for_may_not_advise_only(tmp_path: Path) -> None:
    may = [v.name for v in Engine().knowledge.validators if getattr(v, "may_advise", False)]
    assert may == ["bystanders"]
    for name in (v.name for v in Engine().knowledge.validators if v.name not in may):
        said = rf"limited.yaml:\d+: validator '{name}' may not advise only, .*; only bystanders may"
        with pytest.raises(UserError, match=said) as caught:
            resolved(tmp_path, f"advisory: [{name}]")
        assert "\n" not in str(caught.value)


@pytest.mark.heavy
def test_limits_that_say_more_than_validators_declare_are_not_heeded(tmp_path: Path) -> None:
    """A program that halts is refused, whatever is asked for by hand."""
    engine, scenario = Engine(), read_scenario(find_scenario("place_on_shelf"))
    solution = next(engine.resolve(scenario, setting=engine.setting(scenario, twins=0)))
    halts = replace(solution.candidate, limits=JudgingLimits(advisory=("execution", "goal", "bystanders")))
    assert halts.rollout is not None
    halts = replace(halts, rollout=replace(halts.rollout, outcome="halted", reason="it was told to"))
    (said,) = (f for f in findings_of(halts, engine.knowledge, rollout=True, only=["execution"]))
    assert not said.passed and not said.advice


def test_what_only_advises_stands_in_the_headline(tmp_path: Path) -> None:
    solution, _ = resolved(tmp_path, f"{STRICT}, advisory: [bystanders]")
    assert solution is not None and solution.headline == "Solved, with advice"
    assert solution_text(solution, "").startswith("Solved, with advice: Opening")
    assert solution_answer(solution)["headline"] == "Solved, with advice"
    run = RunDirectory(tmp_path / "run", {})
    said = solution_summary(solution, run, Engine(), 0)
    assert said["headline"] == "Solved, with advice" and said["advice"] == [f.reason for f in solution.advice] != []
    page = Finished(Engine(), run, solution.setting, solution.trace, solution, None, None)
    assert page.outcome == "program proven, with advice" and "Proven, with advice" in summary.render(page)
    assert findings_text(solution.verdict, ()).startswith("Passed, with advice:")


@pytest.mark.heavy
def test_nobody_who_advises_and_has_nothing_to_say_stands_in_it(tmp_path: Path) -> None:
    solution, _ = resolved(tmp_path, f"{STRICT}, bystander_motion: 200 mm, advisory: [bystanders]")
    assert solution is not None and solution.advice == () and solution.headline == "Solved"
    assert findings_text(solution.verdict, ()).startswith("Passed:")


@pytest.mark.parametrize(
    ("limits", "may"),
    [("brush: 2 N", False), ("advisory: [bystanders]", True), ("may_push: true", True), ("advisory: [bystanders], may_push: false", False)],
)
def test_planning_is_permitted_to_push_by_a_word_of_its_own(tmp_path: Path, limits: str, may: bool) -> None:
    path = tmp_path / "limited.yaml"
    text = find_scenario("kitchen/board_driven_along").read_text()
    path.write_text(re.sub(r"^limits: .*$", f"limits: {{{limits}}}", text, count=1, flags=re.MULTILINE))
    assert Engine().setting(read_scenario(path)).limits.may_push is may


def test_a_validator_that_there_is_not_is_refused(tmp_path: Path) -> None:
    with pytest.raises(UserError, match=r"limited.yaml:\d+: no validator 'bystander'; did you mean 'bystanders'"):
        resolved(tmp_path, "advisory: [bystander]")


def test_what_must_keep_its_place_is_in_the_world(tmp_path: Path) -> None:
    with pytest.raises(UserError, match=r"limited.yaml:\d+: no thing 'nobody'; "):
        resolved(tmp_path, "keep: {nobody: 1 mm}")
