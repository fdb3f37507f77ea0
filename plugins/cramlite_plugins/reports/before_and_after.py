"""Pictures of a proven run at its start and its end, and a short film of it; the view is fitted to the things that the tasks name."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from cramlite.model import thing_of
from cramlite.plugin import ReportSection, hookimpl

from .filmstrip import as_uri
from .moment import run_in_short
from .shared import fill

if TYPE_CHECKING:
    from cramlite import Finished, Solution

SIZE = (480, 360)
"""Width and height of a picture [pixel]: three beside each other are as wide as the page."""
QUALITY = 85
"""WebP quality of a picture: it takes about 8 kB."""


@hookimpl
def report_sections() -> Iterable[ReportSection]:
    yield ReportSection("Before and after", 5, render)


def render(done: Finished) -> str:
    """Render the report's pictures of the start and the end of the run as HTML; nothing where nothing ran."""
    rollout = done.solution.candidate.rollout
    if rollout is None:
        return ""
    about, last = things_named(done.solution), len(rollout.times) - 1
    pictures = [(title, as_uri(done.picture(k, SIZE, about), QUALITY)) for title, k in (("Before", 0), ("After", last))]
    run = run_in_short(done, "The run", about)
    return fill("before_and_after", pictures=pictures, run=run, seconds=float(rollout.times[-1]), size=SIZE)


def things_named(solution: Solution) -> tuple[str, ...]:
    """Return the things that the tasks of a program name, each once; a part of a thing counts as the thing."""
    bound = solution.candidate.bindings
    fillers = [f for action in solution.candidate.actions for f in action.roles.values()]
    names = [thing_of(str(f.entity or bound.get(f.name, ""))) for f in fillers]
    return tuple(dict.fromkeys(n for n in names if n))
