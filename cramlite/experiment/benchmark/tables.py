"""Tables of a benchmark: how often its check agreed with a proof, and how many episodes fulfilled it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from statistics import median, quantiles

from ...base.rate import Rate, newcombe_interval
from ...base.value import Value
from .results import EpisodeResult, in_time, plain_reason
from .spec import BenchmarkExperiment, PublishedSpec

Episodes = Sequence[EpisodeResult]


class EpisodeRow(Value):
    """Row of the tables: counts of the episodes of a suite, of a task, or of all.

    Args:
        suite, task: "" and None for all.
        name: of the task.
        proven: programs that stood the proof.
        first, rest: true at first, and at rest, within the budget.
        first_unlimited, rest_unlimited: the same in unlimited time.
        steps: median of actions until the benchmark's check was true; None where it never was.
        budget: of an episode; None for several suites.
        advised: played programs that a validator which only advises objects to.
    """

    suite: str
    task: int | None
    name: str
    proven: Rate
    first: Rate
    rest: Rate
    first_unlimited: Rate
    rest_unlimited: Rate
    steps: float | None
    budget: int | None
    advised: int


class Spread(Value):
    """Spread of a duration over some episodes [s]: median, 95 % quantile, longest, and number of episodes."""

    median: float
    most: float
    longest: float
    count: int


class PublishedRate(Value):
    """Published success rate of another system, with cramlite's rate over its own episodes of the same suites."""

    system: str
    given: str
    rate: str
    source: str
    suites: tuple[str, ...]
    ours: Rate


class Difference(Value):
    """How the success rate of variant suites differs from that of the suites that they vary.

    An episode succeeds if the benchmark's check became true within the budget and holds at rest.

    Args:
        variants, bases: names of suites of both, of which some episode was played.
        rate, base_rate: of the variants and of the bases.
        value: the first less the second.
        interval: bounds of its 95 % interval (Newcombe).
    """

    variants: tuple[str, ...]
    bases: tuple[str, ...]
    rate: Rate
    base_rate: Rate
    value: float
    interval: tuple[float, float]


class Watched(Value):
    """Success rates of the suites in which the robot watches the world while a program runs.

    An episode succeeds if the benchmark's check is true at rest and within the budget.

    One is with simulated time stopped during the search, the other with the search's CPU time passing.
    """

    still: Rate
    passing: Rate


class EpisodeTables(Value):
    """Tables of an experiment about a benchmark.

    Args:
        passing_was_right: proven programs after which the benchmark's check is true at rest, in unlimited time.
        refusal_was_wrong: refused programs after which it is, of those that were played to find out.
        refusals: episodes without a program, and those of them for which there was a program to play.
        whole, suites, tasks: rows.
        seconds: spreads of CPU time by stage, and of the time until a program was there.
        failures: class -> episodes that are not true at rest within the budget.
        apart: episodes that the benchmark's process broke off by its own end; they count nowhere else.
        refused_for: reason -> how many refusals name it first.
        difference: between variants of suites and those suites; None where not both were played.
        published: of the suites that were played.
        watched: None where no suite was that was played.
    """

    passing_was_right: Rate
    refusal_was_wrong: Rate
    refusals: int
    whole: EpisodeRow
    suites: tuple[EpisodeRow, ...]
    tasks: tuple[EpisodeRow, ...]
    seconds: dict[str, Spread]
    failures: dict[str, int]
    apart: int
    refused_for: dict[str, int]
    difference: Difference | None
    published: tuple[PublishedRate, ...]
    watched: Watched | None = None


