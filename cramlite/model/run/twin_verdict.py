"""Verdict of a program's runs in twins: the draws of each, whether it succeeded, and why not."""

from __future__ import annotations

from collections import Counter

from ...base.rate import digits, wilson_interval
from ...base.value import Value
from ..remedy import Remedy
from ..twins.proof_doubts import ProofDoubts
from ..twins.twin_drawing import Draw
from .run_peaks import RunPeaks


class TwinRun(Value):
    """Run of a program in a twin.

    Args:
        number: from 1.
        seed: that the twin was drawn from.
        draws: how the twin differs from the believed world.
        succeeded: no validator objects.
        reason: of the first objection; "" where there is none.
        origin: the task or step that it is about.
        causes: source of error that breaks the program by itself, the first that was found; empty where that was not tried, or where
            no source does.
        looked_for: whether it was tried.
        peaks: of the run; None where it did not begin, and in runs of earlier versions.
        remedy: what to try against the first objection; None where that is not known.
    """

    number: int
    seed: int
    draws: tuple[Draw, ...]
    succeeded: bool
    reason: str = ""
    origin: str = ""
    causes: tuple[str, ...] = ()
    looked_for: bool = False
    peaks: RunPeaks | None = None
    remedy: Remedy | None = None

    def largest(self, count: int = 3) -> str:
        """List the largest random errors of the twin, compared by their shares of the largest possible errors.

        If the causes of a failure are known, only errors of these sources are listed.
        """
        asked = [d for d in self.draws if not self.causes or d.source in self.causes]
        return ", ".join(map(str, sorted(asked, key=lambda d: -abs(d.share))[:count]))

    @property
    def text(self) -> str:
        """Outcome of the run in words: "succeeded", or why it failed, with its largest random errors."""
        if self.succeeded:
            return "succeeded"
        alone = (
            f"; one source of error breaks it alone: {' or '.join(self.causes)}"
            if self.causes
            else "; no source of error breaks it alone" * self.looked_for
        )
        return f"{self.reason}{alone} ({self.largest()})"


class TwinVerdict(Value):
    """Verdict of the nominal run, which succeeded, and of the runs in twins.

    Args:
        doubts: what was asked for.
        twins: runs in twins, in the order in which they were drawn; fewer than asked for, where the others could change nothing.
    """

    doubts: ProofDoubts
    twins: tuple[TwinRun, ...]

    @property
    def ran(self) -> int:
        """Number of a proof's runs, the nominal one included."""
        return 1 + len(self.twins)

    @property
    def succeeded(self) -> int:
        """Number of a proof's runs that succeeded, the nominal one included."""
        return 1 + sum(t.succeeded for t in self.twins)

    @property
    def failed(self) -> tuple[TwinRun, ...]:
        """Runs in twins that failed."""
        return tuple(t for t in self.twins if not t.succeeded)

    @property
    def passed(self) -> bool:
        """Whether as many runs succeeded as the proof requires."""
        return self.succeeded >= self.doubts.needed

    @property
    def interval(self) -> tuple[float, float]:
        """Bounds of the 95 % Wilson interval of the probability of success."""
        return wilson_interval(self.succeeded, self.ran)

    @property
    def weakest(self) -> str:
        """Task or step in which most runs failed; "" where none did."""
        return next((origin for origin, _ in Counter(t.origin for t in self.failed).most_common(1)), "")

    @property
    def text(self) -> str:
        """Number of runs that succeeded, with the interval of the probability of success, in words."""
        low, high = self.interval
        left = self.doubts.runs - self.ran
        spared = f"; {left} not run: the verdict is certain" if left else ""
        return f"{self.succeeded} of {self.ran}, interval {digits(low)} to {digits(high)}{spared}"

    @property
    def reason(self) -> str:
        """Outcome of a proof's runs, as the text of a validator's finding: how many succeeded, the required share,
        and why runs failed."""
        asked = f"{digits(self.doubts.at_least)} of {self.doubts.runs} required"
        why = "; ".join(f"twin {t.number}: {t.text}" for t in self.failed)
        return f"{self.text}; {asked}" + (f"; {why}" if why else "")
