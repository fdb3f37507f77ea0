"""Typed programs written as JSON text, and read back.

This text is the program of robots and devices for whose own language there is no backend.

One object with the fields of ``Program``; every step is an object with its class under "step", on a line of its own. What
is written is read back equal: numbers have as many digits as they need.
"""

from __future__ import annotations

import json
import math
import types
from collections.abc import Mapping
from functools import lru_cache
from typing import Any, Literal, Union, get_args, get_origin, get_type_hints

from msgspec import Struct
from msgspec.structs import asdict, fields

from ...base.errors import UserError, nearest
from ...base.value import Value
from .program import Code, Program
from .steps import Step, walk

FORMAT = "cramlite program 1"
TAG = "step"
SILENT: Mapping[str, object] = {"origin": "", "comment": "", "relative": "", "late": (), "force_limit_of": "robot"}
"""Default values of fields that are omitted from a program's JSON text. Numbers are always written."""
RENAMED: Mapping[str, str] = {"TryInOrder": "Fallback"}
"""Former name of a program step, as older texts have it -> its present name."""


class ProgramText(Value):
    """Program that was read from text.

    Args:
        program: that was read.
        lines: id of a step (the object itself: equal steps are not the same) -> its first line in the text, from 1.
    """

    program: Program
    lines: Mapping[int, int]


def is_program_text(text: str) -> bool:
    """Check whether a text is meant to be a typed program: it begins as a JSON object does."""
    return text.lstrip().startswith("{")


def write_program(program: Program) -> str:
    """Return the JSON text of a program; the same program gives the same text."""
    data = {"format": FORMAT, **_encode(program)}
    return _layout(data, 0, top=True) + "\n"


def typed_code(program: Program) -> Code:
    """Return a program as JSON code, with the origin of each step's line."""
    text = write_program(program)
    back = read_program(text)
    origins = {back.lines[id(s)]: s.origin for s in walk(back.program.steps) if s.origin}
    return Code("json", text, origins, ".json")


def laid_out(text: str) -> str:
    """Return a program's text with a line of its own for every step: unchanged if it has that already, else written anew.

    Raises:
        UserError: as ``read_program``.
    """
    read = read_program(text)
    return text if len(set(read.lines.values())) == len(read.lines) else write_program(read.program)


def read_program(text: str) -> ProgramText:
    """Parse a program from its JSON text.

    Raises:
        UserError: it is no JSON, or no program: one sentence with the line, what is there, and what would be right.
    """
    try:
        data, where = _parse(text)
    except json.JSONDecodeError as error:
        place = f"line {error.lineno}, column {error.colno}"
        raise UserError(f"The program is no JSON: {place}: {error.msg}; correct it there, or emit it anew.") from None
    except RecursionError:
        raise UserError("The program is no JSON that can be read: it is nested too deeply.") from None
    if not isinstance(data, dict) or data.pop("format", None) != FORMAT:
        raise UserError(f'The program does not say "format": "{FORMAT}", so it is no typed program of this version.')
    lines: dict[int, int] = {}
    return ProgramText(_decode(Program, data, where, "the program", lines), lines)


# Writing


def _encode(value: Any) -> Any:
    if isinstance(value, Struct):
        own = {k: _encode(v) for k, v in asdict(value).items() if k not in SILENT or v != SILENT[k]}
        return {TAG: type(value).__name__, **own} if isinstance(value, Step) else own
    if isinstance(value, tuple | list):
        return [_encode(v) for v in value]
    if isinstance(value, Mapping):
        return {str(k): _encode(v) for k, v in value.items()}
    return value


def _layout(value: Any, indent: int, *, top: bool = False) -> str:
    if not (top or _broken(value)):
        return json.dumps(value, ensure_ascii=False, allow_nan=False)
    pad, inner = " " * indent, " " * (indent + 1)
    if isinstance(value, dict):
        items = [f"{inner}{json.dumps(k)}: {_layout(v, indent + 1)}" for k, v in value.items()]
        return "{\n" + ",\n".join(items) + f"\n{pad}}}"
    return "[\n" + ",\n".join(inner + _layout(v, indent + 1) for v in value) + f"\n{pad}]"


def _broken(value: Any) -> bool:
    """Check whether a JSON value is written over several lines.

    That is so if it contains, at some depth, a list of objects that are no poses.
    """
    if isinstance(value, dict):
        return any(_broken(v) for v in value.values())
    if not isinstance(value, list):
        return False
    return any("quaternion" not in v if isinstance(v, dict) else _broken(v) for v in value)


# Reading: the text with the line of every value beside it


class _Where(Value):
    """Line number of a JSON value in its text, and those of the values inside it, by key or index."""

    line: int
    inner: Mapping[Any, _Where]


def _parse(text: str) -> tuple[Any, _Where]:
    decoder = json.JSONDecoder(object_pairs_hook=_once, parse_constant=_finite)
    try:
        data = decoder.decode(text)
    except _Wrong as error:
        raise UserError(f"The program is no JSON that can be used: {error}.") from None
    return data, _walk(text, _skip(text, 0), decoder)[0]


class _Wrong(Exception):
    """Error for JSON that Python's parser accepts, but that no program may contain."""


def _once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    result: dict[str, Any] = {}
    for key, value in pairs:
        if key in result:
            raise _Wrong(f'"{key}" appears twice in one object')
        result[key] = value
    return result


