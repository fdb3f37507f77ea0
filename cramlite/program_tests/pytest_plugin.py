"""Plugin of pytest with the fixtures ``cramlite_robot`` and ``cramlite_world``; the engine is imported when a test uses one."""

from __future__ import annotations

from collections.abc import Generator
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from .robot import ProgramRobot

PAGES = "cramlite-failures"
"""Folder of the pages about failures, in pytest's root folder."""


def pytest_addoption(parser: pytest.Parser) -> None:
    """Declare cramlite's options of pytest."""
    group = parser.getgroup("cramlite", "tests of robot programs")
    group.addoption(
        "--cramlite-pages",
        type=Path,
        metavar="DIR",
        help=f"where pages about failed runs are written (default: {PAGES})",
    )
    group.addoption(
        "--cramlite-accept", action="store_true", help="write snapshots of runs anew, instead of comparing with them"
    )


def pytest_configure(config: pytest.Config) -> None:
    """Declare the pytest marker ``cramlite_fault``, which lets something go wrong in a test's runs."""
    config.addinivalue_line(
        "markers",
        "cramlite_fault(kind, **how): what goes wrong in every run of the test; see cramlite's page on testing programs",
    )


@pytest.fixture
def cramlite_world() -> str | None:
    """World in which a program runs if its test names none.

    A fixture of this name in a test suite gives one world to many tests.
    """
    return None


@pytest.fixture
def cramlite_robot(request: pytest.FixtureRequest, cramlite_world: str | None) -> ProgramRobot:
    """Robot that runs programs: ``cramlite_robot.run("pick.script", world="cell.yaml")``."""
    from ..scenario.faults import read_fault
    from .robot import ProgramRobot, TestPlace

    marks = list(request.node.iter_markers("cramlite_fault"))
    faults = tuple(read_fault(m.kwargs, f"{request.node.nodeid}, mark cramlite_fault") for m in marks)
    pages = request.config.getoption("--cramlite-pages") or request.config.rootpath / PAGES
    place = TestPlace(
        request.node.nodeid, request.path.parent, Path(pages), request.config.getoption("--cramlite-accept"), faults
    )
    return ProgramRobot(place, cramlite_world)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(call: pytest.CallInfo[None]) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """Show a user's error in a test as its message and the line of the test, without the engine's
    traceback."""
    report = yield
    error = call.excinfo.value if call.excinfo is not None else None
    if error is not None and (type(error).__module__, type(error).__name__) == ("cramlite.base.errors", "UserError"):
        assert call.excinfo is not None
        here = next((e for e in call.excinfo.traceback if e.path == report_path(report)), call.excinfo.traceback[0])
        report.longrepr = f"{here.path}:{here.lineno + 1}: {error}"
    return report


def report_path(report: pytest.TestReport) -> Path:
    """Return the file of the test that a pytest report is about."""
    return Path(report.fspath).absolute()
