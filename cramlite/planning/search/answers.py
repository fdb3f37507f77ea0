"""Cache of the answers of plugins: no plugin is asked the same question twice in the searches for one goal.

What an answer depends on is what its plugin looked at: the designator, the belief, and those bindings and that agenda which it
read ("verifying traces" of Mokhov et al. 2018, "Build systems a la carte"). Another seed alone makes no other question.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import Any, overload

from msgspec import Struct, field
from msgspec.structs import replace

from ...base.errors import Unresolvable
from ...model.belief import Belief, Estimate
from ...model.designators import Designator, Location, Place
from ...plugin.grounding import Context, Refused

NOTHING = object()
"""Sentinel for the value of an unbound name, and for the end of a plugin's answers."""

ROUNDING = 1e-6
"""Distance and angle below which two poses count as equal [m, rad]: programs are written with as many digits."""

Streams = Iterable[tuple[str, Iterable[Any] | Unresolvable]]
"""Names of the plugins that answer a question, each with its answers or with the exception that refuses the question."""


class Read(Mapping[str, Any]):
    """Mapping of bindings (names of earlier choices, each with the chosen alternative) that records which of them a plugin reads.

    Args:
        now: the bindings.
    """

    def __init__(self, now: Mapping[str, Any]) -> None:
        self.now = now
        self.values_read: dict[str, Any] = {}
        self.names_read: tuple[str, ...] | None = None

    def __getitem__(self, name: str) -> Any:
        found = self.values_read[name] = self.now.get(name, NOTHING)
        if found is NOTHING:
            raise KeyError(name)
        return found

    def __iter__(self) -> Iterator[str]:
        self.names_read = tuple(self.now)
        return iter(self.now)

    def __len__(self) -> int:
        self.names_read = tuple(self.now)
        return len(self.now)

    def suits(self, other: Mapping[str, Any]) -> bool:
        """Check whether every name that a plugin read has the same value in other bindings."""
        same = all(_same(other.get(name, NOTHING), value) for name, value in self.values_read.items())
        return same and self.names_read in (None, tuple(other))


class ReadAhead(Sequence[Designator]):
    """Agenda (designators that are still open) for a plugin; it records whether the plugin reads it."""

    def __init__(self, now: Sequence[Designator]) -> None:
        self.now, self.read = now, False

    @overload
    def __getitem__(self, index: int) -> Designator: ...
    @overload
    def __getitem__(self, index: slice) -> Sequence[Designator]: ...
    def __getitem__(self, index: int | slice) -> Designator | Sequence[Designator]:
        self.read = True
        return self.now[index]

    def __len__(self) -> int:
        self.read = True
        return len(self.now)


class Kept(Struct):
    """Answers of one plugin to one question: those given so far, and the source of those that the
    search has not asked for yet.

    Args:
        source: gives the others.
        answers: so far.
        impossible: how they ended, if so.
    """

    source: Iterator[Any]
    answers: list[Any] = field(default_factory=list)
    impossible: Unresolvable | None = None
    ended: bool = False

    def at(self, number: int) -> Any:
        """Return the plugin's answer with a given index, from 0; ``NOTHING`` after the last answer.

        Raises:
            Unresolvable: the plugin says so behind the last.
        """
        while len(self.answers) <= number and not self.ended:
            try:
                self.answers.append(next(self.source))
            except StopIteration:
                self.ended = True
            except Unresolvable as impossible:
                self.ended, self.impossible = True, impossible
        if number < len(self.answers):
            return self.answers[number]
        if self.impossible is not None:
            raise self.impossible
        return NOTHING


class Question(Struct):
    """Question to the plugins about a designator, with all inputs on which their answers depend.

    Args:
        item, belief: that it is about.
        read, ahead: what was looked at.
        kept: plugin -> its answers, in the order in which plugins were asked.
    """

    item: Designator
    belief: Belief
    read: Read
    ahead: ReadAhead
    kept: dict[str, Kept] = field(default_factory=dict)

    def suits(self, item: Designator, belief: Belief, context: Context) -> bool:
        """Check whether the answers that plugins gave earlier also hold for a new question, since its inputs
        are the same."""
        same = self.item == item and same_belief(self.belief, belief) and self.read.suits(context.bindings)
        return same and (not self.ahead.read or tuple(self.ahead.now) == tuple(context.agenda))

    @property
    def refused_anywhere(self) -> bool:
        """Whether the location stays refused wherever the arm is: every refusal of it blames things that are
        in the way."""
        return isinstance(self.item, Location) and bool(self.item.of) and all(k.ended and self._about_things(k) for k in self.kept.values())

    def _about_things(self, kept: Kept) -> bool:
        end = kept.impossible
        named = [self.read.now.get(name) for name in end.because] if end else []
        told = end is None or (named and not end.earlier_tasks and not any(isinstance(v, Place) for v in named))
        return bool(told and kept.answers) and all(isinstance(a, Refused) and a.blocking is not None for a in kept.answers)


