"""Page about how the episodes of a benchmark ended, in words and pictures."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from pathlib import Path

from ..page import page, picture
from . import report
from .results import EpisodeResult, plain_reason
from .spec import BenchmarkExperiment, Episode
from .tables import EpisodeTables

COMMONEST = 3
"""Number of classes of failures, the commonest ones, that the page explains by pictures."""
SHOWN = 4
"""Largest number of episodes that the page shows for each class of failures."""


def outcomes_page(tables: EpisodeTables, results: Sequence[EpisodeResult], experiment: BenchmarkExperiment, folder: Path) -> str:
    """Render the HTML page about how the episodes of a benchmark ended.

    Args:
        folder: of the episodes' files, where the pictures are.
    """
    def shown(result: EpisodeResult, name: str) -> str:
        return picture(folder / Episode(result.suite, result.task, result.state).name / (name or "none"))

    return page(
        __package__, experiment.spec.title, given=experiment.spec.given, tables=tables, report=report, experiment=experiment,
        episodes=results, explained=explained(results), why=why, said=outcome_text, seen=lambda r: shown(r, _name(r)),
        believed=lambda r: shown(r, r.attempt.believed if r.attempt else r.miss),
    )  # fmt: skip


def explained(results: Sequence[EpisodeResult]) -> list[tuple[str, int, list[EpisodeResult]]]:
    """Return the commonest classes of failures, each with its count and some of its episodes, those with a
    picture first."""
    counts = Counter(r.failure for r in results if r.failure and not r.apart)
    return [
        (kind, count, sorted((r for r in results if r.failure == kind), key=lambda r: not _name(r))[:SHOWN])
        for kind, count in counts.most_common(COMMONEST)
    ]


def why(result: EpisodeResult) -> str:
    """Say in one line why an episode failed."""
    attempt = result.attempt
    if attempt is None:
        return plain_reason(result.reason)
    if attempt.reason:
        return f"the program ended by {attempt.outcome}: {attempt.reason}"
    ours = "; as cramlite understands the goal, it holds" if attempt.ours else ""
    if attempt.first is None:
        return f"the program ran to its end, and the benchmark's check was never true{ours}"
    if not attempt.rest:
        return f"the benchmark's check was true at action {attempt.first}, but not when all things were at rest{ours}"
    return f"the benchmark's check was true at action {attempt.first}, beyond the budget of {result.budget}"


def outcome_text(result: EpisodeResult) -> str:
    """Format how an episode ended in a few words: "true at rest" if the benchmark's check held once all things
    were at rest, else the class of its failure."""
    if result.apart:
        return f"{result.failure}, counted in no rate"
    return "true at rest" if result.rest() else f"failed: {result.failure}"


def in_a_line(result: EpisodeResult) -> str:
    """Format an episode's result as one line."""
    name = f"{result.suite} {result.task} {result.state} {result.name}"
    if result.attempt is None:
        return f"{name}: no program ({result.failure}): {plain_reason(result.reason)}"
    a = result.attempt
    truth = "benchmark's check never true"
    if a.first is not None:
        truth = f"benchmark's check first true at action {a.first}, {'true' if a.rest else 'not true'} when all things were at rest"
    return f"{name}: {a.outcome} after {a.steps} of {result.budget} steps, {truth}{f' ({result.failure})' if result.failure else ''}"


def _name(result: EpisodeResult) -> str:
    shown = result.attempt or result.refused
    return shown.picture if shown is not None else result.picture
