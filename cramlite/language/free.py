"""Requests in free order of their parts: "the pack from the hook take", "can tray", "into the basket shall the tin go"."""

from __future__ import annotations

from collections.abc import Iterator

from msgspec.structs import replace

from ..base.value import Value
from . import english
from .asides import Asides
from .clauses import ClauseParser
from .english import Words, starts
from .frames import Frame, Frames
from .labels import Labels
from .nouns import NounParser, spoken
from .requests import Found
from .signs import adverb
from .tree import Clause, Link, Noun

ASIDE, AHEAD = "aside", "ahead"
"""Relations of two clauses that ask for nothing: an aside, and an announcement of what follows."""
SAME = "same"
"""Relation of a clause that only names again things that were named before."""
REACH = 22
"""Largest number of words in a request whose parts stand in any order."""


class Heard(Value):
    """Parts of one request that were found so far, in any order: verb, thing, place, state and amount.

    Args:
        verbs: frames of its verb, each with the words that are still to come, and the verb.
        odd: an unknown verb, whose result only its place or state tells.
        theme, place: things.
        relation, words: of the place.
        state: frame of one thing with its words.
        amount: with its unit.
        denied, obliged, firm: whether it is denied, said to be so in the end, and denied of a thing that was named before.
        copula: whether it is said to be so.
        bare: whether no word tells how the thing shall be to the place.
    """

    verbs: tuple[tuple[Frame, Words, tuple[Words, ...]], ...] = ()
    odd: str = ""
    theme: Noun | None = None
    place: Noun | None = None
    relation: str = ""
    words: Words = ()
    beside: Link | None = None
    state: tuple[Frame, Words] | None = None
    amount: str = ""
    denied: bool = False
    obliged: bool = False
    firm: bool = False
    copula: bool = False
    bare: bool = False


