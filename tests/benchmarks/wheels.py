"""For which systems and Python versions a wheel of each dependency exists: the table of ``docs/reference/platforms.md``.

pip is asked what it would install (``--dry-run``), of all packages that the base needs and the extras name, once for each system and
version; nothing is downloaded but the metadata. Some minutes:

    python tests/benchmarks/wheels.py            # prints the table
    python tests/benchmarks/wheels.py --write    # puts it into the page
"""

from __future__ import annotations

import argparse
import datetime
import json
import re
import subprocess
import sys
import tomllib
from collections.abc import Iterable
from importlib import metadata
from itertools import product
from pathlib import Path
from tempfile import gettempdir

from packaging.markers import Marker
from packaging.requirements import Requirement
from packaging.specifiers import SpecifierSet
from packaging.utils import canonicalize_name

ROOT = Path(__file__).parent.parent.parent
PAGE = ROOT / "docs" / "reference" / "platforms.md"
BEGIN, END = "<!-- wheels: begin -->", "<!-- wheels: end -->"
PYTHONS = ("3.11", "3.12", "3.13", "3.14")
DEVELOPERS = ("docs", "test")
"""Extras of those who work on the project."""


def _manylinux(machine: str, oldest: int) -> list[str]:
    """The tags that a Linux with glibc 2.28 accepts (PEP 600), Debian 10 or Red Hat 8; pip expands none but the oldest by itself."""
    return [*(f"manylinux_2_{n}_{machine}" for n in range(28, oldest - 1, -1)), f"manylinux2014_{machine}"]


SYSTEMS: dict[str, tuple[list[str], dict[str, str]]] = {
    "Linux x86-64": (_manylinux("x86_64", 5), {"sys_platform": "linux", "platform_system": "Linux", "os_name": "posix"}),
    "Linux arm64": (_manylinux("aarch64", 17), {"sys_platform": "linux", "platform_system": "Linux", "os_name": "posix"}),
    "macOS arm64": (["macosx_15_0_arm64"], {"sys_platform": "darwin", "platform_system": "Darwin", "os_name": "posix"}),
    "macOS x86-64": (["macosx_15_0_x86_64"], {"sys_platform": "darwin", "platform_system": "Darwin", "os_name": "posix"}),
    "Windows x86-64": (["win_amd64"], {"sys_platform": "win32", "platform_system": "Windows", "os_name": "nt"}),
}
"""Tags of wheels, and what environment markers see, by system."""


def base() -> list[str]:
    """What every installation needs."""
    return list(_project()["dependencies"])


def of_extras() -> list[str]:
    """What the extras of users name."""
    extras = _project()["optional-dependencies"]
    return sorted({r for name, wanted in extras.items() if name not in DEVELOPERS for r in wanted})


def _project() -> dict:  # type: ignore[type-arg]
    return tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]


def closure(wanted: Iterable[str], system: str) -> dict[str, SpecifierSet]:
    """All that some requirements need on a system, with the versions asked for; what the packages here say they require."""
    needed: dict[str, SpecifierSet] = {}
    todo, done = [r for r in map(Requirement, wanted) if _applies(r.marker, system, set())], set()
    while todo:
        one = todo.pop()
        if str(one) in done:
            continue
        done.add(str(one))
        name = canonicalize_name(one.name)
        needed[name] = needed.get(name, SpecifierSet()) & one.specifier
        todo += [r for r in _requires(one.name) if _applies(r.marker, system, one.extras)]
    return needed


def _requires(name: str) -> list[Requirement]:
    """What a package says that it requires; nothing of one that is not installed here."""
    try:
        return [Requirement(text) for text in metadata.requires(name) or ()]
    except metadata.PackageNotFoundError:
        return []


def _applies(marker: Marker | None, system: str, extras: set[str]) -> bool:
    """Whether a marker holds on a system, for any of the Python versions and extras."""
    where = SYSTEMS[system][1]
    environments = [{**where, "python_version": p, "python_full_version": f"{p}.0", "extra": e} for p in PYTHONS for e in extras or {""}]
    return marker is None or any(marker.evaluate(e) for e in environments)


def installable(wanted: Iterable[str], system: str, python: str) -> dict[str, str]:
    """The wheels that pip would install, by package; those without one are left out."""
    left = list(wanted)
    while True:
        asked = _asked(left, system, python)
        if asked.returncode == 0:
            chosen = json.loads(asked.stdout)["install"]
            return {canonicalize_name(i["metadata"]["name"]): i["download_info"]["url"].rsplit("/", 1)[-1] for i in chosen}
        lacking = re.search(r"No matching distribution found for (.+)", asked.stderr)
        less = [r for r in left if lacking and canonicalize_name(Requirement(r).name) != canonicalize_name(Requirement(lacking[1]).name)]
        if not lacking or len(less) == len(left):
            raise SystemExit(f"pip could not be asked: {asked.stderr.strip()}")
        left = less


