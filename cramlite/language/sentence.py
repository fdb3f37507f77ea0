"""A sentence becomes goals: every reading of the grammar is tried on the scene; the only one that makes sense is understood."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, NamedTuple

from msgspec.structs import replace

from ..base.errors import UserError
from ..base.value import Value
from ..model.entity_name import thing_of
from . import english
from .clauses import ClauseParser
from .frames import Frames
from .labels import Labels
from .nouns import spoken
from .places import Places, meaningful
from .reference import Mentions, Referents, Resolver
from .refusal import ABSENT, FALSE, OPEN, UNKNOWN, UNREAD, Refusal, listed
from .space import Space, view_of
from .tree import Clause, Link

if TYPE_CHECKING:
    from ..interpretation.fluents import Fluents, GoalCondition, GoalPhrase, SymbolicWorld

LONGEST = 60
"""Words of a sentence that are read."""


class Literal(Value):
    """Goal that was understood, with the words that it comes from.

    Args:
        goal: in the words of goals.
        origins: words of the sentence, each with what it was taken for.
    """

    goal: str
    origins: tuple[tuple[str, str], ...] = ()

    def __str__(self) -> str:
        said = ", ".join(f"'{words}' = {meant}" for words, meant in self.origins)
        return f"{self.goal}" + (f"  ({said})" if said else "")


class Understood(Value):
    """Sentence with the goals that it was understood as.

    Args:
        sentence: as it was said.
        literals: the goals; all of them shall hold.
        by: who understood it.
        view: from where left and right were told; "" if that played no part.
    """

    sentence: str
    literals: tuple[Literal, ...]
    by: str = "grammar"
    view: str = ""

    @property
    def goals(self) -> tuple[str, ...]:
        """Goals in the words of goals."""
        return tuple(dict.fromkeys(one.goal for one in self.literals))


class NotUnderstood(UserError):
    """Sentence that is not understood: ambiguous, false of the scene, or in words that are not known.

    Args:
        text: what there is, and what to say.
        open: whether it names nothing that is known, so that another reader may know more.
        ambiguous: whether it may mean several things that there are.
    """

    def __init__(self, text: str, *, open: bool = False, ambiguous: bool = False) -> None:
        super().__init__(text)
        self.open, self.ambiguous = open, ambiguous


def understand(sentence: str, scene: SymbolicWorld, fluents: Fluents, view: str = "") -> Understood:
    """Understand a sentence in a scene.

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
    parser = ClauseParser(words, frames)
    found = _meanings(parser.readings(), resolver, fluents, refused) or _meanings(parser.elliptic(), resolver, fluents, refused)
    if len(found) == 1:
        return Understood(sentence, next(iter(found.values())), view=space.view.name if english.SIDES.keys() & set(words) else "")
    if found:
        texts = [f"'{' and '.join(one.goal for one in literals)}'" for literals in found.values()]
        raise NotUnderstood(f"'{sentence}' may mean {listed(texts)}; say it in shorter sentences, or name the things.", ambiguous=True)
    raise _refusal(sentence, words, parser, resolver, refused)


def _meanings(
    readings: Iterable[Sequence[Clause]], resolver: Resolver, fluents: Fluents, refused: list[Refusal]
) -> dict[tuple[str, ...], tuple[Literal, ...]]:
    """Goals of the readings that make sense, each set of goals with its literals; refusals of the others are appended."""
    found: dict[tuple[str, ...], tuple[Literal, ...]] = {}
    for reading in readings:
        try:
            literals = _Reading(resolver, fluents).literals(reading)
            found.setdefault(tuple(sorted(one.goal for one in literals)), literals)
        except Refusal as refusal:
            refused.append(refusal)
    return found


def _viewed(words: english.Words, view: str) -> tuple[english.Words, str]:
    """The words without those that name a view, and that view."""
    for name, phrases in english.VIEWS.items():
        for k in range(len(words)):
            for end in english.starts(words, k, phrases):
                return words[:k] + words[end:], name
    return words, view


