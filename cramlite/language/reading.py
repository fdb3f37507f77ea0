"""Translation of one English sentence: what its grammatical clauses ask for becomes goals about the things of a scene."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import TYPE_CHECKING

from msgspec.structs import replace

from ..model.entity_name import thing_of
from .english import ANYTHING, TOP_WORD
from .meanings import ASIDES, OR, Literal, Meanings, Row
from .mentions import Mentions, Referents
from .nouns import RANKED, spoken
from .places import Places, meaningful
from .reference import Resolver
from .refusal import ABSENT, FALSE, OPEN, UNREAD, Refusal, listed
from .tree import Clause, Link, Noun

if TYPE_CHECKING:
    from ..interpretation.fluents import Fluents, GoalPhrase


class Reading:
    """Reading of a sentence: converts its clauses to goals about a scene.

    In a ``free`` reading, where verbs may be missing, a second place for "it" is refused.
    """

    def __init__(self, resolver: Resolver, fluents: Fluents, *, free: bool = False) -> None:
        self._free = free
        self._its, self._places, self._meanings = resolver, Places(resolver), Meanings(resolver, fluents)
        self._mentions = Mentions()
        self._announced: frozenset[str] = frozenset()
        self.at = 0

    def literals(self, clauses: Sequence[Clause]) -> tuple[Literal, ...]:
        """Return the goals that the parts of a sentence ask for, except a goal that a later part replaces."""
        found: list[Row] = []
        for number, clause in enumerate(clauses):
            self.at = number
            if clause.relation in ASIDES:
                self._overhear(clause)
                continue
            stated = [replace(clause, phrases=(clause.state,), place=None, beside=None)] if clause.state is not None else []
            rows = [row for part in (clause, *stated) for row in self._clause(part)]
            if clause.told and any(OR in row.literal.goal for row in rows):
                raise Refusal(UNREAD, f"'{clause.theme.said}' does not say which thing the statement is about")
            if clause.given:
                self._meanings.check_given(rows)
                continue
            if clause.either:
                found = self._alternative(clause, rows, found, clauses[number - 1])
                continue
            for row in rows:
                same = [f for f in found if f.themes == row.themes and f.clause is not row.clause and f.literal.goal != row.literal.goal]
                moved = self._free and row.clause.place is not None and clause.relation == "phrase"
                same = [f for f in same if moved and f.clause.place is not None]
                refers = clause.theme.pronoun or clause.theme.elided
                if refers and any(not self._meanings.superseded(f, row, clauses, number) for f in same):
                    raise Refusal(
                        FALSE, f"'{row.literal.goal}' is a second goal for {listed([*row.themes], 'and')}; use a verb for each goal"
                    )
                found = [*(f for f in found if not self._meanings.superseded(f, row, clauses, number)), row]
        found = self._meanings.without_left(self._meanings.without_told(found))
        if not found:
            raise Refusal(UNREAD, "the sentence names things, and states no goal for them")
        if left := sorted(self._announced - self._mentions.every):
            raise Refusal(UNREAD, f"the sentence names {listed(left, 'and')}, and states no goal for it")
        self._meanings.check(clauses, found)
        goals = {row.literal.goal: row.literal for row in found}
        return tuple(one for goal, one in goals.items() if not any(other.startswith(f"{goal} ") and OR not in other for other in goals))

    def _alternative(self, clause: Clause, rows: Sequence[Row], found: Sequence[Row], before: Clause) -> list[Row]:
        """Return the goals, with another one as an alternative to the last of them: "hold the block or put
        it on the shelf"."""
        if len(rows) != 1 or not found or found[-1].clause is not before:
            raise Refusal(OPEN, f"'{clause.said}' is an alternative to several goals; say for each goal what may replace it")
        last, other = found[-1].literal, rows[0].literal
        both = Literal(f"{last.goal}{OR}{other.goal}", (*last.origins, *other.origins))
        return [*found[:-1], found[-1]._replace(clause=replace(before, either=True), literal=both)]

    def _overhear(self, clause: Clause) -> None:
        """Remember the things that an aside (a remark in the sentence) names, for later pronouns.

        An apposition ("both mugs, the red and the blue one") is refused if it names other things than the
        phrase that it repeats.
        """
        if clause.relation == "going":
            self._mention(clause, self._its.things(clause.theme, lambda _: True, self._mentions).names, ())
            return
        if clause.relation == "ahead":
            named = {n for noun in clause.theme.members for n in self._its.things(noun, lambda _: True, self._mentions).names}
            self._announced |= named
            return
        if clause.relation == "same":
            named = {*self._its.things(clause.theme, lambda _: True, self._mentions).names}
            last = [{*map(thing_of, g)} for g in (*self._mentions.themes[-1:], *self._mentions.places[-1:])]
            every = {n for g in self._mentions.themes for n in g}
            if named not in (*last, every):
                raise Refusal(UNREAD, f"the sentence names '{clause.theme.said}', and states no goal for it")
            return
        groups: list[tuple[str, ...]] = []
        for noun in clause.theme.members:
            try:
                found = self._its.things(noun, lambda _: True, self._mentions)
            except Refusal:
                continue
            groups += [] if found.some else [found.names]
        if groups:
            self._mentions = replace(self._mentions, words=clause.theme.members[0].words, earlier=self._mentions.words)
            self._mention(clause, groups[0], tuple(n for group in groups[1:] for n in group))

    def _swapped(self, clause: Clause) -> list[Row]:
        """Return the goals of two things that exchange their places."""
        themes = self._its.things(clause.theme, lambda n: self._its.scene.world.thing(n).movable, self._mentions)
        if len(themes.names) != 2 or themes.some:
            raise Refusal(OPEN, f"'{clause.theme.said}' is {themes.listed}, not two things; say which two change places")
        one, other = themes.names
        (mine, here), (its, there) = (self._places.now(n) for n in themes.names)
        if here == there:
            raise Refusal(FALSE, f"{one} and {other} are both on or in {here}; say which of them shall be to the left of the other")
        if other in (here, thing_of(here)) or one in (there, thing_of(there)):
            raise Refusal(FALSE, f"{one} and {other} cannot change places, since one is on the other; say what shall be on what")
        self._mention(clause, themes.names, ())
        origins = ((clause.said, "change places"), (clause.theme.said, themes.listed))
        return [
            *self._rows(clause, its, [(one, self._places.said(its, (one, there)))], 0, origins),
            *self._rows(clause, mine, [(other, self._places.said(mine, (other, here)))], 0, origins),
        ]

    def _clause(self, clause: Clause) -> Iterable[Row]:
        if clause.relation == "swap":
            return self._swapped(clause)
        if clause.relation == "together":
            return self._together(clause)
        if clause.paired and clause.place is not None:
            return self._paired(clause, clause.place)
        if not clause.phrases:
            self._its.needless += 1
            named = self._its.things(clause.theme, lambda _: True, self._mentions)
            self._mention(clause, named.names, (), some=named.some)
            self._mentions = replace(self._mentions, words=clause.theme.words or self._mentions.words)
            return []
        phrase = clause.phrases[0]
        themes = self._themes(clause, phrase)
        self._mention_described(clause.theme)
        if clause.theme.words:
            self._mentions = replace(self._mentions, words=clause.theme.words, earlier=self._mentions.words)
        if clause.place is None:
            rows = self._unary(clause, phrase, themes)
            self._mention(clause, themes.names, (), some=themes.some)
            return rows
        if clause.relation == "phrase":
            themes = self._without_place(clause, self._without_carried(clause, themes))
            places = self._place_of(clause, clause.place, phrase, themes)
            rows = self._placed(clause, phrase, themes, places)
            self._mention(clause, themes.names, places.names, some=themes.some)
            return rows
        return self._spots(clause, themes)

    def _mention_described(self, noun: Noun) -> None:
        """Remember the things by which a noun phrase describes its own, for later pronouns: the basket of "the can nearest to the
        basket"."""
        for other in (n for link in noun.links for n in link.nouns if not n.pronoun and not link.denied):
            try:
                named = self._its.pool(other, lambda _: True, self._mentions)
            except Refusal:  # a part of the thing, such as its handle
                continue
            if len(named) == 1:
                its = self._mentions
                self._mentions = replace(its, themes=(*its.themes, ()), places=(*its.places, tuple(named)))

    def _place_of(self, clause: Clause, place: Noun, phrase: GoalPhrase, themes: Referents) -> Referents:
        """Return the place of a request; a pronoun that tells it may mean the things that are put there, if it means nothing that was
        named before: "the cup on the plate nearest to it"."""
        its = self._mentions
        try:
            return self._places.at(place, clause.words, phrase, themes.names, its)
        except Refusal:
            if not any(n.pronoun for link in place.links for n in link.nouns):
                raise
            now = replace(its, themes=(*its.themes, themes.names), places=(*its.places, ()))
            return self._places.at(place, clause.words, phrase, themes.names, now)

    def _without_carried(self, clause: Clause, themes: Referents) -> Referents:
        """Return the things that a pronoun refers to, except a thing that an earlier clause of the sentence
        put onto another of them."""
        before = zip(self._mentions.themes, self._mentions.places, strict=True)
        put = {t for group, places in before for t in group if {*places} & {*themes.names}}
        left = tuple(n for n in themes.names if n not in put)
        return replace(themes, names=left) if clause.theme.pronoun and left else themes

    def _without_place(self, clause: Clause, themes: Referents) -> Referents:
        """Return the things that "everything" means, except the place where it shall go."""
        if clause.theme.words != ANYTHING or clause.theme.quantity != "all" or clause.place is None or clause.place.pronoun:
            return themes
        try:
            places = self._its.pool(clause.place, lambda _: True, self._mentions)
        except Refusal:
            return themes
        return replace(themes, names=tuple(n for n in themes.names if n not in places) or themes.names)

    def _together(self, clause: Clause) -> list[Row]:
        """Return the goals for several things that shall stand side by side: each further thing next to the
        first."""
        named = self._its.things(clause.theme, lambda n: self._its.scene.world.thing(n).movable, self._mentions).names
        first, *others = clause.theme.members or [Noun(n, (n.lower(),)) for n in named]
        parts = [replace(clause, theme=first, relation="phrase")] if clause.place is not None else []
        for other in others:
            beside = Link("next to", clause.words, (first,))
            near = replace(clause, theme=other, relation="next to", place=first)
            parts.append(replace(clause, theme=other, relation="phrase", beside=beside) if parts else near)
        return [row for part in parts for row in self._clause(part)]

    def _paired(self, clause: Clause, place: Noun) -> list[Row]:
        """Return the goals of things with a place each: "the tin and the can in the drawer and the basket,
        respectively"."""
        if len(clause.theme.members) != len(place.members) or not place.members:
            raise Refusal(OPEN, f"'{clause.theme.said}' and '{place.said}' are different numbers of things; say which thing goes where")
        pairs = zip(clause.theme.members, place.members, strict=True)
        return [row for theme, at in pairs for row in self._clause(replace(clause, theme=theme, place=at, paired=False))]

    def _themes(self, clause: Clause, phrase: GoalPhrase) -> Referents:
        things = self._its.scene.world

        def about(name: str) -> bool:
            alone = clause.place is None and not clause.amount
            return phrase.about(things.thing(name)) and (not alone or meaningful(phrase, self._its, name))

        try:
            return self._its.things(clause.theme, about, self._mentions)
        except Refusal as refused:
            left = [] if refused.rank != OPEN or clause.theme.members or clause.theme.pronoun else self._changed(clause, phrase, about)
            if len(left) != 1:
                raise
            return Referents(clause.theme.said, tuple(left))

    def _changed(self, clause: Clause, phrase: GoalPhrase, about: Callable[[str], bool]) -> list[str]:
        """Return those of the things that a noun phrase may mean for which a request would change something: the open one of the drawers
        to be closed, the bowl on the stove of those to be taken off it."""
        if clause.denied or clause.told or clause.given or clause.theme.several or clause.theme.quantity != "the":
            return []
        found = self._its.pool(clause.theme, about, self._mentions)
        if clause.place is None:
            return [n for n in found if not self._its.so(phrase.meaning, n)] if len(found) > 2 else []  # the odd one out
        if clause.place.pronoun or clause.relation != "phrase":
            return []
        places = self._its.pool(clause.place, lambda n: n not in found, self._mentions)
        return [n for n in found if any(self._places.leaves(phrase, n, p) and self._its.anywhere(n, p) for p in places)]

    def _unary(self, clause: Clause, phrase: GoalPhrase, themes: Referents) -> list[Row]:
        amount = (clause.amount,) if clause.amount else ()
        goals = [(n, self._places.said(phrase, (n, *amount))) for n in themes.names]
        origins = ((clause.said, _verb_of(phrase)), (clause.theme.said, themes.listed))
        return self._rows(clause, phrase, goals, themes.some, origins)

    def _placed(self, clause: Clause, phrase: GoalPhrase, themes: Referents, places: Referents) -> list[Row]:
        if not (themes.names and places.names):
            raise Refusal(FALSE, f"'{clause.said}' is about no thing that the scene has")
        if clause.words and " ".join(clause.words) in _OPEN_WAYS and not phrase.suits(self._its.scene, themes.names[0], places.names[0]):
            raise Refusal(UNREAD, f"'{clause.said}' cannot be said of a place such as {places.names[0]}")
        leaves = len(places.names) > 1 and self._places.leaves(phrase, themes.names[0], places.names[0])
        if len(places.names) > 1 and places.some != 1 and not leaves:
            raise Refusal(OPEN, f"'{places.said}' are {listed(list(places.names), 'and')}; say which thing goes where")
        if clause.place is not None and clause.place.pronoun and clause.words == TOP_WORD and len(themes.names) > 1:
            raise Refusal(OPEN, f"'{clause.theme.said}' are {themes.listed}; say which one is on top of which")
        themes = themes if clause.amount else self._from_there(clause, phrase, themes, places)
        goals = []
        for theme in themes.names:
            amount = (clause.amount,) if clause.amount else ()
            wheres = [p for p in places.names if thing_of(p) != theme and not (leaves and not self._its.anywhere(theme, thing_of(p)))]
            ways = [self._places.said(phrase, (theme, p, *amount)) for p in wheres]
            if clause.beside is not None and ways:
                form, _ = self._places.beside(clause.beside, clause.phrases, theme, self._mentions, thing_of(places.names[0]))
                ways = [form.replace("THING", theme)]
            goals.append((theme, OR.join(ways)))
        origins = [(clause.said, _verb_of(phrase)), (clause.theme.said, themes.listed)]
        origins += [(clause.place.said, listed([*places.names]))] if clause.place is not None else []
        return self._rows(clause, phrase, goals, themes.some, tuple(origins))

    def _from_there(self, clause: Clause, phrase: GoalPhrase, themes: Referents, places: Referents) -> Referents:
        """Return the things that a request takes from a place; "all" or a plural means only those that are there now.

        Refuse things that are not there, unless the sentence put them there before.
        """
        if not self._places.leaves(phrase, themes.names[0], places.names[0]) or {*themes.names} & self._mentions.put:
            return themes
        there = tuple(t for t in themes.names if any(self._its.anywhere(t, thing_of(p)) for p in places.names))
        if there and (clause.theme.quantity == "all" or clause.theme.several):
            return replace(themes, names=there)
        if not there and clause.said != spoken(clause.words):
            at = f"is not on or in {listed([*places.names])}"
            raise Refusal(ABSENT, f"{listed([*themes.names], 'and')} {at}, so it cannot be taken from there")
        return themes

    def _spots(self, clause: Clause, themes: Referents) -> list[Row]:
        """Return the goals of a request to put things beside or under other things."""
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
        if clause.place.pronoun and clause.said == spoken(clause.words):  # "the jug to the left of it": the next "it" is the same
            self._mentions = replace(self._mentions, put=self._mentions.put | {*themes.names})
        else:
            self._mentions = replace(self._mentions, themes=(*self._mentions.themes, (meant,)), places=(*self._mentions.places, ()))
            self._mention(clause, themes.names, ())
        return rows

    def _rows(
        self, clause: Clause, phrase: GoalPhrase, goals: Sequence[tuple[str, str]], some: int, origins: tuple[tuple[str, str], ...]
    ) -> list[Row]:
        kept = tuple((words, meant) for words, meant in origins if words and words != meant)
        goals = [(theme, f"not {goal}" if clause.denied else goal) for theme, goal in goals if goal]
        if not goals:
            raise Refusal(FALSE, f"'{clause.theme.said}' cannot be brought to itself")
        if clause.denied and (some or any(OR in goal for _, goal in goals)):
            raise Refusal(OPEN, f"'{clause.theme.said}' leaves open for which of several things the goal is denied; name the things")
        if some:
            goal = OR.join(g for _, g in goals) if some == 1 else self._number(clause, goals, some)
            return [Row(clause, phrase, tuple(t for t, _ in goals), Literal(goal, kept))]
        return [Row(clause, phrase, (theme,), Literal(goal, kept)) for theme, goal in goals]

    def _number(self, clause: Clause, goals: Sequence[tuple[str, str]], some: int) -> str:
        """Return the goal for a number of things of one class, "two cans on the tray"; refuse it if the
        scene has more of them."""
        scene, themes = self._its.scene, {theme for theme, _ in goals}
        others = {t.name for t in scene.world.things} - themes
        class_ = scene.types[next(iter(sorted(themes)))]
        rests = {goal.removeprefix(theme) for theme, goal in goals}
        if len(rests) > 1 or not all(scene.is_a(t, class_) for t in themes) or any(scene.is_a(t, class_) for t in others):
            raise Refusal(OPEN, self._its.which(clause.theme, [*dict.fromkeys(theme for theme, _ in goals)]))
        return f"{some} of {class_.rpartition(':')[2]}{rests.pop()}"

    def _mention(self, clause: Clause, themes: tuple[str, ...], places: tuple[str, ...], *, some: int = 0) -> None:
        words = self._mentions.words or (clause.place.words if clause.place is not None else ())
        themes = tuple(dict.fromkeys(self._whole(n, clause) for n in themes))
        put = self._mentions.put | ({*themes} if clause.place is not None else set())
        chosen = self._mentions.some | ({(themes, some)} if some else set())
        its = self._mentions
        where = clause.place.words[-1:] if clause.place is not None else ()
        groups = (*its.themes, themes), (*its.places, places)
        named = tuple(dict.fromkeys((*its.two, *themes, *places)))[-2:]
        two = its.two if {clause.theme.pronoun, clause.place and clause.place.pronoun} & {*RANKED} else named
        self._mentions = Mentions(*groups, words, its.earlier, where or its.where, frozenset(put), chosen, two)

    def _whole(self, name: str, clause: Clause) -> str:
        """Return the name of the thing that the sentence named, if one of the thing's parts is meant: the
        stove, for its knob."""
        joint, labels = self._its.scene.world.thing(name).joint, self._its.labels
        carrier = joint.parent if joint is not None and joint.parent in labels.of else name
        named = clause.theme.words
        return carrier if named and labels.fits(carrier, named) > labels.fits(name, named) else name

_OPEN_WAYS = frozenset({"to", "towards", "at", "over to", "toward", "there"})
"""Prepositions that name a place, but not whether the thing goes on it or into it."""


def _verb_of(phrase: GoalPhrase) -> str:
    return " ".join(w for w in phrase.form.split() if not w.isupper())
