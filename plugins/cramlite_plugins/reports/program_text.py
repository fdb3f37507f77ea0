"""The program's text: every line with the step that it came from."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from cramlite import Code, ReportSection, hookimpl
from cramlite.report import Finished

from .shared import fill

COMMENTS = ("#", "//", ";")
"""How a line of comment begins in the languages of robots."""


@dataclass(frozen=True)
class Line:
    """One line: ``origin`` is set on the first line of a step only, ``step`` on all of them."""

    number: int
    text: str
    step: str
    origin: str
    comment: bool


@dataclass(frozen=True)
class Block:
    """Lines that belong together: a task's code, or what is written before and around the tasks."""

    task: str
    lines: tuple[Line, ...]


@hookimpl
def report_sections() -> Iterable[ReportSection]:
    yield ReportSection("The program", 70, render)


def render(done: Finished) -> str:
    code = done.solution.candidate.code
    if code is None:
        return fill("nothing", text="No text was written.")
    sections = {s.task: s.title for s in done.solution.program.sections}
    return fill("program_text", code=code, blocks=list(blocks(code)), sections=sections)


def blocks(code: Code) -> Iterator[Block]:
    """The text cut where the task changes; a comment above a step belongs to it."""
    lines = list(_lines(code))
    start = 0
    for k in range(1, len(lines) + 1):
        if k == len(lines) or lines[k].step.split("/")[0] != lines[start].step.split("/")[0]:
            yield Block(lines[start].step.split("/")[0], tuple(lines[start:k]))
            start = k


def _lines(code: Code) -> Iterator[Line]:
    texts = code.text.splitlines()
    steps, step = [""] * len(texts), ""
    for k in range(len(texts)):
        step = code.origins.get(k + 1, step)
        steps[k] = step
    for k in range(len(texts) - 2, -1, -1):  # a comment or empty line leads to what follows it
        if k + 1 not in code.origins and (not texts[k].strip() or _is_comment(texts[k])):
            steps[k] = steps[k + 1]
    for k, text in enumerate(texts, 1):
        yield Line(k, text, steps[k - 1], code.origins.get(k, ""), _is_comment(text))


def _is_comment(text: str) -> bool:
    return text.lstrip().startswith(COMMENTS)
