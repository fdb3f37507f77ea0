"""Static check of a program: unknown functions and variables, wrong arguments, and calls that cannot run here."""

from __future__ import annotations

import inspect
from collections.abc import Iterator
from difflib import get_close_matches

from msgspec.structs import astuple

from cramlite.model import Value
from cramlite.plugin import did_you_mean, nearest

from .builtins import Library
from .controller_names import CONTROLLER_NAMES, CONTROLLER_VARIABLES
from .lexer import complaint
from .syntax import Assign, Call, Function, Method, Name, Run, Statement

Arity = tuple[tuple[str, ...], int]  # names of all parameters, how many of them are required
MISSPELT = 0.8  # share of letters in order (difflib) from which an unknown function is taken for another one misspelt
_STARTS = "A program is one 'def' without parameters in column 0 up to its 'end' in column 0; or call one of them after its 'end'"
_NAMING = (Call, Name, Method, Run)


class Lack(Value):
    """A line of a program that the controller model cannot run, though a real controller may; ``text`` is the
    reason."""

    line: int
    text: str


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


def check(program: Function, library: Library) -> list[Lack]:
    """Check a program for errors that it would meet at run time.

    Returns:
        The places that no controller would refuse, and that cannot run here.

    Raises:
        UserError: a misspelt function, a variable without a value, or arguments that do not fit; says the line and the nearest
            name. What a script file does not assign may be assigned by the program that it is read into, and is a lack.
    """
    names = _Names(program, library)
    return [lack for node in nodes(program) if isinstance(node, _NAMING) for lack in names.lacks(node)]


def refuse_lacks(program: Function, library: Library) -> None:
    """Refuse a program that can reach a call which the controller model lacks; functions that are never
    called may contain such calls.

    Raises:
        UserError: the line and the reason of the first, and how many more there are; or that nothing would run.
    """
    if not program.name and all(isinstance(s, Function) for s in program.body):
        raise complaint(program.line, f"nothing would run: {_names(program.body)} only defined. {_STARTS}")
    names = _Names(program, library)
    found = list(dict.fromkeys(lack for node in _reached(program) for lack in names.lacks(node)))
    if found:
        first = min(found, key=lambda lack: lack.line)
        places = "place" if len(found) == 2 else "places"
        more = f"; {len(found) - 1} more {places} cannot run here: 'cramlite check' lists them" if len(found) > 1 else ""
        raise complaint(first.line, first.text + more)


def by_reason(lacks: list[Lack]) -> list[Lack]:
    """Merge program lines that cannot run here for the same reason into one entry: the first line, which
    lists the others."""
    lines: dict[str, list[int]] = {}
    for lack in lacks:
        lines.setdefault(lack.text, []).append(lack.line)
    return [Lack(min(found), text + _others(sorted(set(found))[1:])) for text, found in lines.items()]


def _others(lines: list[int]) -> str:
    some = ", ".join(map(str, lines[:8])) + (f" and {len(lines) - 8} more" if len(lines) > 8 else "")
    return f"; also in line{'s' if len(lines) > 1 else ''} {some}" if lines else ""


class _Names:
    """The functions and variables that a program can name."""

    def __init__(self, program: Function, library: Library) -> None:
        self.own, self.library = functions(program), library
        self.functions = library.keys() | (self.own.keys() - {""})
        self.arities: dict[str, Arity] = {}
        self.variables = _assigned(program)
        self.whole = bool(program.name)

    def lacks(self, node: object) -> Iterator[Lack]:
        """Yield a ``Lack`` for each function or variable in a syntax node that the controller model lacks;
        raise errors of wrong calls."""
        if isinstance(node, Call):
            yield from self.call(node)
        elif isinstance(node, Name) and node.name not in self.variables:
            yield from self.variable(node)
        elif isinstance(node, Method):
            yield Lack(node.line, f"'.{node.name}()' is a call on a handle or a list, and the controller model has no values with methods")
        elif isinstance(node, Run):
            self.run(node)

    def call(self, call: Call) -> Iterator[Lack]:
        name = call.function
        if name in self.functions:
            _check_call(call, self.arity(name))
        elif name in CONTROLLER_NAMES:
            yield Lack(call.line, f"the controller model does not have UR's function '{name}'")
        elif self.misspelt(name):
            raise complaint(call.line, f"there is no function '{name}'; {nearest(name, self.functions)}")
        else:
            there_is = f"there is no function '{name}' here; {did_you_mean(name, self.functions)}"
            yield Lack(call.line, f"{there_is}a URCap, another script or a controller of another version may have it")

    def arity(self, name: str) -> Arity:
        """Return the arity of a function, from a cache, since finding that of a built-in function takes a while."""
        if name not in self.arities:
            self.arities[name] = _own(self.own[name]) if name in self.own else _built_in(self.library[name])
        return self.arities[name]

    def misspelt(self, name: str) -> bool:
        """Whether a name differs from a known one by a letter or two; names with different numbers in them
        are no misspellings of each other.

        A script file may well call a relative of its own functions that another one defines.
        """
        valid = (n.lower() for n in self.functions if self.whole or n not in self.own)
        close = [n for n in valid if abs(len(n) - len(name)) < 2 and _digits(n) == _digits(name)]
        return bool(get_close_matches(name.lower(), close, 1, MISSPELT))

    def variable(self, node: Name) -> Iterator[Lack]:
        name = node.name
        if name in self.functions:
            raise complaint(node.line, f"'{name}' is a function: call it with ()")
        if name in CONTROLLER_VARIABLES:
            yield Lack(node.line, f"the controller model does not have UR's variable '{name}'")
        elif self.whole:
            raise complaint(node.line, f"'{name}' is assigned nowhere; {nearest(name, self.variables)}")
        else:
            guess = did_you_mean(name, self.variables)
            yield Lack(node.line, f"'{name}' is assigned nowhere here; {guess}another script or the installation may do it")

    def run(self, node: Run) -> None:
        name = node.call.function
        if name in self.functions and getattr(self.own.get(name), "word", "") != "thread":
            raise complaint(node.line, f"'run' needs a thread, and '{name}' is none")


def _digits(name: str) -> str:
    return "".join(filter(str.isdigit, name))


def _reached(program: Function) -> Iterator[object]:
    """Walk the nodes of a program and of those of its functions that it may call, directly or indirectly."""
    own, seen, waiting = functions(program), {program.name}, [program]
    while waiting:
        for node in _nodes_outside_functions((waiting[-1].parameters, waiting.pop().body)):
            yield node
            if isinstance(node, Call) and node.function in own and node.function not in seen:
                seen.add(node.function)
                waiting.append(own[node.function])


def _nodes_outside_functions(node: object) -> Iterator[object]:
    if isinstance(node, tuple):
        for part in node:
            yield from _nodes_outside_functions(part)
    elif hasattr(node, "line") and not isinstance(node, Function):
        yield node
        for value in astuple(node):  # type: ignore[arg-type]
            yield from _nodes_outside_functions(value)


def _names(body: tuple[Statement, ...]) -> str:
    names = [f"'{f.name}'" for f in body if isinstance(f, Function)]
    some = ", ".join(names[:5]) + (f" and {len(names) - 5} more" if len(names) > 5 else "")
    return f"{some} {'is' if len(names) == 1 else 'are'}"


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


def _check_call(call: Call, arity: Arity) -> None:
    names, required = arity
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
