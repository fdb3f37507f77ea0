"""Of the functions that programs may carry, those that one needs: who loads a program has nothing to read that never runs."""

from __future__ import annotations

import re
from collections.abc import Sequence

HEADING = "# ---- "
DEFINED = re.compile(r"^(?:def|thread|global) (\w+)", re.MULTILINE)


def used(library: Sequence[str], text: str) -> list[str]:
    """The lines of a library that a text refers to, directly or through others, in their order.

    Args:
        library: paragraphs, each a function or variables that belong together, with their comments; empty lines between them.
            A heading stays where anything below it, up to the next one, does.
        text: what calls them.
    """
    paragraphs = ["\n".join(part) for part in _paragraphs(library)]
    kept: set[int] = set()
    while True:
        known = text + "\n".join(paragraphs[k] for k in kept)
        words = set(re.findall(r"\w+", known))
        more = {k for k, p in enumerate(paragraphs) if k not in kept and words & set(DEFINED.findall(p))}
        if not more:
            return _joined(paragraphs, kept)
        kept |= more


def _paragraphs(lines: Sequence[str]) -> list[list[str]]:
    """Split at empty lines, and behind headings."""
    found: list[list[str]] = [[]]
    for line in lines:
        if line.startswith(HEADING):
            found += [[line], []]
        elif line:
            found[-1].append(line)
        elif found[-1]:
            found.append([])
    return [p for p in found if p]


def _joined(paragraphs: Sequence[str], kept: set[int]) -> list[str]:
    lines: list[str] = []
    heading = ""
    for k, paragraph in enumerate(paragraphs):
        if paragraph.startswith(HEADING):
            heading = paragraph
        elif k in kept:
            lines += ["", heading] if heading else [""]
            lines += paragraph.split("\n")
            heading = ""
    return lines[1:]