def _without_phrases(words: english.Words) -> english.Words:
    """The words without those that are only polite: "if you could"."""
    left, k = list[str](), 0
    while k < len(words):
        ends = english.starts(words, k, (*english.POLITE, *english.CLOSING))
        left += [] if ends else [words[k]]
        k = ends[0] if ends else k + 1
    return tuple(left)


def _check_words(sentence: str, words: english.Words) -> None:
    if not words:
        raise NotUnderstood("An empty sentence asks for nothing; say what shall be done, such as 'put the cup on the tray'.")
    if len(words) > LONGEST:
        raise NotUnderstood(f"The sentence has {len(words)} words; up to {LONGEST} are read. Say it in several sentences.")
    plain = _without_phrases(words)
    asked = [w for w in plain if w in english.CONDITIONAL]
    if asked:
        raise NotUnderstood(f"'{sentence}' has a condition ('{asked[0]}'); a goal has none. Say what shall hold in the end.")


def _refusal(sentence: str, words: english.Words, parser: ClauseParser, resolver: Resolver, refused: Sequence[Refusal]) -> NotUnderstood:
    """The reason of the reading that came farthest; of those that were not read through, the words that deny."""
    denied = [w for w in words if w in english.NEGATIVE]
    if denied and not any(r.rank == OPEN for r in refused):
        said = f"'{sentence}' says what shall not be ('{denied[0]}')"
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


class _Row(NamedTuple):
    """A goal of a clause, and the things that it is about."""

    clause: Clause
    phrase: GoalPhrase
    themes: tuple[str, ...]
    literal: Literal


