"""The syntax tree of URScript: every node knows its line."""

from __future__ import annotations

from msgspec import Struct


class Number(Struct, frozen=True):
    value: float | int
    line: int


class Text(Struct, frozen=True):
    value: str
    line: int


class Truth(Struct, frozen=True):
    value: bool
    line: int


class Name(Struct, frozen=True):
    name: str
    line: int


class ListOf(Struct, frozen=True):
    """``[...]``, or ``p[...]`` when ``pose``."""

    items: tuple[Expression, ...]
    pose: bool
    line: int


class Item(Struct, frozen=True):
    """``value[index]``."""

    value: Expression
    index: Expression
    line: int


class Unary(Struct, frozen=True):
    operator: str
    operand: Expression
    line: int


class Binary(Struct, frozen=True):
    operator: str
    left: Expression
    right: Expression
    line: int


class Call(Struct, frozen=True):
    """``function(arguments, name=value)``."""

    function: str
    arguments: tuple[Expression, ...]
    named: tuple[tuple[str, Expression], ...]
    line: int


class Run(Struct, frozen=True):
    """``run thread()``: its value is the thread's handle."""

    call: Call
    line: int


Expression = Number | Text | Truth | Name | ListOf | Item | Unary | Binary | Call | Run


class Assign(Struct, frozen=True):
    """``[local|global] target = value``; ``scope`` is "local", "global" or "" (found by the rules of scope)."""

    target: Name | Item
    value: Expression
    scope: str
    line: int


class Evaluate(Struct, frozen=True):
    """An expression as a statement: a call."""

    value: Expression
    line: int


class If(Struct, frozen=True):
    branches: tuple[tuple[Expression, tuple[Statement, ...]], ...]
    otherwise: tuple[Statement, ...]
    line: int


class While(Struct, frozen=True):
    condition: Expression
    body: tuple[Statement, ...]
    line: int


class Jump(Struct, frozen=True):
    """``break`` or ``continue``."""

    word: str
    line: int


class Return(Struct, frozen=True):
    value: Expression | None
    line: int


class ThreadOrder(Struct, frozen=True):
    """``kill handle`` or ``join handle``."""

    word: str
    handle: Expression
    line: int


class Critical(Struct, frozen=True):
    """``enter_critical`` or ``exit_critical``."""

    word: str
    line: int


class Function(Struct, frozen=True):
    """``def``, ``thread`` or ``sec``, with its parameters (name, default or None)."""

    word: str
    name: str
    parameters: tuple[tuple[str, Expression | None], ...]
    body: tuple[Statement, ...]
    line: int


Statement = Assign | Evaluate | If | While | Jump | Return | ThreadOrder | Critical | Function
