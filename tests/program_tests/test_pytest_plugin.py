"""The plugin in a pytest of its own: what a stranger's suite sees of it."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

SUITE = '''
import pytest

@pytest.fixture
def cramlite_world():
    return "place_on_shelf"

WAITS = "def p():\\n  sleep(0.1)\\nend\\n"

def test_good(cramlite_robot):
    cramlite_robot.run(WAITS).ends().leaves("block")

def test_bad(cramlite_robot):
    cramlite_robot.run(WAITS).ends("block on shelf")

@pytest.mark.cramlite_fault(missing="block")
def test_fault(cramlite_robot):
    assert "block" not in [t.name for t in cramlite_robot.run(WAITS).rollout.world.things]

def test_mistake(cramlite_robot):
    cramlite_robot.run(WAITS, world="nowhere.yaml")
'''


def suite(folder: Path, *options: str) -> str:
    """What pytest prints about a suite in a folder."""
    command = [sys.executable, "-m", "pytest", "-p", "no:cacheprovider", "-rf", *options]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False).stdout


def test_a_suite(tmp_path: Path) -> None:
    (tmp_path / "pytest.ini").write_text("[pytest]\naddopts = --strict-markers\n")
    (tmp_path / "test_cell.py").write_text(SUITE)
    said = suite(tmp_path, "--cramlite-pages", "pages")
    assert "2 failed, 2 passed" in said
    assert "'block on shelf' is not reached" in said and "ProgramFailure: program, ends('block on shelf')" in said
    assert re.search(rf"{tmp_path}/test_cell\.py:\d+: .*nowhere\.yaml", said) and "Traceback" not in said
    assert [p.name for p in (tmp_path / "pages").iterdir()] == ["test_cell.py__test_bad.html"]


def test_names_are_found_where_pytest_rewrites_the_package_as_it_does_when_it_comes_from_a_wheel(tmp_path: Path) -> None:
    rewrites = "import pytest\n\npytest.register_assert_rewrite('cramlite', 'cramlite_plugins')\n"
    (tmp_path / "conftest.py").write_text(f"{rewrites}pytest_plugins = ['cramlite.program_tests.pytest_plugin']\n")
    names = "from cramlite import Engine\nfrom cramlite.model import World\nfrom cramlite.plugin import Finding\n"
    (tmp_path / "test_names.py").write_text(f"{names}\n\ndef test_them():\n    assert Engine and World and Finding\n")
    said = suite(tmp_path, "-p", "no:cramlite")
    assert "1 passed" in said, said


def test_a_suite_without_robots_is_left_alone(tmp_path: Path) -> None:
    (tmp_path / "test_else.py").write_text(
        "import sys\n\ndef test_nothing_is_imported():\n"
        "    few = {'cramlite.base', 'cramlite.base.lazy_names', 'cramlite.version', 'cramlite.program_tests', "
        "'cramlite.program_tests.pytest_plugin'}\n"
        "    assert {m for m in sys.modules if m.startswith(('cramlite.', 'mujoco', 'numpy', 'pydantic'))} <= few\n"
    )
    said = suite(tmp_path)
    assert "1 passed" in said, said


@pytest.mark.heavy
def test_in_parallel(tmp_path: Path) -> None:
    (tmp_path / "test_cell.py").write_text(SUITE)
    assert "2 failed, 2 passed" in suite(tmp_path, "-n", "2")
