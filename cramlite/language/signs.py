"""Signs in the words of a clause: its verb and tense, and whether it names, places, wishes or asks for something."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from . import english
from .english import Words, starts
from .frames import Frames

REPORTED = ("to", "for", *english.OBLIGATION)
"""Words after a verb of speaking by which the reported speech is a request."""


class Signs:
    """Detector of grammatical signs in a clause, such as a command or a place, from its words in any order.

    Args:
        frames: of all goal phrases.
        known: whether a word calls something of the scene.
        noun: whether a word calls something in any scene.
    """

    def __init__(self, frames: Frames, known: Callable[[str], bool], noun: Callable[[str], bool]) -> None:
        self.frames, self.known, self.noun = frames, known, noun
        self._states = frames.states.keys() - english.AUXILIARY

    def of(self, piece: Words) -> Iterator[str]:
        """Yield the signs of a clause, each by its name in ``english.BINDING``."""
        said, piece = {*piece}, tuple(w for w in piece if not adverb(w)) or piece
        at = self.finite(piece)
        subject = piece[: max(at, 0)]
        subject = subject[:-1] if len(subject) > 1 and subject[-1] in english.RELATIVE else subject
        person = bool({*piece[:1]} & english.PERSONS) or (bool({*piece[:1]} & english.POSSESSIVE) and not any(map(self.known, subject)))
        yield "past" if self.past(piece) else "present"
        yield "person" if person else "impersonal"
        named = {name: said & words for name, words in _NAMED.items()}
        tests = {
            "command": self.commands(piece), "request": self.requests(piece), "amount": self.measured(piece), "place": self.placed(piece),
            "state": self.stated(piece), "about": self.about(piece), "wish": self._wishes(piece),
            "reported": self._reports(piece), "condition": bool({*piece[:2]} & english.PROVIDING),
            "known": any(map(self.known, subject)), "pronoun": self.about(subject),
            "noun": any(self.noun(w) and not self.known(w) for w in subject),
            "named": any(map(self.known, piece)), "stands": self._stands(piece),
            "act": at >= 0 and self._acts(piece[at:]),
            "participle": at > 0 and piece[at].endswith("ed") and not self._people(subject) and self._ends(piece[at + 1 :]),
        }  # fmt: skip
        yield from (name for name, true in (*named.items(), *tests.items()) if true)

    # Verbs

    def finite(self, piece: Words) -> int:
        """Return the index of the first finite verb; -1 if there is none. Behind a pronoun for a person any word may be one."""
        found = next((k for k in range(len(piece)) if self.verb(piece, k)), -1)
        return 1 if found < 0 and len(piece) > 1 and piece[0] in english.PERSONS else found

    def verb(self, piece: Words, k: int) -> bool:
        """Check whether the word at an index may be a finite verb, and names nothing of the scene."""
        word = piece[k]
        if word in english.AUXILIARY and k and piece[k - 1] not in english.THE - english.PRONOUNS.keys():
            return True
        if self.known(word) or (k and piece[k - 1] in english.THE | english.ONE):
            return False
        if word in english.AUXILIARY | english.STATIVE | english.PAST | english.NARRATED | english.NARRATING:
            return True
        third = word.endswith("s") and not word.endswith("ss") and not self.noun(word) and piece[k - 1] not in english.PREPOSED
        return k > 0 and len(word) > 3 and (word.endswith("ed") or third)

    def past(self, piece: Words) -> bool:
        """Check whether the clause is about the past."""
        at = self.finite(piece)
        if at < 0:
            return False
        if piece[at] in english.PERFECT and any(self._done(w) for w in piece[at + 1 : at + 4]):
            return True
        active = {*piece[at + 1 : at + 2]} & (english.THE | english.ONE | english.EVERY)  # "facilities left that stool there"
        participle = any(self.frames.participles(piece, at)) and not active and not self._people(piece[:at])
        return self._told(piece[at]) and not (participle and self.about(piece))

    def _told(self, word: str) -> bool:
        return word in english.PAST | english.NARRATED or word.endswith("ed")

    def _done(self, word: str) -> bool:
        return self._told(word) or word == "been" or any(self.frames.participles((word,), 0))

    def _people(self, subject: Words) -> bool:
        return bool({*subject} & (english.PERSONS | english.POSSESSIVE))

    def _acts(self, rest: Words) -> bool:
        """Check whether a verb says more of its subject than how it is: "is next to the tin", but not "is in the way of the tin"."""
        way = any(self.abstract(rest[end:]) for end in self.frames.preposition_ends(rest, 1)[:1])
        done = rest[2:3] == ("by",) and rest[1].endswith("ed") and not any(self.frames.participles(rest, 1))  # "is blocked by"
        return rest[0] not in english.COPULAR or (any(self.known(w) or w in english.STANDING for w in rest) and not way and not done)

    def _reports(self, piece: Words) -> bool:
        """Check whether a clause reports what another one asks for: "my wife asked for the tin"."""
        spoken = {*piece[1:4]} & english.SPEAKING and piece[0] not in ("i", "we")
        return bool(spoken) and (bool({*piece} & {*REPORTED}) or (self.placed(piece) and not self.past(piece)))

    def _ends(self, rest: Words) -> bool:
        rest = tuple(w for w in rest if not adverb(w))
        return not rest or rest[0] in english.PREPOSED  # "the napkin folded" may be asked for

    def clauses(self, span: Words) -> Iterator[Words]:
        """Yield the clauses of a span; what has no verb of its own belongs to the clause before it."""
        start = 0
        for k in range(1, len(span)):
            relative = span[k] in english.RELATIVE and self.finite(span[start:k]) < 0  # "a stack that is out of true comes down"
            own = self.own(span[k + 1 :]) or (span[k] in english.RELATIVE and k + 1 < len(span) and self.verb(span, k + 1))
            if span[k] in english.CLAUSAL and not relative and own:
                yield span[start:k]
                start = k + 1
        if start < len(span):
            yield span[start:]

    def own(self, words: Words) -> bool:
        """Check whether a clause with its own verb begins: "the jug was empty", but not "the jug in the drawer"."""
        end = next((k for k, w in enumerate(words) if w in english.STOPS or (k and w in english.CLAUSAL)), len(words))
        begun = words[0] in english.THE | english.ONE | english.EVERY or self.noun(words[0]) if end else True
        return not begun or self.finite(words[:end]) > 0

    # What could change a goal

    def about(self, piece: Words) -> bool:
        """Check whether words name a thing of the scene, or may stand for one."""
        those = (w in english.STANDING or (k and w == "that" and {*piece[k + 1 :][:1]} <= english.PREPOSED) for k, w in enumerate(piece))
        named = (w in ("one", "ones", "same") and not (k and piece[k - 1] in english.ONE) for k, w in enumerate(piece))
        return any(map(self.known, piece)) or any(named) or any(those)

    def commands(self, span: Words) -> bool:
        """Check whether words begin with the verb of a request, directly or after a polite phrase."""
        ends = (*self.frames.verb_ends(span, 0), *starts(span, 0, english.SWAP))
        perfect = span[1:2] == ("have",) and any(self.frames.participles(span, 2))  # "you have left it open"
        polite = starts(span, 0, english.POLITE)[:1] if not perfect else ()
        return any(e < len(span) or e > 1 for e in ends) or any(self.frames.verb_ends(span, e) for e in polite)

    def requests(self, span: Words) -> bool:
        """Check whether words contain a verb and its object, and thus a request: "so kind as to set it on the tray"."""
        for k in range(len(span)):
            subject = k > 0 and (span[k - 1] in english.PERSONS | english.AUXILIARY | {"not"} or adverb(span[k - 1]))
            for end in self.frames.verb_ends(span, k)[:1] if not subject else ():
                rest = span[end:]
                if rest and (rest[0] in english.PRONOUNS or (rest[0] in english.THE and any(map(self.known, rest[1:4])))):
                    return True
        return False

    def measured(self, span: Words) -> bool:
        """Check whether words contain an amount with its unit."""
        units = {*english.UNITS, *english.UNITS.values()}
        return any(w in units or (w[0].isdigit() and w.strip("0123456789.") in units) for w in span)

    def stated(self, span: Words) -> bool:
        """Check whether words contain a state that a goal may ask for, such as "open"."""
        return any(w in self._states or starts(span, k, f.stated) for k, w in enumerate(span) for f in self.frames.unary)

    def _stands(self, piece: Words) -> bool:
        helping = english.AUXILIARY | english.LIGHT
        ways = [f.stated for f in self.frames.unary]
        return any(w in helping and any(starts(piece, k + 1, way) for way in ways) for k, w in enumerate(piece))

    def placed(self, span: Words) -> bool:
        """Check whether words contain a place: a preposition before something that the scene has or might have."""
        for k in range(len(span)):
            for end in self.frames.preposition_ends(span, k)[:1]:
                rest = span[end:]
                begun = rest and (rest[0] in english.STANDING | {*english.PRONOUNS} - english.THE or any(map(self.noun, rest[:4])))
                if begun and not self.abstract(rest) and not (span[k] == "to" and self.frames.verb_ends(rest, 0)):
                    return True
        return False

    def abstract(self, rest: Words) -> bool:
        """Check whether words begin with a noun that is no thing, such as one of time or manner."""
        return any(singular_in(w, english.ABSTRACT) for w in rest[:3]) and not any(map(self.known, rest[:3]))

    def _wishes(self, piece: Words) -> bool:
        """Check whether a clause wishes for a thing, and not for what no scene has: "I want some air in that cabinet"."""
        own = english.PERSONS | english.AUXILIARY
        at = next((k for k, w in enumerate(piece) if w in english.WISHED and (w != "like" or {*piece[:k][-1:]} & own)), -1)
        thing = piece[at + 1 : at + 4]
        end = next((k for k in range(len(thing)) if self.frames.preposition_ends(thing, k)), len(thing))
        wanted = [w for w in thing[:end] if w not in english.SMALL - english.PRONOUNS.keys()]
        some = any((self.noun(w) and w not in english.STATIVE) or w in english.PRONOUNS for w in wanted)
        return bool(thing) and at >= 0 and (some or not wanted or thing[0] in english.THE | {"to"})


_NAMED = {
    "denial": english.NEGATIVE, "duty": english.OBLIGATION | english.OBLIGING, "speech": english.SPEAKING, "may": english.MODAL,
    "please": frozenset({"please"}), "you": frozenset({"you"}), "meant": english.INTENDED, "glad": english.PLEASED,
    "lasts": english.PERFECT - {"had"},
}  # fmt: skip
"""Sign of a clause -> the words of which each alone is that sign."""


def adverb(word: str) -> bool:
    """Check whether a word is an adverb of manner or comment, of which none changes a goal."""
    return (len(word) > 4 and word.endswith("ly") and word not in english.LIMITING) or word in english.ADVERBS


def singular_in(word: str, words: frozenset[str]) -> bool:
    """Check whether a noun, or its singular, is in a set of words."""
    return word in words or english.singular(word) in words
