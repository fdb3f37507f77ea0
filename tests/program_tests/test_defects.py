"""Defects of robot programs as users met them: a test that a user would write refuses each, and passes for its mended twin."""

from __future__ import annotations

import re
from pathlib import Path
from types import CodeType
from typing import Any

import pytest
import yaml

from cramlite.program_tests.miss import ProgramFailure
from cramlite.program_tests.robot import ProgramRobot, TestPlace

FOLDER = Path(__file__).parent / "defects"
DEFECTS = {p.stem: yaml.safe_load(p.read_text()) for p in sorted(FOLDER.glob("*.yaml")) if p.stem != "cell"}
KEYS = {"kind", "met", "program", "mended", "bad", "test", "because"}
PAGE = Path(__file__).parents[2] / "docs" / "reference" / "program_defects.md"


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
    robot = ProgramRobot(TestPlace(f"test_defects.py::test_{name}", FOLDER, pages), "cell.yaml")
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


def test_there_are_twenty_kinds() -> None:
    assert len(DEFECTS) == 20
    assert {name for name, d in DEFECTS.items() if set(d) != KEYS} == set()
