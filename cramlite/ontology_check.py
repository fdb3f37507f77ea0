"""Checking ontologies: consistency, agreement of the fast taxonomy with OWL-RL, and with the originals.

This is slow (an OWL-RL closure takes seconds), so results are cached by content and nothing
at start-up or over an episode asks for it.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from .ontology import Taxonomy, cache_folder, load_taxonomy, ontology_files, write_cache

_ERROR = "http://www.daml.org/2002/03/agents/agent-ont#error"
"""What owlrl links its reports of contradictions with."""

ORIGINALS = ("soma:", "dul:")
"""Namespaces whose classes must exist in the originals. artm: and vrps: come from the paper's own files."""


@dataclass(frozen=True)
class OntologyReport:
    """What a check found. Every list is empty when all is well.

    Args:
        contradictions: what OWL-RL reports, and classes that nothing can belong to.
        lost: subclass relations that OWL-RL derives and the fast taxonomy does not.
        invented: subclass relations that the fast taxonomy claims and OWL-RL does not derive.
        repairs: what was read differently from how it was written.
        missing: classes of SOMA or DUL that the originals do not have; only if compared.
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
        """Whether nothing needs a person's attention; repairs do not."""
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
    closure = _cached_closure(files, cache or cache_folder())
    missing, unsupported = _compare(taxonomy, load_taxonomy(against, cache)) if against is not None else ((), ())
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
    """The report for people, one finding a line."""
    lines = [f"{report.classes} classes: {'sound' if report.sound else 'not sound'}"]
    for kind, findings in asdict(report).items():
        if kind != "classes":
            lines += [f"{kind}: {finding}" for finding in findings]
    return lines


def _compare(ours: Taxonomy, original: Taxonomy) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Classes that the originals do not have, and subclass claims between theirs that do not follow there."""
    theirs = sorted(c for c in ours.classes if c.startswith(ORIGINALS))
    missing = tuple(c for c in theirs if c not in original.classes)
    claims = ((c, p) for c in theirs for p in ours.parents.get(c, ()) if p.startswith(ORIGINALS))
    false = (f"{c} < {p}" for c, p in claims if c in original.classes and not original.is_a(c, p))
    return missing, tuple(false)


def _cached_closure(files: list[Path], cache: Path) -> dict[str, Any]:
    contents = [file.read_bytes() for file in files]
    digest = hashlib.sha256(b"closure-1" + b"".join(hashlib.sha256(c).digest() for c in contents))
    stored = cache / f"closure-{digest.hexdigest()[:32]}.json"
    try:
        data = json.loads(stored.read_text(encoding="utf-8"))
        if {"subclasses", "contradictions"} <= set(data):
            return data  # type: ignore[no-any-return]
    except (OSError, ValueError, TypeError):
        pass
    data = _closure(list(zip(files, contents, strict=True)))
    write_cache(stored, data)
    return data


def _closure(files: list[tuple[Path, bytes]]) -> dict[str, Any]:
    """The OWL-RL closure's named subclass pairs, without literal subjects, and its contradictions."""
    import owlrl
    import rdflib
    from rdflib.namespace import OWL, RDF, RDFS

    from .ontology import curie
    from .ontology_files import parse, prefixes_of

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
