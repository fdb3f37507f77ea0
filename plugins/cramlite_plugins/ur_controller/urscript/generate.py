"""Compilation of URScript's syntax tree to Python source, so that a statement costs a fraction of a microsecond.

Every function is a Python generator: it yields whenever its thread waits for the next control cycle.
Names: ``f_NAME`` a function of the program, ``v_NAME`` a local variable, ``b_NAME`` a built-in function,
``g["NAME"]`` a global variable, ``m`` the machine. Only names that the lexer accepted and ``repr`` of
constants enter the source, so no program can smuggle Python in; ``python_subset`` checks it once more.

Scope (URScript manual, "Scoping rules"): ``local`` is local; ``global`` is global; a name without either is the
global of that name where there is one, and else local. Variables of the outermost function are
visible in the functions and threads inside it.
"""

from __future__ import annotations

from collections.abc import Iterable

from .builtins import Library, blocks
from .check import functions, nodes
from .syntax import (
    Assign,
    Binary,
    Call,
    Critical,
    Evaluate,
    Expression,
    Function,
    If,
    Item,
    Jump,
    ListOf,
    Member,
    Method,
    Name,
    Nothing,
    Number,
    Return,
    Run,
    Statement,
    StructOf,
    Text,
    ThreadOrder,
    Truth,
    Unary,
    While,
)

_CALLS = {"+": "add", "-": "subtract", "*": "multiply", "/": "divide", "%": "modulo", "<": "less", ">": "greater"}
_SWAPPED = {"<=": "greater", ">=": "less"}  # a <= b is not a > b; there is no NaN in URScript


def generate(program: Function, library: Library) -> str:
    """Generate the Python source of a program: functions nested as in the program, outermost first."""
    scope = _assigned(nodes(program), "global") | _assigned(_flat(program.body), "")
    return "\n".join(_Writer(program, library, scope).function(program, frozenset(), outermost=True)) + "\n"


def _assigned(parts: Iterable[object], scope: str) -> set[str]:
    """Names of the variables that are assigned with a given scope."""
    found = (p.target for p in parts if isinstance(p, Assign) and p.scope == scope)
    return {target.name for target in found if isinstance(target, Name)}


def _flat(body: Iterable[Statement]) -> Iterable[Statement]:
    """Statements of one function, including those inside its branches and loops."""
    for statement in body:
        yield statement
        if isinstance(statement, If):
            yield from _flat(s for branch in (*(b for _, b in statement.branches), statement.otherwise) for s in branch)
        elif isinstance(statement, While):
            yield from _flat(statement.body)


