"""Tables of an experiment: cramlite's columns beside the published ones, and the confusion matrix of the
proof."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import ClassVar

from ...base.rate import Rate, Z
from ...base.value import Value
from .results import CandidateResult, DemonstrationResult, Execution, Program
from .spec import PublishedSpec

STAGES = ("planned", "simulated", "executed")
ALL = "all"
NEAR = 1e-9  # of areas that are one


class Share(Rate):
    """Success rate of cramlite, with the published rate of the same quantity if there is one.

    Args:
        published: the same in the paper; None where there is none.
    """

    TOLD: ClassVar[tuple[str, ...]] = (*Rate.TOLD, "reached")

    published: tuple[int, int] | None = None

    @property
    def reached(self) -> bool:
        """Whether cramlite's success rate is at least the published one; True if none was published."""
        return self.published is None or self.hits * self.published[1] >= self.published[0] * self.total


class ObjectRow(Value):
    """Row of the table: the counts of the demonstrations and candidates of one object, or of all objects
    together.

    Args:
        came_off: demonstrations in which the person brought about what they were to, of all; those that failed count in every column.
        gave: demonstrations that gave candidates, of all.
        candidates, tried: how many there were, and how many of them were planned.
        planned, simulated, executed: candidates, of those tried; executed at the smallest scale of errors.
        harder: executed at the further scales.
        solved, first: demonstrations with a program that succeeded, and whose first-ranked candidate did.
        readings: task sequences before those that contradict themselves were left out.
        peak_force: the largest in a successful execution [N]; 0 if there is none.
        planning: CPU time of planning one candidate, without its simulation [s], the mean; 0 if there is none.
    """

    object: str
    came_off: Share
    gave: Share
    candidates: int
    tried: int
    planned: Share
    simulated: Share
    executed: Share
    harder: tuple[Share, ...]
    solved: Share
    first: Share
    readings: int
    peak_force: float
    planning: float = 0.0


class Confusion(Value):
    """Confusion matrix of the proof against execution in a twin, over all candidates with a program.

    Args:
        scale: of the twin's errors.
        doubted_succeeded, doubted_failed: of the refused ones those that the nominal run let pass, and twins did not.
        confidences: share of the proof's runs that succeeded, and whether the execution did, of each program.
    """

    TOLD: ClassVar[tuple[str, ...]] = ("wrongly_accepted", "wrongly_refused", "area_under_curve", "mcnemar")

    scale: float
    accepted_succeeded: int
    accepted_failed: int
    refused_succeeded: int
    refused_failed: int
    doubted_succeeded: int = 0
    doubted_failed: int = 0
    confidences: tuple[tuple[float, bool], ...] = ()

    @property
    def wrongly_accepted(self) -> Share:
        """Share of the accepted programs that failed in execution."""
        return Share(self.accepted_failed, self.accepted_succeeded + self.accepted_failed)

    @property
    def wrongly_refused(self) -> Share:
        """Share of the refused programs that succeeded in execution."""
        return Share(self.refused_succeeded, self.refused_succeeded + self.refused_failed)

    @property
    def area_under_curve(self) -> tuple[float, float, float] | None:
        """Area under the ROC curve of the confidence as a predictor of success in execution, with the
        bounds of its 95 % interval (``area_under_curve``).

        None where all executions succeeded or all failed, because there is no such curve then.
        """
        return area_under_curve(self.confidences)

    @property
    def mcnemar(self) -> float | None:
        """P value of McNemar's exact test whether twins predict success in execution better than the
        nominal run alone (McNemar, Psychometrika 12, 1947); None if the two never disagree."""
        from scipy.stats import binomtest

        differ = self.doubted_succeeded + self.doubted_failed
        return float(binomtest(self.doubted_failed, differ).pvalue) if differ else None


class ObjectTables(Value):
    """Tables of a run: everything that is reported about it.

    Args:
        rows: an object each, then all together.
        confusions: of the proof, one for each scale of errors in execution.
        reasons: why candidates failed, the most frequent first, with how many.
        lost: demonstrations without a program that succeeded, with why.
        seconds: CPU time by stage.
    """

    rows: tuple[ObjectRow, ...]
    confusions: tuple[Confusion, ...]
    reasons: tuple[tuple[str, int], ...]
    lost: tuple[tuple[str, str], ...]
    seconds: dict[str, float]

    @property
    def whole(self) -> ObjectRow:
        """Row of the table that counts the demonstrations and candidates of all objects together."""
        return self.rows[-1]


def tables(results: Sequence[DemonstrationResult], published: PublishedSpec | None = None) -> ObjectTables:
    """Compute the tables of a run's results."""
    objects = list(dict.fromkeys(r.object for r in results))
    said = _published(published, objects)
    tried = [c for r in results for c in r.results]
    confusions = _confusions(tried)
    rows = [_row(o, [r for r in results if r.object == o], said.get(o, {}), len(confusions)) for o in objects]
    reasons = Counter(_short(c.reason) for c in tried if c.reason)
    return ObjectTables(
        (*rows, _row(ALL, results, said.get(ALL, {}), len(confusions))),
        confusions,
        tuple(sorted(reasons.items(), key=lambda kv: (-kv[1], kv[0]))),
        tuple((r.name, _why(r)) for r in results if not r.solved),
        _seconds(results),
    )


