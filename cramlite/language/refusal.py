"""Refusals: reasons why a noun phrase or a whole sentence is not understood."""

from __future__ import annotations

UNREAD, UNKNOWN, FALSE, ABSENT, OPEN = range(5)
"""Ranks of refused readings, higher for a reading that came farther: not read to its end, with unknown words, in conflict with the scene
or itself, with a false assumption on where things are, ambiguous."""


class Refusal(Exception):
    """Refusal of one way to understand a sentence.

    Args:
        rank: how far it came.
        text: a sentence for people, with candidates and numbers.
    """

    def __init__(self, rank: int, text: str) -> None:
        super().__init__(text)
        self.rank, self.text = rank, text


def listed(names: list[str], joined: str = "or") -> str:
    """Join names to a list in words: "a, b or c"."""
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} {joined} {names[-1]}" if names else "none"
