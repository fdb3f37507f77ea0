"""Defects of robot programs as users met them: a test that a user would write refuses each, and passes for its mended twin."""

from __future__ import annotations

import os
import re
from pathlib import Path
from types import CodeType
from typing import Any

import pytest
from defects_table import DEFECTS, FOLDER, PAGE, table

from cramlite.program_tests.miss import ProgramFailure
from cramlite.program_tests.robot import ProgramRobot, TestPlace

KEYS = {"kind", "met", "program", "mended", "bad", "test", "because"}
OTHERS = Path(os.environ.get("CRAMLITE_URSCRIPT", "")) / "rparak+URScript_Examples"
"""Programs of others (github.com/rparak/URScript_Examples), which are not part of this project; left out where they are not."""
PALLET = "Pick_Place_UR10e_Simulation_PickAndPlace_App_Final.script"
IN_OTHERS = {
    "too fast": ("v=0.1)", "v=2.0)", "the tool moves with"),
    "units": ("v_obj_height=0.030", "v_obj_height=30", "protective stop"),
    "another branch": (", qnear=Waypoint_Home_q", "", "the elbow stays as it was taught"),
}


def text_of(defect: dict[str, Any]) -> str:
    """The mended program: its own text, or a file's."""
    written: str = defect["program"]
    return (FOLDER / written).read_text() if written.endswith(".script") else written


def planted(defect: dict[str, Any]) -> str:
    """The program with the defect in place of what mends it."""
    text = text_of(defect)
    assert defect["mended"] in text, f"{defect['mended']!r} is not in the program"
    return text.replace(defect["mended"], defect["bad"])


def asked(defect: dict[str, Any], name: str) -> CodeType:
    """The user's test."""
    return compile(defect["test"], f"{name}.yaml", "exec")


def run_test(name: str, program: str, pages: Path) -> None:
    robot = ProgramRobot(TestPlace(f"test_defects.py::test_{name}", FOLDER, pages), "cells/cell.yaml")
    exec(asked(DEFECTS[name], name), {"cramlite_robot": robot, "program": program})  # the files are part of these tests


@pytest.mark.heavy
@pytest.mark.parametrize("name", DEFECTS)
def test_a_defect_is_refused_for_its_reason(name: str, tmp_path: Path) -> None:
    with pytest.raises(ProgramFailure) as raised:
        run_test(name, planted(DEFECTS[name]), tmp_path)
    assert re.search(DEFECTS[name]["because"], str(raised.value)), raised.value


@pytest.mark.heavy
@pytest.mark.parametrize("name", DEFECTS)
def test_its_mended_twin_passes(name: str, tmp_path: Path) -> None:
    run_test(name, text_of(DEFECTS[name]), tmp_path)


def test_there_are_twenty_three_kinds() -> None:
    assert len(DEFECTS) == 23
    assert {name for name, d in DEFECTS.items() if set(d) != KEYS} == set()


def test_the_page_lists_them() -> None:
    assert PAGE.read_text(encoding="utf-8").endswith(table()), "write the page: python tests/program_tests/defects_table.py"


def _ask_others(program: str, pages: Path) -> None:
    run = ProgramRobot(TestPlace("test_defects.py::test_others", FOLDER, pages), "cells/stand.yaml").run(program)
    run.moves(0.5).stops("halt, without a message").never_touches("hand", "table")
    run.holds(lambda rollout: rollout.joints[:, 2].max() < 1.7, "the elbow stays as it was taught")


@pytest.mark.heavy
@pytest.mark.skipif(not OTHERS.is_dir(), reason="programs of others are not here: set CRAMLITE_URSCRIPT")
@pytest.mark.parametrize("name", IN_OTHERS)
def test_defects_in_a_program_of_others(name: str, tmp_path: Path) -> None:
    text = (OTHERS / PALLET).read_text(encoding="utf-8")
    mended, bad, because = IN_OTHERS[name]
    assert mended in text
    _ask_others(text, tmp_path)
    with pytest.raises(ProgramFailure, match=because):
        _ask_others(text.replace(mended, bad), tmp_path)
