"""Verb frames: the patterns of requests that goal phrases declare (``GoalPhrase.asked``), parsed for the grammar."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

from msgspec.structs import replace

from ..base.value import Value
from ..interpretation.fluents import GoalPhrase
from .english import BESIDE, UNDER, Words, forms, starts

AMOUNT = "AMOUNT"


class Frame(Value):
    """Verb frame: the verbs and prepositions that request one goal phrase.

    Args:
        phrase: that is asked for.
        verbs: each with its particle: (("turn",), ("on",)).
        place: whether a second thing follows.
        prepositions: before it.
        after: words behind the theme: "pull THING open".
        before: words before the theme: "pour the_contents_of VESSEL into VESSEL".
        converse: whether the place is the object of the verb: "clear PLACE", "fill PLACE with THING".
        stated: adjectives that say that it holds: "open".
        amount: whether an amount follows.
        region: whether the second thing may be a region.
        beside: whether the place may also be told by what it is beside.
    """

    phrase: GoalPhrase
    verbs: tuple[tuple[Words, Words], ...]
    place: bool = False
    prepositions: tuple[Words, ...] = ()
    after: tuple[Words, ...] = ()
    before: tuple[Words, ...] = ()
    converse: bool = False
    stated: tuple[Words, ...] = ()
    amount: bool = False
    region: bool = False
    beside: bool = False


Verb = tuple[Frame, Words, Words, int]
"""Verb found in a sentence: its frame, its words, the particle that must still follow, and the position after the verb."""


class Frames:
    """All verb frames: for each goal phrase the verbs and prepositions by which it can be requested.

    Args:
        phrases: that the plugins declare.
    """

    def __init__(self, phrases: Iterable[GoalPhrase]) -> None:
        self._all = tuple(frame for phrase in phrases for pattern in phrase.asked for frame in (_frame(phrase, pattern),))
        first = next((f.phrase for f in self._all if f.beside), None)
        self._all = tuple(replace(f, beside=f.beside and f.phrase == first) for f in self._all)
        self.placing = tuple(f for f in self._all if f.place and not f.converse)
        self.measured = tuple(f for f in self._all if f.amount)
        self.amid = tuple(replace(self.placing[0], phrase=p) for p in phrases if p.form.split()[-2:-1] == ["within"])
        self.unary = tuple(f for f in self._all if not f.place and not f.amount)
        every = {p for f in self.placing if not f.before for p in f.prepositions}
        self.prepositions = tuple(sorted(every, key=lambda p: (-len(p), p)))
        self._said = _table(self._all, participles=False)
        self._participles = _table(self._all, participles=True)

    @property
    def states(self) -> Mapping[str, str]:
        """Goal phrases about one thing by the adjective that states them: "open" -> "THING open"."""
        return {s[0]: f.phrase.form for f in self.unary for s in f.stated if len(s) == 1}

    @property
    def words(self) -> frozenset[str]:
        """Every word that occurs in a verb frame (a request pattern)."""
        found = {w for table in (self._said, self._participles) for said in table for w in said}
        found |= {w for f in self._all for v, particle in f.verbs for w in (*v, *particle)}
        return frozenset(found | {w for f in self._all for p in (*f.prepositions, *f.after, *f.stated) for w in p})

    def of_preposition(self, words: Words) -> tuple[GoalPhrase, ...]:
        """Return the goal phrases in which a preposition may stand before the place, such as "on"."""
        return tuple(dict.fromkeys(f.phrase for f in self.placing if words in f.prepositions))

    def verbs(self, words: Words, at: int) -> Iterator[Verb]:
        """Yield the verb frames (request patterns) whose verb begins at a word of a sentence, in base form or
        as a gerund."""
        return _verbs(self._said, words, at)

    def verb_ends(self, words: Words, at: int) -> tuple[int, ...]:
        """Return the end positions of the verbs that begin at a position of a sentence, longest first."""
        return tuple(dict.fromkeys(end for _, _, _, end in self.verbs(words, at)))

    def preposition_ends(self, words: Words, at: int) -> tuple[int, ...]:
        """Return the end positions of the prepositions that begin at a position of a sentence, longest
        first."""
        return tuple(sorted({*starts(words, at, self.prepositions), *starts(words, at, (*BESIDE, *UNDER))}, reverse=True))

    def participles(self, words: Words, at: int) -> Iterator[Verb]:
        """Yield the verb frames (request patterns) whose verb begins at a word of a sentence, as a past
        participle."""
        return _verbs(self._participles, words, at)


Table = Mapping[Words, tuple[tuple[Frame, Words], ...]]
"""Words of a verb -> its frames, each with the particle that is still to come."""


def _table(frames: Iterable[Frame], *, participles: bool) -> Table:
    found: dict[Words, dict[tuple[Frame, Words], None]] = {}
    for frame in frames:
        for verb, particle in frame.verbs:
            participle, gerund = forms(verb[0])
            for first in (participle,) if participles else (verb[0], gerund):
                said = (first, *verb[1:])
                found.setdefault((*said, *particle), {})[frame, ()] = None
                if particle:
                    found.setdefault(said, {})[frame, particle] = None
    return {said: tuple(rows) for said, rows in found.items()}


def _verbs(table: Table, words: Words, at: int) -> Iterator[Verb]:
    for length in (4, 3, 2, 1):
        said = words[at : at + length]
        if len(said) == length:
            yield from ((frame, said, particle, at + length) for frame, particle in table.get(said, ()))


def _split(text: str) -> Words:
    return ("on_top_of",) if text == "on_top_of" else tuple(text.split("_"))


def _frame(phrase: GoalPhrase, pattern: str) -> Frame:
    """Return the verb frame of a declared pattern of requests, such as "put|place THING on|onto PLACE"."""
    verbs, *rest = pattern.split()
    first = next(k for k, w in enumerate(rest) if w.isupper())
    before = tuple(_split(p) for w in rest[:first] for p in w.split("|"))
    converse = rest[first] != phrase.form.split()[0]
    rest = rest[first + 1 :]
    slots = [w for w in phrase.form.split()[1:] if w.isupper()]
    others = tuple(_split(p) for w in rest if not w.isupper() for p in w.split("|"))
    place, amount = bool(slots) and slots[0] != AMOUNT, AMOUNT in slots
    behind = bool(others) and not amount and (converse or not place)
    return Frame(
        phrase, tuple(_verb(v) for v in verbs.split("|")), place, others if place and not converse else (), others if behind else (),
        before, converse, () if slots else _stated(phrase, others), amount, "PLACE" in slots, "PLACE" in slots,
    )  # fmt: skip


_DIRECTIONS = frozenset({"up", "in", "out", "over", "back", "down", "there", "away", "to"})
"""Words after a thing that state where it goes, not its resulting state."""
PARTICLES = frozenset({"up", "on", "off", "out", "down", "open", "shut", "closed", "in", "over", "away", "to"})


def _verb(text: str) -> tuple[Words, Words]:
    """Split a verb from its particle, which may also follow the object: "turn on the stove", "turn the stove
    on"."""
    words = tuple(text.split("_"))
    return (words[:-1], words[-1:]) if len(words) == 2 and words[1] in PARTICLES else (words, ())


def _stated(phrase: GoalPhrase, others: tuple[Words, ...]) -> tuple[Words, ...]:
    """Return the phrases by which a sentence says that a goal about one thing is fulfilled, such as "open".

    They are the words of the goal phrase itself, and those that may follow the thing in a request.
    """
    own = tuple(w for w in phrase.form.split()[1:] if not w.isupper())
    return tuple(dict.fromkeys((own, *(o for o in others if o[-1] not in _DIRECTIONS or (len(o) > 2 and o[-1] == "up")))))
