"""Asides of a sentence, which ask for nothing: reasons, purposes, comments, and words that address somebody.

They are recognised by their form.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

from . import english
from .background import Background
from .english import Words, starts
from .frames import Frames

STAYING = (("alone",), ("where", "it", "is"), ("where", "they", "are"), ("as", "it", "is"), ("as", "they", "are"))
"""Words behind what is left as it is."""
LONG = 24
"""Words of an aside, at most."""


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
        self.words, self._frames, self._known, self._noun = words, frames, known, noun
        self._states = frames.states.keys() - english.AUXILIARY
        self._background = Background(frames, known, noun, self._placed, self._commands, self._requests)

    def ends(self, at: int) -> Iterator[int]:
        """Generate the word indices at which an aside (a remark) that begins at a given word may end, the
        longest aside first."""
        k = at
        while k < len(self.words) and self.words[k] in (*english.STOPS, "and", "but"):
            k += 1
        bounds = self._bounds(k)
        for end in range(k + 2, min(k + 4, len(self.words))):
            if end not in bounds and self.words[k] in english.TIMED and self._is_adverbial(self.words[k:end]):
                yield end
        for end in reversed(bounds):
            span = self.words[k:end]
            asked = self._open_ended(span) or self._requests(span)
            told = not self._open_ended(span) and not self._measured(span) and self._background.tells(span, self.words[end:])
            asked = asked or self._background.cut(span, self.words[end:])
            if self._is_indifferent(span) or told or (not asked and self._is_aside(span, k, end)):
                yield end
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
        for start in starts(span, 0, english.REASON):
            return self._is_reason(span[1 if span[0] in english.WHILE else start :])
        if self._is_interjection(span, at, end) or self._is_adverbial(span):
            return True
        if any(len(span) == e for e in starts(span, 0, english.SUITS)):
            return True
        opens = end < len(self.words) and self.words[end] in ("to", "that")  # "I refuse to ..."
        return not opens and self._is_statement(span, at)

    # Kinds

    def _is_reason(self, inner: Words) -> bool:
        """Check whether words tell a reason or purpose, rather than a wanted state of a thing such as "its
        handle is on the left"."""
        if not inner or inner[0] in english.AUXILIARY or self._commands(inner) or self._measured(inner) or not self._has_verb(inner):
            return False
        named = inner[0] in english.THE and any(map(self._known, inner[1:4]))
        its = named or inner[0] in english.PRONOUNS or inner[0] in ("its", "their")
        stands = any(w in self._states and inner[k] in english.AUXILIARY | english.LIGHT for k, w in enumerate(inner[1:]))
        return not (its and (stands or self._placed(inner) or {*inner} & english.ORIENTED))

    def _is_statement(self, span: Words, at: int) -> bool:
        """Check whether words only tell of people, of the past or how something is, without placing or
        asking for anything."""
        if span[0] == "that" and {*span[1:2]} & (english.PRONOUNS.keys() | english.THE | english.PERSONS):
            return self._is_reason(span[1:])  # "so that it ..."
        span = tuple(w for w in span if not adverb(w)) or span
        persons = span[0] in english.PERSONS and len(span) > 1
        verbs = [k for k in range(1, len(span)) if self._tells(span, k)] or [1] * persons
        asks = at > 0 and self.words[at - 1] in english.AUXILIARY  # "could you ..."
        if asks or not verbs or self._commands(span) or self._measured(span) or span[0] in english.AUXILIARY:
            return False
        if not (persons or span[0] in english.DEICTIC or verbs[0] == 1):
            return False
        subject, rest = span[: verbs[0]], span[verbs[0] :]
        if {*span} & english.WISHED and (self._about(span[1:]) or self._placed(span) or self._stated(span)):
            return False
        if self._background.binds(span):
            return False
        if persons:
            return not (span[0] == "you" and self._commands(tuple(w for w in span[1:] if w not in english.AUXILIARY)))
        known = any(map(self._known, subject)) or subject[0] in ("it", "they", "those", "these")
        if not known and subject[0] in english.POSSESSIVE:
            return True
        way = self._frames.preposition_ends(rest, 1)[:1]  # "is in the way of the drawer"
        acted = rest[2:3] == ("by",) and rest[1].endswith("ed") and not any(self._frames.participles(rest, 1))  # "is blocked by"
        copular = rest[0] in english.COPULAR and (not self._about(rest) or acted or any(self._abstract(rest[e:]) for e in way))
        placed = not acted and (self._placed(span) or self._stated(span))
        denied = {*span} & english.NEGATIVE and any(map(self._known, span))
        obliged = {*rest} & english.OBLIGING
        if rest[0] in english.PAST and not any(map(self._known, subject)):
            return True
        return not (placed or denied or obliged or (known and not copular))

    def _tells(self, span: Words, k: int) -> bool:
        """Check whether the word at an index is a verb, and no name of a thing in the scene."""
        return not self._known(span[k]) and self._is_verb(span, k)

    def _is_verb(self, span: Words, k: int) -> bool:
        return span[k] in english.AUXILIARY | english.STATIVE | english.PAST or _inflected(span[k], span, k)

    def _about(self, span: Words) -> bool:
        """Check whether one of the words names a thing of the scene, or is a pronoun that may stand for
        one."""
        return any(self._known(w) or w in english.PRONOUNS or w in ("its", "their") for w in span)

    def _is_indifferent(self, span: Words) -> bool:
        """Check whether words say that something does not matter or stays as it is: "never mind which way
        up", "leave it alone"."""
        starts_ = starts(span, 0, english.INDIFFERENT)
        if span[0] in ("leave", "keep") and any(span[-len(e) :] == e for e in STAYING):
            return not self._placed(span[:-3])
        return bool(starts_) and not self._measured(span[starts_[0] :])

    def _is_adverbial(self, span: Words) -> bool:
        """Check whether words are adverbs, or a phrase of purpose, time or manner: "for the guests", "in one
        go", "by tonight"."""
        if self._measured(span):
            return False
        if all(adverb(w) and not self._known(w) for w in span):
            return True
        if span[0] == "for" and len(span) > 1:
            return True
        if span[0] == "to" and len(span) > 1 and span[1] != "be" and not (self._placed(span[1:]) or self._stated(span)):
            return not any(map(self._known, span[1:2])) and span[1] not in english.THE
        like = span[0] in ("like", "as") and not any(map(self._known, span)) and not {*span} & english.NEGATIVE
        timed = span[0] in english.TIMED and singular_in(span[-1], english.ABSTRACT) and not any(map(self._known, span[1:]))
        return (like and len(span) > 1) or timed

    def _is_interjection(self, span: Words, at: int, end: int) -> bool:
        """Check whether words are an exclamation or address somebody, apart from the rest of the sentence:
        "plop!", "Robbie, ..."."""
        apart = (at == 0 or self.words[at - 1] in english.STOPS) and (end == len(self.words) or self.words[end] in english.STOPS)
        last = end == len(self.words) and len(span) == 1
        if apart and span[-1] in english.ADDRESS and not any(map(self._known, span)):
            return True
        plain = not any(self._noun(w) or w in self._frames.words or w[0].isdigit() for w in span)
        small = {*span} & (english.NEGATIVE | english.LIMITING | english.THE | english.ONE | english.EVERY | english.NUMBERS.keys())
        return len({*span}) == 1 and (apart or last) and plain and not small and not {*span} & english.SIDES.keys()

    def _matrices(self, at: int) -> Iterator[int]:
        """Yield the positions after words that introduce a request: "it would mean a lot to me if", "I was
        hoping that", "do not forget to"."""
        for k in range(at + 2, min(at + 12, len(self.words))):
            span = self.words[at:k]
            if span[-1] == ":" and not (self._placed(span) or self._stated(span) or {*span} & english.NEGATIVE):
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
        return begun and free and not denied and not adverse and not self._measured(span) and not self._placed(span)

    # What could change a goal

    def _open_ended(self, span: Words) -> bool:
        """Check whether words end with an article or the like, so that a noun must follow."""
        return span[-1] in english.THE - english.PRONOUNS.keys() | {"a", "an"} and len(span) > 1

    def _requests(self, span: Words) -> bool:
        """Check whether words contain a verb and its object, and thus a request: "so kind as to set it on
        the tray"."""
        for k in range(len(span)):
            for end in self._frames.verb_ends(span, k)[:1]:
                rest = span[end:]
                its = bool(rest) and (rest[0] in english.PRONOUNS or (rest[0] in english.THE and any(map(self._known, rest[1:4]))))
                subject = k > 0 and (span[k - 1] in english.PERSONS | english.AUXILIARY | {"not"} or adverb(span[k - 1]))
                if its and not subject and not starts(span, 0, english.INDIFFERENT):
                    return True
        return False

    def _has_verb(self, span: Words) -> bool:
        verbs = (w in english.AUXILIARY | english.STATIVE or _inflected(w, span, k) for k, w in enumerate(span) if k)
        return any(verbs) or len(span) > 2 - (span[0] in english.PERSONS)

    def _commands(self, span: Words) -> bool:
        """Check whether words begin with the verb of a request, directly or after a polite phrase."""
        ends = (*self._frames.verb_ends(span, 0), *starts(span, 0, english.SWAP))
        perfect = span[1:2] == ("have",) and any(self._frames.participles(span, 2))  # "you have left it open"
        polite = starts(span, 0, english.POLITE)[:1] if not perfect else ()
        return any(e < len(span) or e > 1 for e in ends) or any(self._frames.verb_ends(span, e) for e in polite)

    def _measured(self, span: Words) -> bool:
        units = {*english.UNITS, *english.UNITS.values()}
        return any(w in units or (w[0].isdigit() and w.strip("0123456789.") in units) for w in span)

    def _stated(self, span: Words) -> bool:
        return any(w in self._states for w in span) or any(starts(span, k, f.stated) for f in self._frames.unary for k in range(len(span)))

    def _placed(self, span: Words) -> bool:
        """Check whether words contain a place: a preposition before something that the scene has or might
        have."""
        for k in range(len(span)):
            for end in self._frames.preposition_ends(span, k)[:1]:
                rest = span[end:]
                begun = rest and (rest[0] in (*english.THE, *english.ONE, *english.PRONOUNS) or any(map(self._noun, rest[:2])))
                if begun and not self._abstract(rest):
                    return True
        return False

    def _abstract(self, rest: Words) -> bool:
        """Check whether words begin with a noun that is no thing, such as one of time or manner."""
        return any(singular_in(w, english.ABSTRACT) for w in rest[:3]) and not any(map(self._known, rest[:3]))


def adverb(word: str) -> bool:
    """Check whether a word is an adverb of manner or comment, of which none changes a goal."""
    return (len(word) > 4 and word.endswith("ly") and word not in english.LIMITING) or word in english.ADVERBS


def singular_in(word: str, words: frozenset[str]) -> bool:
    """Check whether a noun, or its singular, is in a set of words."""
    return word in words or english.singular(word) in words


def _inflected(word: str, span: Words, at: int) -> bool:
    """Whether a word looks like a verb in the past, or in the third person behind a noun."""
    return len(word) > 3 and (word.endswith("ed") or (word.endswith("s") and not word.endswith("ss") and span[at - 1] not in english.THE))