def _published(spec: PublishedSpec | None, objects: Sequence[str]) -> Mapping[str, Mapping[str, tuple[int, int]]]:
    """Return the published success counts by object and table column: (hits, trials)."""
    if spec is None:
        return {}
    found = {}
    for k, name in enumerate(objects[: len(spec.candidates)]):
        found[name] = {"gave": (spec.gave_candidates[k], 10)} | {
            s: (getattr(spec, s)[k], spec.candidates[k]) for s in STAGES
        }
    columns = ("gave", *STAGES)
    found[ALL] = {c: (sum(f[c][0] for f in found.values()), sum(f[c][1] for f in found.values())) for c in columns}
    return found


def _row(name: str, results: Sequence[DemonstrationResult], said: Mapping[str, tuple[int, int]], scales: int) -> ObjectRow:
    tried = [c for r in results for c in r.results]

    def share(test: Callable[[DemonstrationResult], bool], published: tuple[int, int] | None = None) -> Share:
        return Share(sum(test(r) for r in results), len(results), published)

    planned, simulated = (Share(sum(getattr(c, s) for c in tried), len(tried), said.get(s)) for s in STAGES[:2])
    executed = Share(sum(c.succeeded for c in tried), len(tried), said.get("executed"))
    harder = tuple(Share(sum(c.executed[k] for c in tried if c.executed), len(tried)) for k in range(1, scales))
    forces = [a.execution.peak_force for c in tried for a in c.attempts if a.execution and a.execution.succeeded]
    return ObjectRow(
        name, share(lambda r: not r.failure), share(lambda r: r.candidates > 0, said.get("gave")),
        sum(r.candidates for r in results), len(tried),
        planned, simulated, executed, harder, share(lambda r: r.solved), share(lambda r: r.first_solved),
        sum(r.readings for r in results), max(forces, default=0.0),
        sum(c.seconds.get("plan", 0.0) for c in tried) / max(len(tried), 1),
    )  # fmt: skip


def _confusions(tried: Iterable[CandidateResult]) -> tuple[Confusion, ...]:
    ran = [(a, e) for c in tried for a in c.attempts for e in a.executions]
    return tuple(_confusion(k, [(a, e) for a, e in ran if e.scale == k]) for k in sorted({e.scale for _, e in ran}))


def _confusion(scale: float, ran: Sequence[tuple[Program, Execution]]) -> Confusion:
    pairs = Counter((a.passed, e.succeeded) for a, e in ran)
    doubted = Counter(e.succeeded for a, e in ran if a.confidence and not a.passed)
    cells = (pairs[True, True], pairs[True, False], pairs[False, True], pairs[False, False])
    return Confusion(scale, *cells, doubted[True], doubted[False], tuple((a.confidence, e.succeeded) for a, e in ran))


def area_under_curve(cases: Sequence[tuple[float, bool]]) -> tuple[float, float, float] | None:
    """Compute the area under the ROC curve of a score, with the bounds of its 95 % interval.

    Source: Newcombe, Confidence intervals for an effect size measure based on the Mann-Whitney statistic, part 2, Statistics in
    Medicine 25, 2006, method 5: those areas whose standard error (Hanley and McNeil's, with the mean of both numbers) allows the
    observed one. At an observed area of 1 it is no point.

    Args:
        cases: score, and what it should tell, of each.

    Returns:
        The area and its bounds; None where all cases are of one kind.
    """
    from scipy.optimize import brentq
    from scipy.stats import mannwhitneyu

    good, bad = ([score for score, kind in cases if kind is wanted] for wanted in (True, False))
    if not good or not bad:
        return None
    n, m = len(good), len(bad)
    area = float(mannwhitneyu(good, bad).statistic) / (n * m)
    others = (n + m) / 2 - 1

    def beyond(true: float) -> float:
        """Evaluate, for an assumed true area under the ROC curve, a function whose zeros are the bounds of
        the area's confidence interval.

        It is the squared distance of the observed and the assumed area, less Z^2 times the variance that the
        observation would have if the assumed area were true; 0 at the bound.
        """
        variance = true * (1 - true) * (1 + others * (1 - true) / (2 - true) + others * true / (1 + true)) / (n * m)
        return (true - area) ** 2 - Z**2 * variance

    low = float(brentq(beyond, 0.0, area - NEAR)) if area > NEAR else 0.0
    high = float(brentq(beyond, area + NEAR, 1.0)) if area < 1 - NEAR else 1.0
    return area, low, high


def _short(reason: str) -> str:
    """Return a reason without its numbers, so that reasons that differ in numbers only are counted together."""
    import re
    import textwrap

    return textwrap.shorten(re.sub(r"[-+]?\d+(\.\d+)?", "#", reason), 240, placeholder=" ...")


def _why(result: DemonstrationResult) -> str:
    return result.reason or "; ".join(dict.fromkeys(c.reason for c in result.results if c.reason)) or "no candidate"


def _seconds(results: Iterable[DemonstrationResult]) -> dict[str, float]:
    total: Counter[str] = Counter()
    for result in results:
        for seconds in (result.seconds, *(c.seconds for c in result.results)):
            total.update(seconds)
    return {stage: round(total[stage], 1) for stage in sorted(total)}
