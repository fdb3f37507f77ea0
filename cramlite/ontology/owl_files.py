"""Parsing of ontology files with rdflib, and extraction of the data of ``Taxonomy``; this module is imported only
if the cache lacks these data."""

from __future__ import annotations

import logging
import re
from collections.abc import Iterator
from contextlib import contextmanager
from decimal import Decimal
from pathlib import Path
from typing import Any
from xml.sax import SAXParseException

import rdflib
from rdflib.collection import Collection
from rdflib.namespace import OWL, RDF, RDFS, SKOS

from ..base.errors import UserError
from ..base.guarded_files import check_json_ld, check_xml
from .functional_syntax import is_functional, parse_functional
from .prefixes import PREFIXES, curie, local_name

Node = rdflib.term.Node
SYNTAXES = "Turtle (.ttl), RDF/XML (.owl, .rdf), N-Triples (.nt), JSON-LD (.jsonld) or OWL functional syntax (.owl, .ofn)"
_OWL_XML = re.compile(rb"<(?:\w+:)?Ontology\b[^>]*http://www\.w3\.org/2002/07/owl#")


def parse(files: list[tuple[Path, bytes]], origins: dict[Node, tuple[str, int]] | None = None) -> rdflib.Graph:
    """Parse several files, in Turtle, RDF/XML, JSON-LD or OWL functional syntax, into one graph.

    Args:
        origins: is given the file, by name and number, of every restriction.

    Raises:
        UserError: a file is in another syntax, or broken; names the file, the parser's words and a way out.
    """
    graph = rdflib.Graph()
    for number, (path, content) in enumerate(files):
        syntax = _syntax(path, content)
        data = content if syntax == "xml" else _text(path, content)  # XML says itself how it is encoded
        _check(path, syntax, data)
        try:
            with _quiet():
                if syntax == "functional":
                    parse_functional(str(data), graph)
                else:
                    graph.parse(data=data, format=syntax, publicID=path.as_uri() if path.is_absolute() else None)
        except Exception as error:  # rdflib's parsers raise whatever their lexers raise
            line, words = _complaint(error)
            raise UserError(
                f"{path}{line}: this cannot be read as an ontology: {words}. "
                f"It should be {SYNTAXES}; correct it there, or write it anew if it was cut off"
            ) from None
        if origins is not None:
            for node in graph.subjects(OWL.onProperty):
                origins.setdefault(node, (path.name, number))
    return graph


def _check(path: Path, syntax: str, data: bytes | str) -> None:
    """Refuse text that makes a parser open other files or addresses, or take far more memory than the file's
    size."""
    if isinstance(data, bytes):
        check_xml(path, data)
    elif syntax == "json-ld":
        check_json_ld(path, data)


def _syntax(path: Path, content: bytes) -> str:
    start = content[:4000].lstrip(b"\xef\xbb\xbf \t\r\n")
    lines = [line for line in start.splitlines() if line.strip() and not line.startswith(b"#")]
    if not content.strip():
        raise UserError(f"{path}: this file is empty; an ontology is {SYNTAXES}")
    if is_functional(content.decode("utf-8", "replace")):
        return "functional"
    first = lines[0].lstrip() if lines else b""
    other = "Manchester syntax" if first.startswith((b"Prefix:", b"Ontology:")) else "OWL/XML" if _OWL_XML.search(start) else ""
    if other:
        raise UserError(
            f"{path}: this file is in {other}, which is not read here. Convert it: 'robot convert -i {path.name} -o {path.stem}.rdf', "
            f"or save it from Protege as RDF/XML; what is read is {SYNTAXES}"
        )
    if first.startswith((b"[", b"{")) and path.suffix.lower() not in (".ttl", ".n3"):
        return "json-ld"
    return "xml" if first.startswith(b"<") and not first.startswith(b"<http") else "turtle"


def _text(path: Path, content: bytes) -> str:
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        raise UserError(f"{path}:{line}: this is not UTF-8 text (byte {error.start}); save it as UTF-8") from None


@contextmanager
def _quiet() -> Iterator[None]:
    """Silence rdflib's log of malformed IRIs in this block; the error that follows names the IRIs and the
    file."""
    logger = logging.getLogger("rdflib.term")
    before, logger.disabled = logger.disabled, True
    try:
        yield
    finally:
        logger.disabled = before


