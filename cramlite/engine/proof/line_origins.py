"""Task of each line of a program's text, also of a text that was edited after it was written."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from difflib import SequenceMatcher
from typing import NamedTuple

from ...base.value import Value
from ...model.designator_name import task_of
from ...model.program.program import Code
from ...model.program.program_json import is_program_text, read_program
from ...model.program.steps import walk

ALIKE = 0.6
"""Similarity from which on a changed line is taken for an edited version of an old line (the default of ``difflib`` for close matches)."""


class Origins(Value):
    """Origins of a program text's lines: the designators whose steps the lines belong to.

    Args:
        of: line, from 1 -> origin that begins there, as ``Code.origins``; "" where the code of a step ends.
        guessed: lines of code of which nothing says whose they are; they count to the code before them.
    """

    of: Mapping[int, str]
    guessed: tuple[int, ...] = ()


class _Line(NamedTuple):
    """Line of code: its number, its code, and its comments, the nearest last."""

    number: int
    code: str
    said: tuple[str, ...]


CODE = re.compile(r'(?:"[^"]*"|[^"#])*')
"""Pattern of the code in a line: everything before the comment, where "#" inside quotes begins no comment."""


def origins_of(text: str, original: Code) -> Origins:
    """Find the origin (the step's designator) of each line of a program text, which may be an edited copy of
    the proven text.

    Steps of a typed program say theirs. Lines of another text are matched by their code: those that are as they were keep theirs,
    also where they stand elsewhere, and changed ones have that of the line that they replace. Comments count only for
    code that is new.
    """
    if is_program_text(text):
        return _of_steps(text)
    if text == original.text:
        return Origins(original.origins)
    old, new = list(_code_lines(original.text)), list(_code_lines(text))
    own, known = _of_each(old, original), set(original.origins.values())
    changes = SequenceMatcher(None, [x.code for x in old], [x.code for x in new], autojunk=False).get_opcodes()
    moved = _gone(old, own, changes)
    found: list[str | None] = []
    for tag, i1, i2, j1, j2 in changes:
        if tag == "equal":
            found += own[i1:i2]
        else:
            found += [_of_new(line, old[i1:i2], own[i1:i2], moved, known) for line in new[j1:j2]]
    return _begins(found, new)


def origins_by_labels(text: str, tasks: Collection[str]) -> Origins:
    """Find the origins (designators of steps) of a text's lines by the names in them, with no proven text
    to compare."""
    if is_program_text(text):
        return _of_steps(text)
    lines = text.splitlines()
    found = {k: task for k, line in enumerate(lines, 1) if (task := named(line, tasks))}
    return Origins(found)


def named(line: str, known: Collection[str]) -> str:
    """Return the known designator that a line of text names; "" if it names none."""
    words = re.findall(r"\d+\.\w+(?:/\w+)*", line)
    return next((w for w in words if w in known), "") or next((task_of(w) for w in words if task_of(w) in known), "")


def _of_steps(text: str) -> Origins:
    read = read_program(text)
    return Origins({read.lines[id(s)]: s.origin for s in walk(read.program.steps) if s.origin})


def _code_lines(text: str) -> Iterator[_Line]:
    """Yield the lines of a text that hold code, each with its own comment and the comments between it and the code before."""
    said: list[str] = []
    for number, line in enumerate(text.splitlines(), 1):
        code = CODE.match(line)
        assert code is not None  # it matches nothing, too
        said.append(line[code.end() :])
        if code[0].strip():
            yield _Line(number, code[0].strip(), tuple(said))
            said = []


def _of_each(lines: Sequence[_Line], original: Code) -> list[str]:
    """Return, for each line of code, the designator of the step that it belongs to; "" after a step's last line."""
    ends = [k for k, line in enumerate(original.text.splitlines(), 1) if not line.strip()]
    begins = sorted(original.origins)
    found = []
    for line in lines:
        begin = max((k for k in begins if k <= line.number), default=0)
        ended = any(begin < k < line.number for k in ends)
        found.append("" if ended or not begin else original.origins[begin])
    return found


Change = tuple[str, int, int, int, int]
"""A change that SequenceMatcher found: how lines of the old text became lines of the new one."""


def _gone(old: Sequence[_Line], own: Sequence[str], changes: Sequence[Change]) -> Mapping[str, str]:
    """Map the code of each removed line to its origin (the step's designator), unless equal lines had several
    origins."""
    found: dict[str, set[str]] = {}
    for tag, i1, i2, _, _ in changes:
        for k in range(i1, i2) if tag != "equal" else ():
            found.setdefault(old[k].code, set()).add(own[k])
    return {code: next(iter(origins)) for code, origins in found.items() if len(origins) == 1}


def _of_new(line: _Line, old: Sequence[_Line], own: Sequence[str], moved: Mapping[str, str], known: Collection[str]) -> str | None:
    """Origin (the step's designator) of a line that an edit added, from names in its code, the line that it
    replaces, or comments; None if unknown."""
    if by_code := named(line.code, known):
        return by_code
    replaced = moved[line.code] if line.code in moved else _replaced(line, old, own)
    if replaced is not None:
        return replaced
    said = next((o for text in reversed(line.said) if (o := named(text, known))), "")
    whole = own[0] if old and len({task_of(o) for o in own}) == 1 else None
    return said or whole


def _replaced(line: _Line, old: Sequence[_Line], own: Sequence[str]) -> str | None:
    """Origin (the step's designator) of that replaced line whose code is most similar to the new line; None
    if none is similar."""
    shares = [(SequenceMatcher(None, line.code, other.code, autojunk=False).ratio(), -k) for k, other in enumerate(old)]
    share, k = max(shares, default=(0.0, 0))
    return own[-k] if share >= ALIKE else None


def _begins(each: Sequence[str | None], lines: Sequence[_Line]) -> Origins:
    """Return the lines at which the origin (the step's designator) changes, and those whose origin is a guess.

    The guess is that a line belongs to the step of the line before it.
    """
    found, guessed, now = dict[int, str](), list[int](), ""
    for line, origin in zip(lines, each, strict=True):
        if origin is None:
            guessed += [line.number] if now else []
        elif origin != now:
            found[line.number] = now = origin
    return Origins(found, tuple(guessed))