def _asked(wanted: list[str], system: str, python: str) -> subprocess.CompletedProcess[str]:
    options = [o for tag in SYSTEMS[system][0] for o in ("--platform", tag)]
    return subprocess.run(
        [sys.executable, "-m", "pip", "install", "--dry-run", "--ignore-installed", "--no-deps", "--only-binary=:all:", "--quiet",
         "--disable-pip-version-check", "--target", gettempdir(), "--implementation", "cp", "--python-version", python,
         "--report", "-", *options, *wanted], capture_output=True, text=True,
    )  # fmt: skip


def wheels(wanted: dict[str, list[str]]) -> dict[str, dict[str, list[str]] | None]:
    """The Python versions with a wheel, by package and system; None for a package whose one wheel is for all.

    Args:
        wanted: requirements by system.
    """
    found: dict[tuple[str, str], dict[str, str]] = {}
    for system, python in product(SYSTEMS, PYTHONS):
        print(system, python, file=sys.stderr, flush=True)
        found[system, python] = installable(wanted[system], system, python)
    names = sorted({canonicalize_name(Requirement(r).name) for s in SYSTEMS for r in wanted[s]})
    by = {n: {s: [p for p in PYTHONS if n in found[s, p]] for s in SYSTEMS} for n in names}
    pure = {n for n in names if all(f.get(n, "-none-any.whl").endswith("-none-any.whl") and n in f for f in found.values())}
    return {n: None if n in pure else by[n] for n in names}


def cell(pythons: list[str]) -> str:
    """Some versions of Python, as the table says them."""
    if tuple(pythons) == PYTHONS:
        return "yes"
    return ", ".join(pythons) or "**none**"


def table(found: dict[str, dict[str, list[str]] | None], needs: dict[str, set[str]], extras: set[str]) -> list[str]:
    """The lines of the table, of what stands in the way, and of what is for every system."""
    lines = [f"| package | {' | '.join(SYSTEMS)} |", f"|---{'|---' * len(SYSTEMS)}|"]
    for name, by in sorted(found.items()):
        if by is not None:
            cells = [cell(by[s]) if name in needs[s] else "not needed" for s in SYSTEMS]
            lines.append(f"| `{name}`{' (extra)' if name in extras else ''} | {' | '.join(cells)} |")
    everywhere = ", ".join(f"`{n}`" for n, by in sorted(found.items()) if by is None)
    return [*lines, "", f"One wheel for every system and version: {everywhere}.", "", *in_the_way(found, needs, extras)]


def in_the_way(found: dict[str, dict[str, list[str]] | None], needs: dict[str, set[str]], extras: set[str]) -> list[str]:
    """By system and version: the packages of the base that have no wheel."""
    lines = [f"| without a wheel, of the base | {' | '.join(SYSTEMS)} |", f"|---{'|---' * len(SYSTEMS)}|"]
    for python in PYTHONS:
        cells = []
        for system in SYSTEMS:
            lacking = [n for n, by in sorted(found.items()) if n not in extras and n in needs[system] and by and python not in by[system]]
            cells.append(", ".join(f"`{n}`" for n in lacking) or "installs")
        lines.append(f"| Python {python} | {' | '.join(cells)} |")
    return lines


def main() -> None:
    """Ask, and print or write."""
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--write", action="store_true", help=f"put the table into {PAGE.relative_to(ROOT)}")
    write = options.parse_args().write
    needed = {s: closure(base(), s) for s in SYSTEMS}
    more = {canonicalize_name(r.name): r.specifier for r in map(Requirement, of_extras())}
    extras = {n for n in more if not any(n in needed[s] for s in SYSTEMS)}
    needs = {s: {*needed[s], *extras} for s in SYSTEMS}
    found = wheels({s: [f"{n}{v}" for n, v in sorted({**more, **needed[s]}.items())] for s in SYSTEMS})
    text = "\n".join([f"Asked on {datetime.date.today().isoformat()}.", "", *table(found, needs, extras)])
    if not write:
        print(text)
        return
    page = PAGE.read_text(encoding="utf-8")
    before, behind = page.split(BEGIN)[0], page.split(END)[1]
    PAGE.write_text(f"{before}{BEGIN}\n{text}\n{END}{behind}", encoding="utf-8")


if __name__ == "__main__":
    main()
