"""Grammar of noun phrases: "the left bowl that is on the stove", "both mugs", "it"."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping

from msgspec.structs import replace

from ..model.world.colour_words import COLOURS
from . import english
from .english import Words, starts
from .surface import RETRACT
from .tree import UTMOST, Link, Noun

Found = tuple[Noun, int]
"""Noun phrase, and the position after it in the sentence."""
RANKED = ("former", "latter")
"""Pronouns for the first and the second of the last two things that were named."""
MOST = 9
"""Largest number of words in the name of a thing."""
CONJUNCTIONS = (
    ("and", "and"), (", and", "and"), ("as well as", "and"), ("along with", "and"), ("together with", "and"), ("nor", "and"),
    ("or", "or"), (", or", "or"), (",", ","),
)  # fmt: skip
"""Conjunctions between descriptions, each with the one of "and", "or" and the comma that it means."""
DEEP = 4
"""Largest nesting depth of relations in a description."""


class NounParser:
    """Parser of the noun phrases in one sentence; each position is parsed once.

    Args:
        words: of the sentence.
        prepositions: of goal phrases.
        states: adjectives of goal phrases, e.g. "open".
        names: words that are names of things, whatever else they may mean.
        comments: where the comments that begin at a position may end.
    """

    def __init__(
        self, words: Words, prepositions: tuple[Words, ...], states: Mapping[str, str], names: frozenset[str],
        comments: Callable[[int], Iterable[int]] = lambda _at: (),
    ) -> None:  # fmt: skip
        self._comments = comments
        self.words, self.prepositions, self.states, self._names = words, prepositions, states, names
        self._parsed: dict[tuple[int, int, bool], tuple[Found, ...]] = {}
        firsts = {p[0] for p in (*prepositions, *english.BESIDE, *english.UNDER, *english.OF, *english.WITH)}
        firsts |= english.FINITE.firsts - {"can"}
        firsts -= english.SIDES.keys()
        small = {"and", "or", "but", "that", "which", "so", "such", "after", "once", "before", "except", "i", "we", "he", "she", RETRACT}
        self._ends = firsts | english.STOPS | small | english.NEGATIVE | english.PROVIDING

    def nouns(self, at: int, deep: int = 0, *, joined: bool = True) -> tuple[Found, ...]:
        """Return the noun phrases that may begin at a position, the longer ones first."""
        key = at, deep, joined
        if key not in self._parsed:
            self._parsed[key] = ()  # no description begins with itself
            self._parsed[key] = tuple(dict.fromkeys(self._all(at, deep, joined)))
        return self._parsed[key]

    def _all(self, at: int, deep: int, joined: bool) -> Iterator[Found]:
        single = [*self._pronouns(at), *self._described(at, deep)]
        if joined:
            begun = self._described(at + 1, deep) if self.words[at : at + 1] in (("both",), ("either",), ("neither",)) else ()
            denied = self.words[at : at + 1] == ("neither",)
            for first, end in (*begun, *single):
                for noun, last in self._joined(at, (first,), end, deep):
                    yield (replace(noun, quantity="none") if denied else noun), last
        yield from single

    def _joined(self, at: int, members: tuple[Noun, ...], end: int, deep: int) -> Iterator[Found]:
        """Yield noun phrases joined by commas, "and" or "or"."""
        if any(link.relation == "except" for link in members[-1].links):
            return  # "all but the jug and the bowl"
        for word, behind in self._conjunctions(end):
            for other, last in self.nouns(behind, deep, joined=False):
                if other.quantity == "none" != members[0].quantity:
                    continue  # "the top one, and no other"
                found = (*members, other)
                if word == ",":
                    yield from self._joined(at, found, last, deep)
                    continue
                yield Noun(self.text(at, last), members=found, joined=word, several=word == "and"), last
                if word == "and":
                    yield from self._joined(at, found, last, deep)

    def _conjunctions(self, at: int) -> Iterator[tuple[str, int]]:
        here = self.words[at : at + 4]
        for text, word in CONJUNCTIONS:
            said = tuple(text.split())
            if here[: len(said)] == said:
                more = 1 if here[len(said) : len(said) + 1] in (("also",), ("both",)) else 0
                yield word, at + len(said) + more

    def _pronouns(self, at: int) -> Iterator[Found]:
        word = self.words[at] if at < len(self.words) else ""
        after = self.words[at + 1] if at + 1 < len(self.words) else ""
        every = (("both", "of", "them"), ("all", "of", "them"), ("all", "of", "it"))
        if word == "all" and after in english.NUMBERS and self.words[at + 2 : at + 4] == ("of", "them"):
            yield Noun(self.text(at, at + 4), pronoun="them", several=True, count=english.NUMBERS[after]), at + 4
        for phrase in (*every, *((they, both) for they in ("they", "them") for both in ("both", "all"))):
            if self.words[at : at + 3][: len(phrase)] == phrase:
                yield Noun(" ".join(phrase), pronoun="them", several=True), at + len(phrase)
        alone = not after or after in self._ends or after in english.LATER or word in ("it", "them", "they")
        if word in english.PRONOUNS and alone:
            noun = Noun(word, pronoun=word, several=english.PRONOUNS[word])
            for link, end in self._related(at + 1, at + 1, 1) if after == "from" else ():
                yield replace(noun, links=(link,)), end
            yield noun, at + 1
        for end in starts(self.words, at, english.NONE):
            if self.words[end - 1] == "them" or (word == "neither" and end == at + 1 and after in self._ends):
                yield Noun(self.text(at, end), quantity="none", pronoun="them", several=True), end
        if word == "the" and after in RANKED:
            yield Noun(self.text(at, at + 2), pronoun=after), at + 2
        if word == "one" and alone and self.words[at - 1 : at] not in (("that",), ("this",)):
            yield Noun(word, quantity="a", elided=True), at + 1
        if word in ("everything", "anything", "nothing", "something") or (word == "all" and after in ("that", *self._ends)):
            quantity = {"anything": "a", "something": "a", "nothing": "none"}.get(word, "all")
            yield from self._linked(at, Noun("", english.ANYTHING, quantity), at + 1 + (after == "else"), 1)
        if word in ("those", "these"):
            yield from ((n, end) for n, end in self._linked(at, Noun("", english.ANYTHING, "all"), at + 1, 1) if n.links)
        if word in ("whichever", "whatever", "what"):
            for end in self._cores(at + 1):
                named = self._named(Noun(""), self.words[at + 1 : end])
                if named is None or not named.words:
                    continue
                for begin in starts(self.words, end, english.FINITE):
                    for link, last in self._related(begin, at, 1):
                        yield from self._linked(at, replace(named, links=(*named.links, link)), last, 1)
        if word in ("what", "whatever"):
            yield from ((n, end) for n, end in self._linked(at, Noun("", english.ANYTHING, "all"), at, 1) if n.links)
        number = english.NUMBERS.get(after, 0) if word == "all" else 0
        if number and (at + 2 >= len(self.words) or self.words[at + 2] in self._ends):
            yield Noun(f"all {after}", pronoun="them", several=True, count=number), at + 2
        if word == "both" and (after in self._ends or not after):
            yield Noun(word, pronoun="them", several=True, count=2), at + 1

    def _described(self, at: int, deep: int) -> Iterator[Found]:
        if at < len(self.words) and self.words[at] in self._names and self.words[at] in english.FUNCTION:
            yield from self._linked(at, Noun("", (self.words[at],)), at + 1, deep)
        start, noun = self._quantified(at)
        if {*self.words[start : start + 1]} & self._names & english.FUNCTION and {*self.words[start + 1 : start + 2]} <= self._ends:
            yield from self._linked(at, replace(noun, words=(self.words[start],)), start + 1, deep)
        if {*self.words[start : start + 1]} & self._names & english.FUNCTION and {*self.words[start + 1 : start + 2]} & english.FURNITURE:
            yield from self._linked(at, replace(noun, words=self.words[start : start + 2]), start + 2, deep)
        yield from self._two_sides(at, start, noun)
        for end in self._cores(start):
            named = self._named(noun, self.words[start:end])
            compared = self.words[end : end + 1] in (("from",), ("to",), ("away",)) and self.words[end - 1].endswith("est")
            if named is not None and not compared:
                yield from ((n, last) for n, last in self._linked(at, named, end, deep) if _complete(n))

    def _two_sides(self, at: int, start: int, noun: Noun) -> Iterator[Found]:
        """Yield the two noun phrases in one with two sides: "the top and bottom drawers"."""
        for end in self._cores(start):
            core = self.words[start:end]
            k = core.index("and") if "and" in core else 0
            if k and k + 1 < len(core) and core[k - 1] in english.SIDES and core[k + 1] in english.SIDES:
                found = [self._named(noun, c) for c in ((*core[:k], *core[k + 2 :]), (*core[: k - 1], *core[k + 1 :]))]
                members = tuple(replace(n, said=self.text(at, end), several=False) for n in found if n is not None and n.words)
                if len(members) == 2:
                    yield Noun(self.text(at, end), members=members, joined="and", several=True), end

    def _quantified(self, at: int) -> tuple[int, Noun]:
        """Return the position after a noun phrase's quantity, such as "all" or "two", and a noun phrase with
        that quantity."""
        words, quantity, count, k = self.words, "", 0, at
        for end in starts(words, at, english.NONE):
            return end, Noun("", quantity="none")
        while k < len(words):
            word = words[k]
            if word in english.EVERY and quantity != "a":
                quantity, count = "all", 2 if word == "both" else count
            elif word in english.NUMBERS and (quantity != "a" or words[k - 1] == "any"):
                quantity, count = "all" if quantity in ("the", "all") else "number", english.NUMBERS[word]
            elif word in english.THE or (word in english.ONE and quantity == ""):
                quantity = quantity or ("the" if word in english.THE else "a")
            elif word != "of" or k == at or not quantity:
                break
            elif quantity == "number":  # "two of the four tins"
                k += 1
                while k < len(words) and (words[k] in english.THE or words[k] in english.NUMBERS):
                    k += 1
                break
            k += 1
        return k, Noun("", quantity=quantity or "the", count=count)

    def _cores(self, start: int) -> Iterator[int]:
        """Yield the word indices at which the name of a thing may end; "yellow and white mug" has an "and"
        inside."""
        ends, k = [], start
        while k < len(self.words) and k - start < MOST and self.words[k] not in self._ends:
            k += 1
            ends.append(k)
        yield from reversed(ends)
        if ends and self.words[k : k + 1] == ("and",) and k + 1 < len(self.words) and self._alike(k - 1, k + 1):
            more = k + 1
            while more < len(self.words) and more - start < MOST and self.words[more] not in self._ends:
                more += 1
                yield more
        if not ends:
            yield start

    def _named(self, noun: Noun, core: Words) -> Noun | None:
        """Return a noun phrase for given words, such as "left white mug"; None if they name two sides or no thing."""
        k = core.index("and") if "and" in core else 0
        if k and core[k - 1] in english.SIDES:
            return None
        called = next((i for i, w in enumerate(core) if w in english.CALLED and 0 < i < len(core) - 1), 0)
        if called:  # "the basket called paper"
            return replace(noun, words=core[called + 1 :])
        kept: list[str] = []
        sides: list[str] = []
        ordinal = size = count = 0
        other = elided = False
        links: tuple[Link, ...] = ()
        for k, word in enumerate(core):
            if word in ("other", "another", "remaining"):
                other = True
            elif word in english.NUMBERS and (other or sides) and core[k - 1] not in self._names:
                count = english.NUMBERS[word]
            elif word in english.ORDINALS and not (len(core) == 1 and word in self._names):
                ordinal = english.ORDINALS[word]
            elif word in english.SIZES:
                size = english.SIZES[word]
            elif word in english.SIDES:
                sides.append(english.SIDES[word])
            elif word in self.states and k + 1 < len(core) and word not in self._names:
                links += (Link("state", (word,)),)
            elif word in english.EXTRA or (word == "far" and not any(n.startswith("far") for n in self._names)):
                elided = elided or word in ("one", "ones")
            else:
                kept.append(word)
        if not kept and not (sides or ordinal or size or other or elided):
            return None
        noun = replace(noun, links=(*noun.links, *links))
        several = (bool(kept) and english.plural(kept[-1])) or "ones" in core or count > 1
        noun = replace(noun, quantity="all", count=count) if count > 1 else noun
        elided = elided or (count > 1 and not kept)
        return replace(noun, elided=elided, words=tuple(kept), sides=tuple(sides), ordinal=ordinal, size=size, other=other, several=several)

    def _linked(self, at: int, noun: Noun, end: int, deep: int) -> Iterator[Found]:
        """Yield a noun phrase with the relations that follow it, such as "on the stove"; those with more
        relations come first."""
        if deep < DEEP and len(noun.links) < 3:
            for link, last in self._links(end, deep):
                yield from self._linked(at, replace(noun, links=(*noun.links, link)), last, deep)
            for links, last in self._parentheses(end, deep + 1):
                yield from self._linked(at, replace(noun, links=(*noun.links, *links)), last, deep + 1)
        owned = replace(noun, said=self.text(at, end))
        if self.words[end : end + 1] == ("'s",) and deep < DEEP:
            for last in self._cores(end + 1):
                part = self._named(Noun("", quantity="the"), self.words[end + 1 : last])
                if part is not None:
                    yield from self._linked(at, replace(part, links=(Link("of", ("'s",), (owned,)),)), last, deep + 1)
        yield owned, end

    def _parentheses(self, at: int, deep: int) -> Iterator[tuple[tuple[Link, ...], int]]:
        """Yield a parenthesis between commas after a noun phrase, as relations.

        Some describe the thing further (", which stands on the tray," and ", the one on the left,"); others do not (", not the blue
        one," and ", which my aunt gave me,").

        What a condition says, ", if open,", must be so.
        """
        if self.words[at : at + 1] != (",",):
            return
        found: list[tuple[tuple[Link, ...], int]] = [((link,), end) for link, end in self._links(at + 1, deep)]
        for begin in starts(self.words, at + 1, english.APPOSED):
            found += [(noun.links, end) for noun, end in self._linked(begin, Noun(""), begin, deep) if noun.links]
        for begin in starts(self.words, at + 1, english.IDENTIFIED):
            others = [(n, end) for n, end in self.nouns(begin, deep, joined=False) if n.words]
            found += [((Link("same", self.words[at + 1 : begin], (n,)),), end) for n, end in others]
        for begin in starts(self.words, at + 1, english.CONTRAST):
            found += [((), end) for _, end in self.nouns(begin, deep, joined=False) if self.words[end : end + 1] == (",",)]
        found += [((k,), e) for begin in starts(self.words, at + 1, english.CONDITIONS) for k, e in self._related(begin, at + 1, deep)]
        ends = [end for end in self._comments(at + 1) if self.words[end : end + 1] == (",",)]
        found += [((Link("comment", self.words[at + 1 : end]),), end) for end in ends]
        for links, end in found:
            if end >= len(self.words) or self.words[end] in english.STOPS:
                yield links, end + (self.words[end : end + 1] == (",",))

    def _links(self, at: int, deep: int) -> Iterator[tuple[Link, int]]:
        yield from self._excepted(at, deep)
        if self.words[at : at + 1] == (",",) and starts(self.words, at + 1, english.THAT):
            at += 1
        for begin in dict.fromkeys((*starts(self.words, at, english.THAT), at)):
            yield from self._related(begin, at, deep)

    def _related(self, begin: int, at: int, deep: int) -> Iterator[tuple[Link, int]]:
        """Yield the relations that begin at a position of a sentence, such as "on the stove" or "that is open".

        A side, state or colour alone, such as "open", is a relation only after "that is".
        """
        if begin != at and begin < len(self.words) and self.words[begin] in english.SIDES and self.words[begin + 1 : begin + 2] != ("of",):
            yield from self._side_of(self.words[begin], begin, begin + 1, deep)
        for start in dict.fromkeys((*starts(self.words, begin, english.THAT), begin)):
            yield from self._sides(start, deep)
            yield from self._relations(start, deep)
            if self.words[start : start + 1] == ("not",):
                found = self._relations(start + 1, deep)
                yield from ((replace(link, denied=True), end) for link, end in found if link.relation not in UTMOST)
        yield from ((Link("here", self.words[begin:end]), end) for end in starts(self.words, begin, english.POINTED))
        placed = self.words[begin : begin + 1] and self.words[begin] in english.PLACED and starts(self.words, begin + 1, self.prepositions)
        if begin != at and begin < len(self.words) and self.words[begin] in self.states and not placed:
            yield Link("state", (self.words[begin],)), begin + 1
        end = begin
        while end < len(self.words) and (self._is_colour(end) or (end > begin and self.words[end] == "and")):
            end += 1
        if begin != at and end > begin:
            yield Link("colour", self.words[begin:end]), end

    def _excepted(self, at: int, deep: int) -> Iterator[tuple[Link, int]]:
        """Yield the parts of a noun phrase that exclude things, such as "except the jug" in "everything except the jug"."""
        for start in starts(self.words, at + (self.words[at : at + 1] == (",",)), english.EXCEPT):
            yield from ((Link("except", self.words[at:start], (noun,)), end) for noun, end in self.nouns(start, deep + 1))

    def _alike(self, one: int, other: int) -> bool:
        """Check whether two words around an "and" are two colours or two sides."""
        both = (self.words[one], self.words[other])
        return (self._is_colour(one) and self._is_colour(other)) or all(w in english.SIDES for w in both)

    def _is_colour(self, at: int) -> bool:
        return self.words[at] in COLOURS or self.words[at] in english.SHADES

    def _sides(self, at: int, deep: int) -> Iterator[tuple[Link, int]]:
        """Yield relations that state a side: "on the left", "at the back of the table", "from the table's centre"."""
        for start in starts(self.words, at, english.AMONG):
            k = start
            while k < len(self.words) and self.words[k] in ("the", "very", "far", "most", "extreme", "your", "my"):
                k += 1
            if k < len(self.words) and self.words[k] in english.SIDES:
                yield from self._side_of(self.words[k], at, k + 1, deep)
            for whole, end in self._wholes(k):
                if end < len(self.words) and self.words[end] in english.SIDES:
                    yield Link("side", (english.SIDES[self.words[end]], self.words[at]), (whole,)), end + 1

    def _wholes(self, at: int) -> Iterator[Found]:
        """Yield the noun phrase before a word for a side or middle: "table" in "table center", "the table" in "the table's middle"."""
        for end in range(at + 1, min(at + 4, len(self.words))):
            if self.words[end - 1] in self._ends:
                return
            named = self._named(Noun(self.text(at, end)), self.words[at:end])
            if named is not None and named.words:
                yield named, end + (self.words[end] == "'s")

    def _side_of(self, word: str, at: int, end: int, deep: int) -> Iterator[tuple[Link, int]]:
        while end < len(self.words) and self.words[end] in english.ENDS:
            end += 1
        link = Link("side", (english.SIDES[word], self.words[at]))
        if self.words[end : end + 1] == ("of",):
            for noun, last in self.nouns(end + 1, deep + 1, joined=False):
                yield (link if {*noun.words[-1:]} & english.GROUPS else replace(link, nouns=(noun,))), last
        yield link, end

    def _relations(self, at: int, deep: int) -> Iterator[tuple[Link, int]]:
        words = self.words
        yield from self.beside(at, deep)
        for kind, table in (("phrase", self.prepositions), ("under", english.UNDER), ("of", english.OF)):
            for start in starts(words, at, table):
                for noun, end in self.nouns(start, deep + 1, joined=False):
                    yield Link(kind, words[at:start], (noun,)), end
        for start in starts(words, at, english.WITH):
            for noun, end in self.nouns(start, deep + 1, joined=False):
                yield from ((Link("with", words[at:start], (noun,)), last) for last in self._on_it(end))

    def beside(self, at: int, deep: int = 0) -> Iterator[tuple[Link, int]]:
        """Yield spatial relations to other things: "next to the plate", "between the cup and the jug"."""
        if self.words[at : at + 1] == (",",):
            at += 1
        for phrase, relation in english.BESIDE.items():
            if self.words[at : at + len(phrase)] == phrase:
                for noun, end in self.nouns(at + len(phrase), deep + 1, joined=relation == "between"):
                    yield Link(relation, phrase, (noun,)), end

    def _on_it(self, at: int) -> tuple[int, ...]:
        """Return the word indices at which a relation may end: the given one, and those after a redundant "on
        it", "in it" or "inside" there."""
        said = tuple(tuple(text.split()) for text in ("on it", "in it", "inside", "on top", "inside it", "on_top_of it"))
        return (*starts(self.words, at, said), at)

    def text(self, start: int, end: int) -> str:
        """Return the text of the words between two positions."""
        return spoken(self.words[start:end])


def _complete(noun: Noun) -> bool:
    """Check whether a noun phrase can name things; "the left" alone is only a side."""
    return bool(noun.words or noun.elided or noun.other or noun.ordinal or noun.size or any(link.relation == "of" for link in noun.links))


def spoken(words: Words) -> str:
    """Join the words of a sentence to text."""
    return " ".join(words).replace(" 's", "'s").replace(" ,", ",").replace("on_top_of", "on top of")
