"""The pages of dependencies and platforms agree with pyproject.toml, and with the sizes of the packages here."""

from __future__ import annotations

import re
import tomllib
from importlib import metadata
from pathlib import Path
from typing import Any

import pytest
from conftest import ROOT
from packaging.requirements import Requirement
from packaging.specifiers import SpecifierSet
from packaging.utils import canonicalize_name

PROJECT: dict[str, Any] = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
NEEDED = [Requirement(r).name for r in PROJECT["dependencies"]]
EXTRAS = {n: [Requirement(r).name for r in wanted] for n, wanted in PROJECT["optional-dependencies"].items() if n not in ("docs", "test")}
HEAVY = 60
"""A package of which one module has use, and which is larger [MB], is an extra."""
GOALS = "up-fast-downward"  # but the planner of goals, without which most of the shipped kitchens are none


def rows(page: str, heading: str) -> list[list[str]]:
    """The cells of the first table behind a heading of a page of the reference."""
    text = (ROOT / "docs" / "reference" / f"{page}.md").read_text(encoding="utf-8").split(heading, 1)[1]
    table = re.split(r"\n(?!\|)", text[text.index("\n|") :].strip())[0]
    return [[c.strip() for c in line.strip("|").split("|")] for line in table.splitlines()[2:]]


def closure(names: list[str]) -> set[str]:
    """Packages with all that they need in turn, as installed here."""
    todo, found = [Requirement(n) for n in names], set[tuple[str, frozenset[str]]]()
    while todo:
        one = todo.pop()
        key = (canonicalize_name(one.name), frozenset(one.extras))
        if key not in found:
            found.add(key)
            behind = [Requirement(r) for r in metadata.requires(one.name) or ()]
            todo += [r for r in behind if r.marker is None or any(r.marker.evaluate({"extra": e}) for e in one.extras or {""})]
    return {name for name, _ in found}


def size(names: set[str]) -> float:
    """What the files of some packages take [MB]."""
    files = {Path(str(f.locate())) for n in names for f in metadata.files(n) or ()}
    return sum(f.stat().st_size for f in files if f.is_file()) / 1e6


def near(said: str, found: float) -> bool:
    """Whether a size is said to half of it, or 2 MB: packages grow."""
    return abs(float(said.strip("()")) - found) <= max(2.0, 0.5 * found)


def test_every_dependency_is_explained() -> None:
    table = rows("dependencies", "# Dependencies")
    assert [row[0].strip("`") for row in table] == sorted(NEEDED)
    assert all(len(row) == 4 and all(row) for row in table)


@pytest.mark.heavy
@pytest.mark.parametrize("name", NEEDED)
def test_sizes_are_those_of_what_goes_with_a_package(name: str) -> None:
    said = next(row[1] for row in rows("dependencies", "# Dependencies") if row[0] == f"`{name}`")
    others = closure([n for n in NEEDED if n != name])
    alone = closure([name]) - others
    assert said.startswith("(") == (canonicalize_name(name) in others)
    assert near(said, size(alone or {name}))


@pytest.mark.heavy
def test_all_sizes_together_are_said() -> None:
    text = (ROOT / "docs" / "reference" / "dependencies.md").read_text(encoding="utf-8")
    said = re.search(r"All\s+dependencies\s+together\s+take\s+(\d+)\s+MB", text)
    assert said is not None and abs(float(said[1]) - size(closure(NEEDED))) < 100


def test_every_extra_is_explained() -> None:
    table = {row[0].strip("`"): row for row in rows("dependencies", "## Extras")}
    assert table.keys() == EXTRAS.keys()
    assert {n: re.findall(r"`([\w-]+)`", row[1]) for n, row in table.items()} == EXTRAS


@pytest.mark.heavy
def test_what_is_heavy_and_has_one_user_is_an_extra() -> None:
    sources = [p.read_text(encoding="utf-8") for folder in ("cramlite", "plugins") for p in (ROOT / folder).rglob("*.py")]
    used = {n: sum(bool(re.search(rf"^\s*(?:import|from) {m}\b", s, re.MULTILINE)) for s in sources) for n, m in _modules().items()}
    assert used["scipy"] > 10 and used["eaik"] == 1
    others = {n: closure([o for o in NEEDED if o != n]) for n in NEEDED}
    assert [n for n in NEEDED if used[n] <= 1 and size(closure([n]) - others[n]) > HEAVY] == [GOALS]


def test_licences_that_are_not_permissive_are_named() -> None:
    named = (ROOT / "docs" / "reference" / "dependencies.md").read_text(encoding="utf-8").split("## Licences", 1)[1].split("## ", 1)[0]
    assert {canonicalize_name(n) for n in re.findall(r"`([\w-]+)`", named)} == {n for n in closure(NEEDED) if "GPL" in _licence(n)}


def _licence(name: str) -> str:
    """The licence in a package's metadata, without the text of the licence."""
    said = metadata.metadata(name)
    terms = [*(said.get_all("License-Expression") or ()), *(text[:60] for text in said.get_all("License") or ())]
    return " ".join([*terms, *(c for c in said.get_all("Classifier") or () if c.startswith("License"))])


def _modules() -> dict[str, str]:
    """The module that code imports, by package."""
    other = {"pillow": "PIL", "py-horned-owl": "pyhornedowl", "pymongo": "bson", "pyyaml": "yaml"}
    return {n: other.get(n, n.replace("-", "_")) for n in NEEDED}


# Platforms


def test_the_table_of_wheels_is_about_these_packages() -> None:
    text = (ROOT / "docs" / "reference" / "platforms.md").read_text(encoding="utf-8")
    listed = {canonicalize_name(n) for n in re.findall(r"`([\w-]+)`", text.split("<!-- wheels: begin -->")[1])}
    assert closure(NEEDED) | {canonicalize_name(n) for wanted in EXTRAS.values() for n in wanted} == listed


def test_versions_of_python_are_those_that_everything_has_a_wheel_for() -> None:
    ways = {row[0].removeprefix("Python "): row[1:] for row in rows("platforms", "One wheel for every system")}
    promised = SpecifierSet(PROJECT["requires-python"])
    assert {v: "installs" in cells for v, cells in ways.items()} == {v: promised.contains(f"{v}.1") for v in ways}
    assert list(ways) == ["3.11", "3.12", "3.13", "3.14"]
