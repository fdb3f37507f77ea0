"""Places that are asked for in vain: once many situations had no answer, what differed between these is not varied any more."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable

from msgspec import Struct, field

from .choice_point import Choice

ENOUGH = 24
"""Questions about one place, each in another situation and all without an answer, from which is concluded that no situation has one.
On 58 shipped kitchens (seed 2) a place that was answered at all was answered at the second question at the latest."""


class Unanswered(Struct):
    """Questions about places that had no answer, over all task sequences for a goal.

    Args:
        asked: place and payload -> how many of its questions had none.
        answered: places and payloads that had an answer once: nothing is concluded about these.
    """

    asked: Counter[str] = field(default_factory=Counter)
    answered: set[str] = field(default_factory=set)

    def is_enough(self, place: str) -> bool:
        """Count one more question, and check whether there were so many that no situation will have an answer."""
        self.asked[place] += 1
        return place not in self.answered and self.asked[place] >= ENOUGH


class InCommon(Struct):
    """Choices that all unanswered questions about a place had in common, in one task sequence.

    Args:
        choices: place and payload -> the choices.
    """

    choices: dict[str, frozenset[Choice]] = field(default_factory=dict)

    def after(self, place: str, made: Iterable[Choice]) -> frozenset[str]:
        """Take over the choices of one more question, and return the names of those that were the same in all."""
        self.choices[place] = self.choices.get(place, frozenset(made)) & frozenset(made)
        return frozenset(name for name, _ in self.choices[place])
