"""Program listing: every line with the step that it came from."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator
from typing import TYPE_CHECKING

from cramlite.model import Value, task_of
from cramlite.plugin import ReportSection, hookimpl

from .links import COMMENTS, steps_of, target, targets
from .shared import fill

if TYPE_CHECKING:
    from cramlite import Finished
    from cramlite.plugin import Code


class ProgramLine(Value):
    """Program line: ``origin`` is set on the first line of a step only, ``step`` on all of them.

    Args:
        leads: the designator on the page that it leads to; "" for none.
    """

    number: int
    text: str
    step: str
    origin: str
    comment: bool
    leads: str = ""


class Block(Value):
    """Consecutive lines of one task's code, or of the code before and after the tasks."""

    task: str
    lines: tuple[ProgramLine, ...]


@hookimpl
def report_sections() -> Iterable[ReportSection]:
    yield ReportSection("The program", 70, render, refused=True)


def render(done: Finished) -> str:
    """Render the report's listing of the program's text as HTML."""
    if done.shown is None:
        return ""
    code = done.shown.candidate.code
    if code is None:
        return fill("nothing", text="No text was written.")
    sections = {s.task: s.title for s in done.shown.program.sections}
    return fill("program_text", code=code, blocks=list(blocks(code, targets(done))), sections=sections)


def blocks(code: Code, known: Collection[str] = ()) -> Iterator[Block]:
    """Split the program's text where the task changes; a comment above a step belongs to the step's task.

    Args:
        known: designators that have a place on the page.
    """
    lines = list(_lines(code, known))
    start = 0
    for k in range(1, len(lines) + 1):
        if k == len(lines) or task_of(lines[k].step) != task_of(lines[start].step):
            yield Block(task_of(lines[start].step), tuple(lines[start:k]))
            start = k


def _lines(code: Code, known: Collection[str]) -> Iterator[ProgramLine]:
    steps = steps_of(code)
    for k, text in enumerate(code.text.splitlines(), 1):
        step = steps[k - 1]
        comment = text.lstrip().startswith(COMMENTS)
        yield ProgramLine(k, text, step, code.origins.get(k, ""), comment, target(step, known))
