"""Rules of the corpus: an edit of a proven program, and an oracle that judges the tracks of its run."""

from __future__ import annotations

from collections.abc import Callable
from random import Random

from cramlite.base.value import Value
from cramlite.model import Rollout

from .bases import Base, Ready


class Seen(Value):
    """What an oracle looks at.

    Args:
        ready: the base, with the run of its text as it is.
        run: of the edited text.
    """

    ready: Ready
    run: Rollout

    @property
    def base(self) -> Base:
        """The kind of program."""
        return self.ready.base


Edit = Callable[[Ready, Random], str]
Oracle = Callable[[Seen], str]


class Rule(Value):
    """Kind of edit.

    Args:
        name: unique.
        group: class of the audit, "A" to "E", "N" for new ones, "H" for harmless edits.
        says: what is done, a clause.
        asks: what a base must be, any of these words.
        edit: the text of an edited program, with numbers drawn from a generator.
        oracle: of a corruption: the harm in a clause, "" for none; of a harmless edit: what went wrong, "" for nothing.
        about: an honest refusal says one of these, or the name of what the base is about or of what stands beside.
        times: how many programs it makes of each base.
        sealed: whether it is judged but once, at the end.
    """

    name: str
    group: str
    says: str
    asks: frozenset[str]
    edit: Edit
    oracle: Oracle
    about: tuple[str, ...] = ()
    times: int = 2
    sealed: bool = False

    def takes(self, base: Base) -> bool:
        """Whether the rule applies to a base."""
        return bool(self.asks & base.is_a)


def rule(
    name: str, group: str, says: str, asks: str, edit: Edit, oracle: Oracle, about: str = "", times: int = 2
) -> Rule:
    """Write a rule down; ``asks`` and ``about`` are words with spaces between."""
    return Rule(name, group, says, frozenset(asks.split()), edit, oracle, tuple(about.split()), times)
