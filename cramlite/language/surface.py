"""Normalisation of sentences before parsing: fillers, self-corrections, numbers and other variants become words of the grammar."""

from __future__ import annotations

import re
from collections.abc import Callable

from . import english
from .english import STOPS, Words, starts

RETRACT = "<no>"
"""Marker word between a withdrawn request and the request that replaces it."""
Ends = Callable[[Words, int], tuple[int, ...]]
"""Function that returns the possible end positions of a phrase that begins at a given position of a sentence."""


class Surface:
    """Normaliser of English sentences about one scene: it leaves out filler words and carries out self-corrections.

    Args:
        names: single words that are names of things, which mean nothing else.
        kinds: nouns of things that carry a number: "can" of "can 4".
        verb, preposition: where one that stands at a position ends.
    """

    def __init__(self, names: frozenset[str], kinds: frozenset[str], verb: Ends, preposition: Ends) -> None:
        self._names, self._kinds, self._verb, self._preposition = names, kinds, verb, preposition

    def variants(self, words: Words) -> tuple[Words, ...]:
        """Return the normalised readings of a sentence; several if it is unclear which words a
        self-correction replaces."""
        return tuple(dict.fromkeys(self._plain(v) for v in self._repaired(words)))

    def _plain(self, words: Words) -> Words:
        return _stopped(self._numbered(_sided(self._without_fillers(_without_prelude(_without_exclamations(_without_titles(words)))))))

    def _without_fillers(self, words: Words) -> Words:
        left, k = list[str](), 0
        while k < len(words):
            ends = starts(words, k, english.FILLERS) if words[k] not in self._names else ()
            adverb = words[k] in english.EMPHASIS and words[k - 1 : k] not in (("the",), ("far",), ("to",), ("your",), ("my",))
            emphasis = adverb and k + 1 < len(words) and bool(self._preposition(words, k + 1)) and words[k] not in self._names
            left += [] if ends or emphasis else [words[k]]
            k = ends[0] if ends else k + 1
        return tuple(left)

    # Numbers

    def _numbered(self, words: Words) -> Words:
        """Repeat a noun for each number: "cans one and two" becomes "can 1 and can 2"."""
        words, left, k, last = self._listed(words), list[str](), 0, ""
        while k < len(words):
            noun, found, end = english.singular(words[k]), list[str](), k + 1
            last = noun if noun in self._kinds else last
            bare = [e for e in starts(words, k, english.NUMBER) if words[k] != "no" and words[e : e + 1] and _digits(words[e])]
            if bare and last:  # "the tins except number 3"
                left, k = [*left, last, _digits(words[bare[0]])], bare[0] + 1
                continue
            while noun in self._kinds and words[k] not in ("a", "one"):
                start = next(iter((*starts(words, end, english.NUMBER), end)))
                joined = start + (1 if found and words[start : start + 1] in ((",",), ("and",)) else 0)
                joined += 1 if found and words[joined : joined + 1] == ("and",) and joined > start else 0
                start = next(iter((*starts(words, joined, english.NUMBER), joined)))
                number = _digits(words[start]) if start < len(words) else ""
                noun_next = words[start + 1 : start + 2]
                if not number or (found and (joined == end or (noun_next and self._is_noun(noun_next[0])))):
                    break
                found, end = [*found, number], start + 1
            named = [w for n in found for w in (noun, n, ",")][:-1]
            if len(found) > 1:
                named[-3] = "and"
            left += named or [words[k]]
            k = end if found else k + 1
        return tuple(left)

    def _listed(self, words: Words) -> Words:
        """Write a range of numbers as a list: "tins 1 to 3" as "tins 1, 2 and 3"."""
        for k in range(1, len(words) - 2):
            first, last = _digits(words[k]), _digits(words[k + 2])
            if words[k + 1] in english.UP_TO and english.singular(words[k - 1]) in self._kinds and first.isdigit() and last.isdigit():
                between = [w for n in range(int(first), int(last)) for w in (str(n), ",")][:-1]
                return (*words[:k], *between, "and", last, *words[k + 3 :])
        return words

    def _is_noun(self, word: str) -> bool:
        return english.singular(word) in self._kinds or (english.plural(word) and word not in english.PLACED)

    # Corrections

    def _repaired(self, words: Words) -> tuple[Words, ...]:
        """Return the sentences that a self-correction may leave: "on the tray, no, in the basket" becomes "in
        the basket"."""
        for at in range(len(words)):
            if at == 0 or words[at - 1] in STOPS or words[at] in ("oops", "whoops", "scratch"):
                end = self._marked(words, at)
                if end > at:
                    end, denied = self._dismissed(words, end)
                    before, after = _bare(words[:at]), words[end:]
                    if not before or not _bare(after):
                        return self._repaired(before or after)
                    return tuple(dict.fromkeys(r for v in self._corrected(before, after, denied) for r in self._repaired(v)))
        return (words,)

    def _marked(self, words: Words, at: int) -> int:
        """Return the word index after a phrase that announces a self-correction, such as "no" or "I mean"."""
        end, strong = at, False
        while end < len(words):
            ends = starts(words, end, english.REPAIRS)
            if not ends and not (words[end] in STOPS and end > at):
                break
            strong = strong or bool(ends and words[end:ends[0]] != ("no",))
            end = ends[0] if ends else end + 1
        begins = {*words[end : end + 1]} & english.THE or self._preposition(words, end) or starts(words, end, english.DISMISSED)
        alone = words[at:end] == ("no",) and not begins
        return at if alone or words[end : end + 1] == ("than",) or not (strong or end > at) else end

    def _dismissed(self, words: Words, at: int) -> tuple[int, Words]:
        """Return the index of the word after a noun phrase that is taken back, and that phrase: "no, not the can, the tin"."""
        for start in starts(words, at, english.DISMISSED):
            if words[(end := self._ended(words, start)) : end + 1] == (",",):
                return self._marked(words, end + 1), words[start:end]
        return at, ()

    def _corrected(self, before: Words, after: Words, denied: Words) -> tuple[Words, ...]:
        if self._preposition(after, 0):
            at = [k for k in range(1, len(before)) if self._preposition(before, k)]
            return ((*before[: at[-1]], *after),) if at else ((*before, *after),)
        if self._verb(after, 0) or any(self._verb(after, e) for e in starts(after, 0, english.POLITE)):
            return ((*before, RETRACT, *after),)
        counted = [k for k, w in enumerate(before) if _amount(w)]
        if _amount(after[0]) and counted:
            return ((*before[: counted[-1]], *after[:1], *(after[1:] if _bare(after[1:]) else before[counted[-1] + 1 :])),)
        end = self._ended(after, 0)
        nouns = [(k, self._ended(before, k)) for k in self._begun(before)]
        alike = [(k, last) for k, last in nouns if _alike(before[k:last], denied or after[:end])]
        goes_on = bool(self._preposition(after, end))
        chosen = alike or (nouns[-1:] if goes_on else nouns)
        rests = [() if goes_on and before[last:] else before[last:] for _, last in chosen]
        found = tuple((*before[:k], *after[:end], *rest, *after[end:]) for (k, _), rest in zip(chosen, rests, strict=True))
        return found or ((*before, RETRACT, *after),)

    def _begun(self, words: Words) -> list[int]:
        """Return the indices of the words with which noun phrases begin."""
        behind = {e for k in range(len(words)) for e in (*self._verb(words, k)[:1], *self._preposition(words, k)[:1])}
        every = {k for k, w in enumerate(words) if w in english.THE or k in behind}
        return sorted(k for k in every if k < len(words) and not (k - 1 in every and words[k - 1] in english.THE))

    def _ended(self, words: Words, at: int) -> int:
        """Return the index of the word after a plain noun phrase that begins at word ``at``."""
        k = at + 1
        while k < len(words) and words[k] not in STOPS and words[k] != "and" and not self._preposition(words, k):
            k += 1
        return k


