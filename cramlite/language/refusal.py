"""Refusals: reasons why a noun phrase or a whole sentence is not understood."""

from __future__ import annotations

UNREAD, UNKNOWN, FALSE, ABSENT, OPEN = range(5)
"""Ranks of refused readings, by how far each came: the sentence was not read to its end; words name nothing; the scene is
otherwise than the sentence says; things are not where they are to be taken from; words fit several things."""


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
