"""Which task a line of a program's text belongs to, also where somebody has edited the text since it was written."""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping
from difflib import SequenceMatcher

from ..base.value import Value
from ..model.designator_name import task_of
from ..model.program import Code
from ..model.program_json import is_program_text, read_program
from ..model.steps import walk

ALIKE = 0.6
"""Share of characters from which a changed line is taken for the one that it replaces (difflib's own idea of a close match)."""


class Origins(Value):
    """Origins of a text's lines.

    Args:
        of: line, from 1 -> origin that begins there, as ``Code.origins``; "" where the code of a step ends.
        guessed: lines of which nothing says whose they are; they count to what stands before them.
    """

    of: Mapping[int, str]
    guessed: tuple[int, ...] = ()


def origins_of(text: str, original: Code) -> Origins:
    """Find the origins of a text that may be another one's edited copy.

    Steps of a typed program say theirs. Lines of another text that are as they were keep theirs, changed ones that of the line
    that they replace, and new ones have that which they name, as the comments of emitted code do.
    """
    if is_program_text(text):
        return _of_steps(text)
    if text == original.text:
        return Origins(original.origins)
    old, new = original.text.splitlines(), text.splitlines()
    own, known = _of_each(old, original.origins), set(original.origins.values())
    found: dict[int, str | None] = {}
    for tag, i1, i2, j1, j2 in SequenceMatcher(None, old, new, autojunk=False).get_opcodes():
        for j in range(j1, j2):
            same = own[i1 + j - j1] if tag == "equal" else None
            found[j] = same if same is not None else named(new[j], known) or _replaced(new[j], old[i1:i2], own[i1:i2])
    return _begins([found[j] for j in range(len(new))], new)


def origins_by_labels(text: str, tasks: Collection[str]) -> Origins:
    """Find the origins of a text that no program here was written to: those that its lines name, as comments or in messages."""
    if is_program_text(text):
        return _of_steps(text)
    lines = text.splitlines()
    found = {k: task for k, line in enumerate(lines, 1) if (task := named(line, tasks))}
    return Origins(found)


def named(line: str, known: Collection[str]) -> str:
    """Find the origin that a line names; "" where it names none that is known."""
    words = re.findall(r"\d+\.\w+(?:/\w+)*", line)
    return next((w for w in words if w in known), "") or next((task_of(w) for w in words if task_of(w) in known), "")


def _of_steps(text: str) -> Origins:
    read = read_program(text)
    return Origins({read.lines[id(s)]: s.origin for s in walk(read.program.steps) if s.origin})


def _of_each(lines: list[str], origins: Mapping[int, str]) -> list[str]:
    """The origin of every line: the last one that begins at or before it, as far as the next empty line, where the code of a
    step ends; "" behind it."""
    found, now = [], ""
    for number, line in enumerate(lines, 1):
        now = origins.get(number, now if line.strip() else "")
        found.append(now)
    return found


def _replaced(line: str, old: list[str], own: list[str]) -> str | None:
    """The origin of the line that a changed one replaces: the most similar one, or any if all are of one task."""
    shares = [(SequenceMatcher(None, line, other, autojunk=False).ratio(), -k) for k, other in enumerate(old) if other.strip()]
    share, k = max(shares, default=(0.0, 0))
    if share >= ALIKE:
        return own[-k]
    return own[0] if old and len({task_of(o) for o in own}) == 1 else None


def _begins(each: list[str | None], lines: list[str]) -> Origins:
    """Where origins begin; a line of which nothing is known counts to the one before."""
    found, guessed, now = dict[int, str](), list[int](), ""
    for number, origin in enumerate(each, 1):
        if origin is None:
            guessed += [number] if now and lines[number - 1].strip() else []
        elif origin != now:
            found[number] = now = origin
    return Origins(found, tuple(guessed))