def _alike(one: Words, other: Words) -> bool:
    """Check whether two noun phrases share their noun, or use the same kind of word, such as two colours."""
    kinds = (english.ORDINALS, english.SIDES, english.SIZES, english.HUES)
    shared = any({*one} & {*kind} and {*other} & {*kind} for kind in kinds)
    nouns = {english.singular(w) for w in one} & {english.singular(w) for w in other} - english.THE - english.ONE
    return shared or bool(nouns)


def _digits(word: str) -> str:
    """Return a number word as digits; "" for another word."""
    return word if word.isdigit() else str(english.NUMBERS.get(word, "1" if word == "one" else ""))


def _amount(word: str) -> bool:
    """Check whether a word is a number: one that begins with a digit, or a number word of the table
    ``TENS``."""
    return word in english.TENS or word[0].isdigit()


def _bare(words: Words) -> Words:
    """Remove the separators, such as a comma, at the end of a sequence of words."""
    while words and words[-1] in STOPS:
        words = words[:-1]
    return words


def _sided(words: Words) -> Words:
    """Replace variants by words of the grammar: "to its left" by "to the left of it", "a couple of" by
    "two"."""
    said = " ".join(words)
    said = re.sub(r"\b(?:to|on|at|by|onto) (?:its|their|his|her) (left|right)(?: hand)?(?: side)?\b", r"to the \1 of it", said)
    said = re.sub(r"\b((?:a single|any) \w+) left(?= (?:in|on|over)\b)", r"\1", said)
    said = re.sub(r"\ba (?:couple|pair)(?: of)?\b", "two", said)
    said = re.sub(r"\bthere (should|must|shall) not be any\b", r"there \1 be no", said)
    said = re.sub(r"\b(?:can|could|may) (?:i|we) (?:have|get)\b", "give me", said)
    said = re.sub(r"\b((?:the|my|your|this|that) \w+) 's contents?\b", r"the contents of \1", said)
    said = re.sub(r"\bat least (?=a |one |two |three |four |five |\d)", "", said)
    said = re.sub(r"\bthe near (?=ones?\b)", "the nearer ", said)
    said = re.sub(r"\bthe rest of (?:the|my|these|those)\b", "the other", said)
    ends = "on|in|into|inside|onto|to|should|must|shall|goes|go|belong|[,.;]"
    return tuple(re.sub(rf"\bthe rest(?: of them)?(?= (?:{ends})|$)", "the other ones", said).split())