def _finite(name: str) -> Any:
    raise _Wrong(f"{name} is no number that a robot could use")


def _skip(text: str, i: int) -> int:
    while i < len(text) and text[i] in " \t\n\r,:":
        i += 1
    return i


def _walk(text: str, i: int, decoder: json.JSONDecoder) -> tuple[_Where, int]:
    """Return the lines of a JSON value that begins at a position of a valid text, and the position where the
    value ends."""
    line, opened, inner, count = text.count("\n", 0, i) + 1, text[i], {}, 0
    if opened not in "{[":
        return _Where(line, {}), decoder.raw_decode(text, i)[1]
    i = _skip(text, i + 1)
    while text[i] not in "}]":
        key: Any = count
        if opened == "{":
            key, i = decoder.raw_decode(text, i)
        inner[key], i = _walk(text, _skip(text, i), decoder)
        i, count = _skip(text, i), count + 1
    return _Where(line, inner), i + 1


# Reading: values by the type that they should have


def _decode(hint: Any, value: Any, where: _Where, name: str, lines: dict[int, int]) -> Any:
    origin = get_origin(hint)
    if origin in (Union, types.UnionType):
        return _chosen(hint, value, where, name, lines)
    if origin is tuple:
        return _tuple(get_args(hint), value, where, name, lines)
    if origin is Literal:
        if value not in get_args(hint):
            raise _error(where, name, value, f"one of {', '.join(map(repr, get_args(hint)))}")
        return value
    if origin in (dict, Mapping):
        kind = get_args(hint)[1]
        return {k: _decode(kind, v, where.inner[k], f"{name}.{k}", lines) for k, v in _object(value, where, name).items()}
    if isinstance(hint, type) and issubclass(hint, Struct):
        return _struct(hint, value, where, name, lines)
    return _plain(hint, value, where, name)


def _plain(hint: Any, value: Any, where: _Where, name: str) -> Any:
    kinds = {float: "a number", int: "a whole number", str: "text", bool: "true or false"}
    if hint is float and isinstance(value, int) and not isinstance(value, bool):
        value = float(value)
    if hint not in kinds or type(value) is not hint or (hint is float and not math.isfinite(value)):
        raise _error(where, name, value, kinds.get(hint, str(hint)))
    return value


def _tuple(kinds: tuple[Any, ...], value: Any, where: _Where, name: str, lines: dict[int, int]) -> tuple[Any, ...]:
    many = kinds[-1:] == (Ellipsis,)
    if not isinstance(value, list) or not (many or len(value) == len(kinds)):
        raise _error(where, name, value, "a list" if many else f"a list of {len(kinds)}")
    each = (kinds[0],) * len(value) if many else kinds
    return tuple(
        _decode(k, v, where.inner[i], f"{name}[{i}]", lines) for i, (k, v) in enumerate(zip(each, value, strict=True))
    )


def _chosen(hint: Any, value: Any, where: _Where, name: str, lines: dict[int, int]) -> Any:
    """Decode the value of a union type: None, a step by its class's name, or the first other type that
    accepts the value."""
    if value is None and type(None) in get_args(hint):
        return None
    kinds = [k for k in get_args(hint) if k is not type(None)]
    steps = {k.__name__: k for k in kinds if isinstance(k, type) and issubclass(k, Step)}
    if steps:
        tag = _object(value, where, name).get(TAG)
        if not isinstance(tag, str) or tag not in steps:
            now = RENAMED.get(str(tag))
            right = f"'{now}', as it is called now" if now else f"the class of a step; {nearest(str(tag), steps)}"
            raise _error(where.inner.get(TAG, where), f"{name}.{TAG}", tag, right)
        kinds = [steps[tag]]
    failed: UserError | None = None
    for kind in kinds:
        try:
            return _decode(kind, value, where, name, lines)
        except UserError as error:
            failed = failed or error
    assert failed is not None
    raise failed


def _object(value: Any, where: _Where, name: str) -> dict[str, Any]:
    if not isinstance(value, dict):
        raise _error(where, name, value, "an object in braces")
    return value


@lru_cache(maxsize=128)
def _hints(kind: type) -> Mapping[str, Any]:
    return get_type_hints(kind)


def _struct(kind: Any, value: Any, where: _Where, name: str, lines: dict[int, int]) -> Any:
    given = dict(_object(value, where, name))
    if issubclass(kind, Step):
        name = f"{name} ({given.pop(TAG, kind.__name__)})"
    known = {f.name: f for f in fields(kind)}
    for key in given:
        if key not in known:
            raise UserError(f"The program, line {where.inner[key].line}: {name} has no '{key}'; {nearest(key, known)}.")
    for f in known.values():
        if f.name not in given and f.required:
            raise UserError(f"The program, line {where.line}: {name} does not say its '{f.name}'; add it.")
    own = {k: _decode(_hints(kind)[k], v, where.inner[k], f"{name}.{k}", lines) for k, v in given.items()}
    try:
        made = kind(**own)
    except ValueError as error:
        raise UserError(f"The program, line {where.line}: {name}: {error}.") from None
    if isinstance(made, Step):
        lines[id(made)] = where.line
    return made


def _error(where: _Where, name: str, value: Any, wanted: str) -> UserError:
    shown = json.dumps(value, ensure_ascii=False)
    shown = shown if len(shown) < 60 else shown[:57] + "..."
    return UserError(f"The program, line {where.line}: {name} is {shown}; it should be {wanted}.")
