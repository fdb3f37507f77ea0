"""Reader of OWL 2 functional syntax, in which SOMA and many others publish their ontologies, to an RDF graph.

Grammar: W3C, OWL 2 Web Ontology Language: Structural Specification and Functional-Style Syntax (2012); which triples an axiom means:
OWL 2: Mapping to RDF Graphs (2012). Axioms that no taxonomy asks for (chains, keys, rules) are left out.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from itertools import combinations, pairwise

import rdflib
from rdflib.collection import Collection
from rdflib.namespace import OWL, RDF, RDFS, XSD

Node = rdflib.term.Node
Tree = tuple[str, "list[Tree | str]"]
"""A name with its arguments, in parentheses; a leaf is a token."""

_TOKEN = re.compile(
    r"""(?P<blank>\s+|\#[^\n]*) | (?P<iri><[^<>"{}|^`\\\s]*>) | (?P<literal>"(?:[^"\\]|\\.)*"(?:@[\w-]+|\^\^(?:<[^>]*>|[^\s()]+))?)
      | (?P<sign>[()=]) | (?P<name>[^\s()="<>]+)""",
    re.VERBOSE,
)
_BUILT_IN = {"owl": str(OWL), "rdf": str(RDF), "rdfs": str(RDFS), "xsd": str(XSD)}
_ENTITIES = {
    "Class": OWL.Class, "ObjectProperty": OWL.ObjectProperty, "DataProperty": OWL.DatatypeProperty, "Datatype": RDFS.Datatype,
    "AnnotationProperty": OWL.AnnotationProperty, "NamedIndividual": OWL.NamedIndividual,
}  # fmt: skip
_BINARY = {
    "SubClassOf": RDFS.subClassOf, "SubObjectPropertyOf": RDFS.subPropertyOf, "SubDataPropertyOf": RDFS.subPropertyOf,
    "SubAnnotationPropertyOf": RDFS.subPropertyOf, "ObjectPropertyDomain": RDFS.domain, "ObjectPropertyRange": RDFS.range,
    "DataPropertyDomain": RDFS.domain, "DataPropertyRange": RDFS.range, "InverseObjectProperties": OWL.inverseOf,
}  # fmt: skip
_KINDS = {
    "FunctionalObjectProperty": OWL.FunctionalProperty, "FunctionalDataProperty": OWL.FunctionalProperty,
    "InverseFunctionalObjectProperty": OWL.InverseFunctionalProperty, "TransitiveObjectProperty": OWL.TransitiveProperty,
    "SymmetricObjectProperty": OWL.SymmetricProperty, "AsymmetricObjectProperty": OWL.AsymmetricProperty,
    "ReflexiveObjectProperty": OWL.ReflexiveProperty, "IrreflexiveObjectProperty": OWL.IrreflexiveProperty,
}  # fmt: skip
_RESTRICTIONS = {
    "ObjectSomeValuesFrom": OWL.someValuesFrom, "DataSomeValuesFrom": OWL.someValuesFrom, "ObjectAllValuesFrom": OWL.allValuesFrom,
    "DataAllValuesFrom": OWL.allValuesFrom, "ObjectHasValue": OWL.hasValue, "DataHasValue": OWL.hasValue,
}  # fmt: skip
_COUNTS = {"Min": "minQualifiedCardinality", "Max": "maxQualifiedCardinality", "Exact": "qualifiedCardinality"}
_LISTS = {"ObjectIntersectionOf": OWL.intersectionOf, "ObjectUnionOf": OWL.unionOf, "ObjectOneOf": OWL.oneOf}


def is_functional(text: str) -> bool:
    """Check whether a text is in functional syntax: its first word, behind comments, is ``Prefix(`` or ``Ontology(``."""
    return re.match(r"\ufeff?(?:\s|#[^\n]*\n|//[^\n]*\n)*(?:Prefix|Ontology)\s*\(", text) is not None


def parse_functional(text: str, graph: rdflib.Graph) -> None:
    """Add what an ontology in functional syntax says to a graph.

    Raises:
        ValueError: it is not in that syntax; says the line.
    """
    reader = _Reader(graph)
    for name, arguments in _trees(text):
        if name == "Prefix":
            reader.prefix(arguments)
        elif name == "Ontology":
            for axiom in arguments:
                if isinstance(axiom, tuple):
                    reader.axiom(*axiom)


def _trees(text: str) -> Iterator[Tree]:
    """The outermost expressions."""
    stack: list[Tree] = []
    word = ""
    for line, token in _tokens(text):
        if token == "(":
            if not word and not stack:
                raise ValueError(f"line {line}: a name is missing before '('")
            stack.append((word, []))  # without a name inside of HasKey
        elif stack and word:
            stack[-1][1].append(word)
        elif word:
            raise ValueError(f"line {line}: '{word}' stands outside of every parenthesis")
        word = "" if token in "()" else token
        if token == ")":
            if not stack:
                raise ValueError(f"line {line}: this ')' closes nothing")
            done = stack.pop()
            if not stack:
                yield done
            else:
                stack[-1][1].append(done)
    if stack or word:
        raise ValueError(f"the text ends within '{stack[0][0] if stack else word}(', which is never closed")


def _tokens(text: str) -> Iterator[tuple[int, str]]:
    place, line = 0, 1
    text = re.sub(r"(?m)^//[^\n]*$", "", text.removeprefix("\ufeff"))
    while place < len(text):
        found = _TOKEN.match(text, place)
        if found is None:
            raise ValueError(f"line {line}: unexpected {text[place : place + 20]!r}")
        if found.lastgroup != "blank":
            yield line, found.group()
        line += found.group().count("\n")
        place = found.end()


class _Reader:
    def __init__(self, graph: rdflib.Graph) -> None:
        self.graph, self.prefixes = graph, dict(_BUILT_IN)

    def prefix(self, arguments: list[Tree | str]) -> None:
        words = [a for a in arguments if isinstance(a, str)]
        if len(words) != 3 or words[1] != "=" or not words[0].endswith(":"):
            raise ValueError("a prefix is written Prefix(name:=<IRI>)")
        self.prefixes[words[0][:-1]] = words[2][1:-1]
        self.graph.bind(words[0][:-1], words[2][1:-1])

    # Axioms

    def axiom(self, name: str, arguments: list[Tree | str]) -> None:
        """Add the triples of an axiom; of kinds that no taxonomy asks for, none."""
        given = [a for a in arguments if not (isinstance(a, tuple) and a[0] == "Annotation")]
        if name == "Declaration":
            self.declaration(given)
        elif name in _BINARY and len(given) == 2 and not (isinstance(given[0], tuple) and given[0][0] == "ObjectPropertyChain"):
            self.graph.add((self.node(given[0]), _BINARY[name], self.node(given[1])))
        elif name in _KINDS:
            self.graph.add((self.node(given[0]), RDF.type, _KINDS[name]))
        elif axiom := self.others().get(name):
            axiom(given)

    def others(self) -> dict[str, Callable[[list[Tree | str]], None]]:
        return {
            "EquivalentClasses": lambda a: self.each(pairwise(map(self.node, a)), OWL.equivalentClass),
            "DatatypeDefinition": lambda a: self.add(a[0], OWL.equivalentClass, a[1]),
            "EquivalentObjectProperties": lambda a: self.each(pairwise(map(self.node, a)), OWL.equivalentProperty),
            "DisjointClasses": lambda a: self.each(combinations(list(map(self.node, a)), 2), OWL.disjointWith),
            "DisjointUnion": self.disjoint_union,
            "ClassAssertion": lambda a: self.add(a[1], RDF.type, a[0]),
            "ObjectPropertyAssertion": lambda a: self.add(a[1], self.node(a[0]), a[2]),
            "DataPropertyAssertion": lambda a: self.add(a[1], self.node(a[0]), a[2]),
            "AnnotationAssertion": lambda a: self.add(a[1], self.node(a[0]), a[2]),
        }

    def add(self, subject: Tree | str, predicate: Node, value: Tree | str) -> None:
        self.graph.add((self.node(subject), predicate, self.node(value)))

    def each(self, pairs: Iterator[tuple[Node, Node]], predicate: Node) -> None:
        for one, other in pairs:
            self.graph.add((one, predicate, other))

    def declaration(self, given: list[Tree | str]) -> None:
        for entity in given:
            if isinstance(entity, tuple) and entity[0] in _ENTITIES:
                self.graph.add((self.node(entity[1][0]), RDF.type, _ENTITIES[entity[0]]))

    def disjoint_union(self, given: list[Tree | str]) -> None:
        self.add(given[0], OWL.equivalentClass, ("ObjectUnionOf", given[1:]))
        self.each(combinations(list(map(self.node, given[1:])), 2), OWL.disjointWith)

    # Expressions

    def node(self, expression: Tree | str) -> Node:
        """Return the node of an entity, a literal or a class expression, whose triples are added."""
        if isinstance(expression, str):
            return self.leaf(expression)
        name, given = expression
        node = rdflib.BNode()
        if name in _RESTRICTIONS:
            self.restriction(node, given[0], _RESTRICTIONS[name], self.node(given[1]))
        elif name in _LISTS:
            self.graph.add((node, RDF.type, OWL.Class))
            head = rdflib.BNode()
            Collection(self.graph, head, [self.node(a) for a in given])
            self.graph.add((node, _LISTS[name], head))
        elif name == "ObjectComplementOf":
            self.graph.add((node, RDF.type, OWL.Class))
            self.graph.add((node, OWL.complementOf, self.node(given[0])))
        elif name == "ObjectInverseOf":
            self.graph.add((node, OWL.inverseOf, self.node(given[0])))
        elif counted := re.fullmatch(r"(?:Object|Data)(Min|Max|Exact)Cardinality", name):
            count = rdflib.Literal(str(given[0]), datatype=XSD.nonNegativeInteger)
            self.restriction(node, given[1], OWL[_COUNTS[counted[1]]], count)
        return node

    def restriction(self, node: Node, property_: Tree | str, kind: Node, filler: Node) -> None:
        self.graph.add((node, RDF.type, OWL.Restriction))
        self.graph.add((node, OWL.onProperty, self.node(property_)))
        self.graph.add((node, kind, filler))

    def leaf(self, token: str) -> Node:
        if token.startswith("<"):
            return rdflib.URIRef(token[1:-1])
        if token.startswith('"'):
            return self.literal(token)
        if token.startswith("_:"):
            return rdflib.BNode(token[2:])
        prefix, colon, local = token.partition(":")
        if not colon or prefix not in self.prefixes:
            raise ValueError(f"'{token}' has no prefix that the text declares")
        return rdflib.URIRef(self.prefixes[prefix] + local)

    def literal(self, token: str) -> Node:
        end = token.rindex('"')
        text, rest = re.sub(r"\\(.)", r"\1", token[1:end]), token[end + 1 :]
        if rest.startswith("@"):
            return rdflib.Literal(text, lang=rest[1:])
        return rdflib.Literal(text, datatype=str(self.leaf(rest[2:])) if rest else None)
