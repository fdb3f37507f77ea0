"""Proof under doubt: results of the program in twins, the numbers drawn for each, and reasons of failures."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

from cramlite.model import TwinRun, Value
from cramlite.plugin import ReportSection, hookimpl

from .shared import fill

if TYPE_CHECKING:
    from cramlite import Finished

ROW = 18
"""Height of a row of the plot [pixel]; its width is 1000."""


class Spread(Value):
    """Row of the plot of the twins: an error of world or robot, and where each twin's draw of it lies between its
    lowest (0) and its highest possible value (1000).

    Args:
        name: of what was drawn.
        dots: position, whether the run succeeded, and what to say of it.
    """

    name: str
    dots: tuple[tuple[float, bool, str], ...]


@hookimpl
def report_sections() -> Iterable[ReportSection]:
    yield ReportSection("Proof under doubt", 27, render, refused=True)


def render(done: Finished) -> str:
    """Render the report's results of the twins as HTML; nothing where there were no twins."""
    found = done.shown.verdict.twins if done.shown is not None else None
    if found is None:
        return ""
    rows = spreads(found.twins)
    return fill("doubts", found=found, rows=rows, height=ROW * len(rows), row=ROW)


def spreads(twins: Sequence[TwinRun]) -> tuple[Spread, ...]:
    """Return a row for each error that was drawn, those first whose draws differ most between runs that failed and others."""
    names = dict.fromkeys(d.name for t in twins for d in t.draws)
    found = [(_apart(twins, n), Spread(n, tuple(_dots(twins, n)))) for n in names]
    return tuple(row for _, row in sorted(found, key=lambda f: -f[0]))


def _dots(twins: Sequence[TwinRun], name: str) -> Iterable[tuple[float, bool, str]]:
    for twin in twins:
        for draw in twin.draws:
            if draw.name == name:
                said = f"twin {twin.number}: {draw}, {'succeeded' if twin.succeeded else 'failed'}"
                yield round(500 + 500 * draw.share, 1), twin.succeeded, said


def _apart(twins: Sequence[TwinRun], name: str) -> float:
    """Distance between the mean draws of an error in succeeded and in failed twins, as a share of the
    error's range; 0 without one of the groups."""
    groups = [[d.share for t in twins if t.succeeded is good for d in t.draws if d.name == name] for good in (True, False)]
    good, bad = groups
    return abs(sum(good) / len(good) - sum(bad) / len(bad)) if good and bad else 0.0
