"""YAML files with positions: every complaint names file and line."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .errors import UserError, nearest

if TYPE_CHECKING:
    from pydantic import ValidationError

LARGEST = 5_000_000
"""Bytes: hand-written files are far smaller; a larger one is a mistake, and parsing it would take minutes."""

_PLAIN = ("map", "seq", "str", "int", "float", "bool", "null", "timestamp", "merge", "omap", "set")
PLAIN_TAGS = {f"tag:yaml.org,2002:{name}" for name in _PLAIN}
"""What YAML calls its own plain types (YAML 1.2 core schema, and what ruamel.yaml adds)."""


def load_yaml(path: Path) -> Any:
    """Mappings and lists that remember their lines.

    Raises:
        UserError: no such file, not UTF-8 text, too large, not YAML, a tag, or a key given twice.
    """
    from ruamel.yaml import YAML
    from ruamel.yaml.error import MarkedYAMLError, YAMLError

    try:
        if path.stat().st_size > LARGEST:
            raise UserError(f"{path}: {path.stat().st_size} bytes; a file of this kind has at most {LARGEST}.")
        data = YAML(typ="rt").load(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise UserError(f"{path}: cannot be read: {error.strerror}.") from error
    except UnicodeDecodeError as error:
        raise UserError(f"{path}: not UTF-8 text (byte {error.start}); save it as UTF-8.") from error
    except MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        line = f":{mark.line + 1}" if mark else ""
        problem = (error.problem or str(error)).split("\n")[0]
        raise UserError(f"{path}{line}: not valid YAML: {problem}.") from error
    except (YAMLError, ValueError, RecursionError) as error:
        raise UserError(f"{path}: not valid YAML: {error}.") from error
    _refuse_tags(data, path, 1, set())
    return data


def _refuse_tags(node: Any, path: Path, line: int, seen: set[int]) -> None:
    if id(node) in seen:
        return
    seen.add(id(node))
    tag = getattr(getattr(node, "tag", None), "value", None)
    if tag and str(tag) not in PLAIN_TAGS:
        raise UserError(f"{path}:{line}: the YAML tag '{tag}' is not allowed; write plain values.")
    if isinstance(node, dict):
        for key, value in node.items():
            _refuse_tags(value, path, _line_of_key(node, key) or line, seen)
    elif isinstance(node, list):
        for k, value in enumerate(node):
            _refuse_tags(value, path, _line_of_item(node, k) or line, seen)


def line_of(data: Any, location: Sequence[str | int]) -> int:
    """The line (from 1) of the deepest part of ``location`` that the data has."""
    line = getattr(getattr(data, "lc", None), "line", 0) + 1
    for step in location:
        if isinstance(data, dict) and step in data:
            line = _line_of_key(data, step) or line
        elif isinstance(data, list) and isinstance(step, int) and step < len(data):
            line = _line_of_item(data, step) or line
        else:
            continue
        data = data[step]
    return line


def _line_of_key(data: Any, key: Any) -> int | None:
    marks = getattr(getattr(data, "lc", None), "data", None) or {}
    return marks[key][0] + 1 if key in marks else None


def _line_of_item(data: Any, index: int) -> int | None:
    marks = getattr(getattr(data, "lc", None), "data", None) or {}
    return marks[index][0] + 1 if index in marks else None


def explain_validation(path: Path, data: Any, error: ValidationError, fields: Sequence[str]) -> UserError:
    """The first complaints of pydantic as one paragraph with lines and nearest names."""
    clauses = []
    for problem in error.errors()[:3]:
        location = [part for part in problem["loc"] if isinstance(part, int | str)]
        line, key = line_of(data, location), ".".join(str(p) for p in location)
        if problem["type"] == "extra_forbidden":
            clauses.append(f"{path}:{line}: unknown key '{location[-1]}'; {nearest(str(location[-1]), fields)}")
        elif problem["type"] == "missing":
            clauses.append(f"{path}:{line}: '{key}' is missing")
        else:
            said = problem["msg"].removeprefix("Value error, ")
            clauses.append(f"{path}:{line}: '{key}': {said}" if key else f"{path}:{line}: {said}")
    more = error.error_count() - len(clauses)
    return UserError("; ".join(clauses) + (f"; and {more} more." if more > 0 else "."))