class _Reading:
    """One reading of a sentence, on its scene."""

    def __init__(self, resolver: Resolver, fluents: Fluents) -> None:
        self._its, self._fluents, self._places = resolver, fluents, Places(resolver)
        self._mentions = Mentions()

    def literals(self, clauses: Sequence[Clause]) -> tuple[Literal, ...]:
        """Goals of all clauses; those that a later one takes back are left out."""
        found: list[_Row] = []
        for number, clause in enumerate(clauses):
            stated = [replace(clause, phrases=(clause.state,), place=None, beside=None)] if clause.state is not None else []
            for row in (row for part in (clause, *stated) for row in self._clause(part)):
                found = [f for f in found if not self._superseded(f, row, clauses, number)]
                found.append(row)
        if not found:
            raise Refusal(UNREAD, "it names things and asks for nothing")
        return tuple({row.literal.goal: row.literal for row in found}.values())

    def _clause(self, clause: Clause) -> Iterable[_Row]:
        if not clause.phrases:
            self._mention(clause, self._its.things(clause.theme, lambda _: True, self._mentions).names, ())
            return []
        phrase = clause.phrases[0]
        themes = self._themes(clause, phrase)
        if clause.theme.words:
            self._mentions = replace(self._mentions, words=clause.theme.words)
        if clause.place is None:
            rows = self._unary(clause, phrase, themes)
            self._mention(clause, themes.names, ())
            return rows
        if clause.relation == "phrase":
            themes = self._without_carried(clause, themes)
            places = self._places.at(clause.place, clause.words, phrase, themes.names, self._mentions)
            rows = self._placed(clause, phrase, themes, places)
            self._mention(clause, themes.names, places.names)
            return rows
        return self._spots(clause, themes)

    def _without_carried(self, clause: Clause, themes: Referents) -> Referents:
        """Themes of a pronoun, without those that were put onto another of them before."""
        before = zip(self._mentions.themes, self._mentions.places, strict=True)
        put = {t for group, places in before for t in group if {*places} & {*themes.names}}
        left = tuple(n for n in themes.names if n not in put)
        return replace(themes, names=left) if clause.theme.pronoun and left else themes

    def _themes(self, clause: Clause, phrase: GoalPhrase) -> Referents:
        things = self._its.scene.world

        def about(name: str) -> bool:
            alone = clause.place is None and not clause.amount
            return phrase.about(things.thing(name)) and (not alone or meaningful(phrase, self._its, name))

        return self._its.things(clause.theme, about, self._mentions)

    def _unary(self, clause: Clause, phrase: GoalPhrase, themes: Referents) -> list[_Row]:
        amount = (clause.amount,) if clause.amount else ()
        goals = [(n, self._said(phrase, (n, *amount))) for n in themes.names]
        origins = ((clause.said, _verb_of(phrase)), (clause.theme.said, themes.listed))
        return self._rows(clause, phrase, goals, themes.some, origins)

    def _placed(self, clause: Clause, phrase: GoalPhrase, themes: Referents, places: Referents) -> list[_Row]:
        if clause.words and " ".join(clause.words) in _OPEN_WAYS and not phrase.suits(self._its.scene, themes.names[0], places.names[0]):
            raise Refusal(UNREAD, f"'{clause.said}' is said of another kind of place")
        if len(places.names) > 1 and places.some != 1:
            raise Refusal(OPEN, f"'{places.said}' are {listed(list(places.names), 'and')}; say which thing goes where")
        self._check_there(clause, phrase, themes, places)
        goals = []
        for theme in themes.names:
            ways = [self._said(phrase, (theme, p)) for p in places.names if thing_of(p) != theme]
            if clause.beside is not None and ways:
                form, _ = self._places.beside(clause.beside, clause.phrases, theme, self._mentions, thing_of(places.names[0]))
                ways = [form.replace("THING", theme)]
            goals.append((theme, OR.join(ways)))
        origins = [(clause.said, _verb_of(phrase)), (clause.theme.said, themes.listed)]
        origins += [(clause.place.said, listed([*places.names]))] if clause.place is not None else []
        return self._rows(clause, phrase, goals, themes.some, tuple(origins))

    def _check_there(self, clause: Clause, phrase: GoalPhrase, themes: Referents, places: Referents) -> None:
        """Refuse to take things from where none of them is, or was put before."""
        if not meaningful(phrase, self._its, themes.names[0], places.names[0]):
            return
        condition = phrase.meaning(self._its.scene, themes.names[0], places.names[0])
        if condition.needs or not condition.without or clause.said == spoken(clause.words) or {*themes.names} & self._mentions.put:
            return
        if not any(self._its.anywhere(t, thing_of(p)) for t in themes.names for p in places.names):
            at = f"is not on or in {listed([*places.names])}"
            raise Refusal(ABSENT, f"{listed([*themes.names], 'and')} {at}, so it cannot be taken from there")

    def _spots(self, clause: Clause, themes: Referents) -> list[_Row]:
        """Goals to be beside or under things."""
        assert clause.place is not None
        phrase = clause.phrases[0]
        if clause.relation == "under":
            places = self._places.under(clause.place, themes.names, self._mentions)
            rows = self._placed(clause, phrase, themes, places)
            self._mention(clause, themes.names, places.names)
            return rows
        link, goals, meant = Link(clause.relation, clause.words, (clause.place,)), [], ""
        for theme in themes.names:
            form, meant = self._places.beside(link, clause.phrases, theme, self._mentions)
            goals.append((theme, form.replace("THING", theme)))
        themed = (clause.theme.said, listed([*themes.names], "and"))
        origins = ((clause.said, goals[0][1].partition(" ")[2]), themed, (clause.place.said, meant))
        rows = self._rows(clause, phrase, goals, themes.some, origins)
        self._mention(clause, themes.names, (meant,))
        return rows

    def _rows(
        self, clause: Clause, phrase: GoalPhrase, goals: Sequence[tuple[str, str]], some: int, origins: tuple[tuple[str, str], ...]
    ) -> list[_Row]:
        kept = tuple((words, meant) for words, meant in origins if words and words != meant)
        goals = [(theme, f"not {goal}" if clause.denied else goal) for theme, goal in goals if goal]
        if not goals:
            raise Refusal(FALSE, f"'{clause.theme.said}' cannot be brought to itself")
        if clause.denied and (some or any(OR in goal for _, goal in goals)):
            raise Refusal(OPEN, f"'{clause.theme.said}' leaves open which of several things it shall not be; name them")
        if some:
            goal = OR.join(g for _, g in goals) if some == 1 else self._number(clause, goals, some)
            return [_Row(clause, phrase, tuple(t for t, _ in goals), Literal(goal, kept))]
        return [_Row(clause, phrase, (theme,), Literal(goal, kept)) for theme, goal in goals]

    def _number(self, clause: Clause, goals: Sequence[tuple[str, str]], some: int) -> str:
        """Goal for a number of equal things, "2 of Cup...": refused if other things of the scene are of their class."""
        scene, themes = self._its.scene, {theme for theme, _ in goals}
        others = {t.name for t in scene.world.things} - themes
        class_ = scene.types[next(iter(sorted(themes)))]
        rests = {goal.removeprefix(theme) for theme, goal in goals}
        if len(rests) > 1 or not all(scene.is_a(t, class_) for t in themes) or any(scene.is_a(t, class_) for t in others):
            raise Refusal(OPEN, self._its.which(clause.theme, [*dict.fromkeys(theme for theme, _ in goals)]))
        return f"{some} of {class_.rpartition(':')[2]}{rests.pop()}"

    def _said(self, phrase: GoalPhrase, things: tuple[str, ...]) -> str:
        """The goal in words, if it makes sense of these things."""
        try:
            phrase.meaning(self._its.scene, *things)
        except (UserError, KeyError) as error:
            raise Refusal(FALSE, str(error).strip("'.")) from error
        left = list(things)
        return " ".join(left.pop(0) if w.isupper() else w for w in phrase.form.split())

    def _mention(self, clause: Clause, themes: tuple[str, ...], places: tuple[str, ...]) -> None:
        words = self._mentions.words or (clause.place.words if clause.place is not None else ())
        themes = tuple(dict.fromkeys(self._whole(n, clause) for n in themes))
        put = self._mentions.put | ({*themes} if clause.place is not None else set())
        self._mentions = Mentions((*self._mentions.themes, themes), (*self._mentions.places, places), words, frozenset(put))

    def _whole(self, name: str, clause: Clause) -> str:
        """The thing that was named, where a part of it was meant: of "the stove" the knob."""
        joint, labels = self._its.scene.world.thing(name).joint, self._its.labels
        carrier = joint.parent if joint is not None and joint.parent in labels.of else name
        named = clause.theme.words
        return carrier if named and labels.fits(carrier, named) > labels.fits(name, named) else name

    def _superseded(self, before: _Row, row: _Row, clauses: Sequence[Clause], number: int) -> bool:
        """Whether a goal was only a means, or is taken back by what comes later."""
        if before.themes != row.themes or before.clause is row.clause:
            return False
        one, other = (self._meaning(r) for r in (before, row))
        if one is None or other is None:
            return False
        if row.clause.theme.pronoun and before.clause.said == spoken(before.clause.words) and one.needs and one.needs <= self._its.facts:
            return True  # "the tin is on the tray: pick it up" says where it is
        means = not one.needs or any(self._fluents[f[0]].in_hand for f in one.needs)
        if means and (other.needs or other.shown):
            return True
        apart = clauses.index(before.clause) < number - 1 or row.clause.later
        return apart and bool(self._fluents.clash(self._its.scene, one, other))

    def _meaning(self, row: _Row) -> GoalCondition | None:
        """State that a goal asks for; None where it leaves something open."""
        if row.clause.denied:
            return None
        names = [w for w in row.literal.goal.split() if thing_of(w) in self._its.scene.types]
        slots = len([w for w in row.phrase.form.split() if w.isupper()])
        things = [names[0], row.clause.amount] if row.clause.amount else names[:slots]
        try:
            return row.phrase.meaning(self._its.scene, *things)
        except (UserError, KeyError, TypeError):
            return None


OR = " or "
_OPEN_WAYS = frozenset({"to", "towards", "at", "over to", "toward"})
"""Prepositions that leave open whether it is on or in."""


def _verb_of(phrase: GoalPhrase) -> str:
    return " ".join(w for w in phrase.form.split() if not w.isupper())