class _Writer:
    def __init__(self, program: Function, library: Library, scope: set[str]) -> None:
        self.library, self.globals = library, scope
        self.own = functions(program)
        self.locals: frozenset[str] = frozenset()
        self.outermost = False

    def function(self, f: Function, around: frozenset[str], outermost: bool = False) -> list[str]:
        saved = self.locals, self.outermost
        own = {name for name, _ in f.parameters} | _assigned(_flat(f.body), "local")
        self.locals, self.outermost = around | own, outermost
        parameters = ", ".join(f"v_{n}" if d is None else f"v_{n}={self.value(d)}" for n, d in f.parameters)
        body = self.block(f.body)
        self.locals, self.outermost = saved
        return [f"def f_{f.name}({parameters}):", *_indented(body), "    return", "    yield"]

    def block(self, body: Iterable[Statement]) -> list[str]:
        return [line for s in body for line in self.statement(s)] or ["pass"]

    def statement(self, s: Statement) -> list[str]:
        if isinstance(s, Function):
            return self.function(s, self.locals)
        at = f"m.{'main' if self.outermost else 'at'}({s.line})"
        match s:
            case While():
                # Python tests the condition anew in each round, and so each round counts.
                body = [f"if not truth({self.value(s.condition)}): break", *self.block(s.body)]
                return ["while True:", *_indented([at, *body])]
            case If():
                return [at, *self.conditional(s)]
            case Assign():
                return [at, self.assignment(s)]
            case Evaluate():
                return [at, self.value(s.value)]
            case Return():
                return [at, f"return {self.value(s.value) if s.value is not None else ''}"]
            case ThreadOrder():
                order = f"m.{s.word}({self.value(s.handle)})"
                return [at, f"yield from {order}" if s.word == "join" else order]
            case Jump():
                return [at, s.word]
            case Critical():
                return [at, f"m.critical({s.word == 'enter_critical'})"]
        raise AssertionError(s)

    def conditional(self, s: If) -> list[str]:
        lines: list[str] = []
        for word, (condition, body) in zip(["if", *["elif"] * len(s.branches)], s.branches, strict=False):
            lines += [f"{word} truth({self.value(condition)}):", *_indented(self.block(body))]
        return [*lines, "else:", *_indented(self.block(s.otherwise))] if s.otherwise else lines

    def assignment(self, s: Assign) -> str:
        value = self.counted(s.value)
        if isinstance(s.target, Item):
            return f"set_item({self.value(s.target.value)}, {self.value(s.target.index)}, {value})"
        if isinstance(s.target, Member):
            return f"set_member({self.value(s.target.value)}, {s.target.name!r}, {value})"
        if isinstance(s.value, Name | Item | Member):
            value = f"copied({value})"
        is_global = s.scope == "global" or (not s.scope and self.is_global(s.target.name))
        return f'g["{s.target.name}"] = {value}' if is_global else f"v_{s.target.name} = {value}"

    def counted(self, e: Expression) -> str:
        """Python code of a value; if that may be a list, the code also counts its elements towards the
        statement limit."""
        listed = isinstance(e, Name | Item | Member | Call | StructOf | Unary) or (isinstance(e, ListOf) and not e.pose)
        return f"m.kept({self.value(e)})" if listed else self.value(e)

    def is_global(self, name: str) -> bool:
        return name in self.globals and name not in self.locals

    def value(self, e: Expression) -> str:
        match e:
            case Number() | Truth() | Text():
                return repr(e.value)
            case Nothing():
                return "None"
            case Name():
                return f'g["{e.name}"]' if self.is_global(e.name) else f"v_{e.name}"
            case ListOf():
                items = ", ".join(map(self.value, e.items))
                return f"pose_value({items})" if e.pose else f"list_value({items})"
            case StructOf():
                fields = ", ".join(f"{name!r}: {self.value(v)}" for name, v in e.fields)
                return f"struct_value({{{fields}}})"
            case Member():
                return f"member({self.value(e.value)}, {e.name!r})"
            case Item():
                return f"item({self.value(e.value)}, {self.value(e.index)})"
            case Unary():
                operand = self.value(e.operand)
                return f"negative({operand})" if e.operator == "-" else f"(not truth({operand}))"
            case Binary():
                return self.binary(e.operator, self.value(e.left), self.value(e.right))
            case Run() if e.call.function in self.own:
                return f'm.run("{e.call.function}", {self.call(e.call, "f_")})'
            case Run():
                return self.called(e.call)
            case Call():
                return self.called(e)
            case Method():
                return f"lacking({e.name!r})"

    def called(self, e: Call) -> str:
        if e.function in self.own:
            return f"(yield from {self.call(e, 'f_')})"
        if e.function not in self.library:
            return f"lacking({e.function!r})"
        call = self.call(e, "b_")
        return f"(yield from {call})" if blocks(self.library[e.function]) else call

    def call(self, e: Call, prefix: str) -> str:
        named = "v_" if prefix == "f_" else ""
        given = self.value if prefix == "f_" else self.counted
        arguments = [*map(given, e.arguments), *(f"{named}{name}={given(v)}" for name, v in e.named)]
        return f"{prefix}{e.function}({', '.join(arguments)})"

    def binary(self, operator: str, left: str, right: str) -> str:
        if operator in _CALLS:
            value = f"{_CALLS[operator]}({left}, {right})"
            return value if operator in "<>" else f"m.kept({value})"
        if operator in _SWAPPED:
            return f"(not {_SWAPPED[operator]}({left}, {right}))"
        if operator in ("and", "or"):
            return f"(truth({left}) {operator} truth({right}))"
        return f"(truth({left}) != truth({right}))" if operator == "xor" else f"({left} {operator} {right})"


def _indented(lines: Iterable[str]) -> list[str]:
    return ["    " + line for line in lines]
