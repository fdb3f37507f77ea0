"""Experiment files about a benchmark: its connection, suites of episodes, classes of failures, published success
rates."""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path

from pydantic import Field, field_validator, model_validator

from ...base.errors import UserError
from ...base.spec import Name, Spec
from ...base.value import Value
from ..experiment_file import ExperimentFile, read_spec


class SuiteSpec(Spec):
    """Suite of tasks, numbered from 0.

    ``budget`` is the number of actions that the published protocol allows in an episode; ``of`` is the suite
    of which this one is a variant. In a ``watched`` suite the benchmark sends poses while the robot moves, and
    the rest of the task is proven anew where the world changes.
    """

    tasks: int = Field(ge=1)
    states: int = Field(ge=1)
    budget: int = Field(ge=1)
    about: str = ""
    of: str = ""
    watched: bool = False


class FailureSpec(Spec):
    """Class of failures: those whose reason matches a pattern; if several classes match, the one that stands
    first in the file is taken."""

    kind: str
    reason: str

    @field_validator("reason")
    @classmethod
    def _pattern(cls, text: str) -> str:
        try:
            re.compile(text)
        except re.error as error:
            raise ValueError(f"'{text}' is no regular expression: {error}") from None
        return text


class PublishedSpec(Spec):
    """Published success rate of another system over some suites, and the input that the system was given."""

    system: str
    given: str
    rate: str
    suites: tuple[str, ...]
    source: str


class BenchmarkSpec(Spec):
    """Keys of an experiment file about a benchmark.

    ``benchmark`` is the Python file that connects to the benchmark, and ``plugins`` are those that its episodes need, both beside the
    experiment's file.
    """

    experiment: Name
    title: str
    benchmark: str
    plugins: tuple[str, ...] = ()
    given: str
    suites: dict[str, SuiteSpec] = Field(min_length=1)
    failures: tuple[FailureSpec, ...] = ()
    published: tuple[PublishedSpec, ...] = ()

    @model_validator(mode="after")
    def _known_suites(self) -> BenchmarkSpec:
        named = {s.of for s in self.suites.values() if s.of}.union(*(p.suites for p in self.published))
        if wrong := sorted(named - set(self.suites)):
            raise ValueError(f"'{wrong[0]}' is no suite of this file; its suites are {', '.join(self.suites)}")
        return self


class Episode(Value):
    """Episode of a suite: a task from one of its initial states."""

    suite: str
    task: int
    state: int

    @property
    def name(self) -> str:
        """Name of the episode's folder."""
        return f"{self.suite}-{self.task}-{self.state}"

    @staticmethod
    def named(name: str) -> Episode:
        """Return the episode whose folder has a given name."""
        suite, task, state = name.rsplit("-", 2)
        return Episode(suite, int(task), int(state))


class BenchmarkExperiment(ExperimentFile):
    """Experiment file about a benchmark, read and checked."""

    spec: BenchmarkSpec

    def suite(self, name: str) -> SuiteSpec:
        """Return the suite with a given name.

        Raises:
            UserError: there is none of the name.
        """
        return self.named("suite", name, self.spec.suites)

    def episodes(self, suite: str, tasks: str, states: str) -> tuple[Episode, ...]:
        """Return the chosen episodes of a suite, sorted by initial state, then by task.

        Args:
            tasks, states: numbers such as "0,2,8:12", which ends with 11; no task stands for all of them.

        Raises:
            UserError: no such suite, task or state; no numbers.
        """
        spec = self.suite(suite)
        whose = f"the suite '{suite}'"
        which = chosen(tasks or f"0:{spec.tasks}", spec.tasks, "tasks", whose)
        return tuple(Episode(suite, task, state) for state in chosen(states, spec.states, "states", whose) for task in which)

    def failure(self, reason: str, otherwise: str) -> str:
        """Return the class of a failure with a given reason; ``otherwise`` if no pattern matches."""
        return next((f.kind for f in self.spec.failures if re.search(f.reason, reason)), otherwise)


def chosen(text: str, count: int, what: str, whose: str) -> list[int]:
    """Return the numbers that a text such as "0,2,8:12" means: 0, 2, 8, 9, 10 and 11.

    Each number stands once, in the order of the text.

    Args:
        count: there are 0 to ``count`` - 1 of them.
        what, whose: said in errors.

    Raises:
        UserError: it is no such text, names nothing, or a number that there is not.
    """
    wrong = f"--{what} is '{text}'"
    try:
        found = list(dict.fromkeys(n for part in text.split(",") for n in _span(part)))
    except ValueError:
        raise UserError(f"{wrong}; write numbers and ranges such as 0,2,8:12, which ends with 11.") from None
    if not found:
        raise UserError(f"{wrong}, which names no number; 0:5 is 0, 1, 2, 3 and 4.")
    beyond = [n for n in found if not 0 <= n < count]
    if beyond:
        raise UserError(f"{wrong}; {whose} has {what} 0 to {count - 1}, and no {beyond[0]}.")
    return found


def _span(part: str) -> Iterable[int]:
    """Return the numbers that a text means: 8 to 11 for the range "8:12", and 8 for "8"."""
    first, colon, end = part.partition(":")
    return range(int(first), int(end) if colon else int(first) + 1)


def read_benchmark(path: Path) -> BenchmarkExperiment:
    """Read an experiment file about a benchmark.

    Raises:
        UserError: not YAML, an unknown key, or a wrong value: with file and line.
    """
    return BenchmarkExperiment(path, read_spec(path, BenchmarkSpec)[0])
