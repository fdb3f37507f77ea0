"""``cramlite doctor``: ten lines about this machine, each with a sibling that finds something lacking."""

from __future__ import annotations

import importlib
import json
import os
import sys
from pathlib import Path

import pytest
from conftest import Run
from packaging.requirements import Requirement

from cramlite.cli import doctor
from cramlite.cli.doctor import cores, folders, libraries, python

WHATS = ["cramlite", "Python", "libraries", "extras", "cores", "memory", "OpenGL", "fonts", "folders", "plugins"]


@pytest.mark.heavy
def test_this_machine_has_what_is_needed(run: Run) -> None:
    ran = run("doctor")
    lines = ran.out.splitlines()
    assert ran.code == 0 and [line.split()[1] for line in lines] == WHATS, ran.out + ran.err
    assert not any(line.startswith("lacks") for line in lines)
    rows = json.loads(run("doctor", "--json").out)
    assert [r["what"] for r in rows] == WHATS and {r["state"] for r in rows} <= {"ok", "without"}


def test_a_plugin_that_cannot_be_used_is_lacking(tmp_path: Path, run: Run) -> None:
    (tmp_path / "broken.py").write_text("import nothing_of_this_name\n")
    ran = run("doctor", "--plugin", tmp_path / "broken.py")
    assert ran.code == 1 and "nothing_of_this_name" in ran.out.splitlines()[-1] and ran.out.splitlines()[-1].startswith("lacks")


@pytest.mark.parametrize(
    ("wanted", "said"),
    [
        ("no-such-library>=1", "no-such-library is not installed"),
        ("numpy>=99", "is not >=99"),
        ("numpy>=2", ""),
    ],
)
def test_libraries(wanted: str, said: str) -> None:
    examined = libraries([Requirement(wanted)])
    assert examined.state == ("lacks" if said else "ok") and said in examined.found


def test_a_library_that_cannot_be_imported_is_lacking(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "half_there").mkdir()
    (tmp_path / "half_there" / "__init__.py").write_text("raise ImportError('libGL.so.1: cannot open shared object file')")
    info = tmp_path / "half_there-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: half-there\nVersion: 1.0\n")
    (info / "RECORD").write_text("half_there/__init__.py,,\n")
    monkeypatch.syspath_prepend(tmp_path)
    examined = libraries([Requirement("half-there")])
    assert examined.state == "lacks" and "half-there cannot be imported: libGL.so.1" in examined.found


def forget_the_planner(monkeypatch: pytest.MonkeyPatch) -> None:
    """As in a process that has not imported its package."""
    for name in [n for n in sys.modules if n.split(".")[0] == "up_fast_downward"]:
        monkeypatch.delitem(sys.modules, name)


def test_the_planner_needs_nothing_that_only_its_package_imports(monkeypatch: pytest.MonkeyPatch) -> None:
    """What 'pip install cramlite' leaves out is in the way of importing 'up_fast_downward', and of no goal."""
    monkeypatch.setitem(sys.modules, "unified_planning", None)
    forget_the_planner(monkeypatch)
    with pytest.raises(ImportError):
        importlib.import_module("up_fast_downward")
    examined = libraries([Requirement("up-fast-downward")])
    assert examined.state == "ok", examined.found


def test_a_planner_that_does_not_run_is_lacking(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    forget_the_planner(monkeypatch)
    driver = tmp_path / "up_fast_downward" / "downward" / "fast-downward.py"
    driver.parent.mkdir(parents=True)
    driver.write_text("raise SystemExit('no translator here')")
    (tmp_path / "up_fast_downward" / "__init__.py").write_text("")
    monkeypatch.syspath_prepend(tmp_path)
    examined = libraries([Requirement("up-fast-downward")])
    assert examined.state == "lacks" and "up-fast-downward cannot be run: " in examined.found
    assert "no translator here" in examined.found


def test_an_old_python_is_lacking(monkeypatch: pytest.MonkeyPatch) -> None:
    assert python().state == "ok"
    monkeypatch.setattr(sys, "version_info", (3, 9, 1))
    assert python().state == "lacks" and python().found.startswith("3.9.1, and ")


def test_an_extra_that_is_not_installed_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(doctor, "_requirements", lambda extra: [Requirement("no-such-library")] if extra == "view" else [])
    examined = doctor.extras()
    assert examined.state == "without" and "not view (no-such-library is not installed): pip install 'cramlite[NAME]'" in examined.found


def test_missing_graphics_hinder_nothing_that_is_needed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("ctypes.util.find_library", lambda name: None)
    assert doctor.graphics().state == "without" and "no libGL and no libEGL" in doctor.graphics().found
    monkeypatch.setattr("ctypes.util.find_library", lambda name: f"lib{name}.so.1")
    assert doctor.graphics().state == "ok"


def test_only_the_cores_that_may_be_used_are_counted() -> None:
    assert cores().found.startswith(f"{len(os.sched_getaffinity(0))} of {os.cpu_count()} ")


def test_a_folder_that_cannot_be_written_is_named(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.chdir(tmp_path)
    assert folders().state == "ok"
    monkeypatch.setattr("os.access", lambda path, mode: False)
    assert folders().state == "without" and str(tmp_path) in folders().found
