"""Checks of ontologies: consistency, and agreement of the fast taxonomy with an OWL-RL closure and with the original ontologies.

This is slow (an OWL-RL closure takes seconds), so results are cached by content and nothing
at start-up or over an episode asks for it.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

from msgspec import to_builtins

from ..base.cache import cache_folder, keep_file
from ..base.value import Value
from .taxonomy import Taxonomy, content_of, load_taxonomy, ontology_files

_ERROR = "http://www.daml.org/2002/03/agents/agent-ont#error"
"""Property with which owlrl links its reports of contradictions."""

ORIGINALS = ("soma:", "dul:")
"""Namespaces whose names must occur in the original ontologies. The namespaces artm: and vrps: come from the paper's own files."""


class OntologyReport(Value):
    """Report of a check of ontologies; every list is empty if nothing was found.

    Args:
        contradictions: what OWL-RL reports, and classes that nothing can belong to.
        lost: subclass relations that OWL-RL derives and the fast taxonomy does not.
        invented: subclass relations that the fast taxonomy claims and OWL-RL does not derive.
        repairs: what was read differently from how it was written.
        missing: names of SOMA or DUL (classes, properties, roles) that the originals do not have; only if compared.
        unsupported: subclass claims between them that do not follow there; only if compared.
        classes: how many classes were checked.
    """

    contradictions: tuple[str, ...] = ()
    lost: tuple[str, ...] = ()
    invented: tuple[str, ...] = ()
    repairs: tuple[str, ...] = ()
    missing: tuple[str, ...] = ()
    unsupported: tuple[str, ...] = ()
    classes: int = 0

    @property
    def sound(self) -> bool:
        """Whether the check of the ontologies found no error that a person has to correct."""
        return not (self.contradictions or self.lost or self.invented or self.missing or self.unsupported)


def check_ontology(
    paths: Iterable[Path | str], against: Iterable[Path | str] | None = None, cache: Path | None = None
) -> OntologyReport:
    """Check ontologies, and optionally compare them with the originals that they re-use.

    Args:
        paths: files or folders to check.
        against: files or folders of SOMA and DUL (RDF/XML or Turtle).
        cache: folder for results; None means the user's cache folder.

    Raises:
        UserError: a file cannot be read.
    """
    files = ontology_files(paths)
    taxonomy = load_taxonomy(files, cache)
    closure = _cached("closure-1", files, cache or cache_folder(), _closure)
    missing, unsupported = (
        _compare(files, taxonomy, ontology_files(against), cache) if against is not None else ((), ())
    )
    derived = {tuple(pair) for pair in closure["subclasses"]}
    claimed = {(c, a) for c in taxonomy.classes for a in taxonomy.ancestors(c) if a != c}
    known = {(a, b) for a, b in derived if a in taxonomy.classes and b in taxonomy.classes}
    return OntologyReport(
        contradictions=tuple(closure["contradictions"]),
        lost=tuple(f"{a} < {b}" for a, b in sorted(known - claimed)),
        invented=tuple(f"{a} < {b}" for a, b in sorted(claimed - derived)),
        repairs=taxonomy.repairs,
        missing=missing,
        unsupported=unsupported,
        classes=len(taxonomy.classes),
    )


def report_lines(report: OntologyReport) -> list[str]:
    """Format a report for people, one finding a line."""
    lines = [f"{report.classes} classes: {'sound' if report.sound else 'not sound'}"]
    for kind, findings in to_builtins(report).items():
        if kind != "classes":
            lines += [f"{kind}: {finding}" for finding in findings]
    return lines


def _compare(
    files: list[Path], ours: Taxonomy, originals: list[Path], cache: Path | None
) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return the names of SOMA and DUL that the original ontologies lack, and the subclass claims about such names
    that do not follow from the originals."""
    theirs, folder = load_taxonomy(originals, cache), cache or cache_folder()
    known = set(_cached("names-1", originals, folder, _names)["names"]) | theirs.classes
    missing = tuple(n for n in _cached("names-1", files, folder, _names)["names"] if n not in known)
    claims = ((c, p) for c in sorted(ours.classes) for p in ours.parents.get(c, ()))
    both = ((c, p) for c, p in claims if c.startswith(ORIGINALS) and p.startswith(ORIGINALS))
    false = (f"{c} < {p}" for c, p in both if c in theirs.classes and not theirs.is_a(c, p))
    return missing, tuple(false)


def _names(files: list[tuple[Path, bytes]]) -> dict[str, Any]:
    """Return every name of SOMA and DUL that occurs in some files, sorted."""
    import rdflib

    from .owl_files import parse, prefixes_of
    from .prefixes import curie

    graph = parse(files)
    prefixes = prefixes_of(graph)
    found = {curie(str(node), prefixes) for triple in graph for node in triple if isinstance(node, rdflib.URIRef)}
    return {"names": sorted(name for name in found if name.startswith(ORIGINALS))}


def _cached(kind: str, files: list[Path], cache: Path, make: Callable[[list[tuple[Path, bytes]]], Any]) -> Any:
    """Return a result computed from some files, from the cache if a result for equal contents is stored."""
    contents = [content_of(file) for file in files]
    digest = hashlib.sha256(kind.encode() + b"".join(hashlib.sha256(c).digest() for c in contents))
    stored = cache / f"{kind}-{digest.hexdigest()[:32]}.json"
    try:
        return json.loads(stored.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        data = make(list(zip(files, contents, strict=True)))
        keep_file(stored, json.dumps(data).encode())
        return data


def _closure(files: list[tuple[Path, bytes]]) -> dict[str, Any]:
    """Return the subclass pairs of named classes in the OWL-RL closure of some files, and the contradictions
    in it."""
    import owlrl
    import rdflib
    from rdflib.namespace import OWL, RDF, RDFS

    from .owl_files import parse, prefixes_of
    from .prefixes import curie

    graph = parse(files)
    prefixes = prefixes_of(graph)
    for node in {n for t in graph.triples((None, RDFS.subClassOf, None)) for n in (t[0], t[2])}:
        graph.add((node, RDF.type, OWL.Class))  # a class that is only mentioned takes part as well
    owlrl.DeductiveClosure(owlrl.OWLRL_Semantics, axiomatic_triples=False, datatype_axioms=False).expand(graph)
    for triple in [t for t in graph if isinstance(t[0], rdflib.Literal)]:
        graph.remove(triple)
    pairs = sorted(
        (curie(str(a), prefixes), curie(str(b), prefixes))
        for a, b in graph.subject_objects(RDFS.subClassOf)
        if isinstance(a, rdflib.URIRef) and isinstance(b, rdflib.URIRef) and a != b
    )
    words = [str(o) for _, o in graph.subject_objects(rdflib.URIRef(_ERROR))]
    empty = [
        f"nothing can be a {curie(str(c), prefixes)}"
        for c in graph.subjects(RDFS.subClassOf, OWL.Nothing)
        if isinstance(c, rdflib.URIRef) and c != OWL.Nothing
    ]
    return {"subclasses": pairs, "contradictions": sorted({*words, *empty})}
