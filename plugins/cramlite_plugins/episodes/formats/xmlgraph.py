"""Safe parsing of RDF files to plain dictionaries, with rdflib behind guards: size, format, entity declarations."""

from __future__ import annotations

import json
import logging
import re
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING
from xml.sax import SAXParseException

from cramlite.plugin import UserError

from .fields import local_name

if TYPE_CHECKING:
    from rdflib import Graph

#: Larger files are no event logs: RobCoG writes about 1 kB an event; rdflib needs about 30 times the file's size.
MAX_BYTES = 32 * 2**20
#: RobCoG declares six entities, namespaces of at most 60 characters. Longer or nested ones are bombs.
MAX_ENTITIES, MAX_ENTITY = 64, 300
#: Longest line of N-Triples [bytes]: rdflib's time grows with the square, 28 s for 2 MB.
MAX_LINE = 2**19
_ENTITY = re.compile(r"<!ENTITY\s+(%\s+)?(\S+)\s+(?:\"([^\"]*)\"|'([^']*)'|(\S+))")
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
        _check_contexts(path, text)
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
    """Where, as ":line" or "", and what a parser of rdflib objects to, without the bytes that it shows."""
    if isinstance(error, SAXParseException):
        return f":{error.getLineNumber()}", error.getMessage()
    before = getattr(error, "lines", None)  # of Turtle: lines that end before
    return "" if before is None else f":{before + 1}", str(getattr(error, "_why", error))


def _check_contexts(path: Path, text: str) -> None:
    """rdflib would fetch a context that is named by its address; reading a file must not open other files or the net."""
    try:
        open_: list[object] = [json.loads(text)]
    except (ValueError, RecursionError):
        raise UserError(f"{path}:1: cannot be read as JSON-LD: no JSON, or nested too deeply.") from None
    while open_:
        node = open_.pop()
        if isinstance(node, dict):
            for key, value in node.items():
                values = value if isinstance(value, list) else [value]
                if key in ("@context", "@import") and any(isinstance(v, str) for v in values):
                    raise UserError(
                        f"{path}:1: its {key} is kept elsewhere ({values[0]!s:.80}); write it into the file."
                    )
            open_ += node.values()
        elif isinstance(node, list):
            open_ += node


@contextmanager
def _quiet() -> Iterator[None]:
    """rdflib logs a traceback for each literal that is not of its datatype; readers report what matters themselves."""
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
    prolog = text[: text.find("<rdf:RDF")] if "<rdf:RDF" in text else text[:100_000]
    if "<!DOCTYPE" not in prolog and "<!ENTITY" not in text:
        return
    found = list(_ENTITY.finditer(text))
    for match in found:
        parameter, name, value = match[1], match[2], match[3] if match[3] is not None else match[4]
        line = text.count("\n", 0, match.start()) + 1
        if (match[5] or "").startswith(('"', "'")):
            raise UserError(f"{path}:{line}: the file ends within the declaration of entity '{name}'. Check that it is complete.")
        if (
            parameter
            or value is None
            or "&" in value
            or "%" in value
            or len(value) > MAX_ENTITY
            or len(found) > MAX_ENTITIES
        ):
            raise UserError(
                f"{path}:{line}: entity '{name}' is nested, external, or longer than {MAX_ENTITY} characters, "
                "which could exhaust memory or read other files. Only namespace abbreviations are accepted here."
            )


def individuals(graph: Graph) -> Individuals:
    """Return what a graph says of each subject, by local names: RobCoG's generations differ in namespaces only."""
    found: Individuals = {}
    for s, p, o in graph:
        found.setdefault(local_name(str(s)), {}).setdefault(local_name(str(p)), []).append(str(o))
    return found
