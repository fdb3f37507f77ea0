"""Results of a benchmark: one record for each episode, written as JSON and read back."""

from __future__ import annotations

from msgspec import field

from ...base.value import Value
from ...model.run.readings import Notice

BENCHMARK_DIED = "benchmark died"
"""Outcome of an attempt during which the benchmark's process died or hung, and the class of such episodes."""
OLD_NAME = "judge died"
"""``BENCHMARK_DIED`` in results of older versions."""


class Attempt(Value, kw_only=True):
    """Attempt at an episode in the benchmark's simulator.

    Args:
        outcome: how the program ended: "finished", "halted", "protective stop", "timeout", "broken off" where the benchmark refused to go
            on or answered what is no answer, or "benchmark died".
        reason: why, where it did not finish.
        first: the action after which the benchmark's check was true for the first time, from 1; None for never.
        rest: whether it is true when things are at rest after the program's end.
        steps: actions until the program's end.
        ours: where it is not true at rest: whether the goal as cramlite understands it holds in the benchmark's world all the same; None
            where that was not asked or cannot be told.
        picture: name of the file with what the benchmark's camera saw at the end; "" for none.
        believed: name of the file with how the proof ended; "" for none.
        changed: the action after which the benchmark changed its world; None for never.
        avoided: whether what must not be moved was not, until things were at rest; None where nothing must not.
        notices: what was noticed, where the suite is watched.
        thought: CPU time from each notice to the next program [s].
        decisions: why each next program was chosen, in clauses.
        corrections: of poses that were read and cannot be, in clauses.
        waited: actions that would pass while it thought, by that time.
    """

    outcome: str
    reason: str = ""
    first: int | None = None
    rest: bool = False
    steps: int = 0
    ours: bool | None = None
    picture: str = ""
    believed: str = ""
    changed: int | None = None
    avoided: bool | None = None
    notices: tuple[Notice, ...] = ()
    thought: tuple[float, ...] = ()
    decisions: tuple[str, ...] = ()
    corrections: tuple[str, ...] = ()
    waited: int = 0


class EpisodeResult(Value, kw_only=True):
    """Result of an episode: one program, one attempt.

    Args:
        suite, task, state: which episode.
        name: of its task.
        goal: in sentences about things; empty where it has no words here.
        budget: actions of the published protocol.
        proven: whether a program stood the proof.
        reason: why not, where none did; the nearest miss first.
        advice: what validators that only advise object to in the program.
        seconds: CPU time of the search by stage.
        wall: time until the program was proven, or refused [s], on a machine that may do other things, too.
        attempt: in the benchmark's simulator; None where no program was proven.
        refused: the attempt of the best program that was refused, where that was asked for; it counts nowhere else.
        picture: where nothing was played: name of the file with what the benchmark's camera saw; "" for none.
        miss: name of the file with the state that the nearest miss was refused for, where two bodies met in it; "" for none.
        failure: class of the failure; "" for an episode that is true at rest within its budget.
    """

    suite: str
    task: int
    state: int
    name: str
    goal: tuple[str, ...] = ()
    budget: int
    proven: bool = False
    reason: str = ""
    advice: tuple[str, ...] = ()
    seconds: dict[str, float] = field(default_factory=dict)
    wall: float = 0.0
    attempt: Attempt | None = None
    refused: Attempt | None = None
    picture: str = ""
    miss: str = ""
    failure: str = ""

    @property
    def apart(self) -> bool:
        """Whether the episode is left out of all rates, because the benchmark's process died while the robot moved."""
        return self.attempt is not None and self.attempt.outcome in (BENCHMARK_DIED, OLD_NAME)

    def first(self, *, unlimited: bool = False) -> bool:
        """Return whether the benchmark's check was ever true: within the budget, or in unlimited time."""
        return self.attempt is not None and in_time(self.attempt, self.budget, unlimited=unlimited)

    def rest(self, *, unlimited: bool = False) -> bool:
        """Return whether the benchmark's check became true, and was still true when all things were at rest."""
        return self.first(unlimited=unlimited) and self.attempt is not None and self.attempt.rest

    def rest_while_time_passes(self) -> bool:
        """Return whether the benchmark's check came true within the budget, the search's CPU time counted
        as actions, and held at rest."""
        first = self.attempt.first if self.attempt else None
        return self.rest() and first is not None and self.attempt is not None and first + self.attempt.waited <= self.budget


def in_time(attempt: Attempt, budget: int, *, unlimited: bool = False) -> bool:
    """Return whether the benchmark's check was true within the budget, at least once; with ``unlimited``,
    whether it ever was."""
    return attempt.first is not None and (unlimited or attempt.first <= budget)


def plain_reason(reason: str) -> str:
    """Return the text after "Nearest miss: " in a refusal's message; without it, the message's first line."""
    lines = [line.strip() for line in reason.splitlines() if line.strip()]
    miss = next((line for line in lines if line.startswith("Nearest miss: ")), lines[0] if lines else "nothing was said")
    return miss.removeprefix("Nearest miss: ")
