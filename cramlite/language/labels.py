"""Labels of things: words of their names and classes, synonyms from ontologies, and colours."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from functools import cached_property

from ..base.value import Value
from ..interpretation.fluents import SymbolicWorld
from ..model.world.colour_words import COLOURS, colour_of
from ..model.world.thing import Thing
from ..ontology.foundation import OBJECT
from ..ontology.prefixes import local_name
from ..ontology.taxonomy import Synonyms, words_of
from .english import (
    FURNITURE,
    GENERAL,
    MATERIALS,
    PACKAGES,
    PATTERNS,
    REGIONS,
    SHADES,
    SIDES,
    SUBSTANCES,
    TECHNICAL,
    UNCOLOURED,
    Words,
    singular,
)

MATERIAL = "cram:material"
"""Property of a class that names its material."""
SHAPES = {"box": "block", "cylinder": "cylinder", "sphere": "ball"}
"""Shape of a geom -> the noun for it."""


def normal(words: Iterable[str]) -> Words:
    """Normalise words for comparison: nouns become singular, and shades one word for the colour."""
    return tuple(SHADES.get(w, MATERIALS.get(w, w)) for w in map(singular, words))


class Called(Value):
    """Words that can name one entity of the scene.

    Args:
        names: its own, and their ends, e.g. ("moka", "pot") and ("pot",).
        heads: names of its class.
        kinds: names of classes that its own is a kind of.
        synonyms: further ones, which ontologies list.
        words: that may stand before them.
        colours: that it is known to have; none where nothing is known.
        material: of its class; "" where none is known.
    """

    names: frozenset[Words]
    heads: frozenset[Words]
    kinds: frozenset[Words]
    synonyms: frozenset[Words]
    words: frozenset[str]
    colours: frozenset[str]
    material: str = ""


class Labels(Value, dict=True):
    """Words by which sentences may call each entity of a scene, with the colours of each.

    Args:
        scene: what there is.
    """

    scene: SymbolicWorld

    @cached_property
    def of(self) -> Mapping[str, Called]:
        """Thing name -> labels of the thing."""
        return {t.name: self._called(t.name) for t in self.scene.world.things}

    @cached_property
    def names(self) -> frozenset[str]:
        """Names of all things, in lower case."""
        return frozenset(name.lower() for name in self.of)

    @cached_property
    def kinds(self) -> frozenset[str]:
        """Nouns that a number follows in thing names: "can" of "can 4"."""
        return frozenset(head[-2] for c in self.of.values() for head in c.names if len(head) > 1 and head[-1].isdigit())

    @cached_property
    def vocabulary(self) -> frozenset[str]:
        """Every word by which a thing or a class of things may be called."""
        named = {w for c in self.of.values() for head in (*c.names, *c.heads, *c.synonyms) for w in head}
        named |= {w for c in self.of.values() for w in c.words}
        classes = {w for label in self.scene.taxonomy.labels for w in label}
        synonyms = {w for group in self.scene.taxonomy.synonyms for labels in group for label in labels for w in label}
        return frozenset(named | classes | synonyms | set(COLOURS) | set(SHADES) | PACKAGES | GENERAL | REGIONS | SUBSTANCES | PATTERNS)

    @cached_property
    def _calling(self) -> frozenset[str]:
        return frozenset(w for c in self.of.values() for h in (c.names | c.heads | c.kinds | c.synonyms) for w in h[-1:])

    def calls(self, word: str) -> bool:
        """Check whether a word, or its singular, is used to name something of the scene."""
        return bool({word, *normal((word,))} & self._calling)

    def fits(self, name: str, words: Words) -> int:
        """Return how well a noun phrase's words name a thing, from 5 to 0.

        5 is by the thing's name, 4 by its class, 3 by a superclass, 2 by a synonym, 1 by a single word, 0 not
        at all.
        """
        said, called = normal(words), self.of[name]
        if not said:
            return 5
        for level, heads in ((5, called.names), (4, called.heads), (3, called.kinds), (2, called.synonyms)):
            if any(said[k:] in heads and self._describe(name, self._known(said[:k], said[k:])) for k in range(len(said))):
                return level
        if said[-1] in PACKAGES and self._unspecific(name) and len(said) > 1:
            return self.fits(name, tuple(w for w in said[:-1]))
        if said[-1] in GENERAL and self.scene.world.thing(name).movable and self._describe(name, said[:-1]):
            return 2
        if said[-1] in FURNITURE and (said[:-1] in called.names or (len(said) == 1 and name in SIDES)):
            return int(self.scene.world.thing(name).furniture)  # "the left shelf" of a board that is called left
        named = any(w in called.words and w not in COLOURS for w in said)
        return 1 if named and self._describe(name, said) else 0

    def is_called(self, name: str, words: Words) -> bool:
        """Check whether words are a name of a thing, or of a class of it, as a whole."""
        called = self.of[name]
        return bool(words) and normal(words) in called.names | called.heads | called.synonyms

    def describes(self, name: str, words: Words) -> bool:
        """Check whether adjectives are true of a thing and include all its colours."""
        return self._describe(name, normal(words)) and self.exact(name, words)

    def by_name(self, name: str, words: Words) -> bool:
        """Check whether a thing's name contains all colour words of a phrase."""
        own, _ = _parts(name)
        return {*normal(words)} & {*COLOURS} <= {*own}

    def exact(self, name: str, words: Words) -> bool:
        """Check whether words include all colours of a thing: "the white mug" is not the mug that is white
        and yellow."""
        return not self.of[name].colours - set(normal(words))

    def unknown(self, words: Words) -> Words:
        """Return those of some words that name nothing in the scene or in the ontologies."""
        return tuple(w for w in words if not {w, singular(w)} & self.vocabulary and not re.fullmatch(r"[\d/_]+", w))

    def _known(self, words: Words, head: Words) -> Words:
        """Return adjectives without those that tell nothing of the things called so: a pattern that none of them is known to have, and a
        material where that of none is known."""
        alike = [c for c in self.of.values() if head in c.names | c.heads | c.kinds | c.synonyms]
        told = {w for c in alike for w in c.words}
        untold = PATTERNS if any(c.material or c.words & SUBSTANCES for c in alike) else PATTERNS | SUBSTANCES
        return tuple(w for w in words if w not in untold - told)

    def _describe(self, name: str, words: Iterable[str]) -> bool:
        """Check whether words before a noun are true of a thing; an unknown colour counts as true."""
        called = self.of[name]
        return all(w in called.words or w in called.colours or w in UNCOLOURED for w in words)

    def _unspecific(self, name: str) -> bool:
        """Check whether neither the name nor the class of a thing states its packaging, such as "can"."""
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
        kinds |= {normal((noun,)) for noun in thing.looks.nouns} - heads
        heads = heads - names
        shapes = _shapes(thing) if taxonomy.thing_named(name) is None else set()
        synonyms = (_synonyms(names | heads | kinds | shapes, taxonomy.synonyms) | shapes) - names - heads - kinds
        material = next((str(r.filler) for _, r in taxonomy.restrictions_on(thing.type, MATERIAL)), "")
        words = {*own, *rest, *thing.looks.colours, *filter(None, normal((material,)))}
        words |= {*(w for head in (*names, *heads, *kinds) for w in head)}
        if mounted and thing.joint is not None and thing.joint.parent in self.scene.types and thing.joint.parent != name:
            parent = self._called(thing.joint.parent)
            words |= parent.words | {w for head in (*parent.names, *parent.heads) for w in head}
        colours = ({*own} | {w for h in (*names, *heads) for w in h if len(h) == 1}) & set(COLOURS)
        if not colours & {*own}:
            colours = {c for c in ("" if thing.looks.colours else colour_of(thing),) if c} or colours
        nouns = (frozenset(names), frozenset(heads), frozenset(kinds), frozenset(synonyms))
        return Called(*nouns, frozenset(words), frozenset(colours), material)


def _shapes(thing: Thing) -> set[Words]:
    """Return the nouns for the shape of a movable thing with a single geom, such as "cylinder"."""
    shapes = {g.shape for g in thing.geoms if not g.part}
    return {(SHAPES[s],) for s in shapes if len(thing.geoms) == 1 and thing.movable and s in SHAPES}


def _parts(name: str) -> tuple[Words, Words]:
    """Split a thing's name into the words for its kind and those after its last number: "cabinet_1_top" gives
    "cabinet" and "top"."""
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
