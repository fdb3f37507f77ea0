"""Diagram of the demonstration: its states and actions over time, the reading that was used, and the best
other one."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from cramlite.plugin import ReportSection, hookimpl

from .readings import number_of
from .shared import fill

if TYPE_CHECKING:
    from cramlite import Finished


@hookimpl
def report_sections() -> Iterable[ReportSection]:
    yield ReportSection("The demonstration", 30, render, refused=True)


def render(done: Finished) -> str:
    """Render the report's diagram of the demonstration as HTML; nothing where there was none."""
    from cramlite import reading_picture

    if done.episode is None:
        return ""
    picture = reading_picture(done.episode, done.interpretation, number_of(done))
    return fill("demonstration", picture=picture, repairs=done.episode.repairs)
