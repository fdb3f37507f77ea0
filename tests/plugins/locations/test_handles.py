"""How far a drawer is opened: as far as it is asked for, else as far as it goes and the arm comes."""

from __future__ import annotations

from pathlib import Path

import pytest

from cramlite import Budget, Engine, find_scenario, read_scenario

ENGINE = Engine()
POST = "  - {name: post, model: table, at: {position: [0.55, 0.22, 0.45]}, with: {size: [20 mm, 20 mm, 0.4 m]}}\n"
"""It stands where the front comes to when the drawer is open by 182 mm of its 200 mm."""


def _opened(folder: Path, task: str, more: str) -> float | None:
    """How far the drawer is open in the end [m]; None where no program opens it so."""
    text = find_scenario("tasks/opening").read_text()
    head, _, things = text.partition("things:\n")
    path = folder / "opening.yaml"
    path.write_text(head.replace("Patient: drawer", f"Patient: drawer{task}") + "things:\n" + more + things.partition("#")[0])
    scenario = read_scenario(path)
    setting = ENGINE.setting(scenario, twins=0)
    found = next(ENGINE.resolve(scenario, setting=setting, budget=Budget(expansions=400)), None)
    if found is None:
        return None
    closed, there = (b.poses["drawer"].pose for b in (setting.belief(), found.candidate.belief))
    return closed.distance(there)[0]


@pytest.mark.parametrize(
    ("task", "more", "metres"),
    [("", "", 0.19), ("", POST, 0.16), (", parameters: {share: 0.5}", "", 0.10), (", parameters: {share: 0.95}", POST, None)],
)
def test_it_is_opened_as_far_as_it_goes_unless_asked_otherwise(task: str, more: str, metres: float | None, tmp_path: Path) -> None:
    assert _opened(tmp_path, task, more) == (metres if metres is None else pytest.approx(metres, abs=0.005))
