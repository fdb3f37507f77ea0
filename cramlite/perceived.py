"""What was perceived: answers to a query about a view, what was dropped, who said what, and what it cost."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from msgspec import field

from .expert_plan import Pipeline
from .experts import Judged
from .object_query import ObjectQuery
from .value import Value


class Said(Value):
    """A value and the expert that said it."""

    judged: Judged
    expert: str

    @property
    def value(self) -> Any:
        return self.judged.value


class Percept(Value):
    """An object that was seen.

    Args:
        number: among the objects of the view, from 1.
        values: name -> what was said; the part of the image is under "segment".
        confidence: of the weakest value that the query decides on.
        dropped: why it is no answer; "" for answers.
        missing: values that nobody could say of it, with the reasons.
    """

    number: int
    values: Mapping[str, Said]
    confidence: float = 1.0
    dropped: str = ""
    missing: Mapping[str, str] = field(default_factory=dict)

    def value(self, name: str, default: Any = None) -> Any:
        return self.values[name].value if name in self.values else default

    @property
    def experts(self) -> tuple[str, ...]:
        """Who made it what it is."""
        return tuple(dict.fromkeys(s.expert for s in self.values.values()))


class Run(Value):
    """One expert that ran, or failed: over how many objects, CPU time [ms], and what went wrong."""

    expert: str
    output: str
    count: int
    ms: float
    failures: tuple[str, ...] = ()


class Perceived(Value):
    """The answers to a query, best first, and everything that led to them.

    Args:
        answers: objects that satisfy every condition.
        dropped: the other objects, the nearest misses first.
        scene: values of the whole view.
        runs: in order.
        remarks: what a person should know: ambiguity, partial answers, nothing found.
    """

    query: ObjectQuery
    pipeline: Pipeline
    answers: tuple[Percept, ...]
    dropped: tuple[Percept, ...]
    scene: Mapping[str, Said]
    runs: tuple[Run, ...]
    remarks: tuple[str, ...] = ()

    @property
    def ms(self) -> float:
        """CPU time of all experts [ms]."""
        return sum(r.ms for r in self.runs)
