"""Proof under doubt: a program that was accepted in the believed world runs in twins of it, and most of these runs must succeed.

Each twin is drawn around what is believed; the real world of a setting is entered here no more than in the nominal proof. Runs are
judged by the same validators, in the order in which the twins were drawn, until those that are left can change nothing any more; so the
verdict is the same for any number of processes. Where a program is refused, each source of error is tried by itself, with the numbers
of the first twin that failed, so that the reason names what broke it.
"""

from __future__ import annotations

import hashlib
import time
from collections.abc import Callable, Generator, Iterator
from contextlib import closing
from itertools import islice
from typing import TYPE_CHECKING

from msgspec.structs import replace

from ...base.pulse import checkpoint, working
from ...base.seeds import derive_seed
from ...base.value import Value
from ...model.run.run_peaks import RunPeaks, peaks_of
from ...model.run.twin_verdict import TwinRun, TwinVerdict
from ...model.run.verdict import Finding, Verdict
from ...model.twins.error_model import NO_ERRORS, SOURCES, ErrorModel
from ...scenario.twin import Twin, draw_twin
from .executor_group import ExecutorGroup, processes_here
from .proof import judge_run, text_that_runs

if TYPE_CHECKING:
    from ...model.program.program import Code
    from ...model.run.rollout import Rollout
    from ...model.world.world import World
    from ...plugin.catalogue import Knowledge
    from ...plugin.protocols import Candidate
    from ..setting import Setting

FINDING = "twins"
Progress = Callable[[str], None]


class Doubtful(Value):
    """Program that was accepted in the believed world and is to run in twins.

    Args:
        candidate, text: the program, and what of it runs here.
        setting: what is believed, and which doubts it must stand.
    """

    candidate: Candidate
    text: Code
    setting: Setting
    knowledge: Knowledge
    group: ExecutorGroup

    def twin(self, seed: int, errors: ErrorModel) -> Twin:
        """Make a twin of the believed world, with errors drawn at random by the seed."""
        setting = self.setting
        return draw_twin(setting.world, setting.relations, setting.robot, errors, seed, setting.sight)

    def runs(self, places: Iterator[tuple[World, int]]) -> Generator[tuple[Finding | None, RunPeaks | None]]:
        """Run the program in worlds, lazily; yield the first objection to each run, or None, and the peak
        values of the run."""
        with closing(self.group.runs(self.text.text, places)) as runs:
            for rollout in runs:
                yield self._objection(rollout), None if isinstance(rollout, str) else peaks_of(rollout)

    def _objection(self, rollout: Rollout | str) -> Finding | None:
        if isinstance(rollout, str):
            return Finding("execution", False, rollout, stopped=True)
        _, findings = judge_run(self.candidate, self.text, rollout, self.knowledge)
        return next(iter(Verdict(tuple(findings)).objections), None)


def doubt(
    candidate: Candidate, verdict: Verdict, setting: Setting, knowledge: Knowledge, group: ExecutorGroup, progress: Progress,
    seconds: float,
) -> Verdict:  # fmt: skip
    """Return the verdict about a program that was accepted in the believed world, after its runs in twins.

    A program that does not run here is returned as it was judged.

    Args:
        seconds: that its nominal run took, by the wall clock: what is left is told from that.
    """
    text = text_that_runs(candidate, setting.backend)
    if text is None or candidate.rollout is None:
        return verdict
    found = _in_twins(Doubtful(candidate, text, setting, knowledge, group), progress, seconds)
    progress(f"twins: {found.text}")
    finding = Finding(
        FINDING, found.passed, found.reason, value=found.succeeded / found.ran, limit=setting.doubts.at_least,
        origin=found.weakest, remedy=next((t.remedy for t in found.failed if not found.passed), None),
    )
    return replace(verdict, findings=(*verdict.findings, finding), twins=found)


def twin_seed(seed: int, text: str, number: int, family: str = "proof") -> int:
    """Derive the seed of a program's twin.

    Args:
        seed: of the setting.
        text: of the program.
        number: of the twin, from 1.
        family: "proof" for what a search uses; rates that are published come from another one, which no search has seen.
    """
    return derive_seed(seed, ((family, hashlib.blake2b(text.encode(), digest_size=8).hexdigest()),), f"twin {number}")


def _in_twins(doubtful: Doubtful, progress: Progress, seconds: float) -> TwinVerdict:
    doubts = doubtful.setting.doubts
    seeds = [twin_seed(doubtful.setting.seed, doubtful.text.text, k) for k in range(1, doubts.twins + 1)]
    twins: list[Twin] = []
    found = TwinVerdict(doubts, ())
    began = time.monotonic()
    with closing(doubtful.runs(_places(doubtful, seeds, twins))) as runs:
        while not doubts.decided(found.succeeded, found.ran):
            number, done = found.ran, len(found.twins)
            with working(f"twin {number} of {doubts.twins}", ends=over(doubts.twins, done, began, seconds)):
                checkpoint()
                said, peaks = next(runs)
            run = TwinRun(number, seeds[number - 1], twins[number - 1].draws, said is None, peaks=peaks)
            if said is not None:
                run = replace(run, reason=f"{said.validator}: {said.reason}", origin=said.origin, remedy=said.remedy)
            found = replace(found, twins=(*found.twins, run))
            progress(f"twin {number} of {doubts.twins}: {run.reason or 'succeeded'}")
    return found if found.passed else _explained(found, doubtful, progress)


def over(twins: int, done: int, began: float, seconds: float) -> float:
    """Estimate when runs in twins will be over [s of ``time.monotonic``]: each takes as long as those that are done.

    Args:
        began: when the first did.
        seconds: that the nominal run took; as long, in all processes at once, the others are taken to take before one of them is done.
    """
    now = time.monotonic()
    each = (now - began) / done if done else seconds / processes_here()
    return now + each * (twins - done)


def _places(doubtful: Doubtful, seeds: list[int], twins: list[Twin]) -> Iterator[tuple[World, int]]:
    """Yield the world and seed of one twin after another; a twin's errors are drawn only when a process is
    free for it."""
    for seed in seeds:
        twins.append(doubtful.twin(seed, doubtful.setting.doubts.errors))
        yield twins[-1].world, seed


def _explained(found: TwinVerdict, doubtful: Doubtful, progress: Progress) -> TwinVerdict:
    """Return the verdict with the cause of its first failed run: the first source of error that breaks the program
    by itself, of those that break programs most often first."""
    first = found.failed[0]
    looking = f"twin {first.number}: looking for the error that broke it"
    progress(looking)
    errors, seen = doubtful.setting.doubts.errors, doubtful.setting.sight is not None
    none = NO_ERRORS.scaled(errors.scale)
    sources = [s for s in SOURCES if errors.only(s) != none and (seen or s != "hand-eye")]
    worlds = ((doubtful.twin(first.seed, errors.only(s)).world, first.seed) for s in sources)
    with working(looking), closing(doubtful.runs(worlds)) as runs:
        broken = (s for s, (said, _) in zip(sources, runs, strict=True) if said is not None)
        told = replace(first, causes=tuple(islice(broken, 1)), looked_for=True)
    return replace(found, twins=tuple(told if t.number == first.number else t for t in found.twins))
