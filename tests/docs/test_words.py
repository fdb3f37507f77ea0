"""The report on circumlocutions finds them in first lines and messages, and leaves plain sentences alone; no page has conflict marks."""

from __future__ import annotations

import ast
import re
from pathlib import Path

from helpers.circumlocutions import ROOT, found, phrases, texts

MODULE = '''"""What is held."""

def lift(thing):
    """Lift the payload.

    What comes behind an empty line is no first line.
    """
    raise Refused(f"'{thing}' meets what lies there", check="clear")
'''


def test_circumlocutions_are_found_with_their_terms() -> None:
    assert [(line, kind, found(text)) for line, kind, text in texts(ast.parse(MODULE))] == [
        (1, "first line", ("What is held", "payload")),
        (3, "first line", None),
        (8, "message", ("what lies there", "obstacle")),
    ]


def test_a_folder_is_reported(tmp_path: Path) -> None:
    (tmp_path / "cramlite").mkdir()
    (tmp_path / "cramlite" / "module.py").write_text(MODULE)
    assert [(p.place, p.term) for p in phrases(tmp_path)] == [("cramlite/module.py:1", "payload"), ("cramlite/module.py:8", "obstacle")]


def conflicts(text: str) -> list[str]:
    """Lines that a merge leaves where both sides changed."""
    return re.findall(r"^(?:<{7}|>{7}) .*$", text, re.MULTILINE)


def test_no_page_has_marks_of_a_conflict() -> None:
    pages = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
    assert len(pages) > 50
    assert {p.name: conflicts(p.read_text(encoding="utf-8")) for p in pages if conflicts(p.read_text(encoding="utf-8"))} == {}


def test_marks_of_a_conflict_are_found() -> None:
    assert conflicts("a\n<<<<<<< HEAD\nb\n=======\nc\n>>>>>>> main\n") == ["<<<<<<< HEAD", ">>>>>>> main"]