class FreeParser(ClauseParser):
    """Parser of requests whose parts stand in any order; it leaves out asides, which ask for nothing.

    Args:
        words: of the sentence.
        frames: of all goal phrases.
        labels: what things are called.
    """

    def __init__(self, words: Words, frames: Frames, labels: Labels) -> None:
        super().__init__(words, frames, labels.names)
        self._labels = labels
        self._strict: dict[int, int] = {}
        self._aside: dict[int, tuple[Found, ...]] = {}
        self._fitting: dict[Words, bool] = {}
        self._asides = Asides(words, frames, labels.calls, lambda w: labels.calls(w) or not labels.unknown((w,)))
        self._nouns = NounParser(words, frames.prepositions, frames.states, labels.names, self._asides.comments)

    def _clauses(self, at: int) -> tuple[Found, ...]:
        if at not in self._parsed:
            strict = [f for f in super()._clauses(at) if self._known_clause(f[0])]
            self._parsed[at] = tuple(dict.fromkeys((*strict, *self._free(at, at, Heard()))))
            self._strict[at] = max((end for _, end in strict), default=at)
        return self._parsed[at]

    def _left_out(self, at: int) -> tuple[Found, ...]:
        if at not in self._aside:
            self._clauses(at)
            ends = [e for e in self._asides.ends(at) if e > self._strict[at]]
            left = ((self.words[at:e], e) for e in dict.fromkeys(ends))
            self._aside[at] = tuple((self._aside_of(said, at, e), e) for said, e in left) + self._repeated(at)
        return self._aside[at]

    def _repeated(self, at: int) -> tuple[Found, ...]:
        """Return noun phrases after a comma that only repeat in other words what was named: "both blocks, the
        red and the blue one"."""
        nouns = self._nouns.nouns(at + 1) if self.words[at : at + 1] in ((",",), ("!",)) else ()
        same = ((n, end) for n, end in nouns if self._known(n) and (n.several or not n.pronoun))
        meant = ((n, e) for n, end in same for e in (*starts(self.words, end, (("i", "mean"), ("that", "is"))), end))
        return tuple((Clause("", (), n, relation=SAME), end) for n, end in meant)

    def _aside_of(self, said: Words, at: int, end: int) -> Clause:
        """Return a part of a sentence that asks for nothing, such as a reason, with the things that it names.

        Later pronouns may refer to these things.
        """
        named, k = list[Noun](), at
        while k < end:
            found = [(n, e) for n, e in self._nouns.nouns(k, joined=False) if e <= end and n.words and not n.links and self._known(n)]
            named += [found[0][0]] if found else []
            k = found[0][1] if found else k + 1
        relation = AHEAD if said[-1] == ":" and named else ASIDE
        return Clause(spoken(said).strip(",.;:!? "), (), Noun("", members=tuple(named)), relation=relation)

    def _known(self, noun: Noun) -> bool:
        """Check whether a noun phrase could describe something in the scene; a pronoun always could."""
        if noun.members:
            return all(self._known(n) and not (n.pronoun and n.several) for n in noun.members)
        others = [n for link in noun.links for n in link.nouns if not self._known(n)]
        if not all({*n.words} <= english.ROBOT | english.VIEWER and n.words for n in others):
            return False
        if noun.pronoun or not noun.words or noun.words == english.ANYTHING:
            return True
        if noun.words not in self._fitting:
            fits = (self._labels.fits(n, noun.words) for n in self._labels.of)
            self._fitting[noun.words] = any(fits) or bool({*noun.words} & english.REGIONS)
        return self._fitting[noun.words]

    def _named(self, at: int) -> Iterator[Found]:
        """Yield noun phrases to which later pronouns refer, also in statements and questions: "there is a
        bottle in the drawer", "where is the jug?"."""
        yield from super()._named(at)
        for start in starts(self.words, at, english.QUESTIONS):
            for noun, end in self._nouns.nouns(start):
                noun = replace(noun, quantity="the") if noun.quantity == "a" and not noun.count else noun
                yield Clause("", (), noun), end
                for begin in dict.fromkeys((*starts(self.words, end, english.BE), end)):
                    yield from ((replace(c, given=True, told=True), last) for c, last in self._predicates(noun, begin))

    def _further(self, last: Clause, at: int, *, places: bool) -> Iterator[Found]:
        yield from super()._further(last, at, places=True)

    # Free order

    def _free(self, at: int, k: int, heard: Heard) -> Iterator[Found]:
        """Yield the requests that begin at word ``at``; their parts (verb, thing, place) may come in any order.

        ``heard`` are the parts that were found up to word ``k``.
        """
        yield from ((clause, k) for clause in self._made(heard))
        word = self.words[k] if k < len(self.words) and k < at + REACH else ""
        if not word or (word in english.JOINTS - english.LIGHT and k > at):
            return
        for start in starts(self.words, k, english.NOT_YET):
            before = self.words[start : start + 1] and (self.words[start] in english.LIGHT or bool(self._behind_denial(start)))
            if before and (heard.obliged or heard.theme is not None or not heard.verbs):
                yield from self._free(at, start, replace(heard, denied=True, firm=heard.theme is not None))
        floating = word in english.EVERY and heard.theme is not None and heard.theme.several  # "tin and box both basket"
        after = self.words[k + 1] if k + 1 < len(self.words) else ""
        asked = word == "you" and (heard.verbs or heard.place is not None)  # "on the rack lay you the bottle"
        tells = word in english.PERSONS and after not in english.LIGHT | english.WISHED and not asked  # "I put the tin in the drawer"
        named = word in self._names and word in english.ORDINALS
        light = (word in english.LIGHT or adverb(word)) and not named and (k > at or word not in english.ASKING) and not tells
        if light or floating or (word in english.STOPS and k > at):
            more = replace(heard, obliged=heard.obliged or word in english.OBLIGING, copula=heard.copula or word in english.TOLD)
            yield from self._free(at, k + 1, more)
        for start in self._courtesies(k, english.CLOSING, english.TOO) if k > at else ():
            yield from self._free(at, start, heard)
        yield from self._heard_verb(at, k, heard)
        yield from self._heard_things(at, k, heard)
        yield from self._heard_state(at, k, heard)

    def _behind_denial(self, at: int) -> tuple[int, ...]:
        """Return the index of the word after each preposition or state (such as "open") that begins at word
        ``at``."""
        return (*self.frames.preposition_ends(self.words, at), *(e for f in self.frames.unary for e in starts(self.words, at, f.stated)))

    def _heard_verb(self, at: int, k: int, heard: Heard) -> Iterator[Found]:
        if not heard.verbs and not heard.odd and self.words[k] not in english.SIDES:
            found: dict[int, list[tuple[Frame, Words, tuple[Words, ...]]]] = {}
            for frame, verb, particle, end in (*self.frames.verbs(self.words, k), *self.frames.participles(self.words, k)):
                if not frame.converse and not frame.before and (not particle or frame.place):
                    found.setdefault(end, []).append((frame, verb, () if not particle else (particle,)))
            for end, verbs in found.items():
                yield from self._free(at, end, replace(heard, verbs=tuple(verbs)))
            word = self.words[k]
            small = english.SMALL | english.LIMITING | english.PROVIDING
            strange = not found and word.isalpha() and word not in small and not self._labels.calls(word)
            begins = k == at and heard.theme is None and k + 1 < len(self.words) and self._theme_at(k + 1)
            ends = heard.theme is not None and heard.place is not None and (k + 1 == len(self.words) or self.words[k + 1] in english.STOPS)
            if strange and (begins or ends):
                yield from self._free(at, k + 1, replace(heard, odd=self.words[k]))

    def _theme_at(self, at: int) -> bool:
        return any(self._known(n) for n, _ in self._nouns.nouns(at))

    def _heard_things(self, at: int, k: int, heard: Heard) -> Iterator[Found]:
        if heard.theme is None:
            for noun, end in self._nouns.nouns(k):
                yield from self._free(at, end, replace(heard, theme=noun)) if self._known(noun) else ()
        elif heard.place is None and not heard.verbs and not heard.odd and heard.state is None and not heard.denied:
            for noun, end in self._nouns.nouns(k, joined=False):  # "can tray"
                if noun.words and self._known(noun):
                    place = replace(heard, place=noun, relation="phrase", words=("to",), bare=True)
                    yield from self._free(at, end, place)
        if heard.place is not None and heard.relation not in ("phrase", "under") and heard.beside is None:
            for start in starts(self.words, k, self.frames.prepositions):  # "near the first, on the floor"
                for noun, end in self._nouns.nouns(start):
                    link = Link(heard.relation, heard.words, (heard.place,))
                    turned = replace(heard, place=noun, relation="phrase", words=self.words[k:start], beside=link)
                    yield from self._free(at, end, turned) if self._known(noun) else ()
        if heard.place is not None and heard.relation == "phrase":
            for link, end in self._nouns.beside(k) if heard.beside is None else ():
                if self._known(link.nouns[0]):
                    yield from self._free(at, end, replace(heard, beside=link))
            return
        if heard.place is not None:
            return
        erect = self.words[k] == "up" and any({*verb} & english.ERECT for _, verb, _ in heard.verbs)  # "stand it up on the tray"
        for start in starts(self.words, k, self.frames.prepositions) if not erect else ():
            for noun, end in self._nouns.nouns(start):
                if self._known(noun):
                    yield from self._free(at, end, replace(heard, place=noun, relation="phrase", words=self.words[k:start]))
        for table, relation in ((english.BESIDE, ""), (dict.fromkeys(english.UNDER, "under"), "under")):
            for phrase in (p for p in table if self.words[k : k + len(p)] == p):
                for noun, end in self._nouns.nouns(k + len(phrase)):
                    if self._known(noun):
                        yield from self._free(at, end, replace(heard, place=noun, relation=relation or table[phrase], words=phrase))

    def _heard_state(self, at: int, k: int, heard: Heard) -> Iterator[Found]:
        word = self.words[k]
        plain = word in english.SIDES.keys() | english.INWARD | {"to"} or word.endswith("ing")
        if heard.state is None:
            for frame in self.frames.unary:
                for end in starts(self.words, k, frame.stated) if not plain else ():
                    yield from self._free(at, end, replace(heard, state=(frame, self.words[k:end])))
        if not heard.amount:
            for frame in self.frames.measured[:1]:
                for clause, end in self._amounts(frame, (), Noun(""), k):
                    yield from self._free(at, end, replace(heard, amount=clause.amount))

    def _made(self, heard: Heard) -> Iterator[Clause]:
        """Yield the requests that the parts of a sentence found so far make up; none while a needed part is
        missing."""
        if heard.theme is None or (heard.denied and not (heard.obliged or (heard.firm and not heard.verbs))):
            return
        verb = heard.verbs[0][1] if heard.verbs else ()
        allowed = [f for f, _, rest in heard.verbs if not rest and not f.after]
        light = not heard.verbs or {*verb} <= english.LIGHT
        made: list[Clause] = []
        if heard.place is not None and not heard.amount:
            made = self._made_places(heard, verb, allowed, light)
        elif heard.amount:
            measured = (f for f in self.frames.measured if light or f in allowed or heard.state)
            made = [self._clause(f, verb, heard.theme, amount=heard.amount) for f in measured]
        elif heard.state is not None and heard.place is None:
            frame, words = heard.state
            fits = light or any(f.phrase == frame.phrase for f, *_ in heard.verbs) or {*verb} & english.PLACED
            made = [self._clause(frame, words, heard.theme)] if fits or heard.odd else []
        elif not heard.odd:
            made = [self._clause(f, verb, heard.theme) for f in allowed if f in self.frames.unary]
        told = heard.copula and not heard.obliged and not heard.verbs
        yield from (replace(c, denied=c.denied or heard.denied, odd=heard.odd, bare=heard.bare, told=c.told or told) for c in made)

    def _made_places(self, heard: Heard, verb: Words, allowed: list[Frame], light: bool) -> list[Clause]:
        assert heard.theme is not None and heard.place is not None
        state = heard.state[0].phrase if heard.state is not None else None
        if heard.relation != "phrase":
            frames = [f for f in self.frames.placing if f.beside and f.region and (light or f in allowed)][:1]
        else:
            suited = [f for f in self.frames.placing if heard.words in f.prepositions and not f.before]
            usual = max((len(f.verbs) for f in suited), default=0)
            plain = [f for f in suited if len(f.verbs) == usual]
            usual_ = [f for f in suited if f in allowed and f.region]
            frames = usual_ or [f for f in suited if f in allowed] or (plain if light or heard.state is not None else [])
            if heard.odd:
                frames = plain if {*heard.words} & english.DIRECTED else []
        own: dict[str, Frame] = {f.phrase.form: f for f in frames}
        verb = verb or (("taken",) if heard.words[:1] in english.SOURCES and not heard.obliged else ())
        made = [self._clause(f, verb, heard.theme, heard.place, heard.relation, heard.words) for f in own.values()]
        return [replace(c, state=state, beside=heard.beside) for c in made]
