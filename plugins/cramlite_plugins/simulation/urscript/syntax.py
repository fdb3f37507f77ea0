"""The syntax tree of URScript: every node knows its line."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Number:
    value: float | int
    line: int


@dataclass(frozen=True)
class Text:
    value: str
    line: int


@dataclass(frozen=True)
class Truth:
    value: bool
    line: int


@dataclass(frozen=True)
class Name:
    name: str
    line: int


@dataclass(frozen=True)
class ListOf:
    """``[...]``, or ``p[...]`` when ``pose``."""

    items: tuple[Expression, ...]
    pose: bool
    line: int


@dataclass(frozen=True)
class Item:
    """``value[index]``."""

    value: Expression
    index: Expression
    line: int


@dataclass(frozen=True)
class Unary:
    operator: str
    operand: Expression
    line: int


@dataclass(frozen=True)
class Binary:
    operator: str
    left: Expression
    right: Expression
    line: int


@dataclass(frozen=True)
class Call:
    """``function(arguments, name=value)``."""

    function: str
    arguments: tuple[Expression, ...]
    named: tuple[tuple[str, Expression], ...]
    line: int


@dataclass(frozen=True)
class Run:
    """``run thread()``: its value is the thread's handle."""

    call: Call
    line: int


Expression = Number | Text | Truth | Name | ListOf | Item | Unary | Binary | Call | Run


@dataclass(frozen=True)
class Assign:
    """``[local|global] target = value``; ``scope`` is "local", "global" or "" (found by the rules of scope)."""

    target: Name | Item
    value: Expression
    scope: str
    line: int


@dataclass(frozen=True)
class Evaluate:
    """An expression as a statement: a call."""

    value: Expression
    line: int


@dataclass(frozen=True)
class If:
    branches: tuple[tuple[Expression, tuple[Statement, ...]], ...]
    otherwise: tuple[Statement, ...]
    line: int


@dataclass(frozen=True)
class While:
    condition: Expression
    body: tuple[Statement, ...]
    line: int


@dataclass(frozen=True)
class Jump:
    """``break`` or ``continue``."""

    word: str
    line: int


@dataclass(frozen=True)
class Return:
    value: Expression | None
    line: int


@dataclass(frozen=True)
class ThreadOrder:
    """``kill handle`` or ``join handle``."""

    word: str
    handle: Expression
    line: int


@dataclass(frozen=True)
class Critical:
    """``enter_critical`` or ``exit_critical``."""

    word: str
    line: int


@dataclass(frozen=True)
class Function:
    """``def``, ``thread`` or ``sec``, with its parameters (name, default or None)."""

    word: str
    name: str
    parameters: tuple[tuple[str, Expression | None], ...]
    body: tuple[Statement, ...]
    line: int


Statement = Assign | Evaluate | If | While | Jump | Return | ThreadOrder | Critical | Function