class Answers(Struct):
    """Questions that plugins have answered in the searches for one goal, kept so that none is asked twice.

    Args:
        known: name of a designator, where the arm is, and what is held -> the questions then.
        asked: how many were asked of plugins.
    """

    known: dict[tuple[object, ...], list[Question]] = field(default_factory=dict)
    asked: int = 0

    def of(
        self, item: Designator, belief: Belief, context: Context, ask: Callable[[Context], Streams]
    ) -> tuple[bool, list[tuple[str, Iterator[Any]]]]:
        """Return whether a question was answered before, and the answers of each plugin, lazily; they may raise ``Unresolvable``.

        Args:
            ask: asks the plugins.
        """
        asked_before = self.asked
        found = self._question(item, belief, context, ask)
        told = [(plugin, self._told(found, plugin, context, ask)) for plugin in found.kept]
        return self.asked == asked_before, told

    def _question(self, item: Designator, belief: Belief, context: Context, ask: Callable[[Context], Streams]) -> Question:
        """Return the earlier question with the same inputs, else a new one that the plugins are asked."""
        key = (item.name, belief.joints, belief.held.thing if belief.held else "")
        here = self.known.setdefault(key, [])
        found = next((q for q in here if q.suits(item, belief, context)), None)
        found = found or self._refused_before(item, belief, context)
        if found is not None:
            return found
        self.asked += 1
        new = Question(item, belief, Read(context.bindings), ReadAhead(context.agenda))
        watched = replace(context, bindings=new.read, agenda=new.ahead)
        for plugin, answers in ask(watched):
            new.kept[plugin] = Kept(_raising(answers) if isinstance(answers, Unresolvable) else iter(answers))
        here.append(new)
        return new

    def _refused_before(self, item: Designator, belief: Belief, context: Context) -> Question | None:
        """Return an earlier question to the plugins that was refused for every position of the arm, and is otherwise the same.

        None without one.
        """
        others = (q for (name, *_), asked in self.known.items() if name == item.name for q in asked)
        return next((q for q in others if q.refused_anywhere and q.suits(item, _as_near(belief, q.belief), context)), None)

    def _told(self, question: Question, plugin: str, context: Context, ask: Callable[[Context], Streams]) -> Iterator[Any]:
        """Yield the answers of a plugin one by one; each is computed when it is asked for, with the bindings
        of that moment."""
        number = 0
        while True:
            if not question.suits(question.item, question.belief, context):
                question = self._question(question.item, question.belief, context, ask)
            question.read.now, question.ahead.now = context.bindings, context.agenda
            if plugin not in question.kept or (answer := question.kept[plugin].at(number)) is NOTHING:
                return
            yield answer
            number += 1


def same_belief(one: Belief, other: Belief) -> bool:
    """Check whether two beliefs are equal; parts that are the same object in both are equal without a comparison."""
    return one is other or all(_same(getattr(one, name), getattr(other, name)) for name in one.__struct_fields__)


def _as_near(belief: Belief, other: Belief) -> Belief:
    """Return ``belief`` with the arm position of ``other``, and with each pose of ``other`` from which it
    differs by rounding only."""
    poses = {
        name: other.poses[name] if name in other.poses and _near(estimate, other.poses[name]) else estimate
        for name, estimate in belief.poses.items()
    }
    return replace(belief, joints=other.joints, poses=poses)


def _near(one: Estimate, other: Estimate) -> bool:
    return one is other or (replace(one, pose=other.pose) == other and max(one.pose.distance(other.pose)) < ROUNDING)


def _same(one: Any, other: Any) -> bool:
    return one is other or bool(one == other)


def _raising(impossible: Unresolvable) -> Iterator[Any]:
    raise impossible
    yield
