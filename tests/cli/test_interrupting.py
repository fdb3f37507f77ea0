"""Ctrl+C and SIGTERM end ``resolve`` soon, and leave what was found."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from conftest import Run

from cramlite.base.pulse import checkpoint, pulse
from cramlite.cli.signals import Interrupted, interruptible

COMMAND = [sys.executable, "-m", "cramlite", "resolve"]
SOON = 30.0
"""Seconds of a busy machine; drawings alone would take some."""


def interrupted(run: Path, scenario: str, number: signal.Signals, when: str = "program 1: ") -> tuple[int, str]:
    """Exit code and output of a resolution that gets a signal at a line of progress: when its first program begins to run."""
    with subprocess.Popen([*COMMAND, scenario, "--out", run], stderr=subprocess.PIPE, text=True) as process:
        assert process.stderr is not None
        before = next(line for line in process.stderr if when in line)
        began = time.monotonic()
        process.send_signal(number)
        said = before + process.stderr.read()
        assert process.wait() and time.monotonic() - began < SOON
    return process.returncode, said


@pytest.mark.heavy
@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), pytest.param(signal.SIGTERM, 143, marks=pytest.mark.heavy)])
def test_trace_report_and_nearest_miss_are_left(tmp_path: Path, number: signal.Signals, code: int) -> None:
    ended, said = interrupted(tmp_path, "tasks/pouring", number)
    assert ended == code, said
    assert "the search was interrupted after" in said and "(program 1 runs); no program was refused yet" in said
    assert f"What was tried until then: {tmp_path}. The same command goes on there." in said
    entries = json.loads((tmp_path / "trace.json").read_text())["entries"]
    assert "stop" in {e["kind"] for e in entries} and "proof" not in {e["kind"] for e in entries}
    page = (tmp_path / "report.html").read_text()
    assert "was not drawn, since the command was interrupted" in page and "Why nothing was proven" in page
    assert "data:image/webp" not in page
    assert json.loads((tmp_path / "manifest.json").read_text())["refused"] == [], "what was not tried to its end is tried again"


@pytest.mark.heavy
def test_a_signal_behind_the_proof_leaves_the_program_and_a_report_without_drawings(tmp_path: Path, run: Run) -> None:
    ended, said = interrupted(tmp_path / "run", "grasp_one_thing", signal.SIGINT, "writing the report")
    assert ended == 130 and "A program was proven; interrupted before the report was complete" in said
    assert {"program.script", "verdict.json", "trace.json"} <= {f.name for f in (tmp_path / "run").iterdir()}
    page = (tmp_path / "run" / "report.html").read_text()
    assert "was not drawn, since the command was interrupted" in page and "Program proven" in page
    assert run("resolve", "grasp_one_thing", "--out", tmp_path / "run").code == 0
    assert "It draws" not in (tmp_path / "run" / "report.html").read_text()


@pytest.mark.heavy
def test_the_same_command_goes_on(tmp_path: Path, run: Run) -> None:
    assert interrupted(tmp_path / "run", "grasp_one_thing", signal.SIGTERM)[0] == 143
    done = run("resolve", "grasp_one_thing", "--out", tmp_path / "run")
    assert done.code == 0, done.err
    assert "It draws" not in (tmp_path / "run" / "report.html").read_text()


def test_a_second_signal_ends_what_does_not_listen() -> None:
    before = signal.getsignal(signal.SIGINT)
    with interruptible() as came:
        signal.raise_signal(signal.SIGINT)
        assert came.one() and came.number == signal.SIGINT
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(signal.SIGINT)
    assert signal.getsignal(signal.SIGINT) is before


def test_work_between_is_interrupted() -> None:
    with pytest.raises(Interrupted) as ended:
        terminate_and_go_on()
    assert ended.value.exit_code == 143


def terminate_and_go_on() -> None:
    with interruptible() as came, pulse(came.one):
        checkpoint()
        signal.raise_signal(signal.SIGTERM)
        time.sleep(0.2)
        checkpoint()
