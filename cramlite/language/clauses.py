"""Grammar of requests: imperatives, passives and wishes, in any order of their parts, joined by "and" and "then"."""

from __future__ import annotations

import re
from collections.abc import Iterator
from itertools import islice

from msgspec.structs import replace

from . import english
from .english import Words, starts
from .frames import Frame, Frames
from .nouns import NounParser, spoken
from .tree import Clause, Noun

Found = tuple[Clause, int]
TIME = ("after", "once", "before")
"""Words before a clause that is done earlier or later."""
MOST = 600
"""Readings of one sentence that are looked at."""


class ClauseParser:
    """Parser of one sentence.

    Args:
        words: of the sentence.
        frames: of all goal phrases.
    """

    def __init__(self, words: Words, frames: Frames) -> None:
        self.words, self.frames = words, frames
        self._nouns = NounParser(words, frames.prepositions, frames.states)
        self._parsed: dict[int, tuple[Found, ...]] = {}
        self.farthest = 0

    def readings(self) -> Iterator[tuple[Clause, ...]]:
        """Generate the readings of the whole sentence, the likelier ones first."""
        yield from islice(self._rest(0, ()), MOST)

    def elliptic(self) -> Iterator[tuple[Clause, ...]]:
        """Generate the readings of a sentence without any verb: "all blocks on the tray, the tin in the bowl"."""
        yield from islice(self._without_verbs(0, ()), MOST)

    def _without_verbs(self, at: int, before: tuple[Clause, ...]) -> Iterator[tuple[Clause, ...]]:
        start, _ = self._polite(at)
        if start >= len(self.words) and before:
            yield before
            return
        for clause, end in self._brief(start):
            for behind in self._closed(end):
                yield from self._without_verbs(behind, (*before, clause))

    def _rest(self, at: int, before: tuple[Clause, ...]) -> Iterator[tuple[Clause, ...]]:
        start, later = self._polite(at)
        if start >= len(self.words) and before:
            yield before
            return
        for clause, end in (*self._clauses(start), *self._gapped(start, before), *self._brief(start, toward=True)):
            self.farthest = max(self.farthest, end)
            for behind in self._closed(end):
                yield from self._rest(behind, (*before, replace(clause, later=later)))

    def _polite(self, at: int) -> tuple[int, bool]:
        """Start of a request, and whether it is said to come later."""
        start, later = at, False
        while start < len(self.words):
            found = starts(self.words, start, english.POLITE)
            word = self.words[start]
            if found:
                later = later or bool(english.LATER & set(self.words[start : found[0]]))
                start = found[0]
            elif word in english.STOPS or (word == "and" and at):
                start += 1
            else:
                break
        return start, later

    def _closed(self, at: int) -> tuple[int, ...]:
        """Where the next clause may begin: behind a separator, or at the end."""
        found, ends = [at], []
        while found:
            k = found.pop()
            if k >= len(self.words) or self.words[k] in (*english.STOPS, "and", "then", *TIME):
                ends.append(k)
            found += [e for e in starts(self.words, k, english.CLOSING) if e > k and e not in ends]
        return tuple(dict.fromkeys(sorted(ends, reverse=True)))

    def _clauses(self, at: int) -> tuple[Found, ...]:
        if at not in self._parsed:
            found = (*self._imperative(at), *self._fronted(at), *self._wished(at), *self._after(at), *self._named(at))
            self._parsed[at] = tuple(dict.fromkeys(found))
        return self._parsed[at]

    # Imperatives

    def _imperative(self, at: int) -> Iterator[Found]:
        for frame, verb, particle, end in self.frames.verbs(self.words, at):
            end += self.words[end : end + 1] in (("me",), ("us",))
            for theme, last in self._nouns.nouns(end):
                if not particle:
                    yield from self._complements(frame, verb, theme, last)
                    yield from self._purpose(theme, last)
                elif self.words[last : last + len(particle)] == particle:
                    yield from self._complements(frame, (*verb, *particle), theme, last + len(particle))
            if not particle:
                yield from self._place_first(frame, verb, end)

    def _purpose(self, theme: Noun, at: int) -> Iterator[Found]:
        """Purpose of a move of a theme: "turn the cup so that it is upside down"."""
        if self.words[at : at + 2] in (("so", "that"), ("such", "that")):
            for stands, end in self._nouns.nouns(at + 2):
                for begin in starts(self.words, end, english.BE) if stands.pronoun else ():
                    yield from self._predicates(theme, begin)

    def _named(self, at: int) -> Iterator[Found]:
        """Things that are only named, for the words behind them: "find the cup and ...", "the cup: ..."."""
        for start in (*starts(self.words, at, english.PREPARE), at):
            for noun, end in self._nouns.nouns(start):
                if start != at or self.words[end : end + 1] in ((",",), (":",)):
                    yield Clause("", (), noun), end

    def _complements(self, frame: Frame, verb: Words, theme: Noun, at: int) -> Iterator[Found]:
        """Complements behind a verb and its theme."""
        if frame.amount:
            yield from self._amounts(frame, verb, theme, at)
        elif frame.place:
            for begin in self._between(at):
                yield from self._places(frame, verb, theme, begin)
            for unary in self.frames.unary:
                for begin in starts(self.words, at, unary.stated):
                    yield from ((replace(c, state=unary.phrase), end) for c, end in self._places(frame, verb, theme, begin))
        elif not frame.after:
            yield self._clause(frame, verb, theme), at
        else:
            yield from ((self._clause(frame, (*verb, *a), theme), end) for a in frame.after for end in starts(self.words, at, (a,)))

    def _between(self, at: int) -> tuple[int, ...]:
        """Where a place may begin behind its theme: adverbs, commas and "down", "back" may be between."""
        ends = [at]
        if self.words[at : at + 1] == (",",):
            ends.append(at + 1)
        for k in (at, *starts(self.words, at, english.CLOSING)):
            if k < len(self.words) and self.words[k] in ("down", "back", "up", "so", "over", "right", "directly", "that", ",", "away"):
                ends.append(k + 1)
            ends.append(k)
        return tuple(dict.fromkeys(ends))

    def _places(self, frame: Frame, verb: Words, theme: Noun, at: int) -> Iterator[Found]:
        for start in starts(self.words, at, frame.prepositions):
            for place, end in self._nouns.nouns(start):
                if self.words[at:start] in english.TO and ((place.sides and not place.words) or not (frame.region or verb)):
                    continue  # "to the right of the cup" is beside it
                clause = self._clause(frame, verb, theme, place, "phrase", self.words[at:start])
                yield clause, end
                if frame.beside:
                    yield from ((replace(clause, beside=link), last) for link, last in self._nouns.beside(end))
        yield from self._adverbs(frame, verb, theme, at)
        if not frame.beside:
            return
        for phrase, relation in english.BESIDE.items():
            if self.words[at : at + len(phrase)] == phrase:
                for place, end in self._nouns.nouns(at + len(phrase)):
                    yield self._clause(frame, verb, theme, place, relation, phrase), end
        for start in starts(self.words, at, english.UNDER):
            for place, end in self._nouns.nouns(start):
                yield self._clause(frame, verb, theme, place, "under", self.words[at:start]), end

    def _adverbs(self, frame: Frame, verb: Words, theme: Noun, at: int) -> Iterator[Found]:
        """Adverbs that stand for a place: "put the cup inside", "there", "on top"."""
        for text, word in (("in there", "in"), ("inside", "in"), ("there", ""), ("on top", "on"), ("on there", "on")):
            phrase = tuple(text.split())
            end = at + len(phrase)
            if self.words[at:end] == phrase and (not word or (word,) in frame.prepositions):
                yield self._clause(frame, verb, theme, Noun(spoken(phrase), pronoun="there"), "phrase", phrase[:1]), end

    def _place_first(self, frame: Frame, verb: Words, at: int) -> Iterator[Found]:
        """Imperatives with the place first: "put on the plate the cup"."""
        for start in starts(self.words, at, frame.prepositions):
            for place, end in self._nouns.nouns(start, joined=False):
                for theme, last in self._nouns.nouns(end):
                    yield self._clause(frame, verb, theme, place, "phrase", self.words[at:start]), last

    def _amounts(self, frame: Frame, verb: Words, theme: Noun, at: int) -> Iterator[Found]:
        k = at
        while self.words[k : k + 1] in (("by",), ("about",), ("roughly",), ("approximately",)):
            k += 1
        if k < len(self.words):
            number = re.fullmatch(r"(\d+(?:\.\d+)?)([a-z]*)", self.words[k])
            unit = number[2] if number and number[2] else self.words[k + 1] if k + 1 < len(self.words) else ""
            unit = english.UNITS.get(unit, unit)
            if number and unit:
                yield self._clause(frame, verb, theme, amount=f"{number[1]} {unit}"), k + 1 + (not number[2])

    # Other orders

    def _fronted(self, at: int) -> Iterator[Found]:
        """Place before the verb: "into the basket put the soup", "on the plate goes the cup"."""
        for frame in self.frames.placing:
            for start in starts(self.words, at, frame.prepositions):
                for place, end in self._nouns.nouns(start, joined=False):
                    begin, _ = self._polite(end)
                    yield from self._behind_place(frame, place, self.words[at:start], begin)

    def _behind_place(self, frame: Frame, place: Noun, words: Words, at: int) -> Iterator[Found]:
        for other, verb, particle, end in self.frames.verbs(self.words, at):
            if other == frame and not particle:
                for theme, last in self._nouns.nouns(end):
                    yield self._clause(frame, verb, theme, place, "phrase", words), last
        for end in starts(self.words, at, english.BE):
            yield from ((self._clause(frame, (), theme, place, "phrase", words), last) for theme, last in self._nouns.nouns(end))

    def _gapped(self, at: int, before: tuple[Clause, ...]) -> Iterator[Found]:
        """A clause without its verb, which is that of the one before: "and the sauce in the tray"."""
        if before and before[-1].place is not None:
            yield from self._brief(at)

    def _brief(self, at: int, *, toward: bool = False) -> Iterator[Found]:
        """A clause without a verb, "the tin into the bowl"; ``toward``: with a preposition of a destination alone."""
        for frame in self.frames.placing if at < len(self.words) else ():
            for theme, end in self._nouns.nouns(at) if frame.region else ():
                if not toward or self.words[end : end + 1] in english.TOWARD:
                    yield from self._places(frame, (), theme, end)

    def _wished(self, at: int) -> Iterator[Found]:
        """Wishes and passives: "the drawer should be closed", "I want the cup on the plate"."""
        for start in (*starts(self.words, at, english.WISH), at):
            for theme, end in self._nouns.nouns(start):
                been = starts(self.words, end, english.BE)
                for begin in starts(self.words, end, english.NOT_BE):
                    yield from ((replace(clause, denied=True), last) for clause, last in self._predicates(theme, begin))
                for begin in (*been, *((end,) if start != at else ())):
                    yield from self._predicates(theme, begin)

    def _predicates(self, theme: Noun, at: int) -> Iterator[Found]:
        """Predicate of a theme: "open", "on the plate", "put into the basket"."""
        begins = [at, at + 1] if at < len(self.words) and self.words[at] in english.PLACED else [at]
        for begin in begins:
            if begin == at and self.words[at : at + 1] == ("from",):
                continue  # "get the cup from the hook" takes it off
            for frame in self.frames.placing:
                yield from self._places(frame, (), theme, begin)
        for frame, verb, particle, end in self.frames.participles(self.words, at):
            if not particle:
                yield from self._complements(frame, verb, theme, end)
        for frame in self.frames.unary:
            for end in starts(self.words, at, frame.stated):
                yield self._clause(frame, self.words[at:end], theme), end

    def _after(self, at: int) -> Iterator[Found]:
        """A subordinate clause of time: "after opening the drawer, ...", whose verb is a gerund or a participle."""
        if self.words[at : at + 1] in (("by",), *((w,) for w in TIME)):
            for k in (at + 1, at + 2, at + 3):
                yield from self._imperative(k) if self.words[at + 1 : k] in ((), ("you", "have"), ("having",)) else ()
            yield from self._wished(at + 1)

    def _clause(
        self, frame: Frame, verb: Words, theme: Noun, place: Noun | None = None, relation: str = "phrase", words: Words = (),
        amount: str = "",
    ) -> Clause:  # fmt: skip
        said = spoken(tuple(w for w in (*verb, *(words if place is not None else ())) if w))
        return Clause(said, (frame.phrase,), theme, place, relation, words, amount)

