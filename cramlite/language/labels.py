"""Labels of things: words of their names and classes, synonyms that ontologies list, colours."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from functools import cached_property

from ..base.value import Value
from ..interpretation.fluents import SymbolicWorld
from ..model.colour_words import COLOURS, colour_of
from ..model.world import Thing
from ..ontology.foundation import OBJECT
from ..ontology.prefixes import local_name
from ..ontology.taxonomy import Synonyms, words_of
from .english import FURNITURE, GENERAL, MATERIALS, PACKAGES, REGIONS, SHADES, TECHNICAL, UNCOLOURED, Words, singular

SHAPES = {"box": "block", "cylinder": "cylinder", "sphere": "ball"}
"""Shape of a geom -> the noun for it."""


def normal(words: Iterable[str]) -> Words:
    """Return words as they are compared: nouns in the singular, one word for each colour."""
    return tuple(SHADES.get(w, MATERIALS.get(w, w)) for w in map(singular, words))


class Called(Value):
    """Labels of an entity.

    Args:
        names: its own, and their ends, e.g. ("moka", "pot") and ("pot",).
        heads: names of its class.
        kinds: names of classes that its own is a kind of.
        synonyms: further ones, which ontologies list.
        words: that may stand before them.
        colours: that it is known to have; none where nothing is known.
    """

    names: frozenset[Words]
    heads: frozenset[Words]
    kinds: frozenset[Words]
    synonyms: frozenset[Words]
    words: frozenset[str]
    colours: frozenset[str]


class Labels(Value, dict=True):
    """Labels of everything in a scene.

    Args:
        scene: what there is.
    """

    scene: SymbolicWorld

    @cached_property
    def of(self) -> Mapping[str, Called]:
        """Labels of each thing."""
        return {t.name: self._called(t.name) for t in self.scene.world.things}

    @cached_property
    def names(self) -> frozenset[str]:
        """Words that are names of things."""
        return frozenset(name.lower() for name in self.of)

    @cached_property
    def kinds(self) -> frozenset[str]:
        """Nouns of things that carry a number: "can" of "can 4"."""
        return frozenset(head[-2] for c in self.of.values() for head in c.names if len(head) > 1 and head[-1].isdigit())

    @cached_property
    def vocabulary(self) -> frozenset[str]:
        """Every word by which a thing, or a class of things, may be called."""
        named = {w for c in self.of.values() for head in (*c.names, *c.heads, *c.synonyms) for w in head}
        named |= {w for c in self.of.values() for w in c.words}
        classes = {w for label in self.scene.taxonomy.labels for w in label}
        synonyms = {w for group in self.scene.taxonomy.synonyms for labels in group for label in labels for w in label}
        return frozenset(named | classes | synonyms | set(COLOURS) | set(SHADES) | PACKAGES | GENERAL | REGIONS)

    @cached_property
    def _calling(self) -> frozenset[str]:
        return frozenset(w for c in self.of.values() for h in (c.names | c.heads | c.kinds | c.synonyms) for w in h[-1:])

    def calls(self, word: str) -> bool:
        """Check whether a word, or its singular, calls something of the scene."""
        return bool({word, *normal((word,))} & self._calling)

    def fits(self, name: str, words: Words) -> int:
        """Return how well words name a thing: 5 by its name, 4 by its class, 3 by a wider one, 2 by a synonym, 1 by a word, 0 not."""
        said, called = normal(words), self.of[name]
        if not said:
            return 5
        for level, heads in ((5, called.names), (4, called.heads), (3, called.kinds), (2, called.synonyms)):
            if any(said[k:] in heads and self._describe(name, said[:k]) for k in range(len(said))):
                return level
        if said[-1] in PACKAGES and self._unspecific(name) and len(said) > 1:
            return self.fits(name, tuple(w for w in said[:-1]))
        if said[-1] in GENERAL and self.scene.world.thing(name).movable and self._describe(name, said[:-1]):
            return 2
        if said[-1] in FURNITURE and said[:-1] in called.names and self.scene.world.thing(name).furniture:
            return 1  # "the left shelf" of a board that is called left
        named = any(w in called.words and w not in COLOURS for w in said)
        return 1 if named and self._describe(name, said) else 0

    def describes(self, name: str, words: Words) -> bool:
        """Check whether adjectives are true of a thing and name all its colours."""
        return self._describe(name, normal(words)) and self.exact(name, words)

    def by_name(self, name: str, words: Words) -> bool:
        """Check whether the colours among words are in a thing's name."""
        own, _ = _parts(name)
        return {*normal(words)} & {*COLOURS} <= {*own}

    def exact(self, name: str, words: Words) -> bool:
        """Check whether words name all colours of a thing: "the white mug" is not the white and yellow one."""
        return not self.of[name].colours - set(normal(words))

    def unknown(self, words: Words) -> Words:
        """Return the words that name nothing here or in the ontologies."""
        return tuple(w for w in words if not {w, singular(w)} & self.vocabulary and not re.fullmatch(r"[\d/_]+", w))

    def _describe(self, name: str, words: Iterable[str]) -> bool:
        """Whether words before a noun are true of a thing, as far as is known."""
        called = self.of[name]
        return all(w in called.words or w in called.colours or w in UNCOLOURED for w in words)

    def _unspecific(self, name: str) -> bool:
        """Whether neither name nor class gives the packaging of a thing."""
        called = self.of[name]
        return not any(head[-1] in PACKAGES for head in (*called.names, *called.heads))

    def _called(self, name: str) -> Called:
        thing, taxonomy = self.scene.world.thing(name), self.scene.taxonomy
        own, rest = _parts(name)
        mounted = thing.joint is not None and bool(thing.joint.parent)
        names: set[Words] = {own[k:] for k in range(len(own))} if own and not (mounted and rest) else set()
        names |= {(name.lower(),)} | {tuple(re.findall(r"[a-z]+|\d+", name.lower()))}
        classes = [c for c in taxonomy.ancestors(thing.type) if taxonomy.is_a(c, OBJECT)]
        heads = {normal(label) for label, class_ in taxonomy.labels.items() if class_ == thing.type}
        heads |= {normal(words_of(local_name(thing.type)))}
        kinds = {normal(label) for label, class_ in taxonomy.labels.items() if class_ in classes} - heads
        heads = heads - names
        shapes = _shapes(thing) if taxonomy.thing_named(name) is None else set()
        synonyms = (_synonyms(names | heads | kinds | shapes, taxonomy.synonyms) | shapes) - names - heads - kinds
        words = {*own, *rest, *(w for head in (*names, *heads, *kinds) for w in head)}
        if mounted and thing.joint is not None and thing.joint.parent in self.scene.types and thing.joint.parent != name:
            parent = self._called(thing.joint.parent)
            words |= parent.words | {w for head in (*parent.names, *parent.heads) for w in head}
        colours = ({*own} | {w for h in (*names, *heads) for w in h if len(h) == 1}) & set(COLOURS)
        if not colours & {*own}:
            colours = {c for c in (colour_of(thing),) if c} or colours
        return Called(frozenset(names), frozenset(heads), frozenset(kinds), frozenset(synonyms), frozenset(words), frozenset(colours))


def _shapes(thing: Thing) -> set[Words]:
    """Nouns for the shape of a thing that is of one shape."""
    shapes = {g.shape for g in thing.geoms if not g.part}
    return {(SHAPES[s],) for s in shapes if len(thing.geoms) == 1 and thing.movable and s in SHAPES}


def _parts(name: str) -> tuple[Words, Words]:
    """Words of a name for its kind, and those behind its last number: "cabinet_1_top"."""
    found = re.findall(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+|\d+", name)
    last = max((k for k, w in enumerate(found) if w.isdigit()), default=len(found))
    own, rest = found[:last], found[last:]
    kept = [normal(w.lower() for w in part if not w.isdigit() and w.lower() not in TECHNICAL) for part in (own, rest)]
    return kept[0] or kept[1], kept[1] if kept[0] else ()


def _synonyms(heads: set[Words], groups: Iterable[Synonyms]) -> set[Words]:
    found: set[Words] = set()
    for own, hidden in groups:
        labels = set(map(normal, own))
        if labels & heads:
            found |= labels | set(map(normal, hidden))
    return found
