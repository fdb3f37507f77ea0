"""Taxonomy of ontologies: fast subclass, instance and affordance queries.

Turtle and RDF/XML files are read once with rdflib; what the engine needs of them
(named superclasses, restrictions, aliases) is cached by content, so that a second
start imports no rdflib. The class closure follows subClassOf, equivalentClass and
the members of owl:intersectionOf superclasses; against owlrl's OWL-RL closure of
SOMA it agrees on 4,725 of 4,726 pairs.
"""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Iterable
from functools import cached_property
from pathlib import Path
from typing import Any

from msgspec import field

from ..base.cache import cache_folder, keep_file
from ..base.errors import UserError, nearest
from ..base.value import Value
from .foundation import AGENT, OBJECT
from .prefixes import PREFIXES, curie, local_name

_CACHE_FORMAT = "5"
"""Version of the cached data of a taxonomy, part of the cache key. Raise it when the extracted data change."""


def words_of(name: str) -> tuple[str, ...]:
    """Split an identifier into words, in lower case and without numbers: "akita_black_bowl_1",
    "MilkBottle"."""
    return tuple(w.lower() for w in re.findall(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+", name))


def _labels(labels: Iterable[str]) -> tuple[tuple[str, ...], ...]:
    return tuple(map(words_of, labels))


Synonyms = tuple[tuple[tuple[str, ...], ...], tuple[tuple[str, ...], ...]]
"""Labels of a concept, then its hidden labels, each label as a tuple of words."""


class Restriction(Value):
    """OWL restriction ``subject subClassOf (property some|value filler)``; the filler is a class as a CURIE, or a number or text.

    Args:
        source: its rdfs:comment: why it is so.
        file: name of the ontology file that says so.
        order: of that file among all that were read: a later one has the last word on numbers.
    """

    property: str
    filler: str | float
    source: str = ""
    file: str = ""
    order: int = 0


class Taxonomy(Value, dict=True):
    """Class hierarchy, restrictions and individuals of a set of ontologies. All classes are CURIEs (IRIs where no prefix fits).

    Args:
        parents: class -> its direct named superclasses; equivalent classes are each other's superclass.
        restrictions: class -> the restrictions among its own superclasses.
        aliases: name that users or logs know, without namespace -> class.
        types: individual -> its classes.
        prefixes: prefix -> namespace.
        synonyms: groups of labels, as words in lower case: those by any of which people call the same (``skos:Concept``), and further
            ones that they also say of others (``skos:hiddenLabel``).
        repairs: what was read differently from how it was written, and why.
    """

    parents: dict[str, tuple[str, ...]]
    restrictions: dict[str, tuple[Restriction, ...]] = field(default_factory=dict)
    aliases: dict[str, str] = field(default_factory=dict)
    types: dict[str, tuple[str, ...]] = field(default_factory=dict)
    prefixes: dict[str, str] = field(default_factory=lambda: dict(PREFIXES))
    repairs: tuple[str, ...] = ()
    synonyms: tuple[Synonyms, ...] = ()

    @cached_property
    def _closure(self) -> dict[str, frozenset[str]]:
        return {}

    @cached_property
    def classes(self) -> frozenset[str]:
        """Every class that is mentioned in the ontologies."""
        return frozenset(self.parents) | {p for ps in self.parents.values() for p in ps}

    @cached_property
    def _locals(self) -> dict[str, str]:
        """Map the last part of a class's name to the class, for each such part that only one class has."""
        found: dict[str, str] = {}
        for name in sorted(self.classes):
            local = local_name(name)
            found[local] = "" if local in found else name
        return {local: name for local, name in found.items() if name}

    @cached_property
    def labels(self) -> dict[tuple[str, ...], str]:
        """Words of a class's name or alias, in lower case -> the class: ("milk", "bottle") -> "soma:MilkBottle"."""
        named = {**self._locals, **self.aliases}
        return {words: named[name] for name in sorted(named) if (words := words_of(name))}

    def curie(self, iri: str) -> str:
        """Convert an IRI to its CURIE; unchanged if no prefix fits."""
        return curie(iri, self.prefixes)

    def iri(self, name: str) -> str:
        """Expand a CURIE to its IRI; unchanged if the prefix is unknown (or it is an IRI already)."""
        prefix, _, rest = name.partition(":")
        return self.prefixes[prefix] + rest if prefix in self.prefixes else name

    def resolve(self, name: str) -> str | None:
        """Resolve a name to its class: a CURIE, an IRI, an alias, or a name without or with an unknown namespace;
        None if no class fits.

        Names of foreign namespaces are matched by their last part, because the namespaces of
        recorded logs changed from one generation to the next.
        """
        short = self.curie(name)
        if short in self.classes:
            return short
        local = local_name(short)
        return self.aliases.get(local) or self._locals.get(local)

    def thing_named(self, name: str) -> tuple[str, str] | None:
        """Return the class whose label occurs in a thing's name, and that label.

        The longest label wins; of several as long, the last.
        """
        words = words_of(name)
        for count in range(len(words), 0, -1):
            for start in range(len(words) - count, -1, -1):  # what a thing is stands last: a black bowl is a bowl
                label = words[start : start + count]
                found = self.labels.get(label)
                if found and self.is_a(found, OBJECT) and not self.is_a(found, AGENT):  # nor is a thing a feature
                    return found, " ".join(label)
        return None

    def known(self, name: str, where: str) -> str:
        """Resolve a class name written by a person, like ``resolve``, but raise an error if no such class exists.

        Raises:
            UserError: the class is unknown; the message names ``where`` and the nearest class.
        """
        found = self.resolve(name)
        if found is None:
            raise UserError(f"{where}: unknown class '{name}'; {nearest(name, self.classes)}")
        return found

    def ancestors(self, name: str) -> frozenset[str]:
        """Return the class itself and all its superclasses, transitively.

        Cycles are allowed: their members are equivalent. A foreign name has the superclasses of the class that it
        resolves to.
        """
        found = self._closure.get(name)
        if found is None:
            known = name if name in self.classes else self.resolve(name) or name
            seen, todo = {name, known}, [known]
            while todo:
                for parent in self.parents.get(todo.pop(), ()):
                    if parent not in seen:
                        seen.add(parent)
                        todo.append(parent)
            found = self._closure[name] = frozenset(seen)
        return found

    def is_a(self, name: str, other: str) -> bool:
        """Check whether class ``name`` is ``other`` or a subclass of it."""
        return other in self.ancestors(name)

    def any_is_a(self, names: Iterable[str], other: str) -> bool:
        """Check whether one of the classes is ``other`` or a subclass of it."""
        return any(other in self.ancestors(n) for n in names)

    def subclasses(self, name: str) -> tuple[str, ...]:
        """Return the class itself and all its subclasses, sorted."""
        return tuple(sorted(c for c in self.classes if name in self.ancestors(c)))

    def instances(self, name: str) -> tuple[str, ...]:
        """Return the individuals of a class, sorted."""
        return tuple(sorted(i for i, types in self.types.items() if self.any_is_a(types, name)))

    def depth(self, name: str) -> int:
        """Return the depth of a class in the hierarchy: the length of its longest chain of proper superclasses."""
        return self._depth(name, frozenset())

    def _depth(self, name: str, below: frozenset[str]) -> int:
        above = [p for p in self.parents.get(name, ()) if p not in below and p != name]
        return 1 + max((self._depth(p, below | {name}) for p in above), default=-1)

    def fillers(self, name: str, property_: str) -> tuple[str | float, ...]:
        """Return the fillers of a property in the restrictions of the class and its ancestors, nearest ancestors first.

        This is how affordances are asked: ``fillers("soma:Cup", "soma:hasDisposition")``. No OWL-RL
        closure derives them for an individual.
        """
        return tuple(dict.fromkeys(r.filler for _, r in self.restrictions_on(name, property_)))

    def restrictions_on(self, name: str, property_: str) -> tuple[tuple[str, Restriction], ...]:
        """Return the restrictions of the class and its ancestors on a property, each with the class that it is stated for.

        The nearest ancestors come first; of one class, what a later file says.
        """
        order = sorted(self.ancestors(name), key=lambda c: (-len(self.ancestors(c)), c))
        found = [(c, r) for c in order for r in self.restrictions.get(c, ()) if r.property == property_]
        place = {c: k for k, c in enumerate(order)}
        return tuple(sorted(found, key=lambda cr: (place[cr[0]], -cr[1].order, str(cr[1].filler))))

    def restricted_classes(self, property_: str) -> tuple[str, ...]:
        """Return the classes that have a restriction on a property themselves, not only inherited from an ancestor; sorted."""
        return tuple(sorted(c for c, found in self.restrictions.items() if any(r.property == property_ for r in found)))

    def offers(self, name: str, property_: str, wanted: str) -> bool:
        """Check whether some restriction of the class on the property has a filler of class ``wanted``."""
        return any(isinstance(f, str) and self.is_a(f, wanted) for f in self.fillers(name, property_))

    def affords(self, name: str, disposition: str) -> bool:
        """Check whether things of the class have a disposition, e.g. soma:Graspability."""
        return self.offers(name, "soma:hasDisposition", disposition)


def load_taxonomy(paths: Iterable[Path | str], cache: Path | None = None) -> Taxonomy:
    """Load the taxonomy of some ontology files (a folder stands for the .ttl, .owl and .rdf files in it).

    Args:
        paths: files or folders.
        cache: folder for the parsed form; None means the user's cache folder.

    Raises:
        UserError: a file is missing or is no ontology; the message says what would be right.
    """
    files = ontology_files(paths)
    contents = [content_of(file) for file in files]
    digest = hashlib.sha256(_CACHE_FORMAT.encode())
    for content in contents:
        digest.update(hashlib.sha256(content).digest())
    stored = (cache or cache_folder()) / f"taxonomy-{digest.hexdigest()[:32]}.json"
    data = _read_cache(stored)
    if data is None:
        from .owl_files import extract

        data = extract(list(zip(files, contents, strict=True)))
        keep_file(stored, json.dumps(data).encode())
    return Taxonomy(
        parents={c: tuple(p) for c, p in data["parents"].items()},
        restrictions={c: tuple(Restriction(*r) for r in rs) for c, rs in data["restrictions"].items()},
        aliases=data["aliases"],
        types={i: tuple(t) for i, t in data["types"].items()},
        prefixes=data["prefixes"],
        repairs=tuple(data["repairs"]),
        synonyms=tuple((_labels(own), _labels(hidden)) for own, hidden in data["synonyms"]),
    )


def _read_cache(path: Path) -> dict[str, Any] | None:
    """Return the cached data of a taxonomy; None if there is none or it is damaged."""
    try:
        data = json.loads(path.read_text(encoding="utf-8"))
        complete = {"parents", "restrictions", "aliases", "types", "prefixes", "repairs", "synonyms"} <= set(data)
    except (OSError, ValueError, TypeError):
        return None
    return data if complete else None


def ontology_files(paths: Iterable[Path | str]) -> list[Path]:
    """Return the ontology files at some paths: files, and all ontology files of folders.

    Raises:
        UserError: there is no such file, or none in a folder.
    """
    found: list[Path] = []
    for path in map(Path, paths):
        if path.is_dir():
            inside = sorted(p for p in path.iterdir() if p.suffix in {".ttl", ".owl", ".rdf", ".nt", ".ofn"})
            if not inside:
                raise UserError(f"{path}: there is no ontology in this folder; give one with .ttl, .owl or .rdf files")
            found += inside
        elif path.is_file():
            found.append(path)
        else:
            raise UserError(f"{path}: there is no such ontology file or folder; give a .ttl, .owl or .rdf file")
    return found


def content_of(path: Path) -> bytes:
    """Read an ontology file; refuse one that is too large to be an ontology."""
    limit = 200_000_000  # bytes; the largest published ontology in the field (SOMA, all modules) has 2 million
    if path.stat().st_size > limit:
        raise UserError(
            f"{path}: {path.stat().st_size / 1e6:.0f} MB is more than the {limit / 1e6:.0f} MB that is read "
            "as an ontology; is it an episode? Convert or split it first"
        )
    return path.read_bytes()
