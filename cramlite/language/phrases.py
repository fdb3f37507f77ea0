"""Sets of phrases written as patterns: "(can|could) you [please]" stands for four phrases."""

from __future__ import annotations

from collections.abc import Mapping

Words = tuple[str, ...]
Way = tuple["str | Phrases", ...]
"""Sequence of words and of further alternatives."""


class Phrases:
    """Set of phrases, looked up at a position of a sentence.

    Args:
        pattern: alternatives stand in round brackets with bars between them, what may be missing in square ones; ``$name`` stands
            for the alternatives of ``classes``.

    Raises:
        ValueError: its brackets do not match.
    """

    _lacking: bool

    def __init__(self, pattern: str, classes: Mapping[str, str] | None = None) -> None:
        self._read(_parts(_classed(pattern, classes or {})), 0)

    def _read(self, parts: Words, at: int, inner: bool = False) -> int:
        """Read the alternatives of a pattern up to a closing bracket; return the bracket's position."""
        ways: list[Way] = [()]
        while at < len(parts) and parts[at] not in (")", "]"):
            if parts[at] == "|":
                ways.append(())
            elif parts[at] in ("(", "["):
                within = Phrases.__new__(Phrases)
                opened, at = parts[at], within._read(parts, at + 1, inner=True)
                within._lacking |= opened == "["
                ways[-1] = (*ways[-1], within)
            else:
                ways[-1] = (*ways[-1], parts[at])
            at += 1
        if (at < len(parts)) != inner:
            raise ValueError(f"brackets of the pattern '{' '.join(parts)}' do not match")
        self.vocabulary = frozenset(parts) - {*"()[]|"}
        self._lacking = any(all(isinstance(part, Phrases) and part._lacking for part in way) for way in ways)
        self._ways: dict[str, list[Way]] = {}
        for way in ways:
            for word in _firsts(way):
                self._ways.setdefault(word, []).append(way)
        return at

    @property
    def firsts(self) -> frozenset[str]:
        """Words with which the phrases of this set begin."""
        return frozenset(self._ways)

    def ends(self, words: Words, at: int) -> tuple[int, ...]:
        """Return the end positions of the phrases that begin at a position of a sentence, longest first."""
        found = self._ends(words, at) if words[at : at + 1] and words[at] in self._ways else set()
        return tuple(sorted(found - {at}, reverse=True))

    def _ends(self, words: Words, at: int) -> set[int]:
        found = {at} if self._lacking else set()
        for way in self._ways.get(words[at], ()) if at < len(words) else ():
            ends = {at}
            for part in way:
                if isinstance(part, str):
                    ends = {k + 1 for k in ends if k < len(words) and words[k] == part}
                else:
                    ends = {end for k in ends for end in part._ends(words, k)}
                if not ends:
                    break
            found |= ends
        return found


def _firsts(way: Way) -> set[str]:
    """Return the words with which a sequence may begin."""
    found = set[str]()
    for part in way:
        if isinstance(part, str):
            return found | {part}
        found |= part.firsts
        if not part._lacking:
            break
    return found


def _classed(pattern: str, classes: Mapping[str, str]) -> str:
    """Return a pattern with the alternatives of each class in the place of its name."""
    words = (f"({_classed(classes[word[1:]], classes)})" if word.startswith("$") else word for word in _parts(pattern))
    return " ".join(words)


def _parts(text: str) -> Words:
    for mark in "()[]|":
        text = text.replace(mark, f" {mark} ")
    return tuple(text.split())
