"""Results of an experiment: a value for each attempt, candidate and demonstration, written as JSON and read back."""

from __future__ import annotations

from msgspec import field

from ..base.value import Value


class Execution(Value):
    """Execution of a text in a twin.

    Args:
        succeeded: whether it ran to its end, nothing was hit or overloaded, and the goal holds at the end.
        reason: what the judges said against it; empty if nothing.
        peak_force: at the wrist [N].
        seconds: of simulated time.
        picture: file name of the last sample.
    """

    succeeded: bool
    reason: str
    peak_force: float
    seconds: float
    picture: str = ""


class Attempt(Value):
    """Complete program for a candidate, and how it was judged.

    Args:
        accepted: whether the judges of the believed world let it pass.
        reason: why not.
        execution: in the twin; None where there was no text to execute.
        peak_force: in the believed world [N].
    """

    accepted: bool
    reason: str
    execution: Execution | None = None
    peak_force: float = 0.0


class CandidateResult(Value):
    """Result of one candidate task sequence.

    Args:
        number: its rank, from 1.
        tasks: their names with the demonstration's fillers.
        score: of the ranking.
        planned: whether a complete program with a text came out.
        simulated: whether one was accepted, and reached the goal in the believed world.
        executed: whether that one succeeded in the twin.
        reason: of the failure, with its stage; empty if there is none.
        attempts: programs, in the order of the search.
        seconds: CPU time by stage.
    """

    number: int
    tasks: tuple[str, ...]
    score: float
    planned: bool
    simulated: bool
    executed: bool
    reason: str
    attempts: tuple[Attempt, ...] = ()
    seconds: dict[str, float] = field(default_factory=dict)


class DemonstrationResult(Value):
    """Result of one demonstration.

    Args:
        name, object, seed: which.
        readings: task sequences of the interpretation.
        candidates: those that agree with themselves.
        tried: of them, best first.
        results: of those that were tried.
        reason: why there are none.
        seconds: CPU time of recording and interpreting.
    """

    name: str
    object: str
    seed: int
    readings: int
    candidates: int
    tried: int
    results: tuple[CandidateResult, ...] = ()
    reason: str = ""
    seconds: dict[str, float] = field(default_factory=dict)

    @property
    def solved(self) -> bool:
        """True if some candidate's program succeeded in execution."""
        return any(r.executed for r in self.results)

    @property
    def first_solved(self) -> bool:
        """True if the first-ranked candidate's program succeeded in execution."""
        return bool(self.results) and self.results[0].executed
