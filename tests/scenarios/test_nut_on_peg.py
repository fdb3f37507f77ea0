"""A nut of boxes of a foreign scene comes onto a square peg that stands, by a goal; onto one that it does not go over, it does not."""

from __future__ import annotations

from pathlib import Path

import pytest

from cramlite.cli.main import main

SCENE = Path(__file__).parents[1] / "plugins" / "imports" / "scenes_data" / "pegs.xml"


def _resolve(folder: Path, capsys: pytest.CaptureFixture[str], old: str = "", new: str = "") -> tuple[int, str]:
    text = SCENE.read_text()
    assert old in text
    (folder / "pegs.xml").write_text(text.replace(old, new) if old else text)
    scenario = folder / "nut.yaml"
    scenario.write_text("scenario: nut\nrobot: {type: ur5e}\nworld: {file: pegs.xml}\ngoal: [nut on post]\n")
    code = main(["resolve", str(scenario), "--twins", "0", "--no-report", "--out", str(folder / "run")])
    said = capsys.readouterr()
    return code, said.out + said.err


@pytest.mark.heavy
def test_a_nut_comes_onto_a_peg(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    code, said = _resolve(tmp_path, capsys)
    assert code == 0 and "Solved: Grasping -> PickingUp -> InsertHoleOntoPeg -> Releasing -> Retracting" in said, said
    assert "goal: 'nut on post' holds for the last 0.5 s" in said and "end_state: 'nut' hangs on 'post'" in said


@pytest.mark.parametrize(
    ("old", "new", "why"),
    [
        ('size="0.012 0.012 0.09"', 'size="0.0159 0.0159 0.09"', "no sequence of tasks leads"),
        ("<freejoint/>", "", "no task's rule makes supports(post, nut) true"),
    ],
    ids=["a peg as thick as the hole", "a nut that is glued to the table"],
)
def test_a_nut_does_not_come_onto_a_peg(
    old: str, new: str, why: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    code, said = _resolve(tmp_path, capsys, old, new)
    assert code == 1 and f"Nearest miss: candidate 1, goal: {why}" in said, said
