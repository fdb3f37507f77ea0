"""The plan language in physics: a search that is too small fails, and the program itself tries again; sliding, and its limit."""

from __future__ import annotations

from pathlib import Path

import pytest

from cramlite import Budget, Engine, Trace, read_scenario
from cramlite.model import Rollout, SpiralSearch, walk

SHIPPED = Path(__file__).parents[2] / "scenarios" / "retry_on_hanger.yaml"
SLIDE = """
scenario: slide
tasks:
  - {{task: Grasp, Patient: box}}
  - {{task: SlideObject, Locatum: box, Relatum: floor, parameters: {{force_limit_n: {limit}}}}}
robot: {{type: ur5e}}
things:
  - {{name: floor, model: table, at: {{position: [0.2, 0, -5 mm]}}, with: {{size: [1.6 m, 1.6 m, 20 mm]}}}}
  - {{name: box, model: block, at: {{position: [0.5, 0.2, 51 mm]}}, with: {{size: [50 mm, 50 mm, 100 mm]}}}}
"""


TOO_FAR = 1
"""Seed with which the hanger is further off than the first search reaches."""


def resolved(path: Path, seed: int = 0) -> tuple[Rollout | None, str]:
    """The execution of the first program that is proven, of one that may be tried, where it succeeds; and what was said."""
    trace, engine = Trace(), Engine()
    solution = next(engine.resolve(read_scenario(path), seed=seed, budget=Budget(proofs=1), trace=trace), None)
    if solution is None:
        return None, "; ".join(e.reason for e in trace.entries if e.designator == "proof")
    execution = engine.execute(solution).execution
    assert execution is not None
    return (execution.candidate.rollout if execution.verdict.passed else None), execution.verdict.reason


@pytest.mark.heavy
def test_the_second_attempt_finds_what_the_first_one_did_not() -> None:
    rollout, _ = resolved(SHIPPED, TOO_FAR)
    assert rollout is not None
    log = "\n".join(m.text for m in rollout.messages)
    assert "cramlite failed: 3.retry, attempt 1: 4.InsertHoleOntoPeg/search: nothing gave way within a radius" in log
    assert "4.InsertHoleOntoPeg/attempt_2/push: inserted" in log


@pytest.mark.heavy
def test_without_the_retry_the_small_search_ends_the_program(tmp_path: Path) -> None:
    text, once = SHIPPED.read_text(), "  - {task: InsertHoleOntoPeg,"
    begin, end = text.index("  - retry:"), text.index("  - {task: Releasing")
    call = text[begin:end].split("do: {task: InsertHoleOntoPeg,")[1].split("\n")[0]
    path = tmp_path / "once.yaml"
    path.write_text(f"{text[:begin]}{once}{call}\n{text[end:]}")
    rollout, said = resolved(path, TOO_FAR)
    assert rollout is None
    assert "nothing gave way within a radius of 0.001 m" in said


@pytest.mark.heavy
@pytest.mark.parametrize(("limit", "slides"), [(25, "yes"), (12.5, "2.SlidingObject/stroke: force "), (1.5, "it presses with 12 N")])
def test_a_thing_slides_until_the_force_is_too_much(limit: float, slides: str, tmp_path: Path) -> None:
    path = tmp_path / "slide.yaml"
    path.write_text(SLIDE.format(limit=limit))
    rollout, said = resolved(path)
    assert (rollout is not None) == (slides == "yes"), said
    if rollout is not None:
        way = rollout.poses["box"][-1, :2] - rollout.poses["box"][0, :2]
        assert 0.07 < float((way @ way) ** 0.5) < 0.09
    else:
        assert slides in said and f"{limit} N" in said


@pytest.mark.heavy
@pytest.mark.parametrize(("times", "searches"), [(None, 5), (1, 1), (3, 3)])
def test_the_task_itself_begins_again_as_often_as_it_is_told(times: int | None, searches: int, tmp_path: Path) -> None:
    """What the run cannot do three times ends it: a hole of 7 mm jams on the bent tip each time (test_hang_onto_hanger.py)."""
    text, given = SHIPPED.read_text(), "" if times is None else f", parameters: {{attempts: {times}}}"
    begin, end = text.index("  - retry:"), text.index("  - {task: Releasing")
    once = f"  - {{task: InsertHoleOntoPeg, Locatum: coffee, Relatum: hook/peg{given}}}\n"
    path = tmp_path / "times.yaml"
    path.write_text(text[:begin] + once + text[end:])
    solution = next(Engine().resolve(read_scenario(path), budget=Budget(proofs=1)))
    assert sum(isinstance(s, SpiralSearch) for s in walk(solution.program.steps)) == searches
    assert "Releasing" in "".join(s.origin for s in solution.program.steps[-8:])
