"""The page of a judged experiment: one self-contained HTML file with the tables, and a picture of how each episode ended."""

from __future__ import annotations

import base64
from collections import Counter
from collections.abc import Sequence
from importlib.resources import files
from pathlib import Path

from ...base.html_template import html_template
from . import report
from .results import EpisodeResult, plain_reason
from .spec import Episode, JudgedExperiment
from .tables import Tables

COMMONEST = 3
"""Classes of failures that are explained by pictures."""
SHOWN = 4
"""Episodes of each."""


def page(tables: Tables, results: Sequence[EpisodeResult], experiment: JudgedExperiment, out: Path) -> str:
    """Render the page as HTML.

    Args:
        out: the run directory, where the pictures are.
    """
    source = (files(__package__) / "page.html.j2").read_text("utf-8")
    style = (files("cramlite.report") / "page.css").read_text("utf-8")
    return html_template(source).render(
        title=experiment.spec.title, given=experiment.spec.given, tables=tables, style=style, report=report, experiment=experiment,
        episodes=results, explained=explained(results), why=why, said=said,
        picture=lambda r: _picture(out, r, _name(r)), believed=lambda r: _picture(out, r, r.attempt.believed if r.attempt else r.miss),
    )  # fmt: skip


def explained(results: Sequence[EpisodeResult]) -> list[tuple[str, int, list[EpisodeResult]]]:
    """Return the commonest classes of failures, how many there are, and some of them, those with a picture first."""
    counts = Counter(r.failure for r in results if r.failure and not r.apart)
    return [
        (kind, count, sorted((r for r in results if r.failure == kind), key=lambda r: not _name(r))[:SHOWN])
        for kind, count in counts.most_common(COMMONEST)
    ]


def why(result: EpisodeResult) -> str:
    """Return why an episode failed, in one clause."""
    attempt = result.attempt
    if attempt is None:
        return plain_reason(result.reason)
    if attempt.reason:
        return f"the program ended by {attempt.outcome}: {attempt.reason}"
    ours = "; as cramlite understands the goal, it holds" if attempt.ours else ""
    if attempt.first is None:
        return f"the program ran to its end, and the judge's check was never true{ours}"
    if not attempt.rest:
        return f"the check was true at action {attempt.first}, and no longer is at rest{ours}"
    return f"the check was true at action {attempt.first}, beyond the budget of {result.budget}"


def said(result: EpisodeResult) -> str:
    """Return how an episode ended, in a word or two."""
    if result.apart:
        return f"{result.failure}, counted in no rate"
    return "true at rest" if result.rest() else f"failed: {result.failure}"


def _name(result: EpisodeResult) -> str:
    shown = result.attempt or result.refused
    return shown.picture if shown is not None else result.picture


def _picture(out: Path, result: EpisodeResult, name: str) -> str:
    """A picture as a data address; empty if there is none."""
    episode = Episode(result.suite, result.task, result.state)
    path = out / "episodes" / episode.name / (name or "none")
    if not path.is_file():
        return ""
    kind = "png" if name.endswith(".png") else "jpeg"
    return f"data:image/{kind};base64," + base64.b64encode(path.read_bytes()).decode()
