"""Circumlocutions in first lines of docstrings and in messages: "what is held" where the glossary has "payload".

``python tests/helpers/circumlocutions.py [--all]`` prints counts by room, and examples, or all of them. It is a report, and no check:
a sentence may need one. Terms: docs/reference/glossary.md.
"""

from __future__ import annotations

import ast
import re
import sys
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).parents[2]
ROOMS = ("cramlite", "plugins/cramlite_plugins", "experiments")
MESSAGES = re.compile(r"(Error|Refused|Refusal|Unresolvable|NoSolution|Finding|refused|objection)$")
TERMS = {
    r"\bwhat (is|was|it|they|the hand|he) (is |was |are )?(held|holds?|carries|carried)\b": "payload",
    r"\bwhat (lies|stands|is) (there|in the way|before it|beside it)\b": "obstacle",
    r"\bwhat (it|something|a thing|the thing|they) (is |are )?(put|stands?|rests?|lies?)( \w+)? on(to)?\b": "support",
    r"\bwhat (carries|bears|supports|is under)\b": "support",
    r"\bwhat (is over|is above|covers)\b": "overhang",
    r"\bwhat hides\b": "occluder",
    r"\bwhat (lies|is) in (it|there)\b": "content",
    r"\bwhat can be moved\b": "movable thing",
    r"\bwhat cannot be moved\b|\bwhat is fixed\b": "furniture",
    r"\b(what|how|whether) (is|was|it is) said\b|\bwhat \w+ says?\b": "statement, text, answer",
    r"\bsomebody|\bwhoever\b|\bwho\b": "a role: user, client, caller, person",
    r"\bwhat\b": "a noun",
}
"""Regular expression of a circumlocution -> the glossary's term for it, special patterns first."""


class Phrase(NamedTuple):
    """Circumlocution with its place, its text and the term that may stand for it."""

    place: str
    kind: str
    text: str
    term: str


def found(text: str) -> tuple[str, str] | None:
    """Return the first circumlocution of a text and its term; None without one."""
    hits = ((m.start(), m[0], term) for pattern, term in TERMS.items() if (m := re.search(pattern, text, re.IGNORECASE)))
    first = next(iter(hits), None)
    return None if first is None else (first[1], first[2])


def texts(tree: ast.AST) -> Iterator[tuple[int, str, str]]:
    """Yield line, kind and text of each first line and each message of a module."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef) and (doc := ast.get_docstring(node)):
            yield getattr(node, "lineno", 1), "first line", doc.split("\n\n")[0].replace("\n", " ")
        if isinstance(node, ast.Call) and MESSAGES.search(getattr(node.func, "attr", getattr(node.func, "id", ""))):
            parts = [c.value for a in node.args for c in ast.walk(a) if isinstance(c, ast.Constant) and isinstance(c.value, str)]
            yield node.lineno, "message", " ".join(parts)


def phrases(root: Path = ROOT) -> Iterator[Phrase]:
    """Yield the circumlocutions of all modules of the project."""
    for path in sorted(p for room in ROOMS for p in (root / room).rglob("*.py")):
        for line, kind, text in texts(ast.parse(path.read_text(encoding="utf-8"))):
            if (hit := found(text)) is not None:
                yield Phrase(f"{path.relative_to(root)}:{line}", kind, text, hit[1])


def main(everything: bool) -> None:
    """Print the number of circumlocutions by kind, term and folder, and some or all of them."""
    listed = list(phrases())
    rooms = Counter("/".join(Path(p.place).parts[: 3 if p.place.startswith("plugins") else 2]) for p in listed)
    print(f"{len(listed)} circumlocutions: {dict(Counter(p.kind for p in listed))}")
    print("for: " + ", ".join(f"{term} {n}" for term, n in Counter(p.term for p in listed).most_common()))
    print("in: " + ", ".join(f"{room} {n}" for room, n in rooms.most_common(12)))
    shown = listed if everything else [p for p in listed if p.term != "a noun"][:: max(len(listed) // 60, 1)]
    for phrase in shown:
        print(f"  {phrase.place} ({phrase.term}): {phrase.text[:120]}")


if __name__ == "__main__":
    main("--all" in sys.argv)
