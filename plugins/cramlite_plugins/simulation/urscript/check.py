"""Static check of a program: unknown functions and variables, and wrong arguments."""

from __future__ import annotations

import inspect
from collections.abc import Iterator, Mapping

from msgspec.structs import astuple

from cramlite.plugin import nearest

from .builtins import Library
from .lexer import complaint
from .syntax import Assign, Call, Function, Name, Run

Arity = tuple[tuple[str, ...], int]  # names of all parameters, how many of them are required


def functions(program: Function) -> dict[str, Function]:
    """Collect every function and thread of a program by name, the program itself included.

    Raises:
        UserError: a name is defined twice.
    """
    found: dict[str, Function] = {}
    for node in nodes(program):
        if isinstance(node, Function):
            if node.name in found:
                raise complaint(node.line, f"'{node.name}' is defined twice, first in line {found[node.name].line}")
            found[node.name] = node
    return found


def check(program: Function, library: Library) -> None:
    """Check a program for what would fail at run time.

    Raises:
        UserError: an unknown function or variable, or arguments that do not fit; says the line and the nearest name.
    """
    if program.parameters:
        raise complaint(program.line, f"the program '{program.name}' has parameters; it is started without any")
    own = functions(program)
    arities = {name: _built_in(f) for name, f in library.items()} | {name: _own(f) for name, f in own.items()}
    known = _assigned(program)
    for node in nodes(program):
        if isinstance(node, Call):
            _check_call(node, arities)
        elif isinstance(node, Name) and node.name not in known:
            unknown = f"assigned nowhere; {nearest(node.name, known)}"
            what = "a function: call it with ()" if node.name in arities else unknown
            raise complaint(node.line, f"'{node.name}' is {what}")
        if isinstance(node, Run) and getattr(own.get(node.call.function), "word", "") != "thread":
            raise complaint(node.line, f"'run' needs a thread, and '{node.call.function}' is none")


def nodes(node: object) -> Iterator[object]:
    """Walk a node and all below it, in the order of the text."""
    waiting = [node]
    while waiting:
        here = waiting.pop()
        if isinstance(here, tuple):
            waiting += here[::-1]
        elif hasattr(here, "line"):
            yield here
            waiting += astuple(here)[::-1]  # type: ignore[arg-type]


def _assigned(program: Function) -> set[str]:
    names = set()
    for node in nodes(program):
        if isinstance(node, Assign) and isinstance(node.target, Name):
            names.add(node.target.name)
        elif isinstance(node, Function):
            names.update(name for name, _ in node.parameters)
    return names


def _check_call(call: Call, arities: Mapping[str, Arity]) -> None:
    if call.function not in arities:
        raise complaint(call.line, f"there is no function '{call.function}'; {nearest(call.function, arities)}")
    names, required = arities[call.function]
    given = [*names[: len(call.arguments)], *(name for name, _ in call.named)]
    for name, _ in call.named:
        if name not in names:
            raise complaint(call.line, f"'{call.function}' has no parameter '{name}'; {nearest(name, names)}")
        if given.count(name) > 1:
            raise complaint(call.line, f"'{call.function}' is given its parameter '{name}' twice")
    missing = [name for name in names[:required] if name not in given]
    if missing or len(call.arguments) > len(names):
        counts = str(required) if required == len(names) else f"{required} to {len(names)}"
        count = len(call.arguments) + len(call.named)
        raise complaint(call.line, f"'{call.function}({', '.join(names)})' takes {counts} arguments, not {count}")


def _own(function: Function) -> Arity:
    required = [name for name, default in function.parameters if default is None]
    return tuple(name for name, _ in function.parameters), len(required)


def _built_in(function: object) -> Arity:
    parameters = inspect.signature(function).parameters.values()  # type: ignore[arg-type]
    required = [p.name for p in parameters if p.default is inspect.Parameter.empty]
    return tuple(p.name for p in parameters), len(required)
