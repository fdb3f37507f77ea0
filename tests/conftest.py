"""Helpers of tests of the command line: they run it, in this process or in another, and spoil shipped scenarios."""

from __future__ import annotations

import argparse
import gc
import os
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import pytest
from helpers.properties import load_profile
from helpers.times import ASKED, Times
from hypothesis import is_hypothesis_test

from cramlite import Engine, Solution, find_scenario, read_scenario
from cramlite.cli.main import main, parser

ROOT = Path(__file__).parent.parent
(_COMMANDS,) = (a for a in parser()._actions if isinstance(a, argparse._SubParsersAction))
COMMANDS = sorted(_COMMANDS.choices)
"""Every command of the command line."""
os.environ["CRAMLITE_TWINS"] = "0"  # programs are proven by the nominal run alone, unless a test is about doubts and asks for twins
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)  # processes that tests start share compiled modules: else each compiles all again
sys.dont_write_bytecode = False
TASKS = ROOT / "scenarios" / "take_off_hanger_tasks.yaml"
SMALL = ROOT / "scenarios" / "grasp_one_thing.yaml"
"""A scenario of one task: for what does not depend on which tasks are resolved."""
PLANNED = "tasks/transporting"
"""A small scenario whose paths are sampled: another seed gives another text."""


def pytest_configure(config: pytest.Config) -> None:
    """Choose fixed or fresh seeds before a test file is imported; measure times where these are asked for.

    Nothing that is collected is garbage: no cycles are looked for until that is done.
    """
    gc.disable()
    load_profile(config.option.markexpr)
    if path := os.environ.get(ASKED):
        config.pluginmanager.register(Times(Path(path).absolute(), config.option.markexpr))


def pytest_collection_finish() -> None:
    """Look for cycles as rarely as ``cramlite.cli.main`` does in a process of its own: most objects stay."""
    gc.freeze()
    gc.set_threshold(200_000, 30, 30)
    gc.enable()


def pytest_itemcollected(item: pytest.Item) -> None:
    """Mark every property test ``fuzz``, so that no list of them can be out of date."""
    if is_hypothesis_test(getattr(item, "obj", None)):
        item.add_marker("fuzz")


@dataclass(frozen=True)
class Ran:
    """A command that ended: exit code, standard output, standard error."""

    code: int
    out: str
    err: str


Run = Callable[..., Ran]


Proven = Callable[[str], Solution]


@pytest.fixture(scope="session")
def proven() -> Proven:
    """The first program of a shipped scenario at seed 0, resolved once for all tests of a process that look at it."""
    return cache(lambda name: next(Engine().resolve(read_scenario(find_scenario(name)))))


@pytest.fixture
def run(capsys: pytest.CaptureFixture[str]) -> Run:
    """Run one command in this process."""

    def go(*arguments: object) -> Ran:
        try:
            code = main([str(a) for a in arguments])
        except SystemExit as stop:
            code = int(stop.code or 0)
        captured = capsys.readouterr()
        return Ran(code, captured.out, captured.err)

    return go


@pytest.fixture
def process() -> Run:
    """Run one command in a process of its own."""

    def go(*arguments: object) -> Ran:
        command = [sys.executable, "-m", "cramlite", *map(str, arguments)]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        return Ran(done.returncode, done.stdout, done.stderr)

    return go


@pytest.fixture
def spoiled(tmp_path: Path) -> Callable[..., Path]:
    """The shipped task scenario with some text replaced."""

    def write(*changes: tuple[str, str]) -> Path:
        text = TASKS.read_text()
        for old, new in changes:
            assert old in text, f"'{old}' is not in {TASKS}"
            text = text.replace(old, new, 1)
        path = tmp_path / "spoiled.yaml"
        path.write_text(text)
        return path

    return write


@pytest.fixture
def plugin(tmp_path: Path) -> Callable[[str, str], Path]:
    """A plugin module of that name, written to a file."""

    def write(name: str, body: str) -> Path:
        path = tmp_path / f"{name}.py"
        path.write_text(f"from cramlite.model import *\nfrom cramlite.plugin import *\n\n{body}")
        return path

    return write