def tables(results: Episodes, experiment: BenchmarkExperiment) -> EpisodeTables:
    """Compute the tables of a run's results."""
    apart, results = sum(r.apart for r in results), [r for r in results if not r.apart]
    suites = list(dict.fromkeys(r.suite for r in results))
    tasks = list(dict.fromkeys((r.suite, r.task) for r in results))
    played = [r.refused for r in results if r.refused is not None]
    return EpisodeTables(
        passing_was_right=rate((r for r in results if r.proven), lambda r: r.rest(unlimited=True)),
        refusal_was_wrong=Rate(sum(in_time(a, 0, unlimited=True) and a.rest for a in played), len(played)),
        refusals=sum(not r.proven for r in results),
        whole=row(results),
        suites=tuple(row([r for r in results if r.suite == s], s) for s in suites),
        tasks=tuple(row([r for r in results if (r.suite, r.task) == one], *one) for one in tasks),
        seconds=_seconds(results),
        failures=dict(Counter(r.failure for r in results if r.failure).most_common()),
        apart=apart,
        refused_for=dict(Counter(plain_reason(r.reason) for r in results if not r.proven).most_common()),
        difference=_difference(results, experiment),
        published=tuple(_published_rate(p, results) for p in experiment.spec.published if set(p.suites) & set(suites)),
        watched=_watched([r for r in results if experiment.suite(r.suite).watched]),
    )


def _watched(results: Episodes) -> Watched | None:
    if not results:
        return None
    return Watched(rate(results, lambda r: r.rest()), rate(results, lambda r: r.rest_while_time_passes()))


def rate(episodes: Iterable[EpisodeResult], hit: Callable[[EpisodeResult], bool]) -> Rate:
    """Return the share of the episodes that meet a condition."""
    hits = [hit(r) for r in episodes]
    return Rate(sum(hits), len(hits))


def row(results: Episodes, suite: str = "", task: int | None = None) -> EpisodeRow:
    """Return a row of the tables: rates and counts over the given episodes."""
    steps = [r.attempt.first for r in results if r.attempt is not None and r.attempt.first is not None]
    budgets = {r.budget for r in results}
    return EpisodeRow(
        suite, task, results[0].name if task is not None else "",
        proven=rate(results, lambda r: r.proven),
        first=rate(results, lambda r: r.first()), rest=rate(results, lambda r: r.rest()),
        first_unlimited=rate(results, lambda r: r.first(unlimited=True)), rest_unlimited=rate(results, lambda r: r.rest(unlimited=True)),
        steps=median(steps) if steps else None, budget=budgets.pop() if len(budgets) == 1 else None,
        advised=sum(bool(r.advice) for r in results),
    )  # fmt: skip


def _seconds(results: Episodes) -> dict[str, Spread]:
    """Return statistics of each measured duration over the episodes, by the duration's name."""
    named: dict[str, list[float]] = {}
    for r in results:
        for name, value in r.seconds.items():
            named.setdefault(f"{name} (CPU)", []).append(value)
        named.setdefault("until a program was proven or refused (wall)", []).append(r.wall)
    return {name: _spread(values) for name, values in named.items()}


def _spread(values: list[float]) -> Spread:
    high = quantiles(values, n=20, method="inclusive")[-1] if len(values) > 1 else values[0]
    return Spread(median(values), high, max(values), len(values))


def _difference(results: Episodes, experiment: BenchmarkExperiment) -> Difference | None:
    """Return how the success rate of all variant suites that were played differs from that of the suites that they vary."""
    of = {name: spec.of for name, spec in experiment.spec.suites.items() if spec.of}
    played = {r.suite for r in results}
    variants = tuple(name for name in of if name in played and of[name] in played)
    bases = tuple(dict.fromkeys(of[name] for name in variants))
    if not variants:
        return None
    theirs, ours = (rate((r for r in results if r.suite in some), lambda r: r.rest()) for some in (variants, bases))
    interval = newcombe_interval(theirs.hits, theirs.total, ours.hits, ours.total)
    return Difference(variants, bases, theirs, ours, theirs.rate - ours.rate, interval)


def _published_rate(published: PublishedSpec, results: Episodes) -> PublishedRate:
    own = [r for r in results if r.suite in published.suites]
    suites = tuple(s for s in published.suites if any(r.suite == s for r in own))
    return PublishedRate(published.system, published.given, published.rate, published.source, suites, rate(own, lambda r: r.rest()))
