"""Grammar of a request: a verb with its things and places, or a statement about a thing."""

from __future__ import annotations

import re
from collections.abc import Iterator

from msgspec.structs import replace

from . import english
from .english import Words, starts
from .frames import Frame, Frames
from .nouns import NounParser, spoken
from .phrases import Phrases
from .tree import Clause, Link, Noun

Found = tuple[Clause, int]
"""Parsed request, and the position after it in the sentence."""
THERE = (
    ("in there", "in"), ("off there", "off"), ("out of there", "out of"), ("from there", "from"), ("inside", "in"), ("in", "in"),
    *((text, "") for text in ("there", "up there", "over there", "down there")), ("on top", "on"),
    ("on there", "on"), ("on the top", "on"), ("at the top", "on"), ("on the very top", "on"),
)  # fmt: skip
"""Adverbs that stand for a place, such as "inside", each with the preposition that it means."""
RESPECTIVELY = (("respectively",), (",", "respectively"))
AIMS = (("so", "that"), ("such", "that"), ("until",), ("till",), ("so",), ("in", "order", "that"))
"""Words that introduce the state that a motion should bring about, such as "so that"."""


class RequestParser:
    """Parser of the requests in one sentence.

    Args:
        words: of the sentence.
        frames: of all goal phrases.
        names: words that are names of things, whatever else they may mean.
    """

    def __init__(self, words: Words, frames: Frames, names: frozenset[str]) -> None:
        self.words, self.frames, self._names = words, frames, names
        self._nouns = NounParser(words, frames.prepositions, frames.states, names)

    def _known(self, _noun: Noun) -> bool:
        """Check whether the scene may have the things that a noun phrase describes; always true in this
        parser, which does not know the scene."""
        return True

    def _known_clause(self, clause: Clause) -> bool:
        nouns = (clause.theme, clause.place, *(clause.beside.nouns if clause.beside is not None else ()))
        if any(n is not None and n.quantity == "none" for n in nouns[1:]):
            return False  # "next to nothing in particular"
        return all(self._known(n) for n in nouns if n is not None)

    def _courtesies(self, at: int, *tables: Phrases) -> tuple[int, ...]:
        """Return the word indices at which courtesies such as "please", begun at a given word, may end; the latest first.

        No courtesy begins at a word such as "first" where that is a thing's name.
        """
        if self.words[at : at + 1] and self.words[at] in english.ORDINALS and self.words[at] in self._names:
            return ()
        return tuple(sorted((e for table in tables for e in starts(self.words, at, table)), reverse=True))

    def _contrasted(self, at: int) -> Iterator[int]:
        """Yield the word index after a contrast, which says what is not meant: "not in the basket" in "on the
        tray, not in the basket"."""
        for start in starts(self.words, at, english.CONTRAST):
            stated = [f.stated for f in self.frames.unary]
            yield from (end for way in stated for end in starts(self.words, start, way))
            yield from (start + 1,) if self.words[start : start + 1] and self.words[start] in english.PLACED else ()
            for begin in (*starts(self.words, start, self.frames.prepositions), start):
                yield from (end for noun, end in self._nouns.nouns(begin) if self._known(noun))
                if self.words[begin : begin + 1] == ("the",) and {*self.words[begin + 1 : begin + 2]} & english.TELLING:
                    yield begin + 2  # "not the lower"

    def _imperative(self, at: int, *, participle: bool = False) -> Iterator[Found]:
        for end in self.frames.verb_ends(self.words, at) if not participle else ():  # "unlatch and open the door"
            meant = {f.phrase for f, *_ in self.frames.verbs(self.words, at)}
            both = self._imperative(end + 1) if self.words[end : end + 1] == ("and",) else ()
            yield from ((clause, last) for clause, last in both if clause.phrases[0] in meant)
        verbs = self.frames.participles if participle else self.frames.verbs
        for frame, verb, particle, end in verbs(self.words, at):
            given = self.words[end : end + 1] in (("me",), ("us",))
            end += given
            if given and ("from",) in frame.prepositions:
                continue  # "get me the tin from the tray" wants it held
            if frame.converse:
                yield from self._converse(frame, verb, end)
                continue
            for theme, last in self._themes(frame, end):
                if not particle:
                    yield from self._complements(frame, verb, theme, last)
                    yield from self._purpose(theme, last)
                elif self.words[last : last + len(particle)] == particle:
                    yield from self._complements(frame, (*verb, *particle), theme, last + len(particle))

    def _themes(self, frame: Frame, at: int) -> Iterator[tuple[Noun, int]]:
        for start in starts(self.words, at, frame.before) if frame.before else (at,):
            yield from self._nouns.nouns(start)

    def _converse(self, frame: Frame, verb: Words, at: int) -> Iterator[Found]:
        """Yield requests whose verb has the place as its object: "empty the drawer", "fill the basket with
        tins"."""
        several = len({f.phrase for f, *_ in self.frames.verbs(verb, 0) if f.converse and f.after}) > 1
        words = ("to",) if several else verb  # "fill" leaves open whether it is in or on the place
        for place, end in self._nouns.nouns(at):
            if place.words == english.ANYTHING and place.links and place.links[0].nouns:  # "whatever is on it"
                place = place.links[0].nouns[0]
            if frame.after:
                themes = (t for start in starts(self.words, end, frame.after) for t in self._nouns.nouns(start))
                yield from ((self._clause(frame, verb, theme, place, "phrase", words), last) for theme, last in themes)
            else:
                yield self._clause(frame, verb, self._contents(place), place, "phrase", verb), end

    def _purpose(self, theme: Noun, at: int) -> Iterator[Found]:
        """Yield states given as the purpose of a move: "turn the cup so that it is upside down"."""
        for start in starts(self.words, at + (self.words[at : at + 1] == ("over",)), AIMS):
            for stands, end in self._nouns.nouns(start):
                for begin in starts(self.words, end, english.BE) if stands.pronoun else ():
                    yield from self._predicates(theme, begin)

    def _complements(self, frame: Frame, verb: Words, theme: Noun, at: int) -> Iterator[Found]:
        """Yield requests made of a verb, its object and the words that follow: an amount, a place, an adverb
        or an adjective."""
        if frame.amount:
            yield from self._amounts(frame, verb, theme, at)
        elif frame.place:
            for begin in self._between(at, erect=bool({*verb} & english.ERECT)):
                yield from self._places(frame, verb, theme, begin)
            yield from self._posed(frame, verb, theme, at)
            yield from self._together(frame, verb, theme, at)
        elif not frame.after:
            yield self._clause(frame, verb, theme), at
        else:
            yield from ((self._clause(frame, (*verb, *a), theme), end) for a in frame.after for end in starts(self.words, at, (a,)))

    def _posed(self, frame: Frame, verb: Words, theme: Noun, at: int) -> Iterator[Found]:
        """Yield phrases of a place and a state, in either order: "upside down on the tray", "on the tray
        upside down"."""
        if {*verb} & english.ERECT and self.words[at : at + 1] == ("up",):  # "stand it up on the tray"
            upright = (f for f in self.frames.unary if ("upright",) in f.stated)
            yield from ((replace(c, state=f.phrase), end) for f in upright for c, end in self._places(frame, verb, theme, at + 1))
            return
        for unary in self.frames.unary:
            for begin in starts(self.words, at, unary.stated) if self.words[at : at + 1] and self.words[at] not in english.PLACED else ():
                yield from ((replace(c, state=unary.phrase), end) for c, end in self._places(frame, verb, theme, begin))
        for clause, last in self._places(frame, verb, theme, at):
            for unary in self.frames.unary:
                begin = last + (self.words[last : last + 1] == (",",))
                yield from ((replace(clause, state=unary.phrase), end) for end in starts(self.words, begin, unary.stated))

    def _together(self, frame: Frame, verb: Words, theme: Noun, at: int) -> Iterator[Found]:
        """Yield the readings of a request to put several things side by side: "the tin and the can side by side on the tray"."""
        for begin in starts(self.words, at, english.TOGETHER) if theme.several and not theme.pronoun else ():
            placed = [(c, end) for c, end in self._places(frame, verb, theme, begin) if c.relation == "phrase" and c.beside is None]
            alone = [(self._clause(frame, verb, theme), begin)] if frame.beside else []
            yield from ((replace(c, relation="together"), end) for c, end in (*placed, *alone))

    def _between(self, at: int, *, erect: bool = False) -> tuple[int, ...]:
        """Return the positions after a verb's object at which a place may begin; adverbs and commas may be
        skipped, but not the "up" of "stand it up"."""
        ends = [at]
        if self.words[at : at + 1] == (",",):
            ends.append(at + 1)
        for k in (at, *self._courtesies(at, english.CLOSING)):
            plain = k < len(self.words) and not (erect and self.words[k] == "up")
            if plain and self.words[k] in ("down", "back", "up", "so", "over", "right", "directly", "that", ",", "away"):
                ends.append(k + 1)
            ends.append(k)
        ends += [e + (self.words[e : e + 1] == (",",)) for e in self._contrasted(at + (self.words[at : at + 1] == (",",)))]
        return tuple(dict.fromkeys(ends))

    def _places(self, frame: Frame, verb: Words, theme: Noun, at: int) -> Iterator[Found]:
        if {*verb} & english.ERECT and self.words[at : at + 1] == ("up",):
            return
        for start in starts(self.words, at, frame.prepositions):
            for place, end in self._nouns.nouns(start):
                if self.words[at:start] in english.TO and ((place.sides and not place.words) or not (frame.region or verb)):
                    continue  # "to the right of the cup" is beside it
                clause = self._clause(frame, verb, theme, place, "phrase", self.words[at:start])
                yield clause, end
                yield from ((replace(clause, paired=True), last) for last in starts(self.words, end, RESPECTIVELY))
                whole = next((k.nouns[0] for k in place.links if k.relation == "of" and k.nouns), None)
                if place.sides == ("middle",) and not place.words and whole is not None:
                    clause = replace(clause, place=whole)  # "in the middle of the tray, within 3 cm"
                for begin in starts(self.words, end + (self.words[end : end + 1] == (",",)), english.WITHIN):
                    for amid in self.frames.amid:
                        for amount, behind in self._amounts(amid, verb, theme, begin):
                            near = replace(clause, phrases=(amid.phrase,), amount=amount.amount)
                            told = (*starts(self.words, behind, english.SUITS), behind) if clause.place is whole else ()
                            ends = (*starts(self.words, behind, english.CENTRAL), *self._centre(behind), *told)
                            yield from ((near, last) for last in ends)
                if frame.beside:
                    yield from ((replace(clause, beside=link), last) for link, last in self._nouns.beside(end))
        yield from self._adverbs(frame, verb, theme, at)
        if not frame.beside:
            return
        for phrase, relation in english.BESIDE.items():
            if self.words[at : at + len(phrase)] == phrase:
                for place, end in self._nouns.nouns(at + len(phrase)):
                    clause = self._clause(frame, verb, theme, place, relation, phrase)
                    yield from ((clause, last) for last in (*starts(self.words, end, (("there",), ("on", "there"))), end))
        for start in starts(self.words, at, english.UNDER):
            for place, end in self._nouns.nouns(start):
                yield self._clause(frame, verb, theme, place, "under", self.words[at:start]), end

    def _adverbs(self, frame: Frame, verb: Words, theme: Noun, at: int) -> Iterator[Found]:
        """Yield requests with an adverb as the place: "put the cup inside", "there", "on top"."""
        for text, word in THERE:
            phrase = tuple(text.split())
            end = at + len(phrase)
            ways = {("on",), ("in",)} if not word else {tuple(word.split())}
            if self.words[at:end] == phrase and (word or frame.region) and ways & {*frame.prepositions}:
                how = english.TOP_WORD if phrase[-1] == "top" else phrase[:1] if word else ("there",)
                yield self._clause(frame, verb, theme, Noun(spoken(phrase), pronoun="there"), "phrase", how), end
        if not frame.region:
            return
        for end in starts(self.words, at, english.ORIGIN):
            own = theme.pronoun or {*self.words[at:end]} & {"back", "its", "their"}  # "the red one where it was" is another's place
            origin = Noun(self._nouns.text(at, end), pronoun="origin" if own else "vacated")
            yield self._clause(frame, verb, theme, origin, "phrase"), end
        for word in {*self.words[at : at + 1]} & self._names & english.ASIDE if ("on",) in frame.prepositions else ():
            yield self._clause(frame, verb, theme, Noun(word, (word,)), "phrase", ("on",)), at + 1

    def _amounts(self, frame: Frame, verb: Words, theme: Noun, at: int) -> Iterator[Found]:
        k = at
        while k < len(self.words) and self.words[k] in english.AMOUNTING:
            k += 1
        if k < len(self.words):
            number = re.fullmatch(r"(\d+(?:\.\d+)?)([a-z]*)", str(english.TENS.get(self.words[k], self.words[k])))
            unit = number[2] if number and number[2] else self.words[k + 1] if k + 1 < len(self.words) else ""
            unit = english.UNITS.get(unit, unit)
            if number and unit:
                yield self._clause(frame, verb, theme, amount=f"{number[1]} {unit}"), k + 1 + (not number[2])

    def _centre(self, at: int) -> Iterator[int]:
        """Yield the word index after a phrase for the middle of a thing: "from the tray's centre"."""
        for start in starts(self.words, at, english.OF):
            for noun, end in self._nouns.nouns(start, joined=False):
                if noun.sides == ("middle",) or any(k.words[:1] == ("middle",) for k in noun.links):
                    yield end
            for end in range(start + 2, min(start + 6, len(self.words))):
                if self.words[end] in ("centre", "center", "middle") and self.words[end - 1] == "'s":
                    yield end + 1

    def _contents(self, place: Noun) -> Noun:
        return Noun(f"everything in {place.said}", english.ANYTHING, "all", links=(Link("at", (), (place,)),))

    def _predicates(self, theme: Noun, at: int) -> Iterator[Found]:
        """Yield the predicates that may be stated about a thing: "open", "on the plate", "put into the
        basket"."""
        begins = [at, at + 1] if at < len(self.words) and self.words[at] in english.PLACED else [at]
        for begin in begins:
            if self.words[begin : begin + 1] == ("from",):
                continue  # "get the cup from the hook" takes it off, and what is hanging from there is on it
            for frame in self.frames.placing:
                yield from self._places(frame, (), theme, begin)
                yield from self._posed(frame, (), theme, begin)
                yield from self._together(frame, (), theme, begin)
        for frame in self.frames.measured:
            if self.words[at : at + 1] == tuple(frame.phrase.form.split()[1:2]):
                yield from self._amounts(frame, self.words[at : at + 1], theme, at + 1)
        placed = (v for v in self.frames.verbs(self.words, at) if v[1][0] in english.PLACED)
        for frame, verb, particle, end in (*self.frames.participles(self.words, at), *placed):
            if not particle:
                yield from self._complements(frame, verb, theme, end)
        for frame in self.frames.unary:
            for end in starts(self.words, at, frame.stated):
                yield self._clause(frame, self.words[at:end], theme), end

    def _clause(
        self, frame: Frame, verb: Words, theme: Noun, place: Noun | None = None, relation: str = "phrase", words: Words = (),
        amount: str = "",
    ) -> Clause:  # fmt: skip
        said = spoken(tuple(w for w in (*verb, *(words if place is not None else ())) if w))
        return Clause(said, (frame.phrase,), theme, place, relation, words, amount, denied=theme.quantity == "none")
