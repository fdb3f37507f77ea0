"""Table of the defects for docs/reference/program_defects.md: ``python tests/program_tests/defects_table.py`` writes it."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import yaml

FOLDER = Path(__file__).parent / "defects"
DEFECTS: dict[str, dict[str, Any]] = {
    p.stem: yaml.safe_load(p.read_text(encoding="utf-8")) for p in sorted(FOLDER.glob("*.yaml"))
}
PAGE = Path(__file__).parents[2] / "docs" / "reference" / "program_defects.md"
HEAD = "| defect | planted | instead of | the test that refuses it | where users met it |\n|---|---|---|---|---|\n"


def table() -> str:
    """The table, a row for each kind."""
    return HEAD + "".join(f"| {' | '.join(_row(d))} |\n" for d in DEFECTS.values())


def _row(defect: dict[str, Any]) -> Iterator[str]:
    yield defect["kind"]
    yield _code(defect["bad"])
    yield _code(defect["mended"])
    yield _code(defect["test"])
    yield "<br>".join(f"[{m['at']}]({_address(m['at'])}): {m['says']}" for m in defect["met"]) or "not found"


def _code(text: str) -> str:
    lines = [line.strip() for line in text.strip().splitlines()]
    return "<br>".join(f"`{line}`" for line in lines) or "nothing"


def _address(at: str) -> str:
    repository, number = at.split("#")
    return f"https://github.com/{repository}/issues/{number}"


if __name__ == "__main__":
    before = PAGE.read_text(encoding="utf-8").split(HEAD)[0]
    PAGE.write_text(before + table(), encoding="utf-8", newline="\n")
