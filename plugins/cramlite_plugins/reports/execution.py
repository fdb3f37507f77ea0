"""Report of the first execution: the proven program in the real world, once, with the validators' findings."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from cramlite.model import replace
from cramlite.plugin import ReportSection, hookimpl

from .filmstrip import filmstrip
from .shared import fill, spans

if TYPE_CHECKING:
    from cramlite import Finished


@hookimpl
def report_sections() -> Iterable[ReportSection]:
    yield ReportSection("The first execution", 22, render)


def render(done: Finished) -> str:
    execution = done.solution.execution
    if execution is None or execution.candidate.rollout is None:
        return ""
    there = replace(done.solution, candidate=execution.candidate)
    frames = filmstrip(replace(done, shown=there), spans(there))
    findings = sorted(execution.verdict.findings, key=lambda f: f.passed)
    return fill("execution", verdict=execution.verdict, findings=findings, frames=frames, checks=execution.checks)
