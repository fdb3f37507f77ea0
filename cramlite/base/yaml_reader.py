"""Reader of YAML 1.2's core schema (yaml.org/spec/1.2.2, chapter 10.3) on libyaml: plain values with line numbers.

PyYAML by itself reads YAML 1.1, in which ``on`` is true and ``010`` is eight.
"""

from __future__ import annotations

import re
from collections.abc import Hashable, Iterator
from typing import Any, ClassVar

import yaml
from yaml.constructor import ConstructorError

_PREFIX = "tag:yaml.org,2002:"
_SCALARS = {
    "bool": (r"true|True|TRUE|false|False|FALSE", "tTfF"),
    "int": (r"[-+]?[0-9]+|0o[0-7]+|0x[0-9a-fA-F]+", "-+0123456789"),
    "float": (r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?|[-+]?\.(inf|Inf|INF)|\.(nan|NaN|NAN)", "-+.0123456789"),
    "null": (r"~|null|Null|NULL|", ["~", "n", "N", ""]),
    "merge": (r"<<", "<"),
}
"""Types of plain YAML scalars: for each its tag, a pattern of its text, and the characters that it can begin with. ``<<`` is from YAML
1.1 and in common use."""


DEEPEST = 100
"""Largest nesting depth of a YAML file. Hand-written files have some ten levels; PyYAML's composer on libyaml overflows the C stack at
some 10,000."""


MOST = 1_000_000
"""Largest number of values in a YAML file, where the values that an alias repeats count each time."""


class Mapping(dict[Any, Any]):
    """Mapping from a YAML text, with the line number of the mapping and of each key, from 1."""

    line = 1
    lines: dict[Any, int]


class Sequence(list[Any]):
    """List from a YAML text, with the line number of the list and of each item, from 1."""

    line = 1
    lines: list[int]


class Reader(getattr(yaml, "CSafeLoader", yaml.SafeLoader)):  # type: ignore[misc]
    """Reader of one YAML document; a tag outside the core schema and a duplicate key are errors."""

    yaml_implicit_resolvers: ClassVar[dict[str, Any]] = {}  # PyYAML's own are those of YAML 1.1
    yaml_constructors: ClassVar[dict[Any, Any]] = {}


def read(text: str) -> Any:
    """Read the one document of a YAML text.

    Raises:
        yaml.YAMLError: it is none, with the line where that shows.
        ValueError: nested deeper than ``DEEPEST``, more than ``MOST`` values, or a number has too many digits.
    """
    _check(text)
    return Reader(text).get_single_data()


def _check(text: str) -> None:
    """Check the depth and size of a YAML text from its parser events; an alias counts with all that it repeats."""
    open_: list[_Part] = [_Part("")]
    done: dict[str, _Part] = {}
    events: Iterator[Any] = iter(yaml.parse(text, Reader))
    for event in events:
        if isinstance(event, yaml.CollectionStartEvent):
            open_.append(_Part(event.anchor or ""))
        elif isinstance(event, yaml.CollectionEndEvent):
            part = open_.pop()
            done[part.anchor] = part
            open_[-1].add(part)
        elif isinstance(event, yaml.AliasEvent):
            if any(part.anchor == event.anchor for part in open_[1:]):
                raise ConstructorError(None, None, f"the alias '*{event.anchor}' is recursive: it is inside its own anchor", _mark(event))
            open_[-1].add(done.get(event.anchor or "", _Part("", -1)))
        elif isinstance(event, yaml.ScalarEvent):
            part = done[event.anchor or ""] = _Part(event.anchor or "", -1)
            open_[-1].add(part)
        if len(open_) + open_[-1].depth - 1 > DEEPEST:
            raise ValueError(f"the text is nested more than {DEEPEST} deep")
        if sum(part.size for part in open_) > MOST:
            raise ValueError(f"the text has more than {MOST} values, with those that its aliases repeat")


def _mark(event: Any) -> Any:
    """Return the position in the YAML text at which a parser event starts.

    Its type is not declared, because libyaml's and PyYAML's marks have different types.
    """
    return event.start_mark


class _Part:
    """Size of a part of a YAML document: the number of its values, and of the levels below it; -1 levels for a scalar."""

    def __init__(self, anchor: str, depth: int = 0) -> None:
        self.anchor, self.size, self.depth = anchor, 1, depth

    def add(self, inner: _Part) -> None:
        self.size += inner.size
        self.depth = max(self.depth, inner.depth + 1)


def _mapping(reader: Any, node: yaml.MappingNode) -> Iterator[Mapping]:
    made = Mapping()
    made.line, made.lines = node.start_mark.line + 1, {}
    yield made
    for key in _once(reader, node):
        made.lines[key[0]] = key[1]
    reader.flatten_mapping(node)
    for key_node, value in node.value:
        made[reader.construct_object(key_node, deep=True)] = reader.construct_object(value, deep=True)


def _once(reader: Any, node: yaml.MappingNode) -> Iterator[tuple[Hashable, int]]:
    """Yield each key of a YAML mapping with its line, without keys merged by "<<"; refuse a key that stands
    twice."""
    seen = set()
    for key_node, _ in node.value:
        key = reader.construct_object(key_node, deep=True)
        if not isinstance(key, Hashable):
            raise ConstructorError(None, None, "a list or mapping as a key", key_node.start_mark)
        if key in seen:
            raise ConstructorError(None, None, f'found duplicate key "{key}"', key_node.start_mark)
        seen.add(key)
        yield key, key_node.start_mark.line + 1


def _sequence(reader: Any, node: yaml.SequenceNode) -> Iterator[Sequence]:
    made = Sequence()
    made.line, made.lines = node.start_mark.line + 1, [n.start_mark.line + 1 for n in node.value]
    yield made
    made.extend(reader.construct_object(n, deep=True) for n in node.value)


def _int(reader: Any, node: yaml.ScalarNode) -> int:
    text = reader.construct_scalar(node)
    return int(text, 0) if text[:2] in ("0o", "0x") else int(text)


def _float(reader: Any, node: yaml.ScalarNode) -> float:
    return float(re.sub(r"\.(inf|nan)$", r"\1", reader.construct_scalar(node).lower()))


def _bool(reader: Any, node: yaml.ScalarNode) -> bool:
    return bool(reader.construct_scalar(node).lower() == "true")


def _refuse(reader: Any, node: yaml.Node) -> None:
    raise ConstructorError(None, None, f"the YAML tag '{node.tag}' is not allowed; write plain values", node.start_mark)


for _name, (_text, _first) in _SCALARS.items():
    Reader.add_implicit_resolver(_PREFIX + _name, re.compile(f"^(?:{_text})$"), list(_first))
_MAKERS = {
    "map": _mapping, "seq": _sequence, "int": _int, "float": _float, "bool": _bool, "null": lambda *_: None,
    "str": lambda reader, node: reader.construct_scalar(node), "merge": lambda *_: "<<",
}  # fmt: skip
for _name, _maker in _MAKERS.items():
    Reader.add_constructor(_PREFIX + _name, _maker)
Reader.add_constructor(None, _refuse)
