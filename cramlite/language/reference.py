"""Resolution of noun phrases to things of the scene; an ambiguous or empty one is refused with the candidates."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import TYPE_CHECKING

from msgspec.structs import replace

from ..base.errors import UserError
from ..model.entity_name import thing_of
from ..model.world.colour_words import COLOURS
from ..ontology.foundation import BEARS
from ..ontology.prefixes import local_name
from ..ontology.taxonomy import words_of
from .english import ANYTHING, INWARD, ORDINALS, PACKAGES, REGIONS, ROBOT, SIZES, VIEWER, Words, singular
from .labels import Labels, normal
from .mentions import Mentions, Referents
from .nouns import RANKED
from .refusal import FALSE, OPEN, UNKNOWN, Refusal, listed
from .space import AXES
from .tree import UTMOST, Link, Noun

if TYPE_CHECKING:
    from ..interpretation.fluents import Fact, GoalCondition, SymbolicWorld
    from .frames import Frames
    from .space import Space

SIDEWAYS = ("left of", "right of", "in front of", "behind", *AXES)
"""Relations that mean a direction from another thing."""
About = Callable[[str], bool]
FILTERS = (
    *("phrase", "of", "with", "under", "state", "colour", "left of", "right of", "in front of", "behind", "between", "at", "except"),
    *AXES, "same", "here", "comment",
)


class Resolver:
    """Resolver of noun phrases to things of one scene.

    Args:
        scene: what there is.
        facts: that hold in it.
        frames: whose prepositions and adjectives descriptions use.
        labels: what things are called.
        space: where they are.

    Attributes:
        needless: relations in descriptions, so far, without which they would mean the same.
    """

    def __init__(self, scene: SymbolicWorld, facts: frozenset[Fact], frames: Frames, labels: Labels, space: Space) -> None:
        self.scene, self.facts, self.frames, self.labels, self.space = scene, facts, frames, labels, space
        self.fresh()

    def fresh(self) -> None:
        """Forget what was noted on one way of reading a sentence (needless relations, sizes), before the next
        way is tried."""
        self.needless = 0
        self._sizes: dict[str, int] = {}

    def things(self, noun: Noun, about: About, mentions: Mentions) -> Referents:
        """Return the things that a noun phrase means.

        Args:
            about: whether a thing can be meant at all.
            mentions: what was named before.

        Raises:
            Refusal: none is, or too many are.
        """
        if noun.members:
            if noun.quantity == "none":
                noun = replace(noun, joined="and")
            members = [self.things(m, about, mentions) for m in noun.members]
            names = tuple(dict.fromkeys(n for m in members for n in m.names))
            return Referents(noun.said, names, some=int(noun.joined == "or"))
        if noun.pronoun:
            meant = self._meant_before(noun, about, mentions)
            self._kept(list(meant.names), noun, mentions)
            return meant
        found = self.pool(noun, about, mentions)
        before = [n for n in found if n in mentions.every - mentions.put]
        one = noun.quantity == "the" and not (noun.several or noun.count or noun.other) and len(before) == 1
        return self._counted(noun, before if one else found)

    def pool(self, noun: Noun, about: About, mentions: Mentions) -> list[str]:
        """Return all things that a noun phrase may mean.

        Raises:
            Refusal: there is none.
        """
        if noun.members or noun.pronoun:
            return list(self.things(noun, about, mentions).names)
        noun = _unpacked(noun)
        found = self._called(noun, about, mentions)
        found = self._kept(found, noun, mentions)
        for link in (k for k in noun.links if k.relation in ("next to", *UTMOST) and not k.denied):
            found = self._nearest(found, noun, link, mentions)
        return self._placed(found, noun, mentions)

    def _kept(self, found: list[str], noun: Noun, mentions: Mentions) -> list[str]:
        """Return, of the things ``found``, those for which the relations of a noun phrase hold, such as "on
        the tray"."""
        for link in (k for k in noun.links if k.relation in FILTERS or k.denied):
            kept = self._related(found, link, mentions)
            if not kept:
                raise Refusal(FALSE, f"'{noun.said}' is not in the scene: {self._not_so(found, noun, link)}")
            self.needless += len(kept) == len(found)
            found = kept if noun.several else self._straight(kept, link, mentions)
        return found

    def _straight(self, names: list[str], link: Link, mentions: Mentions) -> list[str]:
        """Return, of several things on one side of another, those that are rather straight there than askew; all if none or each is."""
        if link.relation not in SIDEWAYS or link.denied or len(names) < 2:
            return names
        others = self.pool(link.nouns[0], _anything, mentions)
        return [n for n in names if any(n != o and self.space.straight(n, link.relation, o) for o in others)] or names

    def holds(self, preposition: Words, thing: str, place: str, *, parts: bool = True) -> bool:
        """Check whether a thing is at a place in the sense of a preposition; with ``parts``, contents of a part are contents
        of the whole."""
        mounted = [t.name for t in self.scene.world.things if parts and t.joint is not None and t.joint.parent == place]
        phrases, wheres = self.frames.of_preposition(preposition), [at for at in (place, *mounted) if at != thing]
        return any(self.so(p.meaning, thing, at) for p in phrases for at in wheres)

    def so(self, meaning: Callable[..., object], *things: str) -> bool:
        """Check whether the state that a goal phrase means holds in the present scene."""
        from ..interpretation.fluents import GoalCondition

        try:
            asked = meaning(self.scene, *things)
        except (UserError, KeyError):
            return False
        return isinstance(asked, GoalCondition) and (bool(asked.needs) or len(things) == 1) and self.true(asked)

    def true(self, asked: GoalCondition) -> bool:
        """Check whether a goal condition holds in the present scene; False if it requires no fact."""
        positive = asked.needs or asked.shown
        return bool(positive) and positive <= self.facts

    def anywhere(self, thing: str, place: str) -> bool:
        """Check whether a thing is at a place in the sense of any preposition."""
        return any(self.holds(p, thing, place) for p in self.frames.prepositions)

    # By words

    def _called(self, noun: Noun, about: About, mentions: Mentions) -> list[str]:
        """Return the things that fit the words of a noun phrase."""
        every = [n for n in self.labels.of if not (noun.other and n in mentions.every)]
        if whole := self._of_kind(noun, every, about, mentions):
            return self._called(whole, about, mentions)
        if not noun.words:
            words = mentions.words[-1:] if noun.other else mentions.words
            found = [n for n in every if self.labels.fits(n, words) > 1 and about(n)] if words else []
            return found or [n for n in every if self.scene.world.thing(n).movable and about(n)]
        if named := [n for n in every if self.labels.is_called(n, _with_size(noun)) and about(n)]:
            return named
        fits = {n: self.labels.fits(n, noun.words) for n in every}
        if {*normal(noun.words)} & {*COLOURS}:  # the white mug is not the white and yellow one
            every = [n for n in every if fits[n] > 1 and self.labels.exact(n, noun.words)] or every
            every = [n for n in every if fits[n] > 1 and self.labels.by_name(n, noun.words)] or every
        if {*normal(noun.words)} & REGIONS and not any(fits.values()):
            return self._layers(noun, about, mentions)
        for level in (5, 4, 3, 2, 1):
            named = [n for n in every if fits[n] == level]
            suited = [n for n in named if about(n)] or self._parts(named, about)
            if suited:
                return suited
        raise self._unknown(noun, [n for n in every if fits[n]])

    def _of_kind(self, noun: Noun, names: Sequence[str], about: About, mentions: Mentions) -> Noun | None:
        """Return "the red one" as a noun phrase of a kind that was named before; None if no kind makes one, or it is a name itself."""
        if not (noun.elided and noun.words) or any(self.labels.fits(n, noun.words) and about(n) for n in names):
            return None
        before = (words[-1:] for words in (mentions.words, mentions.earlier, mentions.where) if words)
        wholes = (replace(noun, words=(*noun.words, *kind), elided=False) for kind in before)
        return next((w for w in wholes if any(self.labels.fits(n, w.words) > 1 and about(n) for n in names)), None)

    def _layers(self, noun: Noun, about: About, mentions: Mentions) -> list[str]:
        """Return parts of the things that a noun phrase means: "the top layer of the cabinet" is a drawer."""
        owners = [n for k in noun.links if k.relation == "of" for n in self.pool(k.nouns[0], _anything, mentions)]
        found = [n for n in owners if about(n) and self.scene.world.thing(n).joint is not None] or self._parts(owners, about)
        if not found:
            raise self._unknown(noun, [])
        return found

    def _parts(self, wholes: Iterable[str], about: About) -> list[str]:
        """Return the parts on joints of some things, such as a stove's knob, that suit the request."""
        inside = set(wholes)
        return [t.name for t in self.scene.world.things if t.joint is not None and t.joint.parent in inside and about(t.name)]

    def _unknown(self, noun: Noun, unsuited: list[str]) -> Refusal:
        if unsuited:
            return Refusal(FALSE, f"'{noun.said}' is {listed(unsuited)}, for which the request makes no sense")
        words = self.labels.unknown(noun.words)
        alike = [n for n in self.labels.of if self.labels.fits(n, noun.words[-1:])]
        if alike and not self.labels.unknown(noun.words[-1:]):
            places = listed([self.space.place(n) for n in alike], "and")
            strange = [w for w in noun.words[:-1] if not any(self.labels.describes(n, (w,)) for n in alike)] or list(noun.words[:-1])
            known = f"nothing is known of {listed([repr(w) for w in strange])} at {places}"
            return Refusal(FALSE, f"there is no '{noun.said}' here: {known}; say {listed([repr(n) for n in alike], 'or')}")
        if words:
            said = listed([repr(w) for w in words])
            return Refusal(UNKNOWN, f"nothing here is called {said} (in '{noun.said}'); there are: {self._names()}")
        return Refusal(FALSE, f"there is no '{noun.said}' here; there are: {self._names()}")

    def _names(self) -> str:
        return ", ".join(t.name for t in self.scene.world.things)

    # By relations

    def _related(self, names: list[str], link: Link, mentions: Mentions) -> list[str]:
        """Return those of the named things to which a relation applies, such as "on the stove"."""
        if link.denied:
            related = self._related(names, replace(link, denied=False), mentions)
            return [n for n in names if n not in related]
        if link.relation == "colour":
            return [n for n in names if self.labels.describes(n, link.words)]
        if link.relation == "state":
            form = self.frames.states[link.words[0]]
            phrases = [f.phrase for f in self.frames.unary if f.phrase.form == form]
            return [n for n in names if any(self.so(p.meaning, n) for p in phrases)]
        if link.relation in ("here", "comment"):
            return names
        if link.relation == "between":
            others = self.things(link.nouns[0], _anything, mentions).names
            if len(others) != 2:
                raise Refusal(FALSE, f"a thing is between two others, and '{link.nouns[0].said}' names {listed(list(others), 'and')}")
            between = [n for n in names if n not in others and self.space.beside(n, "between", others)]
            return [n for n in between if self.space.crosses(n, *others)] or between
        if link.relation == "except":
            return self._without(names, link, mentions)
        if link.relation == "with" and (having := self._having(names, link.nouns[0]) or self._marked(names, link.nouns[0])):
            return having
        others = tuple(self.pool(link.nouns[0], _anything, mentions))
        if link.relation == "same":
            return [n for n in names if n in others]
        every = [n for n in names if any(self._relates(n, o, link) if n != o else link.relation == "of" for o in others)]
        return self._outside(every, others, link) or every

    def _outside(self, names: list[str], others: Sequence[str], link: Link) -> list[str]:
        """Return those of some things that are at a place itself, such as on the cabinet and not in its drawer."""
        if link.relation != "phrase" or {*link.words} <= INWARD:
            return []
        return [n for n in names if any(n != o and self.holds(link.words, n, o, parts=False) for o in others)]

    def _without(self, names: list[str], link: Link, mentions: Mentions) -> list[str]:
        """Return some things without the excepted ones, which must be among them."""
        left_out = self.things(link.nouns[0], lambda n: n in names, mentions)
        if not {*left_out.names} <= {*names}:
            raise Refusal(FALSE, f"'{link.nouns[0].said}' is {left_out.listed}, which is not among {listed(names, 'and')}")
        return [n for n in names if n not in left_out.names]

    def _having(self, names: list[str], noun: Noun) -> list[str]:
        """Return those of the named things that have a certain feature, such as a hole."""
        word = noun.words[-1:]
        its = {n: self.scene.world.thing(n).features for n in names}
        return [n for n, features in its.items() if word and any(word[0] in words_of(local_name(f.type)) for f in features)]

    def _marked(self, names: list[str], noun: Noun) -> list[str]:
        """Return those of the named things that have the colours of a part that is no thing here, such as "the green cap"."""
        colours = {*normal(noun.words)} & {*COLOURS}
        if not colours or self.labels.calls(noun.words[-1]):
            return []
        looks = {n: self.scene.world.thing(n).looks for n in names}
        return [n for n in names if colours <= {*self.labels.of[n].colours, *looks[n].colours, *looks[n].marks}]

    def _hollow(self, place: str) -> bool:
        """Check whether a thing, or a part that is mounted on it by a joint, has a cavity."""
        world = self.scene.world
        parts = (t for t in world.things if t.name == place or (t.joint is not None and t.joint.parent == place))
        return any("inside" in self.scene.taxonomy.fillers(f.type, BEARS) for t in parts for f in t.features)

    def _relates(self, name: str, other: str, link: Link) -> bool:
        if link.relation == "phrase":
            taken = link.words in (("from",), ("out", "of"))
            loosely = taken or ({*link.words} <= INWARD and not self._hollow(other))  # "in the cupboard", which is modelled as a board
            return self.holds(link.words, name, other) or (loosely and self.anywhere(name, other))
        if link.relation == "of":
            joint, its = self.scene.world.thing(name).joint, self.scene.world.thing(other).joint
            has = link.words == ("of",) and its is not None and its.parent == name  # "the chest of drawers"
            return has or (joint is not None and joint.parent == other) or (link.words == ("'s",) and name.startswith(f"{other}_"))
        if link.relation == "at":
            return self.anywhere(name, other)
        if link.relation in ("with", "under"):
            return self.anywhere(other, name) or (link.relation == "under" and self.space.is_under(name, other))
        return self.space.beside(name, link.relation, (other,))

    def _not_so(self, names: list[str], noun: Noun, link: Link) -> str:
        where = " ".join((*("not",) * link.denied, *link.words, *(n.said for n in link.nouns))).replace("on_top_of", "on top of")
        return f"of {listed([self.space.place(n) for n in names], 'and')} none is {where}"

    def _nearest(self, names: list[str], noun: Noun, link: Link, mentions: Mentions) -> list[str]:
        if observer := {*link.nouns[0].words} & (ROBOT | VIEWER):
            return self.space.from_observer(names, robot=bool(observer & ROBOT), far=link.relation == "farthest")
        others = [o for o in self.pool(link.nouns[0], _anything, mentions) if o not in names or len(names) > 1]
        near = [(n, o) for n in names for o in others if n != o and (link.relation != "next to" or self._next_to(n, o))]
        if not near:
            raise Refusal(FALSE, f"'{noun.said}' is not in the scene: {self._gaps(names, others, link)}")
        if noun.several or noun.quantity != "the":
            return [n for n in names if any(n == a for a, _ in near)]
        far = link.relation == "farthest"
        chosen = (max if far else min)(near, key=lambda p: self.space.apart(*p))[1]
        return self.space.nearest([n for n in names if (n, chosen) in near], chosen, far=far)

    def _next_to(self, name: str, other: str) -> bool:
        return self.space.beside(name, "next to", (other,)) and not self.anywhere(name, other) and not self.anywhere(other, name)

    def _gaps(self, names: list[str], others: Sequence[str], link: Link) -> str:
        said = [f"{n} is {1000 * self.space.gap(n, o):.0f} mm from {o}" for n in names for o in others if n != o]
        return f"{listed(said, 'and')}; 'next to' means at most 350 mm" if said else f"nothing is {' '.join(link.words)} it"

    # By position among others

    def _placed(self, names: list[str], noun: Noun, mentions: Mentions) -> list[str]:
        """Return those of the named things that match a noun phrase's size, side or ordinal: "big",
        "left", "second"."""
        if noun.size:
            names = self._sized(names, noun)
        sides = [(s, None) for s in noun.sides] + [(k.words[0], k) for k in noun.links if k.relation == "side"]
        if noun.ordinal:
            own = [n for n in names if ORDINALS.get(n.lower()) == noun.ordinal]
            own = own or ([] if sides else self._numbered(names, noun.ordinal))
            if own and not sides:
                return own  # it is a name
            if not sides and len(names) > 1:
                raise Refusal(OPEN, f"'{noun.said}': it is not said from where {listed(names, 'and')} are counted; say 'from the left'")
            return self._ordinal(names, noun, sides[-1][0] if sides else "left")
        if noun.sides and noun.count > 1 and noun.quantity in ("all", "the") and len(names) > noun.count:  # "the top two"
            return sorted(names, key=lambda n: -self.space.along(n, noun.sides[0]))[: noun.count]
        for side, link in sides:
            found = self._at_side(names, noun, side, link, mentions)
            self.needless += link is not None and len(found) == len(names)
            names = found
        return names

    def _numbered(self, names: list[str], ordinal: int) -> list[str]:
        """Return the thing whose name has a given number: can 2 for "the second can"; empty unless all names
        have numbers."""
        numbers = {n: {h[-1] for h in self.labels.of[n].names if len(h) > 1 and h[-1].isdigit()} for n in names}
        return [n for n in names if str(ordinal) in numbers[n]] if all(numbers.values()) else []

    def _sized(self, names: list[str], noun: Noun) -> list[str]:
        height, sign = abs(noun.size) == 2, 1.0 if noun.size > 0 else -1.0
        size = {n: sign * self.space.size(n, height=height) for n in names}
        if not names:
            raise Refusal(FALSE, f"'{noun.said}' is not in the scene")
        best = max(size.values())
        found = [n for n in names if size[n] >= best - 0.05 * abs(best)]
        if len(found) == 1 and self._sizes.setdefault(found[0], noun.size) == -noun.size:
            raise Refusal(FALSE, f"'{noun.said}' means {found[0]}, which the sentence called by the opposite size before")
        if len(found) == len(names) > 1 and not noun.several:
            raise Refusal(FALSE, f"'{noun.said}': {listed(names, 'and')} are of one size, within 5 %")
        return found

    def _ordinal(self, names: list[str], noun: Noun, side: str) -> list[str]:
        order = sorted(names, key=lambda n: -self.space.along(n, side if side != "middle" else "left"))
        k = noun.ordinal - 1 if noun.ordinal > 0 else -1
        if k >= len(order):
            raise Refusal(FALSE, f"'{noun.said}' is not in the scene: there are only {len(order)}")
        return [order[k]]

    def _at_side(self, names: list[str], noun: Noun, side: str, link: Link | None, mentions: Mentions) -> list[str]:
        by_name = [n for n in names if side in self.labels.of[n].words and self.scene.world.thing(n).joint is not None]
        if len(by_name) == 1 and len(names) > 1:
            return by_name
        if link is not None and link.nouns:
            names, whole = self._on_whole(names, noun, link, mentions)
            if side == "middle":
                return self.space.nearest(names, whole)
        if len(names) == 1:
            if not self.space.is_at(names[0], side):
                raise Refusal(
                    FALSE, f"'{noun.said}' is not in the scene: there is only {self.space.place(names[0])}, which is not at the {side}"
                )
            return names
        found = self.space.middle(names) if side == "middle" else self.space.most(names, side)
        if not found:
            raise Refusal(OPEN, f"of {listed([self.space.place(n) for n in names], 'and')} none stands between the others ('{noun.said}')")
        return found

    def _on_whole(self, names: list[str], noun: Noun, link: Link, mentions: Mentions) -> tuple[list[str], str]:
        """Return the things that are on the thing whose side is named: "on the left side of the table"."""
        wholes = self.pool(link.nouns[0], _anything, mentions)
        found = [n for n in names if any(n != w and self.space.gap(n, w) == 0 for w in wholes)]
        if not found:
            raise Refusal(FALSE, f"'{noun.said}' is not in the scene: none of {listed(names)} is on {listed(wholes)}")
        return found, wholes[0]

    # By number

    def _counted(self, noun: Noun, names: list[str]) -> Referents:
        count = noun.count
        if noun.quantity == "a":
            return Referents(noun.said, tuple(names), some=int(len(names) > 1))
        if noun.quantity in ("all", "none") or (noun.quantity == "the" and noun.several):
            if len(names) == 1 and noun.several and not noun.elided and self._one(noun, names[0]):
                raise Refusal(FALSE, f"'{noun.said}' is a plural, but there is only {self.space.place(names[0])}")
            if (count and len(names) != count) or (noun.quantity == "all" and count == 2 and len(names) != 2):
                places = listed([self.space.place(n) for n in names], "and")
                raise Refusal(FALSE, f"'{noun.said}' are {count}, but there are {len(names)}: {places}")
            return Referents(noun.said, tuple(names))
        if noun.quantity == "number" and len(names) > count:
            return Referents(noun.said, tuple(names), some=count)
        if len(names) > max(count, 1):
            raise Refusal(OPEN, self.which(noun, names))
        if len(names) < count:
            raise Refusal(FALSE, f"'{noun.said}' are {count}, but there is only {listed(names, 'and')}")
        return Referents(noun.said, tuple(names))

    def _one(self, noun: Noun, name: str) -> bool:
        """Check whether a noun in the plural may mean a single thing: only if the thing's name does not
        contain the noun."""
        return bool(noun.words) and noun.words != ANYTHING and noun.words[-1] not in name.lower()

    def which(self, noun: Noun, names: list[str]) -> str:
        """Return a question which of several things is meant, with a property that tells one apart."""
        kind = noun.words[-1] if noun.words else "one"
        tell = [s for s in ("left", "right", "front", "back", "top", "bottom") if len(self.space.most(names, s)) == 1]
        said = f"'the {tell[0]} {singular(kind)}'" if tell else f"its name, '{names[0]}'"
        places = listed([self.space.place(n) for n in names])
        return f"'{noun.said}' may be {places}; say {said}" + (f", as seen from {self.space.view.name}" if tell else "")

    def _meant_before(self, noun: Noun, about: About, mentions: Mentions) -> Referents:
        """Return the things that a pronoun refers to: the last ones named that suit the request."""
        def known(group: tuple[str, ...]) -> tuple[str, ...]:
            wholes = tuple(dict.fromkeys(map(thing_of, group)))
            return wholes if all(map(about, wholes)) else tuple(self._parts(wholes, about))

        if noun.pronoun in RANKED and len(mentions.two) == 2:
            return Referents(noun.said, known((mentions.two[RANKED.index(noun.pronoun)],)))
        last_some = next((n for group, n in mentions.some if group == mentions.themes[-1]), 0)
        if last_some and noun.several == (last_some > 1):
            return Referents(noun.said, mentions.themes[-1], some=last_some)
        if noun.several:
            last: tuple[tuple[str, ...], ...] = (*(mentions.themes[-1:]), *(mentions.places[-1:]))
            together = tuple(dict.fromkeys(n for g in last for n in map(thing_of, g) if about(n)))
            groups = [known(g) for g in (*reversed(mentions.themes), *reversed(mentions.places)) if len(g) > 1 and known(g)]
            found = groups[0] if groups else together
            if len(found) < 2:
                earlier = tuple(dict.fromkeys(n for g in mentions.themes for n in map(thing_of, g) if about(n)))
                found = earlier if len(earlier) > 1 else found
        else:
            groups = [known(g) for k in range(len(mentions.themes) - 1, -1, -1) for g in (mentions.themes[k], mentions.places[k])]
            single = [g for g in groups if len(g) == 1]
            found = single[0] if single else ()
        if not found or (noun.count and len(found) != noun.count):
            raise Refusal(OPEN, f"'{noun.said}' refers to nothing named before for which the request makes sense; name the thing")
        return Referents(noun.said, found)


def _with_size(noun: Noun) -> Words:
    """Return what a thing is called together with the size before it, which may be its name: "small dish"; () without a size."""
    said = tuple(noun.said.split())
    end = said.index(noun.words[-1]) + 1 if noun.size and noun.words[-1] in said else 0
    begin = next((k for k in range(end) if said[k] in SIZES), end)
    return said[begin:end]


def _anything(_name: str) -> bool:
    return True


def _unpacked(noun: Noun) -> Noun:
    """Return a noun phrase of a packaging as one of the packaged product: "a can of soup" means a soup."""
    if not noun.words or singular(noun.words[-1]) not in PACKAGES or singular(noun.words[-1]) in REGIONS:
        return noun
    for k, link in enumerate(noun.links[:1]):
        if link.relation == "of" and link.words == ("of",) and link.nouns[0].words and link.nouns[0].quantity != "all":
            inner = link.nouns[0]
            words = (*inner.words, *noun.words[:-1], noun.words[-1])
            return replace(noun, words=words, links=(*noun.links[:k], *noun.links[k + 1 :], *inner.links))
    return noun
