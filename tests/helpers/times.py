"""Processor time of the tests, by folder and of the longest: printed after a run, added to the file that CRAMLITE_TEST_TIMES names."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Generator
from pathlib import Path
from typing import Any

import pytest

ASKED = "CRAMLITE_TEST_TIMES"
"""Environment variable that names the file to which the processor times are added."""
LONGEST = 20
"""How many tests are listed one by one."""
PARTS = {"plugins": 3}
"""Folders of tests whose subfolders are counted separately -> number of path parts of the subfolders."""


class Times:
    """Plugin of pytest that measures processor time in each worker and sums it up in the main process.

    Time is the processor's, that of ended children included: it does not depend on what else runs.
    """

    def __init__(self, path: Path, marks: str) -> None:
        self.path, self.marks = path, marks
        self.seconds, self.count, self.tests, self._last = Counter[str](), Counter[str](), Counter[str](), spent()

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_makereport(self) -> Generator[None, Any, Any]:
        """Add to a report the processor time since the report before."""
        report = yield
        now = spent()
        report.processor, self._last = now - self._last, now
        return report

    def pytest_runtest_logreport(self, report: Any) -> None:
        """Add the processor time of a report of this process or of a worker to the sums."""
        folder, seconds = folder_of(report.nodeid), getattr(report, "processor", 0.0)
        self.seconds[folder] += seconds
        self.tests[report.nodeid] += seconds
        self.count[folder] += report.when == "call"

    def pytest_terminal_summary(self, terminalreporter: Any) -> None:
        """Print the table of processor times and append it to the file; a worker has no terminal."""
        terminalreporter.write_line(self.table())
        self.path.parent.mkdir(parents=True, exist_ok=True)
        with self.path.open("a", encoding="utf-8") as file:
            file.write(self.table() + "\n\n")

    def table(self) -> str:
        """Return one line for each folder, the longest first, then one for each of the longest tests."""
        head = f"processor time by folder ({self.marks or 'all tests'}): {self.seconds.total():.0f} s, {self.count.total()} tests"
        rows = [f"{seconds:8.1f} s {self.count[name]:6} tests  {name}" for name, seconds in self.seconds.most_common()]
        longest = [f"{seconds:8.1f} s  {name}" for name, seconds in self.tests.most_common(LONGEST)]
        return "\n".join((head, *rows, f"the {len(longest)} longest tests", *longest))


def spent() -> float:
    """Return the processor time of this process and of its children that have ended [s]."""
    now = os.times()
    return now.user + now.system + now.children_user + now.children_system


def folder_of(test: str) -> str:
    """Return the folder of a test, without its file."""
    folders = test.partition("::")[0].split("/")[:-1]
    return "/".join(folders[: PARTS.get(folders[1] if len(folders) > 1 else "", 2)])
