"""Sets of phrases written as patterns: "(can|could) you [please]" stands for four phrases."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from itertools import product

Words = tuple[str, ...]
Tree = dict[str, "Tree"]
END = ""
"""Key in a tree below a phrase's last word."""


class Phrases:
    """Set of phrases, looked up at a position of a sentence.

    Args:
        patterns: alternatives stand in round brackets with bars between them, what may be missing in square ones; ``$name`` stands
            for the alternatives of ``classes``.
    """

    def __init__(self, patterns: Iterable[str], classes: Mapping[str, str] | None = None) -> None:
        self._tree: Tree = {}
        for pattern in patterns:
            for phrase in expanded(pattern, classes or {}):
                self._add(phrase)

    def _add(self, phrase: Words) -> None:
        tree = self._tree
        for word in phrase:
            tree = tree.setdefault(word, {})
        tree[END] = {}

    def ends(self, words: Words, at: int) -> tuple[int, ...]:
        """Return the end positions of the phrases that begin at a position of a sentence, longest first."""
        found, tree = list[int](), self._tree
        while at < len(words) and words[at] in tree:
            tree, at = tree[words[at]], at + 1
            found += [at] if END in tree else []
        return tuple(reversed(found))

    @property
    def firsts(self) -> frozenset[str]:
        """Words with which the phrases of this set begin."""
        return frozenset(self._tree)

    @property
    def vocabulary(self) -> frozenset[str]:
        """All words of all phrases in the set."""
        return frozenset(_words(self._tree))


def _words(tree: Tree) -> Iterator[str]:
    for word, below in tree.items():
        yield from (word, *_words(below)) if word else ()


def expanded(pattern: str, classes: Mapping[str, str]) -> tuple[Words, ...]:
    """Expand a pattern to the phrases that it stands for."""
    parts = [p for word in _parts(pattern) for p in (("(", *_parts(classes[word[1:]]), ")") if word.startswith("$") else (word,))]
    if any(p.startswith("$") for p in parts):
        return expanded(" ".join(parts), classes)
    found, end = _alternatives(parts, 0)
    if end != len(parts):
        raise ValueError(f"brackets of the pattern '{pattern}' do not match")
    return tuple(dict.fromkeys(f for f in found if f))


def _parts(text: str) -> tuple[str, ...]:
    for mark in "()[]|":
        text = text.replace(mark, f" {mark} ")
    return tuple(text.split())


def _alternatives(parts: list[str], at: int) -> tuple[list[Words], int]:
    """Return the phrases of a pattern's alternatives up to a closing bracket, and the bracket's position."""
    found: list[Words] = []
    sequence: list[list[Words]] = []
    while at < len(parts) and parts[at] not in (")", "]"):
        if parts[at] == "|":
            found += _chained(sequence)
            sequence = []
        elif parts[at] in ("(", "["):
            inner, end = _alternatives(parts, at + 1)
            sequence.append([*inner, ()] if parts[at] == "[" else inner)
            at = end
        else:
            sequence.append([(parts[at],)])
        at += 1
    return [*found, *_chained(sequence)], at


def _chained(sequence: list[list[Words]]) -> list[Words]:
    return [tuple(w for part in parts for w in part) for parts in product(*sequence)]
