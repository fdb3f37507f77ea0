"""Safe parsing of RDF files to plain dictionaries, with rdflib behind guards: size, format, entity declarations."""

from __future__ import annotations

import logging
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING
from xml.sax import SAXParseException

from cramlite.plugin import UserError, check_json_ld, check_xml

from .fields import local_name

if TYPE_CHECKING:
    from rdflib import Graph

#: Larger files are no event logs: RobCoG writes about 1 kB an event; rdflib needs about 30 times the file's size.
MAX_BYTES = 32 * 2**20
#: Longest line of N-Triples [bytes]: rdflib's time grows with the square, 28 s for 2 MB.
MAX_LINE = 2**19
FORMATS = {
    ".owl": "xml",
    ".rdf": "xml",
    ".xml": "xml",
    ".ttl": "turtle",
    ".nt": "nt",
    ".n3": "n3",
    ".jsonld": "json-ld",
}
#: subject local name -> predicate local name -> objects: IRIs whole, literals as text.
Individuals = dict[str, dict[str, list[str]]]


def parse(path: Path) -> Graph:
    """Parse an RDF file.

    Raises:
        UserError: too large, functional syntax, harmful entities, or not well-formed; names file and line.
    """
    from rdflib import Graph

    size = path.stat().st_size
    if size > MAX_BYTES:
        raise UserError(
            f"{path}: {size / 1e6:.0f} MB of RDF; event logs and maps up to {MAX_BYTES / 1e6:.0f} MB are read. "
            "Split the log by episode; poses belong into a tf collection (mongodump), which has no such limit."
        )
    text = path.read_text(encoding="utf-8", errors="replace")
    format_ = FORMATS.get(path.suffix.lower(), "xml")
    if format_ == "xml":
        _check_xml(path, text)
    if format_ == "json-ld":
        check_json_ld(path, text)
    if format_ == "nt" and (long := next((k for k, t in enumerate(text.splitlines(), 1) if len(t) > MAX_LINE), None)):
        raise UserError(f"{path}:{long}: a line of more than {MAX_LINE} characters; write the file as Turtle (.ttl).")
    try:
        with _quiet():
            return Graph().parse(data=text, format=format_)
    except Exception as error:
        line, said = _complaint(error)
        reason = " ".join(said.split())[:300]
        raise UserError(
            f"{path}{line}: cannot be read as RDF ({format_}): {reason}. Check that the file is complete."
        ) from None


def _complaint(error: Exception) -> tuple[str, str]:
    """Line (":12", or "" if unknown) and message of an rdflib parser's error, without the file content that
    it quotes."""
    if isinstance(error, SAXParseException):
        return f":{error.getLineNumber()}", error.getMessage()
    before = getattr(error, "lines", None)  # of Turtle: lines that end before
    return "" if before is None else f":{before + 1}", str(getattr(error, "_why", error))


@contextmanager
def _quiet() -> Iterator[None]:
    """Silence rdflib's log of each literal that is not of its datatype; readers report the ones that
    matter."""
    logger = logging.getLogger("rdflib.term")
    before = logger.disabled
    logger.disabled = True
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            yield
    finally:
        logger.disabled = before


def _check_xml(path: Path, text: str) -> None:
    head = text.lstrip("\ufeff \t\r\n")[:200]
    if head.startswith(("Prefix(", "Prefix:", "Ontology(", "Ontology:")):
        raise UserError(
            f"{path}:1: this is OWL in functional or Manchester syntax; RDF/XML or Turtle is read. Convert it, "
            "for example with Protégé (save as RDF/XML) or 'robot convert --format owl'."
        )
    if not head.startswith("<"):
        raise UserError(
            f"{path}:1: this is no XML: it begins with {head[:20]!r}. RDF/XML begins with <?xml or <rdf:RDF."
        )
    check_xml(path, text)


def individuals(graph: Graph) -> Individuals:
    """Return the statements of an RDF graph about each subject, by local names, since versions of RobCoG's format
    differ in namespaces only."""
    found: Individuals = {}
    for s, p, o in graph:
        found.setdefault(local_name(str(s)), {}).setdefault(local_name(str(p)), []).append(str(o))
    return found
