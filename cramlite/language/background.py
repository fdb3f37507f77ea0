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
        self._placed, self._commands, self._requests = placed, commands, requests

    def tells(self, span: Words, behind: Words) -> bool:
        """Check whether words are a background clause with all that depends on it.

        Args:
            behind: words after it.
        """
        pieces = list(self._pieces(span))
        cut = behind[:1] and behind[0] in ("and", "or", "than") and not self._own(behind[1:])
        if cut or not pieces or any(w in english.ENDED for w in span[-1:]):
            return False
        first, *others = pieces
        if first[0] in english.DEPENDENT and len(first) > 2:  # ", when all the pipes froze"
            return self._past(first[1:]) and all(map(self._harmless, (first[1:], *others)))
        return self._story(first) and all(map(self._harmless, others))

    def _pieces(self, span: Words) -> Iterator[Words]:
        """Yield the clauses of a span; what has no verb of its own belongs to the clause before it."""
        start = 0
        for k in range(1, len(span)):
            if span[k] in english.CLAUSAL and self._own(span[k + 1 :]):
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
        if article or self._known(word):
            return False
        if word in english.AUXILIARY | english.STATIVE | english.PAST | english.NARRATED:
            return True
        ends = word.endswith("ed") or (word.endswith("s") and not word.endswith("ss") and not self._noun(word))
        return k > 0 and len(word) > 3 and ends and (word.endswith("ed") or piece[k - 1] not in english.PREPOSED)

    def _past(self, piece: Words) -> bool:
        at = self._finite(piece)
        if at < 0:
            return False
        word = piece[at]
        told = word in english.PAST | english.NARRATED or word in ("was", "were", "had", "did") or word.endswith("ed")
        participle = any(self._frames.participles(piece, at)) and not {*piece[:at]} & (english.PERSONS | english.POSSESSIVE)
        return told and not (participle and self._about(piece))

    def _about(self, piece: Words) -> bool:
        return any(self._known(w) or w in ("it", "them", "they", "that") for w in piece)

    def _story(self, piece: Words) -> bool:
        at = self._finite(piece)
        if at < 1 or piece[0] in english.AUXILIARY or self._commands(piece) or not self._harmless(piece):
            return False
        subject = piece[:at]
        if subject == ("there",):
            subject = piece[at + 1 : at + 6]
        bare = len(subject) < 4 and not {*subject} & (english.THE | english.ONE)
        begun = subject[0] in english.DEICTIC | english.PERSONS | english.POSSESSIVE | english.PREPOSED | english.DATED
        if not (bare or begun) or subject[-1] in english.PRONOUNS or {*piece} & {"you", "please"}:
            return False
        return not any(map(self._known, subject)) and (self._past(piece) or not any(map(self._noun, subject)))

    def _harmless(self, piece: Words) -> bool:
        """Check whether a clause can change no goal."""
        said = {*piece}
        if self._commands(piece) or said & {"please"} or ("you" in said and self._about(piece)):
            return False
        if not self._about(piece):
            return not (said & english.WISHED and self._placed(piece))
        if said & (english.WISHED | english.SPEAKING | english.OBLIGATION):
            return False
        if self._past(piece):
            return True
        person = bool({*piece[:1]} & english.PERSONS)
        if said & english.NEGATIVE and not person:
            return False
        return not self._requests(piece) and (person or not (any(map(self._known, piece)) and self._placed(piece)))
