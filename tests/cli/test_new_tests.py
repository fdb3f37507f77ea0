"""``cramlite new tests``: a suite around somebody's programs, which runs as it is."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

from conftest import Run

GOOD = "# for a UR5e\ndef good():\n  movej([0.1, -1.6, 1.3, -1.2, -1.57, 0], a=1, v=1)\nend\n"
LACKS = "def lacks():\n  modbus_set_output_signal(\"a\", True)\nend\n"
CLIENT = "import socket, sys\nwith socket.create_connection((sys.argv[1], 30002)) as robot:\n    robot.sendall(b'textmsg(1)\\n')\n"


def _write(folder: Path) -> None:
    (folder / "a").mkdir()
    (folder / "a" / "good.script").write_text(GOOD)
    (folder / "good.script").write_text(GOOD)
    (folder / "lacks.script").write_text(LACKS)
    (folder / "client.py").write_text(CLIENT)
    (folder / "helper.py").write_text("print('no robot here')\n")
    (folder / "notes.json").write_text("{}\n")


def test_a_suite_runs_as_it_is(run: Run, tmp_path: Path) -> None:
    _write(tmp_path)
    said = run("new", "tests", tmp_path)
    assert said.code == 0 and "cramlite show" in said.out
    tests = tmp_path / "robot_tests"
    text = (tests / "test_programs.py").read_text()
    assert [line.split("(")[0] for line in text.splitlines() if line.startswith("def")] == [
        "def test_good", "def test_client", "def test_good_2", "def test_lacks",
    ]  # fmt: skip
    assert "# line 2: cannot run here" in text and "helper" not in text and "notes" not in text
    assert "robot: {type: ur5e}" in (tests / "cell.yaml").read_text()
    assert "pytest -n auto robot_tests" in (tmp_path / ".github" / "workflows" / "robot-programs.yml").read_text()
    assert run("check", tests / "cell.yaml").code == 0
    command = [sys.executable, "-m", "pytest", "-p", "no:cacheprovider", "robot_tests", "-k", "not client"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert "2 passed, 1 deselected, 1 xfailed" in done.stdout, done.stdout


def test_what_is_there_stays(run: Run, tmp_path: Path) -> None:
    _write(tmp_path)
    assert run("new", "tests", tmp_path, "--out", tmp_path / "own").code == 0
    again = run("new", "tests", tmp_path, "--out", tmp_path / "own")
    assert again.code == 2 and "not an empty folder; nothing was written" in again.err
    (tmp_path / "none").mkdir()
    assert "holds no robot program" in run("new", "tests", tmp_path / "none").err
    assert "is no folder" in run("new", "tests", tmp_path / "nowhere").err
    assert "--from" in run("new", "tests", tmp_path, "--from", tmp_path / "x.xml").err


def test_a_program_with_a_syntax_error_fails(run: Run, tmp_path: Path) -> None:
    (tmp_path / "endless.script").write_text(GOOD.removesuffix("end\n"))
    assert run("new", "tests", tmp_path).code == 0
    assert "xfail" not in (tmp_path / "robot_tests" / "test_programs.py").read_text()
    command = [sys.executable, "-m", "pytest", "-p", "no:cacheprovider", "robot_tests"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 1 and "has no 'end'" in done.stdout, done.stdout
