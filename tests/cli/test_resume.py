"""A stopped run goes on where it stopped; a finished one is not done again."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from conftest import Run

from cramlite import find_scenario

COMMAND = [sys.executable, "-m", "cramlite", "resolve"]

WORLD = """
scenario: two_ways
demonstration: {demonstration}
robot: {{type: ur5e}}
budget: {{proofs: 1}}
things:
  - {{name: hook, model: hanger, at: {{position: [0.87, 0, 0.45], yaw: 180 deg}}, with: {{friction: 30}}}}
  - {{name: tea, model: boxed_product, type: cram:TeaBox, hangs_on: {{hanger: hook, depth: 70 mm}}, with: {{friction: 30}}}}
  - {{name: basket, model: basket, at: {{position: [0.30, -0.45, 0]}}}}
"""


@pytest.mark.heavy
def test_a_killed_run_keeps_what_it_refused(tmp_path: Path) -> None:
    """The peg jams, so every candidate is refused; the run is killed as soon as the first one is."""
    scenario, run = tmp_path / "two_ways.yaml", tmp_path / "run"
    shipped = Path(__file__).parents[2] / "scenarios" / "fetch_from_hanger" / "demonstration"
    scenario.write_text(WORLD.format(demonstration=shipped))
    process = subprocess.Popen([*COMMAND, scenario, "--out", run], stderr=subprocess.PIPE, text=True)
    manifest = run / "manifest.json"
    while process.poll() is None and not (manifest.is_file() and json.loads(manifest.read_text())["refused"]):
        time.sleep(0.02)
    process.send_signal(signal.SIGKILL)
    process.wait()
    before = json.loads(manifest.read_text())["refused"]
    assert before[:1] == [1]
    done = subprocess.run([*COMMAND, scenario, "--out", run], capture_output=True, text=True, check=False)
    assert done.returncode == 1, done.stderr
    assert "program 1 refused: " in done.stderr and "ExtractHoleFromPeg" in done.stderr
    assert "candidate 1:" not in done.stderr.split("No solution")[0]
    assert "candidate 1, proof" in done.stderr or "candidates 1 to 4, proof" in done.stderr
    entries = json.loads((run / "trace.json").read_text())["entries"]
    assert {e["candidate"] for e in entries} == {1, 2, 3, 4}  # as many readings agree with themselves
    assert [e["number"] for e in entries] == list(range(1, len(entries) + 1))


def test_a_finished_run_is_not_done_again(run: Run, tmp_path: Path) -> None:
    arguments = ("resolve", "grasp_one_thing", "--out", tmp_path / "run", "--no-report", "--json")
    first = run(*arguments)
    assert first.code == 0, first.err
    program = tmp_path / "run" / "program.script"
    written = program.stat().st_mtime_ns
    again = run(*arguments)
    assert again.code == 0
    assert program.stat().st_mtime_ns == written
    assert json.loads(again.out)["plan"] == json.loads(first.out)["plan"]


@pytest.mark.heavy
def test_wider_rounds_are_tried_and_not_again(run: Run, tmp_path: Path) -> None:
    """A post hangs in the way of hands, not of the drawer: more of them than the first round tries take the handle, and none gets far."""
    text = find_scenario("tasks/opening_blocked").read_text()
    for old, new in (("[0.66, 0.20, 0.45]", "[0.50, 0.10, 0.62]"), ("[20 mm, 20 mm, 0.4 m]", "[40 mm, 40 mm, 0.4 m]")):
        assert old in text
        text = text.replace(old, new)
    (tmp_path / "post.yaml").write_text(text)
    arguments = ("resolve", tmp_path / "post.yaml", "--out", tmp_path / "run", "--no-report")
    first = run(*arguments)
    assert first.code == 1 and "candidate 1: Opening, with 2 times as many alternatives as in the first round" in first.err
    assert "No solution: every alternative was refused." in first.err, "what the first round left out, a wider one tried"
    spent = json.loads((tmp_path / "run" / "manifest.json").read_text())["spent"]["1"]
    assert spent["breadth"] >= 2 and not spent["capped"]
    again = run(*arguments)
    assert again.code == 1 and "candidate 1: Opening" not in again.err.split("No solution")[0]
    assert again.err.split("No solution")[1] == first.err.split("No solution")[1]
