"""Asides of a sentence, which ask for nothing: reasons, purposes, stories, comments, and words that address somebody.

They are recognised by their form.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

from . import english
from .english import Words, starts
from .frames import Frames
from .signs import Signs, adverb, singular_in

STAYING = (("alone",), ("where", "it", "is"), ("where", "they", "are"), ("as", "it", "is"), ("as", "they", "are"))
"""Endings of requests to leave a thing as it is, such as "leave it alone"."""
LONG = 24
"""Largest number of words in an aside."""


class Asides:
    """Finder of the asides in one sentence: parts that ask for nothing, such as reasons, comments and words
    that address somebody.

    What could change a goal is no aside: a place, a state, an amount, or what is asked for or denied.

    Args:
        words: of the sentence.
        frames: of all goal phrases.
        known: whether a word calls something of the scene.
        noun: whether a word calls something in any scene.
    """

    def __init__(self, words: Words, frames: Frames, known: Callable[[str], bool], noun: Callable[[str], bool]) -> None:
        can = (w == "can" and {*words[k - 1 : k]} & english.PERSONS for k, w in enumerate(words))  # "I can see it" names no can
        self.words = tuple("could" if modal else word for word, modal in zip(words, can, strict=True))
        self._frames, self._known, self._noun = frames, known, noun
        self._signs = Signs(frames, known, noun)

    def comments(self, at: int) -> Iterator[int]:
        """Generate the word indices at which an aside that begins at a given word ends at punctuation."""
        ends = (k for k in self._bounds(at)[-1:] if k < len(self.words) and self._is_aside(self.words[at:k], at, k))
        yield from ends

    def ends(self, at: int) -> Iterator[int]:
        """Generate the word indices at which an aside (a remark) that begins at a given word may end, the
        longest aside first."""
        k = at
        while k < len(self.words) and self.words[k] in (*english.STOPS, "and", "but"):
            k += 1
        bounds = self._bounds(k)
        for end in range(k + 2, min(k + 5, len(self.words))):
            if end not in bounds and self.words[k] in english.TIMED and self._is_adverbial(self.words[k:end]):
                yield end
        yield from (end for end in reversed(bounds) if self._is_aside(self.words[k:end], k, end))
        yield from self._matrices(k)

    def _bounds(self, at: int) -> list[int]:
        """Return the word indices at which an aside (a remark) that begins at a given word may end: at
        punctuation, or at a word that joins clauses."""
        found = []
        for k in range(at + 1, min(at + LONG, len(self.words)) + 1):
            stop = k == len(self.words) or self.words[k] in english.STOPS
            if stop or self.words[k] in english.JOINTS:
                found.append(k)
            if stop:
                break
        return found

    def _is_aside(self, span: Words, at: int, end: int) -> bool:
        if self._is_indifferent(span):
            return True
        stops = end == len(self.words) or self.words[end] in english.STOPS
        if (span[-1] in english.ENDED and not stops) or self._goes_on(span, self.words[end:]):
            return False
        if self._is_interjection(span, at, end) or self._is_adverbial(span) or any(len(span) == e for e in starts(span, 0, english.SUITS)):
            return True
        asked = at > 0 and self.words[at - 1] in english.AUXILIARY  # "could you ..."
        opens = end < len(self.words) and self.words[end] in ("to", "that")  # "I refuse to ..."
        return not (asked or opens) and self._is_clause(span, expletive=not any(map(self._known, self.words[:end])))

    def _is_clause(self, span: Words, *, expletive: bool) -> bool:
        """Check whether words are clauses that give a reason or tell a story, or how something is.

        ``expletive`` says that "it" stands for nothing in them, since no thing was named before: "it will freeze tonight".
        """
        first, *others = self._signs.clauses(span)
        inner, opened = self._opened(first)
        if expletive:
            inner, *others = (tuple("she" if w in english.STANDING else w for w in piece) for piece in (inner, *others))
        signs = {*self._signs.of(inner), *(opened or ("main",))}
        if not (opened or (self._has_subject(inner) and not _binds(signs, english.ALONE))):
            return False
        return not _binds(signs) and not any(_binds({*self._signs.of(piece), "main"}) for piece in others)

    def _opened(self, piece: Words) -> tuple[Words, tuple[str, ...]]:
        """Return a clause without the word that joins it to another one, and signs of how it is joined."""
        for start in starts(piece, 0, english.REASON):
            inner = piece[1 if piece[0] in english.WHILE else start :]
            return (inner, ("reason", *(("oriented",) if {*inner} & english.ORIENTED else ()))) if inner else (piece, ("command",))
        if piece[0] == "that" and {*piece[1:2]} & (english.PRONOUNS.keys() | english.THE | english.PERSONS):
            return piece[1:], ("reason", *(("oriented",) if {*piece} & english.ORIENTED else ()))
        return (piece[1:], ("dependent",)) if piece[0] in english.DEPENDENT and len(piece) > 2 else (piece, ())

    def _has_subject(self, piece: Words) -> bool:
        """Check whether words begin with what may be the subject of their verb."""
        at = self._signs.finite(piece)
        if at < 1 or piece[0] in english.AUXILIARY or {*piece[:at]} <= english.ADVERBS | english.CLAUSAL - english.DEICTIC:
            return False
        begun = piece[0] in english.DEICTIC | english.PERSONS | english.POSSESSIVE | english.PREPOSED | english.DATED
        return begun or (at < 4 and not {*piece[:at]} & (english.THE | english.ONE))

    def _goes_on(self, span: Words, behind: Words) -> bool:
        """Check whether a story may continue after the given words: "somebody moved the can and (the mug | put the mug on the tray)"."""
        goes_on = behind[:1] in (("and",), ("or",), ("than",)) and len(behind) > 1
        again = goes_on and any(self._frames.participles(behind, 1)) and any(self._frames.verbs(behind, 1)) and self._signs.past(span)
        return again or (goes_on and self._signs.finite(span) > 0 and not self._signs.own(behind[1:]))

    def _is_indifferent(self, span: Words) -> bool:
        """Check whether words say that something does not matter or stays as it is: "never mind which way
        up", "leave it alone"."""
        starts_ = starts(span, 0, english.INDIFFERENT)
        if span[0] in ("leave", "keep") and any(span[-len(e) :] == e for e in STAYING):
            return not self._signs.placed(span[:-3])
        return bool(starts_) and not self._signs.measured(span[starts_[0] :])

    def _is_adverbial(self, span: Words) -> bool:
        """Check whether words are adverbs, or a phrase of purpose, time or manner: "for the guests", "in one
        go", "by tonight"."""
        if self._signs.measured(span):
            return False
        if all(adverb(w) and not self._known(w) for w in span):
            return True
        if span[0] == "for" and len(span) > 1:
            return True
        if span[0].endswith("ing") and len(span) > 1 and not (self._signs.about(span) or any(map(self._noun, span))):
            return not self._signs.commands(span)  # "being a careful man"
        if span[0] == "to" and len(span) > 1 and span[1] != "be" and not (self._signs.placed(span[1:]) or self._signs.stated(span)):
            return not any(map(self._known, span[1:2])) and span[1] not in english.THE
        like = span[0] in ("like", "as") and not any(map(self._known, span)) and not {*span} & english.NEGATIVE
        timed = span[0] in english.TIMED and singular_in(span[-1], english.ABSTRACT) and not any(map(self._known, span[1:]))
        return (like and len(span) > 1) or timed

    def _is_interjection(self, span: Words, at: int, end: int) -> bool:
        """Check whether words are an exclamation or address somebody, apart from the rest of the sentence:
        "plop!", "Robbie, ..."."""
        apart = (at == 0 or self.words[at - 1] in english.STOPS) and (end == len(self.words) or self.words[end] in english.STOPS)
        last = end == len(self.words) and len(span) == 1
        if apart and singular_in(span[-1], english.ADDRESS) and not any(map(self._known, span)):
            return True
        times = any(singular_in(w, english.ABSTRACT) for w in span) and not {*span} & english.NEGATIVE and self._sentence(at, end)
        if times and not self._signs.commands(span) and not self._signs.about(span) and not self._signs.stated(span):
            told = (w for w in span if w not in english.SMALL | english.TIMED and not singular_in(w, english.ABSTRACT))
            return not any(map(self._noun, told))  # "Guests at eight."
        plain = not any(self._noun(w) or w in self._frames.words or w[0].isdigit() for w in span)
        small = {*span} & (english.NEGATIVE | english.LIMITING | english.THE | english.ONE | english.EVERY | english.NUMBERS.keys())
        return len({*span}) == 1 and (apart or last) and plain and not small and not {*span} & english.SIDES.keys()

    def _sentence(self, at: int, end: int) -> bool:
        """Check whether words are a sentence of their own, between full stops."""
        ends = english.STOPS - {","}
        return (at == 0 or self.words[at - 1] in ends) and (end == len(self.words) or self.words[end] in ends)

    def _matrices(self, at: int) -> Iterator[int]:
        """Yield the positions after words that introduce a request: "it would mean a lot to me if", "I was
        hoping that", "do not forget to"."""
        for k in range(at + 2, min(at + LONG, len(self.words))):
            span = self.words[at:k]
            if span[-1] == ":" and not (self._signs.placed(span) or self._signs.stated(span) or {*span} & english.NEGATIVE):
                yield k
            if self.words[k - 1] in english.STOPS:
                return
            noun = self.words[k - 1] == "that" and self._known(self.words[k])
            if self.words[k - 1] in english.OPENS and not noun and self._is_matrix(self.words[at : k - 1]):
                yield k

    def _is_matrix(self, span: Words) -> bool:
        begun = span[0] in english.PERSONS | english.MATRIX
        denied = {*span} & english.NEGATIVE and not {*span} & english.FORGETTING
        adverse = {*span} & english.ADVERSE and not ({*span} & english.NEGATIVE or {*span} & {"mind"})
        free = not any(self._known(w) for w in span if w not in english.AUXILIARY | english.PERSONS)
        return begun and free and not denied and not adverse and not self._signs.measured(span) and not self._signs.placed(span)


def _binds(signs: set[str], table: tuple[frozenset[str], ...] = english.BINDING) -> bool:
    return any(together <= signs for together in table)

