"""Background clauses of a sentence, which tell a story and ask for nothing: "my mother hid the sweets in a tin"."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from . import english
from .english import Words
from .frames import Frames

Test = Callable[[Words], bool]


class Background:
    """Test whether words are a clause that tells a story, whatever its words are.

    It has a finite verb, and as its subject a person, "there" or something that no scene has. It could change no goal: it neither
    places, denies, wishes nor obliges anything about a thing of the scene, unless in the past.

    Args:
        frames: of all goal phrases.
        known: whether a word calls something of the scene.
        noun: whether a word calls something in any scene.
        placed, commands, requests: whether words contain a place, begin with a request, and contain one.
    """

    def __init__(
        self, frames: Frames, known: Callable[[str], bool], noun: Callable[[str], bool], placed: Test, commands: Test, requests: Test
    ) -> None:
        self._frames, self._known, self._noun = frames, known, noun
        self._states = frames.states.keys() - english.AUXILIARY
        self._placed, self._commands, self._requests = placed, commands, requests

    def tells(self, span: Words, behind: Words) -> bool:
        """Check whether words are a background clause with all that depends on it.

        Args:
            behind: words after it.
        """
        pieces = list(self._pieces(span))
        if {*span[:2]} & english.PROVIDING:
            return False
        if self.cut(span, behind) or not pieces or any(w in english.ENDED for w in span[-1:]):
            return False
        first, *others = pieces
        stop = next((k for k, w in enumerate(behind) if w in english.STOPS), 0)
        if "so" in behind[: stop + 2] and not others and self._needs(first):
            return True
        if first[0] in english.DEPENDENT and len(first) > 2:  # ", when all the pipes froze"
            strange = first[1] in english.PERSONS or not self._about(first)
            lasts = {*first} & english.PERFECT - {"had"}
            return strange and not lasts and self._past(first[1:]) and all(map(self._harmless, (first[1:], *others)))
        return self._story(first) and all(map(self._harmless, others))

    def cut(self, span: Words, behind: Words) -> bool:
        """Check whether a story may go on behind its words: "somebody moved the can and (the mug | put the mug on the tray)"."""
        goes_on = behind[:1] in (("and",), ("or",), ("than",)) and len(behind) > 1
        again = goes_on and any(self._frames.participles(behind, 1)) and any(self._frames.verbs(behind, 1)) and self._past(span)
        return again or (goes_on and self._finite(span) > 0 and not self._own(behind[1:]))

    def _needs(self, piece: Words) -> bool:
        """Check whether a clause before "so" wants something that no scene has: "I want some air in that cabinet"."""
        at = next((k for k, w in enumerate(piece) if w in english.WISHED), 0)
        thing = piece[at + 1 : at + 4]
        end = next((k for k in range(len(thing)) if self._frames.preposition_ends(thing, k)), len(thing))
        wanted = [w for w in thing[:end] if w not in english.THE | english.ONE and w not in english.SMALL]
        begun = piece[0] in ("i", "we") and 0 < at < 3 and not {*piece} & english.NEGATIVE
        free = piece[at + 1 : at + 2] != ("to",) and not {*piece} & self._states
        things = any((self._noun(w) and w not in english.STATIVE) or w in english.PRONOUNS for w in wanted)
        return begun and free and bool(wanted) and not things

    def _pieces(self, span: Words) -> Iterator[Words]:
        """Yield the clauses of a span; what has no verb of its own belongs to the clause before it."""
        start = 0
        for k in range(1, len(span)):
            relative = span[k] in english.RELATIVE and self._finite(span[start:k]) < 0  # "a stack that is out of true comes down"
            own = self._own(span[k + 1 :]) or (span[k] in english.RELATIVE and k + 1 < len(span) and self._verb(span, k + 1))
            if span[k] in english.CLAUSAL and not relative and own:
                yield span[start:k]
                start = k + 1
        if start < len(span):
            yield span[start:]

    def _own(self, words: Words) -> bool:
        """Check whether a clause with its own verb begins: "the jug was empty", but not "the jug in the drawer"."""
        end = next((k for k, w in enumerate(words) if w in english.STOPS or (k and w in english.CLAUSAL)), len(words))
        begun = words[0] in english.THE | english.ONE | english.EVERY or self._noun(words[0]) if end else True
        return not begun or self._finite(words[:end]) > 0

    def _finite(self, piece: Words) -> int:
        """Return the index of the first finite verb; -1 if there is none."""
        return next((k for k in range(len(piece)) if self._verb(piece, k)), -1)

    def _verb(self, piece: Words, k: int) -> bool:
        word = piece[k]
        article = k > 0 and piece[k - 1] in english.THE | english.ONE
        if word in english.AUXILIARY and k and piece[k - 1] not in english.THE - english.PRONOUNS.keys():
            return True
        if article or self._known(word):
            return False
        if word in english.AUXILIARY | english.STATIVE | english.PAST | english.NARRATED | english.NARRATING:
            return True
        ends = word.endswith("ed") or (word.endswith("s") and not word.endswith("ss") and not self._noun(word))
        return k > 0 and len(word) > 3 and ends and (word.endswith("ed") or piece[k - 1] not in english.PREPOSED)

    def _past(self, piece: Words) -> bool:
        at = self._finite(piece)
        if at < 0:
            return False
        word = piece[at]
        perfect = word in english.PERFECT and any(self._done(w) for w in piece[at + 1 : at + 4])
        if perfect:
            return True
        told = word in english.PAST | english.NARRATED or word in ("was", "were", "had", "did") or word.endswith("ed")
        participle = any(self._frames.participles(piece, at)) and not {*piece[:at]} & (english.PERSONS | english.POSSESSIVE)
        return told and not (participle and self._about(piece))

    def _done(self, word: str) -> bool:
        return word.endswith("ed") or word in english.PAST | english.NARRATED | {"been"} or any(self._frames.participles((word,), 0))

    def _about(self, piece: Words) -> bool:
        relative = {k for k, w in enumerate(piece) if w == "that" and k + 1 < len(piece) and self._verb(piece, k + 1)}
        those = (w in ("it", "them", "they", "that") and k not in relative for k, w in enumerate(piece))
        named = any(w in ("one", "ones", "same") and not (k and piece[k - 1] in english.ONE) for k, w in enumerate(piece))
        return any(map(self._known, piece)) or named or any(those)

    def _story(self, piece: Words) -> bool:
        at = self._finite(piece)
        if at < 1 or piece[0] in english.AUXILIARY or self._commands(piece) or not self._harmless(piece):
            return False
        if {*piece[:at]} <= english.ADVERBS | english.CLAUSAL or (piece[0].startswith(("wh", "how")) and piece[0] != "who"):
            return False
        subject = piece[:at]
        if subject == ("there",):
            subject = piece[at + 1 : at + 6]
        subject = subject[:-1] if len(subject) > 1 and subject[-1] in english.RELATIVE else subject
        people = {*subject} & (english.PERSONS | english.POSSESSIVE)
        rest = tuple(w for w in piece[at + 1 :] if w not in english.ADVERBS and not w.endswith("ly"))
        if piece[at].endswith("ed") and not people and (not rest or rest[0] in english.PREPOSED):
            return False  # "the napkin folded" may be asked for
        bare = len(subject) < 4 and not {*subject} & (english.THE | english.ONE)
        begun = subject[0] in english.DEICTIC | english.PERSONS | english.POSSESSIVE | english.PREPOSED | english.DATED
        if not (bare or begun) or (len(subject) == 1 and subject[0] in {*english.PRONOUNS, "one", "ones"}) or {*piece} & {"you", "please"}:
            return False
        strange = not any(map(self._noun, subject)) or not (self._about(piece) or self._placed(piece) or {*piece} & self._states)
        return not self._about(subject) and (self._past(piece) or strange)

    def binds(self, piece: Words) -> bool:
        """Check whether a clause about a thing of the scene forbids something or reports a request: "nobody may open the drawer"."""
        said = {*piece}
        forbids = bool(said & english.NEGATIVE and said & english.MODAL)
        spoken = {*piece[1:4]} & english.SPEAKING if piece[0] not in ("i", "we") else frozenset()
        reports = bool(spoken and (said & (english.OBLIGATION | {"to", "for"}) or (self._placed(piece) and not self._past(piece))))
        hopes = bool(said & english.PLEASED and (self._placed(piece) or said & self._states))
        return any(map(self._known, piece)) and bool(forbids or reports or hopes or said & english.INTENDED)

    def _harmless(self, piece: Words) -> bool:
        """Check whether a clause can change no goal."""
        said = {*piece}
        if self._commands(piece) or said & {"please"} or ("you" in said and self._about(piece)):
            return False
        if not self._about(piece):
            dislikes = said & english.NEGATIVE and "like" in said
            return bool(dislikes) or not (said & english.WISHED and self._placed(piece))
        past = self._past(piece)
        wished = english.WISHED - {"like"} if past else english.WISHED
        if said & (wished | english.SPEAKING | english.OBLIGATION):
            return False
        if past:
            return True
        person = bool({*piece[:1]} & english.PERSONS)
        if said & english.NEGATIVE and not person:
            return False
        return not self._requests(piece) and (person or not (any(map(self._known, piece)) and self._placed(piece)))
