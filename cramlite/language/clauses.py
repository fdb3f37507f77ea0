"""Grammar of sentences: requests, wishes, conditions and statements, joined by "and" and "then", with their parts in any order."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice

from msgspec.structs import replace

from . import english
from .english import Words, starts
from .frames import Frames
from .requests import AIMS, Found, RequestParser
from .surface import RETRACT
from .tree import Clause, Link, Noun

Clauses = tuple[Clause, ...]
TIME = ("after", "once", "before", "when", "having")
"""Words that introduce a clause about an earlier or later action, such as "after" and "before"."""
FURTHER = (
    *("and", "or", "but", "then", "so", "such", "until", "till", "if", "while", "with", "leaving", "keeping", "making", "ensuring", "by"),
    *("unless", "provided", "providing", "only", RETRACT),
)
"""Words that introduce a further clause, such as "and" and "unless"."""
MOST = 600
"""Largest number of readings of one sentence that are examined."""


class ClauseParser(RequestParser):
    """Parser of one English sentence to clauses, which are requests or statements about things.

    Args:
        words: of the sentence.
        frames: of all goal phrases.
        names: words that are names of things, whatever else they may mean.
    """

    def __init__(self, words: Words, frames: Frames, names: frozenset[str] = frozenset()) -> None:
        super().__init__(words, frames, names)
        self._parsed: dict[int, tuple[Found, ...]] = {}
        self._dropped: set[Clauses] = set()
        self.farthest = 0

    def readings(self, *, brief: bool = False) -> Iterator[Clauses]:
        """Yield the ways to split the whole sentence into requests and statements, the more likely ones first.

        Args:
            brief: whether verbs may be missing everywhere: "all blocks on the tray, the drawer shut".
        """
        self._seen: set[tuple[int, Clauses]] = set()
        yield from islice(self._rest(0, (), brief), MOST)

    def drop(self, clauses: Clauses) -> None:
        """Exclude all ways to read the sentence that begin with certain clauses, because these make no sense
        in the scene."""
        self._dropped.add(clauses)

    def _rest(self, at: int, before: Clauses, brief: bool) -> Iterator[Clauses]:
        start, later = self._polite(at)
        if (start, before) in self._seen:
            return
        self._seen.add((start, before))
        if start >= len(self.words) and before:
            yield before
            return
        if self.words[start : start + 1] == (RETRACT,):
            yield from self._rest(start + 1, (*before[:-1], *(Clause("", (), c.theme, told=True) for c in before[-1:])), brief)
        plain = self._separated(at)
        asked = self._clauses(plain) if plain != start else ()
        meant = [e for k in dict.fromkeys((start, plain)) for e in self._contrasted(k)]
        meant = [e + 1 for e in meant if self.words[e : e + 1] == (",",)]  # "not the tin, the can ..."
        asked = (*asked, *(c for e in dict.fromkeys(meant) for c in (*self._clauses(e), *(self._stated(e) if brief else ()))))
        further = self._stated(start) if brief else self._brief(start, toward=True)
        found = dict.fromkeys((*self._clauses(start), *asked, *self._remnants(at, start, before, later=later), *further))
        for clause, end in (f for f in found if self._known_clause(f[0])):
            self.farthest = max(self.farthest, end)
            clauses = (*before, replace(clause, later=later))
            for behind in self._closed(end):
                if any(clauses[:k] in self._dropped for k in range(1, len(clauses) + 1)):
                    break
                yield from self._rest(behind, clauses, brief)
            yield from (r for aside, last in self._left_out(end) for r in self._rest(last, (*clauses, aside), brief))
        yield from (r for clauses, last in self._amended(start, before) for r in self._rest(last, clauses, brief))
        for k in dict.fromkeys((start, at)):
            yield from (r for aside, last in self._left_out(k) for r in self._rest(last, (*before, aside), brief))

    def _amended(self, at: int, before: Clauses) -> Iterator[tuple[Clauses, int]]:
        """Yield the requests read so far plus what comes next: an alternative ("..., or put it on the shelf")
        or an amount."""
        asked = [k for k, c in enumerate(before) if c.phrases]
        if not asked:
            return
        last = before[asked[-1]]
        if self.words[at : at + 1] == ("or",):
            start = at + 1 + (self.words[at + 1 : at + 2] == ("else",))
            for clause, end in (*self._clauses(start), *self._further(last, start, places=True)):
                if self._known_clause(clause):
                    yield from (((*before, replace(clause, either=True)), behind) for behind in self._closed(end))
        for frame in self.frames.measured if last.place is None and not last.amount else ():
            if frame.phrase.form.startswith(last.phrases[0].form):
                for measured, end in self._amounts(frame, (), last.theme, at):
                    more = replace(last, phrases=(frame.phrase,), amount=measured.amount)
                    ends = (*starts(self.words, end, english.SUITS), *starts(self.words, end, english.INDIFFERENT), end)
                    clauses = (*before[: asked[-1]], more, *before[asked[-1] + 1 :])
                    yield from ((clauses, behind) for e in ends for behind in self._closed(e))

    def _left_out(self, _at: int) -> tuple[Found, ...]:
        """Return the asides (parts of a sentence that ask for nothing) that begin at a word index; this
        parser knows none."""
        return ()

    def _separated(self, at: int) -> int:
        """Return the index of the word after the separators (commas, "and", "but") that begin at word ``at``."""
        while at < len(self.words) and self.words[at] in (*english.STOPS, "and", "but"):
            at += 1
        return at

    def _polite(self, at: int) -> tuple[int, bool]:
        """Return the index of the word after polite phrases that begin at word ``at``, and whether one of
        them says "later"."""
        start, later = at, False
        while start < len(self.words):
            found = self._courtesies(start, english.POLITE, english.CLOSING)
            word = self.words[start]
            if found:
                later = later or bool(english.LATER & set(self.words[start : found[0]]))
                start = found[0]
            elif word in english.STOPS or (word in ("and", "but") and start):
                start += 1
            elif at and (aims := starts(self.words, start, AIMS)):
                start = aims[0]
            else:
                break
        return start, later

    def _closed(self, at: int) -> tuple[int, ...]:
        """Return the word indices at which a request that reaches to word ``at`` may end: before a separator, or at the sentence's end."""
        found, ends = [at], []
        while found:
            k = found.pop()
            if k >= len(self.words) or self.words[k] in (*english.STOPS, *FURTHER, *TIME):
                ends.append(k)
            comma = k + (self.words[k : k + 1] == (",",))
            more = (*self._courtesies(k, english.CLOSING), *self._contrasted(comma))
            found += [e for e in more if e > k and e not in ends]
        return tuple(dict.fromkeys(sorted(ends, reverse=True)))

    def _clauses(self, at: int) -> tuple[Found, ...]:
        if at not in self._parsed:
            ways = (self._imperative, self._wished, self._after, self._given, self._swapped, self._named, self._excepting)
            self._parsed[at] = tuple(dict.fromkeys(found for way in ways for found in way(at)))
        return self._parsed[at]

    def _given(self, at: int) -> Iterator[Found]:
        """Yield conditions, which are checked in the present scene: "if the drawer is open", "unless the tin is on the tray".

        One that lasts is a request: "provided that the mug stays upright".
        """
        tables = ((english.REASONS, True, False), (english.CONDITIONS, False, False), (english.PROVISOS, False, True))
        for start, told, unless in ((end, told, unless) for table, told, unless in tables for end in starts(self.words, at, table)):
            for theme, end in self._nouns.nouns(start):
                ways = [(b, unless) for b in starts(self.words, end, english.BE)]
                ways += [(b, not unless) for b in starts(self.words, end, english.IS_NOT)]
                for begin, denied in ways:
                    given = told or unless or not {*self.words[end:begin]} & english.LASTING
                    yield from ((replace(c, given=given, told=told, denied=denied), last) for c, last in self._predicates(theme, begin))

    def _excepting(self, at: int) -> Iterator[Found]:
        """Yield requests after a phrase that excepts things from them: "except for the jug, put everything in the basket"."""
        for start in starts(self.words, at, english.EXCEPT):
            for noun, end in self._nouns.nouns(start):
                asked = self._clauses(end + 1) if self.words[end : end + 1] == (",",) else ()
                for clause, last in (f for f in asked if not (f[0].theme.members or f[0].theme.pronoun)):
                    links = (*clause.theme.links, Link("except", self.words[at:start], (noun,)))
                    yield replace(clause, theme=replace(clause.theme, links=links)), last

    def _swapped(self, at: int) -> Iterator[Found]:
        """Yield requests to exchange two things: "swap the can and the jug"."""
        def swap(theme: Noun) -> Clause:
            return Clause("change places", (), theme, relation="swap")

        for start in starts(self.words, at, english.SWAP):
            for theme, end in self._nouns.nouns(start):
                if theme.several:
                    yield from ((swap(theme), last) for last in (*starts(self.words, end, english.SWAPPED), end))
                for begin in starts(self.words, end, (("with",), ("for",))):
                    for other, last in self._nouns.nouns(begin, joined=False):
                        both = Noun(f"{theme.said} and {other.said}", members=(theme, other), joined="and", several=True)
                        yield swap(both), last
        for theme, end in (n for k in (*starts(self.words, at, english.WISH), at) for n in self._nouns.nouns(k)):
            for start in starts(self.words, end, english.SWAP) if theme.several else ():
                yield from ((swap(theme), last) for last in starts(self.words, start, english.SWAPPED))

    def _named(self, at: int) -> Iterator[Found]:
        """Yield noun phrases without a verb, to which later pronouns refer: "find the cup and ...", "the cup:
        ..."."""
        for start in starts(self.words, at, english.GOING):
            yield from ((Clause("", (), noun, relation="going"), end) for noun, end in self._nouns.nouns(start))
        for start in (*starts(self.words, at, english.PREPARE), at):
            for noun, end in self._nouns.nouns(start):
                ends = starts(self.words, end, english.WILL_DO)
                if start != at or ends or self.words[end : end + 1] in ((",",), (":",)):
                    yield Clause("", (), noun), ends[0] if ends else end
                yield from ((Clause("", (), noun, relation="base"), last) for last in starts(self.words, end, english.BASED))

    def _remnants(self, since: int, at: int, before: tuple[Clause, ...], *, later: bool) -> Iterator[Found]:
        """Yield parts of a sentence that take their verb from the part before: "and the sauce in the tray", "but not in the bowl",
        "then the can"."""
        if not before or not (before[-1].phrases or before[-1].relation == "base"):
            return
        last = before[-1]
        ends = ((), *((w,) for w in (*english.STOPS, "and", "then")))
        for noun, end in self._nouns.nouns(at, joined=False) if later else ():
            if self.words[end : end + 1] not in ends:
                continue
            if last.relation == "base" or (last.place is not None and last.place.pronoun):  # each on the one before
                upon = next(f for f in self.frames.placing if english.TOP_WORD in f.prepositions)
                yield self._clause(upon, (), noun, Noun("that", pronoun="there"), "phrase", english.TOP_WORD), end
            elif last.relation == "phrase":
                yield replace(last, theme=noun), end
        if not last.phrases:
            return
        if last.place is not None:
            yield from self._brief(at)
        for noun, end in self._nouns.nouns(at):
            comma = end + (self.words[end : end + 1] == (",",))
            if (noun.quantity == "none" and (noun.words or not noun.other)) or starts(self.words, comma, english.TOO):
                yield replace(last, theme=noun, denied=last.denied or noun.quantity == "none"), end
        for start in starts(self.words, at, english.SO_DOES) if self.words[at - 1] == "so" else ():  # "so does the can"
            yield from ((replace(last, theme=noun), end) for noun, end in self._nouns.nouns(start))
        joined = bool({"and", "then", "but"} & {*self.words[since:at], self.words[at - 1]})
        if joined or self.words[at - 1] == ",":
            yield from self._further(last, at, places=joined or last.place is None)
        for start in starts(self.words, at, english.NOT_YET) if joined else ():
            for noun, end in self._nouns.nouns(start):
                yield replace(last, theme=noun, denied=True), end
            for frame in self.frames.placing:
                yield from ((replace(c, denied=True), end) for c, end in self._places(frame, (), last.theme, start))

    def _further(self, last: Clause, at: int, *, places: bool) -> Iterator[Found]:
        """Yield further parts of a sentence, about the things of the part before: "off the tray and into the drawer",
        "and in it the tin"."""
        for begin in starts(self.words, at, english.BE):
            yield from self._predicates(last.theme, begin)
        for frame, verb, particle, end in self.frames.participles(self.words, at):  # "removed from the floor and put in the drawer"
            yield from self._complements(frame, verb, last.theme, end) if not particle else ()
        for frame in self.frames.placing if places else ():
            yield from self._places(frame, (), last.theme, at)
            for start in starts(self.words, at, frame.prepositions):
                for place, end in self._nouns.nouns(start, joined=False):
                    for theme, last_ in self._nouns.nouns(end) if place.pronoun else ():
                        yield self._clause(frame, (), theme, place, "phrase", self.words[at:start]), last_
        for frame in self.frames.unary:
            yield from ((self._clause(frame, self.words[at:end], last.theme), end) for end in starts(self.words, at, frame.stated))

    def _stated(self, at: int) -> Iterator[Found]:
        """Yield requests that state what is wanted without a verb: "the drawer shut", "the mug upside down on the tray"."""
        for theme, end in self._nouns.nouns(at) if at < len(self.words) else ():
            for begin in dict.fromkeys((*self._between(end), end + (self.words[end : end + 1] == (":",)))):
                yield from self._predicates(theme, begin)
                for frame, verb, particle, last in self.frames.verbs(self.words, begin):
                    if frame in self.frames.unary and not particle and not frame.after:
                        yield self._clause(frame, verb, theme), last

    def _brief(self, at: int, *, toward: bool = False) -> Iterator[Found]:
        """Yield clauses of a thing and its place without a verb: "the tin into the bowl".

        ``toward`` requires a preposition of motion, such as "into".
        """
        for frame in self.frames.placing if at < len(self.words) else ():
            for theme, end in self._nouns.nouns(at) if frame.region else ():
                if not toward or self.words[end : end + 1] in english.TOWARD:
                    yield from self._places(frame, (), theme, end)

    def _wished(self, at: int) -> Iterator[Found]:
        """Yield wishes and clauses in the passive: "the drawer should be closed", "I want the cup on the
        plate"."""
        for start in starts(self.words, at, english.UNWISH):
            for theme, end in self._nouns.nouns(start):
                for begin in (*starts(self.words, end, english.BE), end):
                    yield from ((replace(clause, denied=True), last) for clause, last in self._predicates(theme, begin))
        wishes = starts(self.words, at, english.WISH)
        for start in (*wishes, *(e for w in wishes for e in starts(self.words, w, english.EXISTS)), at):
            for theme, end in self._nouns.nouns(start):
                been = starts(self.words, end, english.BE)
                for begin in starts(self.words, end, english.NOT_BE):
                    yield from ((replace(clause, denied=True), last) for clause, last in self._predicates(theme, begin))
                for begin in (*been, *((end,) if start != at else ())):
                    told = start == at and self.words[end] in english.TOLD
                    yield from ((replace(c, told=told), last) for c, last in self._predicates(theme, begin))
                    for degree in starts(self.words, begin + (self.words[begin : begin + 1] == ("left",)), english.DEGREE) if told else ():
                        yield from ((replace(c, told=True, given=True), last) for c, last in self._predicates(theme, degree))
                for begin in (*been, end):
                    yield from self._holding(theme, begin)
                for begin in starts(self.words, end, english.IS_NOT) if start != at else ():
                    yield from ((replace(c, denied=True), last) for c, last in self._predicates(theme, begin))
                for begin in starts(self.words, end, english.NEEDS):
                    for frame, verb, particle, last in self.frames.verbs(self.words, begin):
                        if verb[0].endswith("ing") and not particle:
                            yield from self._complements(frame, verb, theme, last)

    def _holding(self, place: Noun, at: int) -> Iterator[Found]:
        """Yield requests about what a place should contain: "the basket should contain the tin", "the basket should be emptied"."""
        for start in starts(self.words, at, english.HOLDS):
            for theme, end in self._nouns.nouns(start):
                ends = starts(self.words, end, (("on", "it"), ("in", "it"), ("inside",), ("on",), ("in",)))
                for last in (*ends, *(() if self.words[at : at + 1] in (("need",), ("needs",), ("want",), ("wants",)) else (end,))):
                    for frame in (f for f in self.frames.placing if f.region and ("to",) in f.prepositions):
                        yield self._clause(frame, self.words[at:start], theme, place, "phrase", ("to",)), last
        for frame, verb, _, end in (*self.frames.verbs(self.words, at), *self.frames.participles(self.words, at)):
            if frame.converse and not frame.after and len(verb) == 1:
                yield self._clause(frame, verb, self._contents(place), place, "phrase", verb), end

    def _after(self, at: int) -> Iterator[Found]:
        """Yield subordinate clauses of time with a gerund or participle: "after opening the drawer, ..."."""
        if self.words[at : at + 1] in (("by",), ("while",), *((w,) for w in TIME)):
            for k in (at + 1, at + 2, at + 3):
                yield from self._imperative(k) if self.words[at + 1 : k] in ((), ("you",), ("having",)) else ()
                done = self.words[k - 1 : k] in (("have",), ("having",)) and self.words[at + 1 : k] in ((), ("you", "have"), ("having",))
                yield from self._imperative(k, participle=True) if done else ()
            yield from self._wished(at + 1)


