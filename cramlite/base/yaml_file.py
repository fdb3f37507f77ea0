"""YAML files with line numbers, so that every error message names file and line."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from .errors import UserError, nearest

if TYPE_CHECKING:
    from pydantic import ValidationError
    from pydantic_core import ErrorDetails

LARGEST = 5_000_000
"""Largest size of a YAML file [bytes]. Hand-written files are far smaller, and a larger one would take minutes to parse."""


def load_yaml(path: Path) -> Any:
    """Read a YAML file as mappings and lists that keep their line numbers.

    Raises:
        UserError: no such file, not UTF-8 text, too large, not YAML, a tag, or a key given twice.
    """
    try:
        if path.stat().st_size > LARGEST:
            raise UserError(f"{path}: {path.stat().st_size} bytes; a file of this kind has at most {LARGEST}.")
        text = path.read_text(encoding="utf-8")
    except OSError as error:
        raise UserError(f"{path}: cannot be read: {error.strerror}.") from error
    except UnicodeDecodeError as error:
        raise UserError(f"{path}: not UTF-8 text (byte {error.start}); save it as UTF-8.") from error
    return parse_yaml(text, path)


def parse_yaml(text: str, path: Path) -> Any:
    """Parse YAML text as ``load_yaml`` parses a file; messages name ``path`` as the file.

    Raises:
        UserError: not YAML, a tag, or a key given twice.
    """
    from yaml import MarkedYAMLError, YAMLError

    from .yaml_reader import read

    try:
        return read(text)
    except MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        line = f":{mark.line + 1}" if mark else ""
        problem = (error.problem or str(error)).split("\n")[0]
        if mark and "\t" in "".join(text.split("\n")[mark.line : mark.line + 1]):  # YAML counts more line ends than "\n"
            problem += "; there is a tab in this line: YAML is indented with spaces"
        raise UserError(f"{path}{line}: not valid YAML: {problem}.") from error
    except (YAMLError, ValueError, RecursionError) as error:
        raise UserError(f"{path}: not valid YAML: {str(error).splitlines()[0]}.") from error


def line_of(data: Any, location: Sequence[str | int]) -> int:
    """Return the line (from 1) of the deepest existing part of a location in YAML data."""
    line: int = getattr(data, "line", 1)
    for step in location:
        if isinstance(data, dict) and step in data:
            line = getattr(data, "lines", {}).get(step, line)
        elif isinstance(data, list) and isinstance(step, int) and step < len(data):
            line = [*getattr(data, "lines", ()), *[line] * len(data)][step]
        else:
            continue
        data = data[step]
    return line


def explain_validation(
    path: Path, data: Any, error: ValidationError, fields: Sequence[str], renamed: Mapping[str, str] = MappingProxyType({})
) -> UserError:
    """Convert pydantic's first complaints to one paragraph with lines and the nearest valid names.

    Args:
        fields: keys that are right where the first unknown key stands.
        renamed: keys that older files have -> what they are called now.
    """
    problems = error.errors()
    inside = {p["loc"][:k] for p in problems for k in range(len(p["loc"]))}  # a list of which nothing can be used is not short as well
    problems = [p for p in problems if p["type"] != "too_short" or p["loc"] not in inside]
    clauses = []
    for problem in problems[:3]:
        location = [part for part in problem["loc"] if isinstance(part, int | str)]
        line, key = line_of(data, location), _in_words(data, location)
        if problem["type"] == "extra_forbidden":
            given = str(location[-1])
            right = f"it is called '{renamed[given]}' now" if renamed.get(given) in fields else nearest(given, fields)
            clauses.append(f"{path}:{line}: unknown key '{given}'; {right}")
        elif problem["type"] == "missing":
            clauses.append(f"{path}:{line}: {key} is missing")
        else:
            said = _complaint(problem)
            clauses.append(f"{path}:{line}: {key}: {said}" if key else f"{path}:{line}: {said}")
    more = len(problems) - len(clauses)
    return UserError("; ".join(clauses) + (f"; and {more} more." if more > 0 else "."))


KINDS = {
    "model_type": "a mapping", "model_attributes_type": "a mapping", "dict_type": "a mapping", "tuple_type": "a list",
    "list_type": "a list", "string_type": "text",
}  # fmt: skip
"""Type of a value in pydantic's error codes -> its name in words for YAML authors, such as "a list"."""


def _complaint(problem: ErrorDetails) -> str:
    """Say what pydantic complains about, in words for the author of a YAML file."""
    kind, said, given = problem["type"], problem["msg"], problem["input"]
    if kind == "too_short":
        least = problem["ctx"]["min_length"]
        return f"it has {len(given) or 'no'} entries, and needs at least {least}"
    if kind == "string_too_long":
        return f"'{_cut(given)}' has {len(given)} characters, and at most {problem['ctx']['max_length']} should be in it"
    if kind == "string_pattern_mismatch":  # names are the only text with a pattern
        return f"'{_cut(given)}' is no name; a name is a letter of A to Z, then such letters, digits and underscores"
    if kind not in KINDS:
        return said.removeprefix("Value error, ")
    names = {dict: "a mapping", list: "a list", str: "text", bool: "true or false", type(None): "empty"}
    found = next((name for t, name in names.items() if isinstance(given, t)), "a number")
    how = {"a mapping": ", such as 'key: value'", "a list": ", such as [one, two]"}.get(KINDS[kind], "")
    return f"this is {found}; it should be {KINDS[kind]}{how}"


SHOWN = 80
"""Largest number of characters that a message quotes of a text."""
ORDINALS = ("first", "second", "third", "fourth", "fifth", "sixth", "seventh", "eighth", "ninth", "tenth")


def _in_words(data: Any, location: Sequence[str | int]) -> str:
    """Return the location of a YAML value in words: "'hangs_on.depth' of the third thing 'tea'"; empty for
    the whole file."""
    said, keys, here = "", list[str](), data
    for step in location:
        inside = here[step] if _has(here, step) else None
        if isinstance(step, int):
            said = f"the {_ordinal(step)} {_item(inside, keys)}" + (f" of {said}" if said else "")
            keys = []
        elif inside is not None or step is location[-1]:  # else it is a name that pydantic gives a choice
            keys.append(step)
        here = here if inside is None and isinstance(step, str) else inside
    last = f"'{'.'.join(keys)}'" if keys else ""
    return f"{last} of {said}" if last and said else last or said


def _item(inside: Any, keys: Sequence[str]) -> str:
    """Name of a list's entry: "thing 'tea'" for a mapping in ``things``, "value of 'at.position'" for a plain value."""
    if not isinstance(inside, dict) or not keys:
        return f"value of '{'.'.join(keys)}'" if keys else "value"
    name = f" '{_cut(inside['name'])}'" if isinstance(inside.get("name"), str) else ""
    return keys[-1].removesuffix("s") + name + (f" of '{'.'.join(keys[:-1])}'" if keys[:-1] else "")


def _cut(text: str) -> str:
    """Text for a message, cut to its beginning where it is long."""
    return f"{text[:SHOWN]}..." if len(text) > SHOWN else text


def _has(data: Any, step: str | int) -> bool:
    return (isinstance(data, dict) and step in data) or (isinstance(data, list) and isinstance(step, int) and step < len(data))


def _ordinal(index: int) -> str:
    return ORDINALS[index] if index < len(ORDINALS) else f"{index + 1}th"
