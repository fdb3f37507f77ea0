"""The code imports what every system has, and reads and writes text the same everywhere."""

from __future__ import annotations

import ast
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from conftest import ROOT

from cramlite.base import process_group
from cramlite.base.file_lock import lock
from cramlite.planning.symbolic import symbolic_planner

SOURCES = sorted([*(ROOT / "cramlite").rglob("*.py"), *(ROOT / "plugins" / "cramlite_plugins").rglob("*.py")])
POSIX = {"fcntl", "grp", "posix", "pty", "pwd", "resource", "syslog", "termios", "tty"}
"""Modules that Windows does not have (Python's documentation, "Unix-specific services" and each module's availability)."""
FUNCTIONS = {
    "chroot", "fork", "forkpty", "getegid", "geteuid", "getgid", "getpgid", "getpgrp", "getuid", "killpg", "mkfifo", "nice",
    "sched_getaffinity", "setpgid", "setsid", "sysconf", "uname", "wait", "wait3", "wait4", "getloadavg", "openpty", "ttyname",
}  # fmt: skip
"""Functions of ``os`` that Windows does not have (Python's documentation)."""
GUARDED = {"cramlite/base/file_lock.py", "cramlite/base/process_group.py", "cramlite/base/stopwatch.py", "cramlite/cli/doctor.py",
           "cramlite/experiment/measured.py", "cramlite/planning/symbolic/translator_room.py"}  # fmt: skip
"""Modules that ask what the system has, and have another way."""


def posix_only(tree: ast.AST) -> Iterator[str]:
    """Modules and functions that not every system has."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (a.name for a in node.names if a.name in POSIX)
        elif isinstance(node, ast.ImportFrom) and node.module in POSIX and not node.level:
            yield node.module
        elif isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id == "os" and node.attr in FUNCTIONS:
            yield f"os.{node.attr}"


def without_encoding(tree: ast.AST) -> Iterator[str]:
    """Calls that read or write text in whatever encoding the system has."""
    for node in ast.walk(tree):
        if not isinstance(node, ast.Call) or any(k.arg in ("encoding", None) for k in node.keywords):
            continue
        name = node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
        if name in ("read_text", "write_text") and len(node.args) == (name == "write_text"):
            yield f"line {node.lineno}: {name}"
        if name == "open" and _is_text(node):
            yield f"line {node.lineno}: open"


def _is_text(call: ast.Call) -> bool:
    """Whether ``path.open`` is given a mode, its first argument, or ``open``, its second, and that of text."""
    place = 1 if isinstance(call.func, ast.Name) else 0
    mode = call.args[place] if len(call.args) > place else None
    return isinstance(mode, ast.Constant) and set(str(mode.value)) <= set("rwxa+t")


def parsed(path: Path) -> ast.AST:
    return ast.parse(path.read_text(encoding="utf-8"))


@pytest.mark.heavy
def test_what_not_every_system_has_is_asked_for_first() -> None:
    found = {p.relative_to(ROOT).as_posix(): list(posix_only(parsed(p))) for p in SOURCES}
    assert {path for path, names in found.items() if names} == GUARDED


@pytest.mark.heavy
def test_texts_are_read_and_written_in_one_encoding() -> None:
    found = {p.relative_to(ROOT).as_posix(): list(without_encoding(parsed(p))) for p in SOURCES}
    assert {path: calls for path, calls in found.items() if calls} == {}


@pytest.mark.parametrize(
    ("source", "names", "calls"),
    [
        ("import os, fcntl\nos.killpg(1, 9)", ["fcntl", "os.killpg"], []),
        ("def f():\n    from pwd import getpwuid", ["pwd"], []),
        ("p.read_text()\np.write_text('a')\np.open('w')", [], ["line 1: read_text", "line 2: write_text", "line 3: open"]),
        ("p.read_text(encoding='utf-8')\np.open('rb')\nopen(p, 'a+b')\nImage.open(p)\nav.open(p, 'w')", [], []),
    ],
)  # fmt: skip
def test_what_is_not_portable_is_seen(source: str, names: list[str], calls: list[str]) -> None:
    assert list(posix_only(ast.parse(source))) == names
    assert list(without_encoding(ast.parse(source))) == calls


def test_a_lock_is_for_one_process_and_ends_with_it(tmp_path: Path) -> None:
    path = tmp_path / "lock"
    code = "import sys; from cramlite.base.file_lock import lock; lock(open(sys.argv[1], 'a+'))"
    with path.open("a+", encoding="utf-8") as file:
        lock(file)
        refused = subprocess.run([sys.executable, "-c", code, str(path)], capture_output=True, text=True, check=False)
        assert refused.returncode == 1 and "Error" in refused.stderr
    subprocess.run([sys.executable, "-c", code, str(path)], check=True)
    with path.open("a+", encoding="utf-8") as file:
        lock(file)


def test_without_groups_the_tree_of_a_process_is_ended(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Windows' command, by a stand-in of the same arguments."""
    command = tmp_path / "taskkill"
    command.write_text('#!/bin/sh\ntest "$1 $2 $3" = "/F /T /PID" && kill -9 "$4"\n', encoding="utf-8")
    command.chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path), prepend=os.pathsep)
    monkeypatch.delattr(os, "killpg")
    with subprocess.Popen([sys.executable, "-c", "input()"], stdin=subprocess.PIPE) as sleeper:
        process_group.end_group(sleeper.pid)
        assert sleeper.wait() == -9
    with pytest.raises(ProcessLookupError):
        process_group.end_group(sleeper.pid)


@pytest.mark.parametrize("system", ["darwin", "win32"])
def test_goals_are_planned_where_memory_cannot_be_limited(monkeypatch: pytest.MonkeyPatch, system: str) -> None:
    assert symbolic_planner.fast_downward(symbolic_planner.ARRIVE).plan
    monkeypatch.setattr(symbolic_planner.sys, "platform", system)
    assert symbolic_planner._room() == ()
    assert symbolic_planner.fast_downward(symbolic_planner.ARRIVE).plan