def _complaint(error: Exception) -> tuple[str, str]:
    """Return the place (":line" or "") and the message of an rdflib parser's error, without the file content
    that it quotes."""
    if isinstance(error, SAXParseException):
        return f":{error.getLineNumber()}", error.getMessage()
    before = getattr(error, "lines", None)  # of Turtle: lines that end before
    return "" if before is None else f":{before + 1}", " ".join(str(getattr(error, "_why", error)).split())[:300]


def prefixes_of(graph: rdflib.Graph) -> dict[str, str]:
    """Return cramlite's prefixes and those that the files add; a file cannot redefine a prefix of
    cramlite."""
    prefixes = dict(PREFIXES)
    for prefix, namespace in graph.namespaces():
        if prefix and prefix not in prefixes and str(namespace) not in prefixes.values():
            prefixes[prefix] = str(namespace)
    return prefixes


def extract(files: list[tuple[Path, bytes]]) -> dict[str, Any]:
    """Extract the data of ``Taxonomy`` from ontology files, as JSON data."""
    origins: dict[Node, tuple[str, int]] = {}
    graph = parse(files, origins)
    prefixes = prefixes_of(graph)
    parents, restrictions = _classes(graph, prefixes, origins)
    return {
        "parents": {c: sorted(p) for c, p in sorted(parents.items())},
        "restrictions": {c: sorted(map(list, r), key=str) for c, r in sorted(restrictions.items())},
        "aliases": _aliases(graph, prefixes),
        "synonyms": _synonyms(graph),
        "types": _individuals(graph, prefixes),
        "prefixes": prefixes,
        "repairs": [*_strays(graph), *_cycles(graph, prefixes)],
    }


Said = tuple[str, Any, str, str, int]
"""Fields of a ``Restriction`` as a plain tuple: property, filler, source, file, order."""


def _classes(
    graph: rdflib.Graph, prefixes: dict[str, str], origins: dict[Node, tuple[str, int]]
) -> tuple[dict[str, set[str]], dict[str, set[Said]]]:
    parents: dict[str, set[str]] = {}
    restrictions: dict[str, set[Said]] = {}
    for node in set(graph.subjects(RDF.type, OWL.Class)) | set(graph.subjects(RDFS.subClassOf)):
        if isinstance(node, rdflib.URIRef):
            parents.setdefault(curie(node, prefixes), set())
    for name, node in _superclasses(graph, prefixes):
        for member in _members(graph, node, set()):
            if isinstance(member, rdflib.URIRef):
                parents.setdefault(name, set()).add(curie(member, prefixes))
            for property_, filler in _restriction(graph, member, prefixes):
                said = str(graph.value(member, RDFS.comment) or ""), *origins.get(member, ("", 0))
                restrictions.setdefault(name, set()).add((property_, filler, *said))
    return parents, restrictions


def _superclasses(graph: rdflib.Graph, prefixes: dict[str, str]) -> Iterator[tuple[str, Node]]:
    for predicate in (RDFS.subClassOf, OWL.equivalentClass):
        for subject, object_ in graph.subject_objects(predicate):
            if isinstance(subject, rdflib.URIRef) and subject != object_:
                yield curie(subject, prefixes), object_
            if predicate == OWL.equivalentClass and isinstance(object_, rdflib.URIRef) and subject != object_:
                yield curie(object_, prefixes), subject


def _members(graph: rdflib.Graph, node: Node, seen: set[Node]) -> Iterator[Node]:
    """Yield a class expression (an RDF node) and, if it is an intersection, its members: a subclass of an
    intersection is a subclass of each member."""
    if node in seen:
        return
    seen.add(node)
    yield node
    if isinstance(node, rdflib.BNode):
        for head in graph.objects(node, OWL.intersectionOf):
            for member in Collection(graph, head):
                yield from _members(graph, member, seen)


