"""Remedy of a refusal: what is missing, how much of it, and a change to try."""

from __future__ import annotations

from ..base.value import Value


class Remedy(Value):
    """Remedy of a refusal, which is reported when a search found no program.

    Args:
        about: key of the cause; of refusals with the same key only the one that lacks least is told. "" for a place or motion that is
            asked for: it is named before ``says``, and what differs in numbers only is one cause.
        says: what is missing and what to try, a clause with numbers and units:
            "'tray' is 0.24 m out of reach: move it, or the robot, at least so much nearer".
        missing: how much is missing, in the unit of ``says``; 0 where that is no number.
    """

    about: str
    says: str
    missing: float = 0.0

    def __str__(self) -> str:
        return self.says
