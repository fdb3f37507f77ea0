"""Allowances: the things that a task may touch and move while it runs."""

from __future__ import annotations

from ..base.value import Value

HAND, HELD = "hand", "held"
"""Words in ``TaskType.touches`` besides role names: the hand, and its payload."""


class Allowance(Value):
    """Allowance of one task of a plan, while its code runs: things that it may touch and move.

    What touches already when the task begins may go on touching; what is in the hand and the hand always touch.

    Args:
        touches: pairs of things that may touch; ``HAND`` is the hand, ``HELD`` what it holds.
        moves: things that the task moves without holding them.
        carries_on: whether what is held may touch what it stood or hung on when it was taken, until it was lifted from that.
        slides: whether what is held may be moved along what it touches.
        force: the most that the arm may feel while the task runs, beside what it carries [N]; None for the program's limit.
    """

    touches: frozenset[frozenset[str]] = frozenset()
    moves: frozenset[str] = frozenset()
    carries_on: bool = True
    force: float | None = None
    slides: bool = True
