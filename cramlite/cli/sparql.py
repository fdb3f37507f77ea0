"""``cramlite query``: SPARQL over ontologies and episodes together. rdflib is imported only when a query is asked."""

from __future__ import annotations

import argparse
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..base.errors import PluginError, UserError
from ..base.value import Value
from ..model.episode import Episode
from ..ontology.prefixes import PREFIXES, curie
from ..ontology.taxonomy import content_of, ontology_files
from .arguments import Add, plugin_choice
from .texts import counted

_OUTSIDE = {"ServiceGraphPattern": "SERVICE", "DatasetClause": "FROM"}
"""Operators with which rdflib opens an address or a file."""

if TYPE_CHECKING:
    import rdflib

    from ..plugin.registry import Registry


class Answer(Value):
    """Solutions of a SPARQL query.

    Args:
        columns: names of the variables; "answer" for ASK, "subject", "predicate", "object" for CONSTRUCT.
        rows: a value for each column: text, numbers, truth values, None where unbound; IRIs in short form.
    """

    columns: tuple[str, ...]
    rows: tuple[tuple[Any, ...], ...]


def query_text(text: str) -> str:
    """Return the text of a query, read from a file for ``@file``.

    Raises:
        UserError: the file cannot be read.
    """
    if not text.startswith("@"):
        return text
    try:
        return Path(text[1:]).read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise UserError(f"{text[1:]}: the query cannot be read: {error}; give @FILE of a SPARQL text.") from None


def ask(sparql: str, ontologies: Iterable[Path], episodes: Sequence[Episode], registry: Registry) -> Answer:
    """Run a SPARQL query over ontology files and episodes in one graph; the prefixes of cramlite's ontologies
    need no declaration.

    Raises:
        UserError: the query is no SPARQL, or changes data, or no plugin can express an episode as triples.
        PluginError: what a plugin gives as triples is none.
    """
    prepared = _prepared(sparql)
    graph = _graph(ontologies)
    for episode in episodes:
        lines = registry.first("episode_triples", episode=episode)
        if lines is None:
            raise UserError(f"No plugin can express the episode '{episode.name}' as triples; see 'cramlite plugins'.")
        try:
            graph.parse(data="".join(lines), format="nt")
        except Exception as error:  # whatever a plugin yields, and rdflib says of it
            said = " ".join(str(error).split())[:200]
            raise PluginError(
                f"A plugin's triples of '{episode.name}' (episode_triples) are no N-Triples: {said}. See 'cramlite plugins'."
            ) from error
    return _answer(graph.query(prepared))


def _prepared(sparql: str) -> Any:
    from rdflib.plugins.sparql import prepareQuery

    try:
        prepared = prepareQuery(sparql, initNs=PREFIXES)
    except Exception as error:  # pyparsing's errors, and rdflib's own, share no class
        words = " ".join(str(error).split())[:300]
        raise UserError(
            f"This is no SPARQL query: {words}. Write for example 'SELECT ?task WHERE {{ ?task "
            f"rdfs:subClassOf soma:PhysicalTask }}'; the prefixes {', '.join(PREFIXES)} are known."
        ) from None
    if outside := next((_OUTSIDE[name] for name in _operators(prepared.algebra) if name in _OUTSIDE), None):
        raise UserError(f"'{outside}' would read another file or address; a query is answered from the ontologies and episodes alone.")
    return prepared


def _operators(part: Any) -> Iterator[str]:
    """Yield the names of the SPARQL operators in a query, nested ones included."""
    if isinstance(part, dict):
        yield str(getattr(part, "name", ""))
    for inner in part.values() if isinstance(part, dict) else part if isinstance(part, list | tuple) else ():
        yield from _operators(inner)


def _graph(ontologies: Iterable[Path]) -> rdflib.Graph:
    from ..ontology.owl_files import parse

    return parse([(file, content_of(file)) for file in ontology_files(ontologies)])


def _answer(result: Any) -> Answer:
    if result.type == "ASK":
        return Answer(("answer",), ((bool(result.askAnswer),),))
    columns = [str(v) for v in result.vars] if result.type == "SELECT" else ["subject", "predicate", "object"]
    return Answer(tuple(columns), tuple(tuple(_shown(value) for value in row) for row in result))


def _shown(node: Any) -> Any:
    import rdflib

    if isinstance(node, rdflib.URIRef):
        return curie(str(node), PREFIXES)
    if isinstance(node, rdflib.Literal):
        value = node.toPython()
        return value if isinstance(value, str | int | float | bool) else str(node)
    return None if node is None else str(node)


def table(answer: Answer) -> str:
    """Format an answer for people: a table, and its number of rows."""
    lines = [list(answer.columns), *[["" if v is None else str(v) for v in row] for row in answer.rows]]
    widths = [max(len(line[k]) for line in lines) for k in range(len(answer.columns))]
    shown = ["  ".join(v.ljust(w) for v, w in zip(line, widths, strict=True)).rstrip() for line in lines]
    rule = "  ".join("-" * w for w in widths)
    return "\n".join([shown[0], rule, *shown[1:], f"{counted(len(answer.rows), 'row')}"])


def to_json(answer: Answer) -> dict[str, Any]:
    """Return an answer in the form of ``cramlite query --json``."""
    return {"columns": list(answer.columns), "rows": [list(row) for row in answer.rows]}


def _query(arguments: argparse.Namespace) -> int:
    from ..base.json_text import as_json
    from ..engine.engine import Engine
    from .texts import warn_of

    engine = Engine.with_plugins(plugin_choice(arguments))
    episodes = [engine.read_episode(path) for path in arguments.episode]
    found = ask(query_text(arguments.sparql), engine.knowledge.ontology_paths, episodes, engine.registry)
    print(as_json(to_json(found)) if arguments.json else table(found))
    warn_of(engine.registry.faults)
    return 0


def add_commands(add: Add) -> None:
    """Add the command ``query``, with its arguments, to the command line."""
    query = add("query", _query)
    query.add_argument(
        "sparql", metavar="SPARQL",
        help="a query, or @FILE that holds one; the prefixes dul, soma, artm, vrps, cram need no declaration",
    )
    query.add_argument(
        "--episode", type=Path, action="append", default=[], metavar="PATH",
        help="an episode to ask about as well; may be given several times",
    )
    query.add_argument("--json", action="store_true", help="print columns and rows as JSON")
