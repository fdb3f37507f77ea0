"""The gallery shows every shipped scenario as its file is now; no picture is missing or too many."""

from __future__ import annotations

import re

import pytest
from conftest import ROOT

from cramlite import read_scenario

DOCS = ROOT / "docs"
PAGE = (DOCS / "gallery.md").read_text("utf-8")
FILES = [p for p in (ROOT / "scenarios").glob("**/*.yaml") if "demonstration" not in p.parts]
SHIPPED = {p.relative_to(ROOT / "scenarios").with_suffix("").as_posix(): p for p in FILES}
ROWS = {m[1]: m[0] for m in re.finditer(r"^\| `([^`]+)` \|.*$", PAGE, re.MULTILINE)}
AGAIN = "make it again: python docs/site/gallery.py NAME"


def test_every_scenario_is_there() -> None:
    assert set(ROWS) == set(SHIPPED), AGAIN


@pytest.mark.parametrize("name", SHIPPED)
def test_it_says_what_the_file_says(name: str) -> None:
    assert f"**{read_scenario(SHIPPED[name]).spec.title}.**" in ROWS[name], AGAIN
    assert ("Refused." in ROWS[name]) == SHIPPED[name].read_text("utf-8").startswith("# Must fail."), AGAIN


def test_pictures_are_those_of_the_page() -> None:
    shown = set(re.findall(r'src="(assets/gallery/[^"]+)"', PAGE))
    assert shown == {p.relative_to(DOCS).as_posix() for p in (DOCS / "assets" / "gallery").glob("*.webp")}
    assert shown
