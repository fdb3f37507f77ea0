"""Report on the episodes of a benchmark in Markdown: how often proofs were right, then the success rates."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from ...base.rate import Rate, digits
from ..figure import Number
from ..measured import rates, value
from .spec import BenchmarkExperiment
from .tables import Difference, EpisodeRow, EpisodeTables, Spread, Watched

WITHIN = (
    "Within the budget means that the benchmark's check was true for the first time within it; unlimited, at any time. At rest: still true "
    "when everything has come to rest after the program's end. No program counts as a failure. Intervals: Wilson, 95 %."
)
HEAD = ("proven", "true at first", "true at rest", "at first, unlimited", "at rest, unlimited", "steps", "advised")
PUBLISHED = ("system", "given", "published", "ours, at rest", "suites", "source")
MOST_REASONS = 10


def markdown(tables: EpisodeTables, experiment: BenchmarkExperiment) -> str:
    """Return the tables of an experiment about a benchmark as a page of Markdown."""
    spec = experiment.spec
    return "\n".join([
        f"# {spec.title}", "", f"Given: {spec.given}. {WITHIN}", "",
        "## What the proof was worth", "", *worth(tables), "",
        "## Suites", "", *grid(("suite", "about", "budget", *HEAD), suite_rows(tables, experiment)), "",
        *([difference(tables.difference), ""] if tables.difference else []),
        *([watched(tables.watched), ""] if tables.watched else []),
        "## Tasks", "", *grid(("suite", "task", "name", *HEAD), task_rows(tables)), "",
        "## Failures", "", *failures(tables), "",
        "## Time", "", *grid(("time [s]", "median", "95 % under", "longest", "episodes"), times(tables.seconds)), "",
        *(["## Beside published figures", "", *grid(PUBLISHED, published_rows(tables)), ""] if tables.published else []),
    ])  # fmt: skip


def worth(tables: EpisodeTables) -> list[str]:
    """Return lines on how often proofs were right: passing verdicts and refusals against the benchmark's
    check."""
    known = tables.refusal_was_wrong
    lines = [f"- A passing verdict was right, in the benchmark's physics and at rest: {tables.passing_was_right.text}."]
    lines += [f"- Episodes without a program: {tables.refusals}."]
    lines += [f"- Episodes in which the process of the benchmark died, counted in no rate: {tables.apart}."] if tables.apart else []
    said = "not known: none was played (`--attempt-refused`)"
    if known.total:
        said = f"{known.text} of the episodes in which a refused program was run nevertheless"
    return [*lines, f"- A refusal was wrong: {said}."]


def suite_rows(tables: EpisodeTables, experiment: BenchmarkExperiment) -> list[list[str]]:
    """Return the rows of the table of success rates by suite, with a last row for all suites together."""
    rows = [[r.suite, experiment.spec.suites[r.suite].about, str(r.budget), *_counts(r)] for r in tables.suites]
    return [*rows, ["all", "", "", *_counts(tables.whole)]] if len(rows) > 1 else rows


def difference(found: Difference) -> str:
    """Return a sentence on the difference between the rates of variant suites and of the suites that they
    vary."""
    low, high = found.interval
    return (
        f"Difference of success rates at rest, variants ({', '.join(found.variants)}) less originals ({', '.join(found.bases)}): "
        f"{signed(found.value)} ({signed(low)} to {signed(high)}, Newcombe): {found.rate.text} less {found.base_rate.text}."
    )


def watched(found: Watched) -> str:
    """Return a sentence with the success rates of suites in which the robot watches the world while a program runs.

    One rate is with simulated time stopped during the search, the other with the search's CPU time passing.
    """
    return (
        f"Success rates at rest of suites in which the robot watches the world: {found.still.text} if simulated time stops during the "
        f"search; {found.passing.text} if the search's CPU time passes."
    )


def signed(value: float) -> str:
    """Return a difference of success rates with its sign, "-.04"."""
    return f"{'-' if round(value, 2) < 0 else '+'}{digits(abs(value))}"


def task_rows(tables: EpisodeTables) -> list[list[str]]:
    """Return the rows of the table of success counts by task of the benchmark."""
    return [[r.suite, str(r.task), r.name, *_counts(r, short=True)] for r in tables.tasks]


def failures(tables: EpisodeTables) -> list[str]:
    """Return Markdown lines with the number of failed episodes of each class of failures, and the commonest reasons of
    refusals."""
    if not tables.failures:
        return ["None."]
    classes = grid(("class", "episodes"), [[kind, str(n)] for kind, n in tables.failures.items()])
    said = list(tables.refused_for.items())[:MOST_REASONS]
    return [*classes, "", "Refusals:", "", *(f"- {n} × {reason}" for reason, n in said)] if said else classes


def times(seconds: dict[str, Spread]) -> list[list[str]]:
    """Return the rows of the table of measured durations: median, 95 % quantile, longest, number of episodes."""
    return [[n, f"{s.median:.1f}", f"{s.most:.1f}", f"{s.longest:.1f}", str(s.count)] for n, s in seconds.items()]


def published_rows(tables: EpisodeTables) -> list[list[str]]:
    """Return the rows of the table that compares published success rates of other systems with cramlite's."""
    return [[p.system, p.given, p.rate, p.ours.text, ", ".join(p.suites), p.source] for p in tables.published]


def grid(head: Sequence[str], rows: Iterable[Sequence[str]]) -> list[str]:
    """Format a table, given its header and rows, as lines of Markdown."""
    lines = [head, ["---"] * len(head), *rows]
    return [f"| {' | '.join(cell.replace('|', '/') for cell in line)} |" for line in lines]


def numbers(tables: EpisodeTables) -> list[Number]:
    """Return the numbers to publish: rates by suite, how often passing verdicts were right, and CPU times."""
    rows = [(r.suite, r) for r in tables.suites] + ([("all", tables.whole)] if len(tables.suites) > 1 else [])
    found = [number for name, row in rows for number in rates(name, _columns(row))]
    if tables.watched:
        found += rates("watched suites, true at rest", {"time stands still": tables.watched.still, "time passes": tables.watched.passing})
    found += rates("a passing verdict was right", {"": tables.passing_was_right})
    return found + [value(stage, s.median, "s", "CPU, median") for stage, s in tables.seconds.items()]


def _columns(row: EpisodeRow) -> dict[str, Rate]:
    return {"proven": row.proven, "true at rest": row.rest, "at rest, unlimited": row.rest_unlimited}


def _counts(row: EpisodeRow, *, short: bool = False) -> list[str]:
    def text(value: Rate) -> str:
        return f"{value.hits} of {value.total}" if short else value.text

    rates = (row.proven, row.first, row.rest, row.first_unlimited, row.rest_unlimited)
    return [*map(text, rates), "" if row.steps is None else f"{row.steps:g}", str(row.advised)]


