"""The table "to change X, open Y" leads to files that exist and have the names that it gives, two at most for a change."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from conftest import ROOT

PAGE = ROOT / "docs" / "how-to" / "contribute.md"
MOST = 2
PLACE = re.compile(r"`([\w./-]+[/.][\w./-]*)`(?: \(((?:`[^`]+`(?:, )?)+)\))?")


def rows(text: str) -> list[tuple[str, list[tuple[str, tuple[str, ...]]]]]:
    """The changes of the table, each with its places: a path, and the names to be found there."""
    table = text.partition("## To change X, open Y")[2].partition("\n## ")[0]
    lines = [line.strip("| ").partition(" | ") for line in table.splitlines() if line.startswith("| ")][1:]
    return [(change, [(m[1], tuple(re.findall(r"`([^`]+)`", m[2] or ""))) for m in PLACE.finditer(rest)]) for change, _, rest in lines]


def wrong(path: str, names: tuple[str, ...], root: Path = ROOT) -> list[str]:
    """The error in a place of the table: a path or a name that does not exist."""
    there = root / path
    if not there.exists() or path.endswith("/") != there.is_dir():
        return [f"there is no '{path}'"]
    files = sorted(there.rglob("*.py")) if there.is_dir() else [there]
    texts = [f.read_text(encoding="utf-8") for f in files]
    said = [f"'{n}' is not in '{path}'" for n in names if not any(re.search(rf"\b{re.escape(n)}\b", t) for t in texts)]
    return said or ([] if names else [f"'{path}' says no name to look for"])


ROWS = rows(PAGE.read_text(encoding="utf-8"))


def test_the_changes_are_there() -> None:
    assert len(ROWS) == 16


@pytest.mark.parametrize(("change", "places"), ROWS, ids=[change for change, _ in ROWS])
def test_a_row_leads_to_what_it_says(change: str, places: list[tuple[str, tuple[str, ...]]]) -> None:
    assert 1 <= len(places) <= MOST, change
    assert [w for path, names in places for w in wrong(path, names)] == []


def test_a_row_that_leads_nowhere_is_seen(tmp_path: Path) -> None:
    row = "| a wheel | `cart/wheel.py` (`SPOKES`, `Rim`): it | or `cart/` (`axle`) |"
    ((change, places),) = rows(f"## To change X, open Y\n| to change | open | and |\n|---|---|---|\n{row}\n")
    assert (change, places) == ("a wheel", [("cart/wheel.py", ("SPOKES", "Rim")), ("cart/", ("axle",))])
    assert wrong(*places[0], tmp_path) == ["there is no 'cart/wheel.py'"]
    (tmp_path / "cart").mkdir()
    (tmp_path / "cart" / "wheel.py").write_text("SPOKES = 8\n")
    assert wrong(*places[0], tmp_path) == ["'Rim' is not in 'cart/wheel.py'"]
    assert wrong(*places[1], tmp_path) == ["'axle' is not in 'cart/'"]
    assert wrong("cart/wheel.py", ("SPOKES",), tmp_path) == []
    assert wrong("cart/wheel.py", (), tmp_path) == ["'cart/wheel.py' says no name to look for"]
    assert wrong("cart/wheel.py/", ("SPOKES",), tmp_path) != []
