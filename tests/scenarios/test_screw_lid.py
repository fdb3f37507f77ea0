"""A lid that turns farther than a wrist in one grasp: it is turned in strokes, with the open hand turning back between them."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from cramlite import Engine, Solution, Trace, read_scenario

ENGINE = Engine()
BASES = {"ur5e": "", "fr3": ", at: {position: [0.05, 0, 0]}"}
LID = """scenario: screw_lid
tasks:
  - {{task: {task}, Patient: lid}}
robot: {{type: {robot}{base}}}
things:
  - {{name: floor, model: table, at: {{position: [0.2, 0, -5 mm]}}, with: {{size: [1.6 m, 1.6 m, 20 mm]}}}}
  - {{name: counter, model: table, at: {{position: [0.5, 0, 0.15]}}, with: {{size: [0.5 m, 0.9 m, 40 mm]}}}}
  - {{name: jar, model: jar, at: {{position: [0.45, 0.05, 0.24]}}}}
  - {{name: lid, model: screw_lid, at: {{position: [0.45, 0.05, 0.24]}}, with: {{parent: jar, turns: 1.5, {lid}}}}}
budget: {{proofs: {proofs}}}
"""


def turned(folder: Path, task: str, robot: str, lid: str, twins: int = 0, proofs: int = 4) -> tuple[Solution | None, str]:
    """The first solution, and the reasons of refusals."""
    path, trace = folder / "screw_lid.yaml", Trace()
    path.write_text(LID.format(task=task, robot=robot, base=BASES[robot], lid=lid, proofs=proofs), encoding="utf-8")
    scenario = read_scenario(path)
    found = next(ENGINE.resolve(scenario, setting=ENGINE.setting(scenario, seed=0, twins=twins), seed=0, trace=trace), None)
    return found, "; ".join(e.reason for e in trace.entries)


@pytest.mark.heavy
@pytest.mark.parametrize("robot", BASES)
def test_a_lid_is_screwed_shut_in_strokes(robot: str, tmp_path: Path) -> None:
    solution, reasons = turned(tmp_path, "Closing", robot, "turned: 0.9", twins=8)
    assert solution is not None, reasons
    twins = next(f for f in solution.verdict.findings if f.validator == "twins")
    candidate = solution.candidate
    assert twins.passed and candidate.rollout is not None and candidate.episode is not None
    held = [e for e in candidate.episode.of("state") if e.type == "cram:GraspState"]
    assert len(held) == math.ceil(0.9 * 360 / 150) and candidate.rollout.values["lid"][-1] < 0.05 * 1.5 * math.tau


@pytest.mark.heavy
def test_a_lid_is_unscrewed_in_strokes(tmp_path: Path) -> None:
    solution, reasons = turned(tmp_path, "Opening", "ur5e", "turned: 0.0")
    assert solution is not None and solution.candidate.rollout is not None, reasons
    assert solution.candidate.rollout.values["lid"][-1] > 0.8 * 1.5 * math.tau


@pytest.mark.heavy
def test_a_lid_that_is_stuck_is_refused(tmp_path: Path) -> None:
    solution, reasons = turned(tmp_path, "Closing", "ur5e", "turned: 1.3, joint_friction: 20", proofs=1)
    assert solution is None and "'joint_falls(Patient) or" in reasons
