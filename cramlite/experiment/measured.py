"""Conditions of a measurement, such as commit, machine and command, for the file of a figure; and the
figure's numbers."""

from __future__ import annotations

import os
import platform
import shlex
import subprocess
import sys
from collections.abc import Iterable, Sequence
from importlib.metadata import version
from pathlib import Path

from ..base.errors import UserError
from ..base.rate import Rate
from .figure import Figure, Number, Seen, read_figure

SUFFIX = ".yaml"
SIGNIFICANT = 4
"""Number of significant digits of a measured value."""


def rate(what: str, hits: int, of: int, part: str = "", *, x: float | None = None, note: str = "") -> Number:
    """Return the entry for a rate of hits among trials in a file of measured numbers."""
    return Number(what=what, part=part, hits=hits, of=of, x=x, note=note)


def rates(what: str, columns: dict[str, Rate]) -> list[Number]:
    """Return the entries of a table row in a file of measured numbers, one for each rate with at least one trial."""
    return [rate(what, found.hits, found.total, part) for part, found in columns.items() if found.total]


def value(what: str, found: float, unit: str = "", part: str = "", *, x: float | None = None, note: str = "") -> Number:
    """Return the entry for a value with a unit in a file of measured numbers, rounded to ``SIGNIFICANT``
    digits."""
    return Number(what=what, part=part, value=float(f"{found:.{SIGNIFICANT}g}"), unit=unit, x=x, note=note)


def figure_now(
    title: str, command: str, numbers: Iterable[Number], *, seeds: str | None = None, seen: Seen | None = None, cpu_s: float | None = None
) -> Figure:
    """Return measured numbers with the commit, machine and CPU time of the measurement that this process just
    made.

    Args:
        cpu_s: of it all; that of this process and of those that it waited for, where nothing is said.

    Raises:
        UserError: there is no number.
    """
    if not (kept := tuple(numbers)):
        raise UserError("Nothing was measured, so there is no figure to write; run the measurement first.")
    used = os.times()
    spent = used.user + used.system + used.children_user + used.children_system
    commit, changed = revision(Path(__file__).parents[2])
    return Figure(
        title=title, command=command, commit=commit, changed=changed, seeds=seeds, seen=seen, machine=machine(),
        cpu_s=round(spent if cpu_s is None else cpu_s, 1), numbers=kept,
    )  # fmt: skip


def revision(root: Path) -> tuple[str | None, bool]:
    """Return the commit of a checkout, and whether files other than those of measured numbers differ from it;
    (None, False) outside of a checkout."""
    top = git(root, "rev-parse", "--show-toplevel")
    if top is None or Path(top).resolve() != root.resolve():
        return None, False
    return git(root, "rev-parse", "--short=8", "HEAD"), bool(git(root, "status", "--porcelain", "--", ":!docs/figures"))


def git(root: Path, *arguments: str) -> str | None:
    """Run git in a folder and return what it prints; None without git or if git fails."""
    try:
        done = subprocess.run(["git", "-C", str(root), *arguments], capture_output=True, text=True, check=False)
    except OSError:
        return None
    return done.stdout.strip() if done.returncode == 0 else None


def machine() -> str:
    """Name the processor type, cores, load, and versions of Python and MuJoCo, as part of a sentence."""
    load = f", load {os.getloadavg()[0]:.1f}" if hasattr(os, "getloadavg") else ""
    versions = f"Python {platform.python_version()}, MuJoCo {version('mujoco')}"
    return f"{platform.machine()}, {os.cpu_count()} cores{load}; {versions}"


def repeated(program: str, arguments: Sequence[str], without: Sequence[str] = ("--figure", "--seen")) -> str:
    """Return the command line that repeats a measurement, without the options for its output and with
    absolute paths shortened to names."""
    kept, skip = list[str](), False
    for word in arguments:
        name = word.partition("=")[0]
        if not skip and name not in without:
            kept.append(Path(word).name if Path(word).is_absolute() else word)
        skip = not skip and word in without
    return f"{program} {shlex.join(kept)}".strip()


def check_figure_file(path: Path | None) -> None:
    """Refuse a path to which no file of measured numbers can be written, before anything is measured.

    Raises:
        UserError: it has another ending, is a folder, or is there and no figure.
    """
    if path is None:
        return
    if path.suffix != SUFFIX or path.is_dir():
        raise UserError(f"--figure {path}: a figure is a YAML file; name it like docs/figures/{path.stem or 'NAME'}{SUFFIX}.")
    if path.exists():
        read_figure(path)


def this_command() -> str:
    """Return the ``cramlite`` command line that repeats the measurement of this process."""
    return repeated("cramlite", sys.argv[1:])

