"""Understanding of sentences: every reading of the grammar is tried on the scene, and the only one that makes sense is taken."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import TYPE_CHECKING

from ..base.errors import UserError
from ..base.value import Value
from . import english
from .clauses import ClauseParser
from .frames import Frames
from .free import FreeParser
from .labels import Labels
from .meanings import Literal
from .reading import Reading
from .reference import Resolver
from .refusal import ABSENT, OPEN, UNKNOWN, Refusal, listed
from .space import Space, view_of
from .surface import Surface
from .tree import Clause

if TYPE_CHECKING:
    from ..interpretation.fluents import Fluents, SymbolicWorld

LONGEST = 60
"""Largest number of words in a sentence that is read."""


class Understood(Value):
    """Sentence with the goals that it was understood to mean.

    Args:
        sentence: as it was said.
        literals: the goals; all of them shall hold.
        by: who understood it.
        view: from where left and right were told; "" if that played no part.
        left_out: words that ask for nothing.
    """

    sentence: str
    literals: tuple[Literal, ...]
    by: str = "grammar"
    view: str = ""
    left_out: tuple[str, ...] = ()

    @property
    def goals(self) -> tuple[str, ...]:
        """Goals in the goal language, each once."""
        return tuple(dict.fromkeys(one.goal for one in self.literals))


class NotUnderstood(UserError):
    """Refusal of a sentence that is not understood: ambiguous, untrue in the scene, or with unknown words.

    Args:
        text: what there is, and what to say.
        open: whether it names nothing that is known, so that another reader may know more.
        ambiguous: whether it may mean several things that there are.
    """

    def __init__(self, text: str, *, open: bool = False, ambiguous: bool = False) -> None:
        super().__init__(text)
        self.open, self.ambiguous = open, ambiguous


def understand(sentence: str, scene: SymbolicWorld, fluents: Fluents, view: str = "") -> Understood:
    """Return the goals that a sentence means in a scene.

    Args:
        fluents: with the goal phrases.
        view: from where left and right are told: "robot", "camera" or a point; by default that of a fixed camera, else the robot's.

    Raises:
        NotUnderstood: it is ambiguous, false of the scene, or not in the words of the grammar; says what to say.
    """
    words, view = _viewed(english.tokens(sentence), view)
    _check_words(sentence, words)
    frames, space = Frames(fluents.phrases), Space(scene.world, view_of(scene.world, view))
    resolver = Resolver(scene, fluents.initial(scene), frames, Labels(scene), space)
    refused: list[Refusal] = []
    names = resolver.labels.names
    variants = Surface(names, resolver.labels.kinds, frames.verb_ends, frames.preposition_ends).variants(words)
    parsers: list[ClauseParser] = [ClauseParser(variant, frames, names) for variant in variants]
    found = _meanings(parsers, resolver, fluents, refused)
    if not found:
        parsers = [FreeParser(variant, frames, resolver.labels) for variant in variants]
        found = _meanings(parsers, resolver, fluents, [] if refused else refused, free=True)
    words, parser = variants[0], parsers[0]
    if len(found) == 1:
        literals, left_out = next(iter(found.values()))
        return Understood(sentence, literals, left_out=left_out, view=space.view.name if english.SIDES.keys() & set(words) else "")
    if found:
        texts = [f"'{' and '.join(one.goal for one in literals)}'" for literals, _ in found.values()]
        raise NotUnderstood(f"'{sentence}' may mean {listed(texts)}; say it in shorter sentences, or name the things.", ambiguous=True)
    raise _refusal(sentence, words, parser, resolver, refused)


def cancels(sentence: str) -> bool:
    """Return whether a sentence asks the robot to do nothing more: each of its parts between full stops asks to stop, or says that the task
    is called off, and none asks for anything else."""
    words = [w for w in english.tokens(sentence) if w not in {*english.STOPS - {".", "!", ";"}, "please", "now"}]
    parts = [p.split() for p in re.split(r" ?[.!;] ?", " ".join(words)) if p]
    asks_more = {"and", "then", "instead", "but"}
    states = english.THE | english.STANDING | english.PRONOUNS.keys() | {"everything", "task"}
    stops = (p[0] in english.HALT or (p[0] in states and p[-1] in english.CALLED_OFF) for p in parts)
    return bool(parts) and all(stops) and not asks_more & set(words)


def _meanings(
    parsers: Sequence[ClauseParser], resolver: Resolver, fluents: Fluents, refused: list[Refusal], *, free: bool = False
) -> dict[tuple[str, ...], tuple[tuple[Literal, ...], tuple[str, ...]]]:
    """Return the goals of each reading of a sentence that makes sense in the scene; collect why the others do not.

    With the goals come the words from which they were understood, and those that were left out.

    As little as possible is left out, and a description says no more than it takes to tell a thing apart: of several readings, those
    that leave out the fewest words, then those with the fewest needless relations.
    """
    found: dict[tuple[str, ...], tuple[tuple[int, int, int], tuple[Literal, ...], tuple[str, ...]]] = {}
    for parser, clauses in ((p, clauses) for p in parsers for clauses in p.readings(brief=free)):
        resolver.fresh()
        reading = Reading(resolver, fluents, free=free)
        try:
            literals = reading.literals(clauses)
            key = tuple(sorted(one.goal for one in literals))
            left_out = tuple(said for c in clauses for said in _left_out(c) if said)
            cost = sum(len(said.split()) for said in left_out), sum(c.bare for c in clauses), resolver.needless
            if key not in found or cost < found[key][0]:
                found[key] = cost, literals, left_out
        except Refusal as refusal:
            refused.append(refusal)
            parser.drop(tuple(clauses[: reading.at + 1]))
    least = min((cost for cost, *_ in found.values()), default=(0, 0, 0))
    return {goals: (literals, left_out) for goals, (cost, literals, left_out) in found.items() if cost == least}


def _left_out(clause: Clause) -> tuple[str, ...]:
    """Return the words of a clause that ask for nothing."""
    comments = clause.theme.comments + (clause.place.comments if clause.place is not None else ())
    return (clause.said if clause.relation in ("aside", "ahead") else "", clause.odd, *comments)


def _viewed(words: english.Words, view: str) -> tuple[english.Words, str]:
    """Remove the words that name a view, such as "from the camera", and return that view."""
    for name, phrases in english.VIEWS.items():
        for k in range(len(words)):
            for end in english.starts(words, k, phrases):
                return words[:k] + words[end:], name
    return words, view


def _check_words(sentence: str, words: english.Words) -> None:
    if not words:
        raise NotUnderstood("An empty sentence asks for nothing; say what shall be done, such as 'put the cup on the tray'.")
    if len(words) > LONGEST:
        raise NotUnderstood(f"The sentence has {len(words)} words; up to {LONGEST} are read. Say it in several sentences.")


def _refusal(sentence: str, words: english.Words, parser: ClauseParser, resolver: Resolver, refused: Sequence[Refusal]) -> NotUnderstood:
    """Return why a sentence was refused: because of a denying word in it, or for the way to read it that came farthest."""
    asked = [w for w in words if w in english.CONDITIONAL]
    if asked and not any(r.rank == OPEN for r in refused):
        return NotUnderstood(f"'{sentence}' has a condition ('{asked[0]}'); a goal has none. Say what shall hold in the end.")
    denied = [w for w in words if w in english.NEGATIVE]
    if denied and not any(r.rank in (ABSENT, OPEN) for r in refused):
        said = f"'{sentence}' says what shall not hold ('{denied[0]}'), in words that are not understood"
        advice = "say what shall hold instead, or 'the tin should not be on the tray'."
        return NotUnderstood(f"{said}; {advice}")
    if refused:
        best = max(refused, key=lambda r: r.rank)
        return NotUnderstood(f"'{sentence}': {best.text}.", open=best.rank == UNKNOWN, ambiguous=best.rank == OPEN)
    known = resolver.labels.vocabulary | parser.frames.words | english.vocabulary()
    strange = [w for w in dict.fromkeys(words) if w not in known and english.singular(w) not in known and w not in english.STOPS]
    if len(strange) * 2 >= len(set(words)):
        return NotUnderstood(f"'{sentence}' is not in English, as far as its words are known; sentences are read in English.", open=True)
    if strange:
        said = listed([repr(w) for w in strange], "and")
        return NotUnderstood(f"'{sentence}' has words that are not known here: {said}; use others.", open=True)
    behind = " ".join(words[parser.farthest :]) or " ".join(words)
    return NotUnderstood(f"'{sentence}' cannot be read from '{behind}' on; say it as 'put THING on PLACE' or 'open THING'.", open=True)
