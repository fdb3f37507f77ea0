"""Kinds of motions that plugins declare and resolve."""

from __future__ import annotations

from collections.abc import Mapping

from msgspec import field

from ..base.value import Value
from ..base.word import Word
from .task_type import Parameter


class MotionKind(Value):
    """Kind of motion: a plugin's declaration of a program step and its parameters.

    Args:
        name: ``Motion.kind``.
        step: class of the program step that it becomes.
        ends: where it ends well.
        parameters: what a ``Motion`` may say; the name ends in the unit. A source of "task" means that there is no
            default: whoever asks for the motion says it.
        aborts: reasons in the log; "#" stands for a number.
        widens: standard deviation that it adds to where a held thing is in the hand [m].
        words: parameters that are one of a few words -> the words, each with a sentence.
        other: names of further parameters, such as the corners of a path.
    """

    name: str
    step: str
    ends: str
    parameters: tuple[Parameter, ...] = ()
    aborts: tuple[str, ...] = ()
    widens: float = 0.0
    words: Mapping[str, type[Word]] = field(default_factory=dict)
    other: tuple[str, ...] = ()

    def knows(self) -> tuple[str, ...]:
        """Return the names of all parameters that a motion of this kind may have."""
        return (*(p.name for p in self.parameters), *self.words, *self.other)
