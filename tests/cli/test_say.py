"""``--say`` as a process, in scenario files, and for clients of ``serve``."""

from __future__ import annotations

import io
import json
import subprocess
import sys
from pathlib import Path

import pytest
from helpers.as_a_user import cramlite

from cramlite import Engine
from cramlite.cli.serving.serve import Service

CELL = """scenario: cell
robot: {type: ur5e}
things:
  - {name: floor, model: table, at: {position: [0.2, 0, -5 mm]}, with: {size: [1.6 m, 1.6 m, 20 mm]}}
  - {name: shelf, model: table, at: {position: [0.45, -0.35, 0.15]}, with: {size: [0.25 m, 0.25 m, 20 mm]}}
  - {name: block_1, model: block, at: {position: [0.5, 0.2, 51 mm]}, with: {size: [50 mm, 50 mm, 100 mm]}}
  - {name: block_2, model: block, at: {position: [0.5, 0.0, 51 mm]}, with: {size: [50 mm, 50 mm, 100 mm]}}
"""


@pytest.fixture
def cell(tmp_path: Path) -> Path:
    path = tmp_path / "cell.yaml"
    path.write_text(CELL)
    return path


def test_a_sentence_is_planned_for_and_a_doubtful_one_asked_back_by_a_process(cell: Path) -> None:
    def asked(sentence: str) -> subprocess.CompletedProcess[str]:
        command = [sys.executable, "-m", "cramlite", "goal", str(cell), "--say", sentence]
        return subprocess.run(command, capture_output=True, text=True, timeout=120)

    done = asked("please put the left block on the shelf")
    assert done.returncode == 0 and "understood 'block_1 on shelf'" in done.stdout and "'the left block' is block_1" in done.stdout
    refused = asked("please put the block on the shelf")
    assert refused.returncode == 2 and refused.stdout == ""
    assert refused.stderr.count("\n") == 1, "one paragraph"
    assert "block_1 at (0.50, 0.20) m or block_2 at (0.50, 0.00) m; say 'the left block'" in refused.stderr


def test_an_empty_sentence_is_refused_by_its_option(cell: Path) -> None:
    refused = cramlite("goal", cell, "--say", " ")
    assert (refused.returncode, refused.stdout) == (2, "") and refused.stderr.startswith("cramlite: --say is empty; ")


def test_a_program_is_proven_for_a_sentence(cell: Path, tmp_path: Path) -> None:
    done = cramlite("resolve", cell, "--say", "put the right block onto the shelf", "--out", tmp_path / "run", "--twins", 0, "--no-report")
    assert done.returncode == 0, done.stderr
    assert "understood 'block_2 on shelf'" in done.stderr and "Understood: block_2 on shelf" in done.stdout
    entries = json.loads((tmp_path / "run" / "trace.json").read_text())["entries"]
    assert [e["text"] for e in entries if e["designator"] == "sentence"] == ["block_2 on shelf"]
    other = cramlite("resolve", cell, "--say", "put the left block onto the shelf", "--out", tmp_path / "run", "--twins", 0, "--no-report")
    assert other.returncode == 2 and "said" in other.stderr, "the run directory is that of another sentence"


def test_a_file_says_its_goal_in_a_sentence(cell: Path) -> None:
    cell.write_text(CELL + "goal: {say: put the left block on the shelf, view: robot}\n")
    assert "Grasping(Patient=block_1)" in cramlite("goal", cell).stdout
    cell.write_text(CELL + "goal: {say: put the block on the shelf}\n")
    refused = cramlite("goal", cell)
    assert refused.returncode == 2 and f"{cell}:8: " in refused.stderr
    cell.write_text(CELL + "goal: {say: put the left block on the shelf, veiw: robot}\n")
    assert "'veiw'" in cramlite("check", cell).stderr


def test_a_client_says_a_sentence(cell: Path) -> None:
    def check(**params: str) -> dict[str, object]:
        line = json.dumps({"id": 1, "method": "check", "params": {"scenario": str(cell), **params}})
        out = io.StringIO()
        Service(Engine(), io.StringIO(line + "\n"), out).run()
        answer: dict[str, object] = json.loads(out.getvalue().splitlines()[-1])
        return answer

    cell.write_text(CELL + "tasks: [{task: Grasping, Patient: block_1}]\n")
    assert "result" in check(say="put the left block on the shelf")
    assert "may be block_1" in str(check(say="put the block on the shelf")["error"])
    assert "leave one of them out" in str(check(say="put the left block on the shelf", goal="x")["error"])
