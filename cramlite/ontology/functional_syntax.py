"""Reader of OWL 2 functional syntax, in which SOMA and many other ontologies are published: py-horned-owl converts
it to RDF/XML.

Its readers of OWL/XML and Manchester syntax are not used: a file that was cut off took them 22 GB (py-horned-owl 2.0.0).
"""

from __future__ import annotations

import re

import rdflib
from rdflib.namespace import OWL, RDF, RDFS, XSD

_BUILT_IN = {"owl": OWL, "rdf": RDF, "rdfs": RDFS, "xsd": XSD}
"""Prefixes that OWL 2 functional syntax predefines (W3C, OWL 2 Functional-Style Syntax, 2012, table 2). They are added to a text that
lacks them, since py-horned-owl requires their declaration."""
_PREFIX = re.compile(r"^[ \t]*Prefix[ \t]*\([ \t]*([\w.-]*):[ \t]*=[ \t]*<([^>]*)>", re.MULTILINE)
_BRACKET = re.compile(r'"(?:[^"\\]|\\.)*"|<[^>\s]*>|[()]')
"""Pattern of a bracket, and of a literal or an IRI, whose brackets do not count."""
DEEPEST = 100
"""Largest nesting depth of expressions in functional syntax. Ontologies have some ten levels; py-horned-owl overflows the stack at some
thousands."""
_PLACE = re.compile(r"positives: \[(.*?)\].*line_col: Pos\(\((\d+), (\d+)\)\)")
_SPAN = re.compile(r'ValidityError\("(.*?)", ByteSpan\((\d+)\.\.(\d+)\)\)')


def is_functional(text: str) -> bool:
    """Check whether a text is in OWL functional syntax: its first word after comments is ``Prefix(`` or
    ``Ontology(``."""
    return re.match(r"\ufeff?(?:\s|#[^\n]*\n)*(?:Prefix|Ontology)\s*\(", text) is not None


def parse_functional(text: str, graph: rdflib.Graph) -> None:
    """Add the statements of an ontology in functional syntax to a graph.

    Raises:
        ValueError: it is not in that syntax; says the line.
    """
    import pyhornedowl

    _check_depth(text)
    text = text.removeprefix("\ufeff")
    declared = dict(_PREFIX.findall(text))
    added = " ".join(f"Prefix({name}:=<{space}>)" for name, space in _BUILT_IN.items() if name not in declared)  # all lines stay
    try:
        made = pyhornedowl.open_ontology_from_string(added + text, "ofn").save_to_string("rdf")
    except ValueError as error:
        raise ValueError(_complaint(str(error), added + text, len(added))) from None
    graph.parse(data=made, format="xml")
    for name, space in declared.items():
        graph.bind(name, space)


def _check_depth(text: str) -> None:
    depth = 0
    for found in _BRACKET.finditer(text):
        depth += {"(": 1, ")": -1}.get(found[0], 0)
        if depth > DEEPEST:
            raise ValueError(f"line {text.count(chr(10), 0, found.start()) + 1}: the text is nested more than {DEEPEST} deep")


def _complaint(error: str, text: str, added: int) -> str:
    """Return py-horned-owl's error message with the line number and the text at the place of the error."""
    if found := _PLACE.search(error):
        line, column = int(found[2]), int(found[3]) - (added if found[2] == "1" else 0)
        rest = text[added:].split("\n")[line - 1][column - 1 :].strip()
        return f"line {line}: expected {found[1].replace(', ', ' or ')}, found {rest[:40]!r}" if rest else (
            f"line {line}: the text ends where the syntax needs {found[1].replace(', ', ' or ')}"
        )
    if found := _SPAN.search(error):
        content = text.encode()
        word = content[int(found[2]) : int(found[3])].decode("utf-8", "replace")
        return f"line {content[: int(found[2])].count(10) + 1}: {found[1]} in {word!r}"
    return error
