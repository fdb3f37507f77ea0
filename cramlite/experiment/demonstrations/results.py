"""Results of an experiment: one record for each demonstration, candidate and execution, written as JSON
and read back."""

from __future__ import annotations

from msgspec import field

from ...base.value import Value


class Execution(Value):
    """Execution of a program's text in a twin.

    Args:
        scale: how many times the declared errors the twin was drawn from.
        succeeded: whether it ran to its end, nothing was hit or overloaded, and the goal holds at the end.
        reason: objections of the validators; empty if nothing.
        peak_force: at the wrist [N].
        seconds: of simulated time.
        picture: file name of the last sample.
    """

    scale: float
    succeeded: bool
    reason: str
    peak_force: float
    seconds: float
    picture: str = ""


class Program(Value):
    """Program of a candidate, whether its proof accepted it, and how its executions ended.

    Args:
        accepted: whether the proof let it pass.
        reason: why not.
        executions: one at each scale of the experiment, the smallest first; none where there was no text to execute.
        peak_force: in the believed world [N].
        confidence: share of the proof's runs that succeeded, the nominal one counted; 0 where that failed, or missed the goal.
        reached: whether the experiment's goal was reached in the believed world.
    """

    accepted: bool
    reason: str
    executions: tuple[Execution, ...] = ()
    peak_force: float = 0.0
    confidence: float = 0.0
    reached: bool = True

    @property
    def passed(self) -> bool:
        """True if the proof accepted the program, and its simulation reached the goal."""
        return self.accepted and self.reached

    @property
    def execution(self) -> Execution | None:
        """Execution at the experiment's smallest scale of errors; None where the candidate has no program."""
        return self.executions[0] if self.executions else None


class CandidateResult(Value):
    """Result of one candidate task sequence.

    Args:
        number: its rank, from 1.
        tasks: their names with the demonstration's fillers.
        score: of the ranking.
        planned: whether a complete program with a text came out.
        simulated: whether one was accepted, and reached the goal in the believed world.
        executed: whether the execution of that one succeeded, at each scale; none where there was none.
        reason: of the failure, with its stage; empty if there is none.
        attempts: programs, in the order of the search.
        seconds: CPU time by stage.
    """

    number: int
    tasks: tuple[str, ...]
    score: float
    planned: bool
    simulated: bool
    executed: tuple[bool, ...]
    reason: str
    attempts: tuple[Program, ...] = ()
    seconds: dict[str, float] = field(default_factory=dict)

    @property
    def succeeded(self) -> bool:
        """True if the candidate's program succeeded in the execution at the smallest scale of errors."""
        return bool(self.executed) and self.executed[0]


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
        failure: what the person did not bring about; "" where the demonstration came off. It is kept and counted all the same.
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
    failure: str = ""

    @property
    def solved(self) -> bool:
        """True if some candidate's program succeeded in execution."""
        return any(r.succeeded for r in self.results)

    @property
    def first_solved(self) -> bool:
        """True if the first-ranked candidate's program succeeded in execution."""
        return bool(self.results) and self.results[0].succeeded