def _without_prelude(words: Words) -> Words:
    """Return the words after an announcement: "the red block on the blue one" of "a tower, please: the red
    block on the blue one"."""
    if ":" in words:
        k = words.index(":")
        if {*words[:k]} <= english.PRELUDE | STOPS | english.FILLERS.vocabulary:
            return words[k + 1 :]
    return words


def _stopped(words: Words) -> Words:
    """Reduce several punctuation marks in a row, which are left where filler words were removed, to one."""
    found: list[str] = []
    for word in words:
        unsaid = word == "," and found[-1:] and found[-1] in ("the", "a", "an", "my", "on", "in", "into", "onto", "to")
        if word in STOPS and (not found or found[-1] in STOPS or unsaid):
            continue
        found.append(word)
    return tuple(found)


def _without_exclamations(words: Words) -> Words:
    """Return the words without exclamations and comments between commas: "my late husband, God rest him, never left"."""
    left, k = list[str](), 0
    while k < len(words):
        apart = not left or left[-1] in STOPS
        end = next((e for e in starts(words, k, english.EXCLAIMED) if words[e : e + 1] == () or words[e] in STOPS), k) if apart else k
        follows = words[end + 1 : end + 2]
        finite = bool(follows) and follows[0] in english.AUXILIARY | english.PAST | english.NARRATED | {"never", "always"}
        if end > k and finite and words[end] == "," and left[-1:] == [","]:
            left.pop()
            k = end + 1
        elif end > k:
            k = end
        else:
            left.append(words[k])
            k += 1
    return tuple(left)


def _without_titles(words: Words) -> Words:
    """Return the words without the numbers of a list: "one, open the drawer; two, ...", "job one: ..."."""
    titles = list[tuple[int, int]]()
    for k in range(len(words)):
        at = k + (words[k] in english.TITLES)
        number = _digits(words[at]) if at < len(words) else ""
        begins = k == 0 or words[k - 1] in STOPS - {","}
        if begins and number == str(len(titles) + 1) and words[at + 1 : at + 2] in ((",",), (":",)):
            titles.append((k, at + 2))
    left = (w for k, w in enumerate(words) if not any(start <= k < end for start, end in titles))
    return tuple(left) if len(titles) > 1 else words
