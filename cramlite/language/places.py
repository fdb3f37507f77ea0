"""Places that a sentence asks for: a whole thing, a region of a thing, or a spot beside another thing."""

from __future__ import annotations

from typing import TYPE_CHECKING

from msgspec.structs import replace

from ..base.errors import UserError
from ..model.entity_name import EntityName, thing_of
from ..ontology.foundation import BEARS
from .english import INWARD, LOW, PLAIN, REGIONS, SIDES, TECHNICAL, TOP_WORD, Words, singular
from .labels import normal
from .mentions import Mentions, Referents
from .reference import Resolver
from .refusal import FALSE, OPEN, Refusal, listed
from .tree import Link, Noun

if TYPE_CHECKING:
    from ..interpretation.fluents import GoalPhrase
    from ..model.world.thing import Feature

NEAR = "near"
"""Word for "next to" in the goal language."""
USUAL = frozenset({"top", "inside", "bottom"})
"""Names of regions that add nothing to the prepositions "on" and "in"."""


class Places:
    """Places in a scene to which the noun phrases of a sentence refer.

    Args:
        resolver: of descriptions.
    """

    def __init__(self, resolver: Resolver) -> None:
        self._its, self._labels = resolver, resolver.labels

    def at(self, noun: Noun, words: Words, phrase: GoalPhrase, themes: tuple[str, ...], mentions: Mentions) -> Referents:
        """Return the places to which a preposition with a noun phrase refers: whole things or regions of
        them, as a goal phrase needs.

        Raises:
            Refusal: none is, or too many are.
        """
        if noun.pronoun in ("origin", "vacated"):
            others = [g for g in reversed(mentions.themes) if len(g) == 1 and not {*g} & {*themes}]
            return self._origin(noun, phrase, others[0] if noun.pronoun == "vacated" and others else themes)
        if noun.pronoun:
            return self._before(noun, words, phrase, themes, mentions)
        if noun.elided and not noun.words and {*mentions.where} & REGIONS:  # "in the right compartment, ... in the left one"
            noun = replace(noun, words=mentions.where)
        try:
            found = self._whole(noun, words, themes, mentions)
        except Refusal as refused:
            regions = self._regions(noun, mentions)
            if not regions:
                raise
            if len(regions) > 1 and not noun.several:
                raise Refusal(OPEN, f"'{noun.said}' may be {listed(regions)}; say which") from refused
            return Referents(noun.said, tuple(regions))
        if themes and "AMOUNT" not in phrase.form and all(self.leaves(phrase, themes[0], n) for n in found.names):
            return found
        words = ("in",) if {*phrase.form.split()} & INWARD else words
        chosen = tuple(self._chosen(name, noun, words) for name in found.names)
        return replace(found, names=chosen)

    def _whole(self, noun: Noun, words: Words, themes: tuple[str, ...], mentions: Mentions) -> Referents:
        part = noun.words and singular(noun.words[-1]) in REGIONS and any(k.relation in ("of", "side", "phrase") for k in noun.links)
        if part and self._regions(noun, mentions):
            raise Refusal(FALSE, "a region")
        if noun.sides and not noun.words:  # "the top of the cabinet"
            if self._regions(noun, mentions):
                raise Refusal(FALSE, "a region")
            owners = [k.nouns[0] for k in noun.links if k.relation == "of"]
            if owners and noun.sides == ("top",):
                return self._its.things(owners[0], lambda n: n not in themes, mentions)
        among = noun.sides or noun.ordinal or noun.size or any(k.relation == "side" for k in noun.links)
        try:
            found = self._its.things(noun, lambda n: bool(among) or n not in themes, mentions)  # a theme is one of those among which it is
            before = mentions.earlier or mentions.where
            if noun.elided and {*found.names} <= {*themes} and before:
                return self._its.things(noun, lambda _: True, replace(mentions, words=before))
            return found
        except Refusal as refused:
            if refused.rank == OPEN and words == TOP_WORD:  # what is on top of drawers is on what they are mounted in
                carriers = {self._carrier(n) for n in self._its.pool(noun, lambda n: n not in themes, mentions)}
                if len(carriers) == 1:
                    return Referents(noun.said, tuple(carriers))
            raise

    def _before(self, noun: Noun, words: Words, phrase: GoalPhrase, themes: tuple[str, ...], mentions: Mentions) -> Referents:
        """Return the place to which a pronoun refers: the last one named that suits the goal phrase."""
        pairs = zip(reversed(mentions.places), reversed(mentions.themes), strict=True)
        upon = words == TOP_WORD or noun.pronoun == "that"  # "on top of it" is on what was put, not on where it was put
        groups = [g for place, theme in pairs for g in ((theme, place) if upon else (place, theme))]
        order = [g for g in groups if len(g) == 1 and not set(map(thing_of, g)) & set(themes)]
        hollow = [g for g in order if any(map(self._inward, self._its.scene.world.thing(thing_of(g[0])).features))]
        suited = [g for g in order if phrase.suits(self._its.scene, themes[0], g[0])]
        suited = hollow if {*words} & INWARD and hollow else suited
        if not order:
            raise Refusal(OPEN, f"'{noun.said}' stands for no place that was named before; name it")
        name = (suited or order)[0][0]
        place = name if name != thing_of(name) else self._chosen(name, noun, words)
        return Referents(noun.said, (place,))

    def leaves(self, phrase: GoalPhrase, theme: str, place: str) -> bool:
        """Check whether a goal phrase only says that a thing shall no longer be at a place."""
        if not meaningful(phrase, self._its, theme, place):
            return False
        condition = phrase.meaning(self._its.scene, theme, place)
        return bool(condition.without) and not (condition.needs or condition.shown)

    def said(self, phrase: GoalPhrase, things: tuple[str, ...]) -> str:
        """Return the goal in words; refuse things for which the goal phrase has no meaning."""
        try:
            phrase.meaning(self._its.scene, *things)
        except (UserError, KeyError) as error:
            raise Refusal(FALSE, str(error).strip("'.")) from error
        left = list(things)
        return " ".join(left.pop(0) if w.isupper() else w for w in phrase.form.split())

    def now(self, name: str) -> tuple[GoalPhrase, str]:
        """Return the smallest thing or region that a thing is on or in now, with the goal phrase that states
        it.

        Raises:
            Refusal: nothing is known.
        """
        phrases = tuple(dict.fromkeys(f.phrase for f in self._its.frames.placing if f.region))
        places = sorted((t.name for t in self._its.scene.world.things if t.geoms and t.name != name), key=self._size)
        for place in places:
            for phrase in phrases:
                if self._its.so(phrase.meaning, name, place):
                    return phrase, place
        raise Refusal(FALSE, f"it is not known what {name} is on or in")

    def _size(self, name: str) -> float:
        return self._its.space.size(name, height=False)

    def _origin(self, noun: Noun, phrase: GoalPhrase, themes: tuple[str, ...]) -> Referents:
        """Return the present place of the things of a request such as "put it back where it was"."""
        places = {self.now(n) for n in themes}
        if len(places) != 1 or next(iter(places))[0] != phrase:
            raise Refusal(FALSE, f"{listed([*themes], 'and')} are not at a single place, so '{noun.said}' is no place for them")
        return Referents(noun.said, (places.pop()[1],))

    def _carrier(self, name: str) -> str:
        joint = self._its.scene.world.thing(name).joint
        return joint.parent if joint is not None and joint.parent in self._its.scene.types else name

    # Regions

    def named(self, thing: str) -> dict[str, Feature]:
        """Return the regions of a thing that have a name of their own and are not named after another
        thing."""
        others = {w for n, c in self._labels.of.items() if n != thing for head in (*c.names, *c.heads) if len(head) == 1 for w in head}
        its = self._labels.of[thing]
        others -= {w for head in (*its.names, *its.heads) for w in head} | set(SIDES) | REGIONS
        found = {}
        for feature in self._its.scene.world.thing(thing).features:
            said = {w for w in _words(feature.name) if w not in TECHNICAL}
            bears = self._its.scene.taxonomy.fillers(feature.type, BEARS)
            own = said - PLAIN - REGIONS and feature.name not in USUAL and not said & (others | {"init", "initial"})
            if own and {"inside", "standing"} & set(bears):
                found[feature.name] = feature
        return found

    def _inward(self, feature: Feature) -> bool:
        """Check whether a region encloses its contents: it is a cavity, or an area with a height."""
        return "inside" in self._its.scene.taxonomy.fillers(feature.type, BEARS) or "height" in feature.size

    def _chosen(self, name: str, noun: Noun, words: Words) -> str:
        """Return the region of a thing to which a preposition refers, else the whole thing."""
        if words == TOP_WORD and self._carrier(name) != name:
            name = self._carrier(name)
        named = self.named(name)
        if {*words} & INWARD:
            return self._inside(name, noun, named)
        upon = [n for n, f in named.items() if not self._inward(f)]
        top = [n for n in upon if "top" in _words(n)]
        one = top if len(upon) > 1 else upon
        if len(self._its.scene.world.thing(name).features) == 1:
            return name  # it has no other place
        return str(EntityName(name, one[0])) if len(one) == 1 else name

    def _inside(self, name: str, noun: Noun, named: dict[str, Feature]) -> str:
        within = [n for n, f in named.items() if self._inward(f)]
        if len(within) == 1:
            return str(EntityName(name, within[0]))
        if len(within) > 1:
            places = listed([str(EntityName(name, n)) for n in within], "and")
            raise Refusal(OPEN, f"'{noun.said}' has several places inside: {places}; say which")
        its = self._its.scene.world
        if any(self._inward(f) for f in its.thing(name).features):
            return name
        mounted = [t for t in its.things if t.joint is not None and t.joint.parent == name and any(self._inward(f) for f in t.features)]
        if len(mounted) > 1:
            raise Refusal(OPEN, f"'{noun.said}' has several places inside: {listed([t.name for t in mounted], 'and')}; say which")
        return self._chosen(mounted[0].name, noun, ("in",)) if mounted else name

    def _regions(self, noun: Noun, mentions: Mentions) -> list[str]:
        """Return the regions that a noun phrase names: "the right compartment of the caddy"."""
        words = [w for w in normal(noun.words) if w not in REGIONS]
        owners = [k.nouns[0] for k in noun.links if k.relation in ("of", "phrase") and k.nouns]
        generic = bool(set(normal(noun.words)) & REGIONS)
        if not (generic or words or (noun.sides and owners)):
            return []
        wholes = [o for owner in owners for o in self._pool(owner, mentions)] if owners else list(self._labels.of)
        sides = [*noun.sides, *(k.words[0] for k in noun.links if k.relation == "side")]
        found = self._mounted(noun, wholes, sides) if generic and owners else []
        for whole in () if found else wholes:
            rest = [w for w in words if w not in self._labels.of[whole].words]
            named = self.named(whole)
            if not owners and not rest and not (generic and (words or len(named) > 1)):
                continue
            said = [n for n in named if all(w in self._said(n) for w in rest) and all(s in self._said(n) for s in sides)]
            found += [str(EntityName(whole, n)) for n in said]
        return found

    def _mounted(self, noun: Noun, wholes: list[str], sides: list[str]) -> list[str]:
        """Return places inside of parts that are mounted in things: "the top layer of the cabinet" means its
        top drawer."""
        parts = [t for t in self._its.scene.world.things if t.joint is not None and (t.joint.parent in wholes or t.name in wholes)]
        deep = [t.name for t in parts if any(map(self._inward, t.features))]
        inward = [n for n in deep if all(s in self._labels.of[n].words for s in sides)]
        return [self._chosen(n, noun, ("in",)) for n in inward] if sides else []

    def _pool(self, noun: Noun, mentions: Mentions) -> list[str]:
        try:
            return self._its.pool(noun, lambda _: True, mentions)
        except Refusal:
            return []

    def _said(self, region: str) -> set[str]:
        """Return the words by which a region may be called."""
        own = {SIDES.get(w, w) for w in _words(region)}
        groups = self._its.scene.taxonomy.synonyms
        same = [labels for labels, _ in groups if any(len(label) == 1 and {*normal(label)} & own for label in labels)]
        return own | {w for labels in same for label in labels for w in normal(label)}

    def under(self, noun: Noun, themes: tuple[str, ...], mentions: Mentions) -> Referents:
        """Return the place under each thing that a noun phrase means: a region of that thing.

        Raises:
            Refusal: it has none.
        """
        found = self._its.things(noun, lambda n: n not in themes, mentions)
        places = []
        for name in found.names:
            named = self.named(name)
            low = [n for n in named if LOW & _words(n)] or [n for n, f in named.items() if "height" in f.size]
            if len(low) != 1:
                raise Refusal(FALSE, f"no goal can name a place under {name}; say a thing to put it on, in or next to")
            places.append(str(EntityName(name, low[0])))
        return Referents(noun.said, tuple(places), found.some)

    # Beside

    def beside(self, link: Link, phrases: tuple[GoalPhrase, ...], theme: str, mentions: Mentions, on: str = "") -> tuple[str, str]:
        """Fill a place beside another thing into PLACE of a goal's text; return the text, and the name of that other thing.

        Args:
            on: where; "" for where the other one stands.

        Raises:
            Refusal: no goal says so.
        """
        relation = "next to" if link.relation in ("next to", "nearest") else link.relation
        if relation in ("between", "farthest"):
            said = f"{' '.join(link.words)} {link.nouns[0].said}"
            raise Refusal(FALSE, f"no goal can express '{said}'; say on which thing {theme} shall be, or next to which one")
        needless = self._its.needless
        others = self._its.things(link.nouns[0], lambda n: n != theme, mentions).names
        self._its.needless = needless  # "behind the jug on the counter" says where
        if on and others == (on,):
            raise Refusal(FALSE, f"{theme} cannot be on {on} and {' '.join(link.words)} it")
        fixed = len(others) == 1 and not self._its.scene.world.thing(others[0]).movable
        if fixed and not on and self._its.holds(("on",), theme, others[0]):
            raise Refusal(FALSE, f"{theme} is on {others[0]}, and no goal can name a side of it; say next to which thing {theme} shall be")
        if len(others) != 1:
            raise Refusal(OPEN, f"'{link.nouns[0].said}' are {listed(list(others), 'and')}; say next to which one")
        other, form = others[0], _placing(phrases)
        if region := self._region_beside(other, relation):
            return form.replace("PLACE", region), other
        where = on or _put_on(other, mentions)
        if not where:
            form, where = self._support(other, form)
        if not where:
            raise Refusal(FALSE, f"it is not known what {other} stands on, so there is no place {' '.join(link.words)} it")
        side = NEAR if relation == "next to" else self._its.space.side_word(relation)
        return f"{form.replace('PLACE', where)} {side} {other}", other

    def _region_beside(self, other: str, relation: str) -> str:
        """Return a region of furniture whose name says that it is beside a thing, such as
        "table/plate_right_region"; "" if there is none."""
        side = {"left of": "left", "right of": "right", "in front of": "front", "behind": "back", "next to": NEAR}.get(relation, relation)
        called = self._labels.of[other]
        for thing in self._its.scene.world.things:
            for feature in thing.features if thing.furniture and thing.name != other else ():
                said = _words(feature.name) - _words(thing.name)
                named = any(set(head) <= said for head in (*called.names, *called.heads) if head) or said - {side} - REGIONS <= called.words
                if side in said and "init" not in said and named and said - {side} - REGIONS:
                    return str(EntityName(thing.name, feature.name))
        return ""

    def _support(self, name: str, form: str) -> tuple[str, str]:
        """Return (phrase, place) of the goal that a thing be where it is now; if no phrase fits, ``form``
        and the furniture below the thing."""
        try:
            phrase, place = self.now(name)
            return phrase.form, place
        except Refusal:
            things = self._its.scene.world.things
            return form, self._its.space.below(name, [t.name for t in things if not t.movable and t.geoms])


def _words(name: str) -> set[str]:
    from ..ontology.taxonomy import words_of

    return set(normal(words_of(name)))


def _put_on(name: str, mentions: Mentions) -> str:
    """Return the place to which an earlier part of the sentence moves a thing; "" if none does, or if it
    names several places."""
    pairs = zip(reversed(mentions.themes), reversed(mentions.places), strict=True)
    last = next((places for themes, places in pairs if name in themes and places and name in mentions.put), ())
    return thing_of(last[0]) if len(last) == 1 else ""


def _placing(phrases: tuple[GoalPhrase, ...]) -> str:
    return next((p.form for p in phrases if "PLACE" in p.form.split()), "")


def meaningful(phrase: GoalPhrase, resolver: Resolver, *things: str) -> bool:
    """Check whether a goal phrase has a meaning for given things."""
    try:
        phrase.meaning(resolver.scene, *things)
    except (UserError, KeyError):
        return False
    return True
