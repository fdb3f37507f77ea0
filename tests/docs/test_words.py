"""The report on circumlocutions finds them in first lines and messages, and leaves plain sentences alone."""

from __future__ import annotations

import ast
from pathlib import Path

from helpers.circumlocutions import found, phrases, texts

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