def _restriction(graph: rdflib.Graph, node: Node, prefixes: dict[str, str]) -> Iterator[tuple[str, Any]]:
    property_ = graph.value(node, OWL.onProperty) if isinstance(node, rdflib.BNode) else None
    if not isinstance(property_, rdflib.URIRef):
        return
    for filler in graph.objects(node, OWL.someValuesFrom):
        for member in _members(graph, filler, set()):
            if isinstance(member, rdflib.URIRef):
                yield curie(property_, prefixes), curie(member, prefixes)
    for value in graph.objects(node, OWL.hasValue):
        if isinstance(value, rdflib.URIRef):
            yield curie(property_, prefixes), curie(value, prefixes)
        elif isinstance(value, rdflib.Literal):
            number = value.toPython()
            yield curie(property_, prefixes), float(number) if isinstance(number, int | float | Decimal) else str(value)


def _aliases(graph: rdflib.Graph, prefixes: dict[str, str]) -> dict[str, str]:
    """Return further names of classes as name -> class: other labels, and names of close matches in other ontologies.

    Of a close match the last part of its name is taken.
    """
    found: dict[str, str] = {}
    for subject, label in sorted(graph.subject_objects(SKOS.altLabel), key=str):
        if isinstance(subject, rdflib.URIRef):
            found[str(label)] = curie(subject, prefixes)
    for subject, target in sorted(graph.subject_objects(SKOS.closeMatch), key=str):
        if isinstance(subject, rdflib.URIRef) and isinstance(target, rdflib.URIRef):
            found[local_name(curie(subject, prefixes))] = curie(target, prefixes)
    return found


def _synonyms(graph: rdflib.Graph) -> list[list[list[str]]]:
    """Return the labels of each concept: its synonyms, and hidden labels, which may also mean other
    concepts."""
    concepts = sorted(graph.subjects(RDF.type, SKOS.Concept), key=lambda c: sorted(map(str, graph.objects(c, SKOS.altLabel))))
    found = []
    for concept in concepts:
        own = {str(label) for kind in (SKOS.prefLabel, SKOS.altLabel) for label in graph.objects(concept, kind)}
        found.append([sorted(own), sorted(map(str, graph.objects(concept, SKOS.hiddenLabel)))])
    return sorted(found)


def _individuals(graph: rdflib.Graph, prefixes: dict[str, str]) -> dict[str, list[str]]:
    builtin = (str(OWL), str(RDF), str(RDFS))
    found: dict[str, set[str]] = {}
    for subject, class_ in graph.subject_objects(RDF.type):
        if (
            isinstance(subject, rdflib.URIRef)
            and isinstance(class_, rdflib.URIRef)
            and not str(class_).startswith(builtin)
        ):
            found.setdefault(curie(subject, prefixes), set()).add(curie(class_, prefixes))
    return {i: sorted(t) for i, t in sorted(found.items())}


def _strays(graph: rdflib.Graph) -> list[str]:
    slash = "http://www.ease-crc.org/ont/SOMA.owl/"
    strays = sorted(
        {str(n) for triple in graph for n in triple if isinstance(n, rdflib.URIRef) and n.startswith(slash)}
    )
    return [f"read {stray} as {stray.replace(slash, PREFIXES['soma'])}" for stray in strays]


def _cycles(graph: rdflib.Graph, prefixes: dict[str, str]) -> list[str]:
    """Return complaints about cycles of subClassOf axioms, which are legal OWL but nearly always a
    mistake."""
    above = {
        s: {o for o in graph.objects(s, RDFS.subClassOf) if isinstance(o, rdflib.URIRef) and o != s}
        for s in set(graph.subjects(RDFS.subClassOf))
        if isinstance(s, rdflib.URIRef)
    }
    reach = {start: _reach(above, start) for start in above}
    groups = {frozenset(o for o in reach[s] if s in reach.get(o, ())) for s in above if s in reach[s]}
    return sorted(
        f"cyclic subclass axioms: {', '.join(sorted(curie(str(c), prefixes) for c in group))} are below each "
        "other and so taken as the same class"
        for group in groups
    )


def _reach(above: dict[Any, set[Any]], start: Any) -> set[Any]:
    seen: set[Any] = set()
    todo = list(above.get(start, ()))
    while todo:
        node = todo.pop()
        if node not in seen:
            seen.add(node)
            todo.extend(above.get(node, ()))
    return seen
