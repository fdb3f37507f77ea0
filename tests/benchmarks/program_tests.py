"""Costs of tests of robot programs: a suite around one cell, and the plugin beside a suite that does not use it.

    python tests/benchmarks/program_tests.py [--tests 100] [--runs 20]

The suite is made of the mended programs of ``tests/program_tests/defects``, each with assertions of its own, one pytest run in one
process. The plugin's cost at start is the difference of CPU time between pytest with it alone and with no plugin at all, of a suite with
one empty test: runs in turn, the smallest of each, for what a machine does beside them only adds.
"""

from __future__ import annotations

import argparse
import os
import resource
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from figure import add_figure, value, write

ROOT = Path(__file__).resolve().parents[2]
CELL = ROOT / "tests" / "program_tests" / "defects"
PLUGIN = ("-p", "cramlite.program_tests.pytest_plugin")
HEAD = "import pytest\n\n@pytest.fixture\ndef cramlite_world():\n    return 'cell.yaml'\n"
TEST = """
def test_{number}(cramlite_robot):
    run = cramlite_robot.run('pick.script', seed={number})
    run.ends('part on tray').{claim}
"""
CLAIMS = (
    "pushes('25 N')", "moves(0.9)", "takes('20 s')", "logs('done')", "leaves('tray', 'post')", "never_touches('hand', 'table')",
    "touches('hand', 'part')", "never_touches('arm', 'post')", "pushes('5 N', before='3 s')", "never_touches('part', 'post')",
)  # fmt: skip


def cpu_time(folder: Path, *options: str) -> float:
    """User and system time of pytest in a folder [s]."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", *options]
    alone = {**os.environ, "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1"}
    subprocess.run(command, cwd=folder, stdout=subprocess.DEVNULL, check=True, env=alone)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def suite(folder: Path, count: int) -> None:
    """Write the tests of a cell."""
    shutil.copy(CELL / "pick.script", folder)
    shutil.copy(CELL / "cells" / "cell.yaml", folder)
    tests = [TEST.format(number=k, claim=CLAIMS[k % len(CLAIMS)]) for k in range(count)]
    (folder / "test_cell.py").write_text(HEAD + "\n".join(tests), encoding="utf-8")


def at_start(folder: Path, runs: int) -> tuple[float, float]:
    """Time of pytest for one empty test, with the plugin and without [ms]."""
    (folder / "test_else.py").write_text("def test_else():\n    pass\n", encoding="utf-8")
    pairs = [(cpu_time(folder, *PLUGIN), cpu_time(folder)) for _ in range(runs)]
    with_it, without = (1000 * min(times) for times in zip(*pairs, strict=True))
    return with_it, without


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    options.add_argument("--tests", type=int, default=100)
    options.add_argument("--runs", type=int, default=20)
    add_figure(options)
    asked = options.parse_args()
    with tempfile.TemporaryDirectory() as cell, tempfile.TemporaryDirectory() as other:
        suite(Path(cell), asked.tests)
        took, (with_it, without) = cpu_time(Path(cell), *PLUGIN), at_start(Path(other), asked.runs)
    print(f"{asked.tests} tests of a cell: {took:.1f} s of CPU; an empty test: {with_it:.0f} ms with the plugin, {without:.0f} without")
    numbers = [
        value(f"{asked.tests} tests of one cell, CPU", took, "s"),
        value("an empty test of somebody else, CPU", with_it, "ms", "with the plugin, least"),
        value("an empty test of somebody else, CPU", without, "ms", "without, least"),
    ]
    write(asked, numbers, f"0 to {asked.tests - 1}")


if __name__ == "__main__":
    main()
