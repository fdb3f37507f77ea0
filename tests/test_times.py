"""Processor time by folder: what is measured, how it is summed up, where it is kept."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
from conftest import ROOT
from helpers.times import ASKED, Times, folder_of, spent

BUSY = """
import time

def test_busy():
    until = time.process_time() + 0.3
    while time.process_time() < until: pass

def test_asleep():
    time.sleep(0.3)
"""


@pytest.mark.parametrize(
    ("test", "folder"),
    [
        ("tests/test_times.py::test_it[a/b]", "tests"),
        ("tests/cli/test_cli.py::test_it", "tests/cli"),
        ("tests/plugins/locations/test_pegs.py::test_it", "tests/plugins/locations"),
        ("test_elsewhere.py::test_it", ""),
    ],
)
def test_a_folder_is_that_of_the_file(test: str, folder: str) -> None:
    assert folder_of(test) == folder


def test_time_of_ended_children_counts() -> None:
    before = spent()
    subprocess.run([sys.executable, "-c", "import time\nwhile time.process_time() < 0.2: pass"], check=True)
    assert spent() - before > 0.19  # the clock of a process counts in hundredths


@pytest.mark.heavy
@pytest.mark.parametrize("workers", ["0", "1"])
def test_a_run_prints_and_keeps_the_times_of_its_tests(workers: str, tmp_path: Path) -> None:
    folder, kept = tmp_path / "tests" / "made", tmp_path / "times.txt"
    folder.mkdir(parents=True)
    (folder / "test_busy.py").write_text(BUSY)
    (tmp_path / "conftest.py").write_text(
        "from pathlib import Path\nfrom helpers.times import Times\n\n"
        f"def pytest_configure(config):\n    config.pluginmanager.register(Times(Path({str(kept)!r}), 'fuzz'))\n"
    )
    (tmp_path / "pytest.ini").touch()
    path = str(ROOT / "tests")
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-n", workers]
    ran = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, env={**os.environ, "PYTHONPATH": path}, check=False)
    assert ran.returncode == 0, ran.stdout
    head, row = kept.read_text().split("\n")[:2]
    assert head in ran.stdout and head.startswith("processor time by folder (fuzz): ") and head.endswith(" s, 2 tests")
    assert row.endswith("2 tests  tests/made")
    assert float(row.split()[0]) >= 0.3


def test_the_longest_comes_first() -> None:
    times = Times(Path("unused"), "")
    times.seconds.update({"tests/a": 1.0, "tests/b": 2.5})
    times.count.update({"tests/a": 7, "tests/b": 1})
    times.tests.update({"tests/a/test_a.py::test_one": 0.4, "tests/b/test_b.py::test_two": 2.5})
    assert times.table().splitlines() == [
        "processor time by folder (all tests): 4 s, 8 tests",
        "     2.5 s      1 tests  tests/b",
        "     1.0 s      7 tests  tests/a",
        "the 2 longest tests",
        "     2.5 s  tests/b/test_b.py::test_two",
        "     0.4 s  tests/a/test_a.py::test_one",
    ]


def test_continuous_integration_asks_for_them() -> None:
    assert f"export {ASKED}=" in (ROOT / ".ci" / "run").read_text()
