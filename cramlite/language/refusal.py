"""Reasons why a description, or a whole sentence, is not understood."""

from __future__ import annotations

UNREAD, UNKNOWN, FALSE, ABSENT, OPEN = range(5)
"""How far a reading came before it was refused: not through the sentence; words that name nothing; what is not so in the scene; things that
are not where they are to be taken from; what may be several things."""


class Refusal(Exception):
    """Reading that was dropped.

    Args:
        rank: how far it came.
        text: a sentence for people, with candidates and numbers.
    """

    def __init__(self, rank: int, text: str) -> None:
        super().__init__(text)
        self.rank, self.text = rank, text


def listed(names: list[str], joined: str = "or") -> str:
    """Return names as people list them: "a, b or c"."""
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} {joined} {names[-1]}" if names else "none"
