"""For which systems and Python versions a wheel of each dependency exists: the table of ``docs/reference/platforms.md``.

pip's index is read once for each package that the base needs or an extra names, by pip's own code, and the wheels there are compared
with the tags that each system accepts; no package is downloaded. A minute:

    python tests/benchmarks/wheels.py            # prints the table
    python tests/benchmarks/wheels.py --write    # puts it into the page
"""

from __future__ import annotations

import argparse
import datetime
import sys
import tomllib
from collections.abc import Iterable
from importlib import metadata
from itertools import product
from pathlib import Path

from packaging.markers import Marker
from packaging.requirements import Requirement
from packaging.specifiers import SpecifierSet
from packaging.tags import Tag, compatible_tags, cpython_tags, mac_platforms
from packaging.utils import InvalidWheelFilename, canonicalize_name, parse_wheel_filename
from pip._internal.commands import create_command
from pip._internal.index.collector import LinkCollector, parse_links
from pip._internal.models.link import Link

ROOT = Path(__file__).parent.parent.parent
PAGE = ROOT / "docs" / "reference" / "platforms.md"
BEGIN, END = "<!-- wheels: begin -->", "<!-- wheels: end -->"
PYTHONS = ("3.11", "3.12", "3.13", "3.14")
DEVELOPERS = ("docs", "test")
"""Extras of those who work on the project."""


def _manylinux(machine: str, oldest: int) -> list[str]:
    """The tags that a Linux with glibc 2.31 accepts (PEP 600): Debian 11, Ubuntu 20.04, Red Hat 9 and later."""
    return [*(f"manylinux_2_{n}_{machine}" for n in range(31, oldest - 1, -1)), f"manylinux2014_{machine}"]


SYSTEMS: dict[str, tuple[list[str], dict[str, str]]] = {
    "Linux x86-64": (_manylinux("x86_64", 5), {"sys_platform": "linux", "platform_system": "Linux", "os_name": "posix"}),
    "Linux arm64": (_manylinux("aarch64", 17), {"sys_platform": "linux", "platform_system": "Linux", "os_name": "posix"}),
    "macOS arm64": ([], {"sys_platform": "darwin", "platform_system": "Darwin", "os_name": "posix"}),
    "macOS x86-64": ([], {"sys_platform": "darwin", "platform_system": "Darwin", "os_name": "posix"}),
    "Windows x86-64": (["win_amd64"], {"sys_platform": "win32", "platform_system": "Windows", "os_name": "nt"}),
}
"""Platforms of wheels (of macOS: those that version 15 accepts), and what environment markers see, by system."""


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
    """All packages that some requirements need on a system, with the versions asked for, by the metadata of the packages
    installed here."""
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
    """Requirements that a package states; none for a package that is not installed here."""
    try:
        return [Requirement(text) for text in metadata.requires(name) or ()]
    except metadata.PackageNotFoundError:
        return []


def _applies(marker: Marker | None, system: str, extras: set[str]) -> bool:
    """Whether a marker holds on a system, for any of the Python versions and extras."""
    where = SYSTEMS[system][1]
    environments = [{**where, "python_version": p, "python_full_version": f"{p}.0", "extra": e} for p in PYTHONS for e in extras or {""}]
    return marker is None or any(marker.evaluate(e) for e in environments)


def files(names: Iterable[str]) -> dict[str, list[Link]]:
    """The files of packages in pip's index, as pip reads it: one look each."""
    command = create_command("download")
    options, _ = command.parse_args(["--quiet"])
    found = {}
    with command.main_context():
        session = command.get_default_session(options)  # type: ignore[attr-defined]
        collector = LinkCollector.create(session, options)
        for name in names:
            print(name, file=sys.stderr, flush=True)
            places = [u for u in collector.search_scope.get_index_urls_locations(name) if u.startswith("http")]
            pages = [page for url in places if (page := collector.fetch_response(Link(url))) is not None]
            found[name] = [link for page in pages for link in parse_links(page) if link.is_wheel and not link.is_yanked]
    return found


def tags(system: str, python: str) -> frozenset[Tag]:
    """The tags of wheels that a system with a version of Python installs."""
    version = tuple(map(int, python.split(".")))
    platforms = SYSTEMS[system][0]
    if system.startswith("macOS"):
        platforms = [*mac_platforms((15, 0), system.rsplit(" ", 1)[1].replace("-", "_"))]
    return frozenset([*cpython_tags(version, platforms=platforms), *compatible_tags(version, f"cp{python.replace('.', '')}", platforms)])


def installs(link: Link, versions: SpecifierSet, accepted: frozenset[Tag], python: str) -> bool:
    """Whether pip would install a wheel."""
    try:
        _, version, _, wheel = parse_wheel_filename(link.filename)
    except InvalidWheelFilename:
        return False
    fits = versions.contains(version) and SpecifierSet(link.requires_python or "").contains(f"{python}.9")
    return fits and not wheel.isdisjoint(accepted)


def wheels(needed: dict[str, dict[str, SpecifierSet]]) -> dict[str, dict[str, list[str]] | None]:
    """The Python versions with a wheel, by package and system; None for a package whose one wheel is for all.

    Args:
        needed: packages with the versions asked for, by system.
    """
    versions = {n: v for by in needed.values() for n, v in by.items()}
    accepted = {(s, p): tags(s, p) for s, p in product(SYSTEMS, PYTHONS)}
    found: dict[str, dict[str, list[str]] | None] = {}
    for name, links in files(sorted(versions)).items():
        pure = [link for link in links if link.filename.endswith("-none-any.whl")]
        if pure and all(any(installs(link, versions[name], a, p) for link in pure) for (_, p), a in accepted.items()):
            found[name] = None
        else:
            found[name] = {
                s: [p for p in PYTHONS if any(installs(link, versions[name], accepted[s, p], p) for link in links)] for s in SYSTEMS
            }
    return found


def cell(pythons: list[str]) -> str:
    """Some versions of Python, as the table says them."""
    if tuple(pythons) == PYTHONS:
        return "yes"
    return ", ".join(pythons) or "**none**"


def table(found: dict[str, dict[str, list[str]] | None], needs: dict[str, set[str]], extras: set[str]) -> list[str]:
    """The lines of the table, of packages that stand in the way, and of wheels that are for every system."""
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
    found = wheels({s: {**more, **needed[s]} for s in SYSTEMS})
    text = "\n".join([f"Asked on {datetime.date.today().isoformat()}.", "", *table(found, needs, extras)])
    if not write:
        print(text)
        return
    page = PAGE.read_text(encoding="utf-8")
    before, behind = page.split(BEGIN)[0], page.split(END)[1]
    PAGE.write_text(f"{before}{BEGIN}\n{text}\n{END}{behind}", encoding="utf-8")


if __name__ == "__main__":
    main()
