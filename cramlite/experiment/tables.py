"""The tables of an experiment: the paper's columns with intervals, our own, and the confusion matrix of the filter."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence

from ..base.value import Value
from ..base.wilson import wilson_interval
from .results import CandidateResult, DemonstrationResult
from .spec import PublishedSpec

STAGES = ("planned", "simulated", "executed")
ALL = "all"


class Share(Value):
    """Proportion: so many of so many, with the 95 % Wilson score interval (Wilson, JASA 22, 1927).

    Args:
        published: the same in the paper; None where there is none.
    """

    hits: int
    total: int
    published: tuple[int, int] | None = None

    @property
    def rate(self) -> float:
        """Observed rate, 0 to 1; 0 where nothing was tried."""
        return self.hits / self.total if self.total else 0.0

    @property
    def interval(self) -> tuple[float, float]:
        """Wilson score interval of the rate; (0, 1) where nothing was tried."""
        return wilson_interval(self.hits, self.total)

    @property
    def reached(self) -> bool:
        """True if the published rate is reached, or there is none."""
        return self.published is None or self.hits * self.published[1] >= self.published[0] * self.total


class Row(Value):
    """Row of the table: an object, or all of them.

    Args:
        gave: demonstrations that gave candidates, of all.
        candidates, tried: how many there were, and how many of them were planned.
        planned, simulated, executed: candidates, of those tried.
        solved, first: demonstrations with a program that succeeded, and whose first-ranked candidate did.
        readings: task sequences before those that contradict themselves were left out.
        peak_force: the largest in a successful execution [N]; 0 if there is none.
    """

    object: str
    gave: Share
    candidates: int
    tried: int
    planned: Share
    simulated: Share
    executed: Share
    solved: Share
    first: Share
    readings: int
    peak_force: float


class Confusion(Value):
    """Confusion matrix of the filter against execution in the twin, over all programs with a text."""

    accepted_succeeded: int
    accepted_failed: int
    refused_succeeded: int
    refused_failed: int


class Tables(Value):
    """Tables of a run: everything that is reported about it.

    Args:
        rows: an object each, then all together.
        confusion: of the filter.
        reasons: why candidates failed, the most frequent first, with how many.
        lost: demonstrations without a program that succeeded, with why.
        seconds: CPU time by stage.
    """

    rows: tuple[Row, ...]
    confusion: Confusion
    reasons: tuple[tuple[str, int], ...]
    lost: tuple[tuple[str, str], ...]
    seconds: dict[str, float]

    @property
    def whole(self) -> Row:
        """Row of all objects together."""
        return self.rows[-1]


def tables(results: Sequence[DemonstrationResult], published: PublishedSpec | None = None) -> Tables:
    """Compute the tables of a run's results."""
    objects = list(dict.fromkeys(r.object for r in results))
    said = _published(published, objects)
    rows = [_row(o, [r for r in results if r.object == o], said.get(o, {})) for o in objects]
    tried = [c for r in results for c in r.results]
    reasons = Counter(_short(c.reason) for c in tried if c.reason)
    return Tables(
        (*rows, _row(ALL, results, said.get(ALL, {}))),
        _confusion(tried),
        tuple(sorted(reasons.items(), key=lambda kv: (-kv[1], kv[0]))),
        tuple((r.name, _why(r)) for r in results if not r.solved),
        _seconds(results),
    )


def _published(spec: PublishedSpec | None, objects: Sequence[str]) -> Mapping[str, Mapping[str, tuple[int, int]]]:
    """Object -> column -> (hits, of how many)."""
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


def _row(name: str, results: Sequence[DemonstrationResult], said: Mapping[str, tuple[int, int]]) -> Row:
    tried = [c for r in results for c in r.results]

    def share(test: Callable[[DemonstrationResult], bool], published: tuple[int, int] | None = None) -> Share:
        return Share(sum(test(r) for r in results), len(results), published)

    planned, simulated, executed = (Share(sum(getattr(c, s) for c in tried), len(tried), said.get(s)) for s in STAGES)
    forces = [a.execution.peak_force for c in tried for a in c.attempts if a.execution and a.execution.succeeded]
    return Row(
        name, share(lambda r: r.candidates > 0, said.get("gave")), sum(r.candidates for r in results), len(tried),
        planned, simulated, executed, share(lambda r: r.solved), share(lambda r: r.first_solved),
        sum(r.readings for r in results), max(forces, default=0.0),
    )  # fmt: skip


def _confusion(tried: Iterable[CandidateResult]) -> Confusion:
    pairs = Counter((a.accepted, a.execution.succeeded) for c in tried for a in c.attempts if a.execution is not None)
    return Confusion(pairs[True, True], pairs[True, False], pairs[False, True], pairs[False, False])


def _short(reason: str) -> str:
    """A reason without its numbers, so that equal ones are counted together."""
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
