"""Parts of an execution are killed by SIGKILL: the arm halts, the program says why it ends, and the recording can be read."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest
from helpers.killed import (
    BRAKING,
    ENDS,
    SILENT,
    WATCHDOG,
    client_of,
    killed_client,
    killed_controller,
    killed_executor,
    lost,
)

from cramlite.cli.main import main

CLIENT = pytest.mark.skipif(sys.version_info >= (3, 13), reason="ur_rtde has wheels for 3.11 and 3.12")
SCENARIO = "place_on_shelf"


@pytest.fixture(scope="module")
def run_of(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("killed")
    assert main(["resolve", SCENARIO, "--twins", "0", "--out", str(folder / "run"), "--no-report", "--json"]) == 0
    return folder / "run"


@pytest.mark.heavy
@CLIENT
@pytest.mark.parametrize("moment", [1.0, 11.0])
def test_the_arm_stands_within_the_watchdogs_time_once_its_program_is_killed(run_of: Path, moment: float, tmp_path: Path) -> None:
    stands = killed_client(client_of(run_of / "program.json", tmp_path), SCENARIO, tmp_path, moment)
    assert stands is not None and stands <= WATCHDOG + BRAKING


@pytest.mark.heavy
@CLIENT
@pytest.mark.parametrize("moment", [3.0, 7.5])
def test_a_program_ends_by_itself_and_says_why_once_its_controller_is_killed(run_of: Path, moment: float, tmp_path: Path) -> None:
    """In a motion, and where a command waits for the robot."""
    ended = killed_controller(client_of(run_of / "program.json", tmp_path), SCENARIO, tmp_path, moment)
    assert ended is not None
    seconds, code, said = ended
    assert seconds <= SILENT + ENDS and code == 1 and said.startswith("cramlite abort: "), ended


@pytest.mark.heavy
@pytest.mark.parametrize("seconds", [2.0, 6.0])
def test_what_an_executor_recorded_before_it_was_killed_can_be_read(run_of: Path, seconds: float, tmp_path: Path) -> None:
    fault = "moved: block, by: [0, 60 mm, 0], near: block, within: 0.18 m"
    command = ["execute", run_of / "program.script", "--world", SCENARIO, "--replan", SCENARIO, "--fault", fault]
    killed_executor(command, tmp_path / "out", seconds)
    assert not lost(tmp_path / "out")


def test_a_cut_record_is_seen(tmp_path: Path) -> None:
    (tmp_path / "round_1").mkdir()
    (tmp_path / "round_1" / "world.json").write_text("{")
    assert lost(tmp_path).startswith("round_1: ")
