"""The syntax tree of URScript: every node knows its line."""

from __future__ import annotations

from cramlite.model import Value


class Number(Value):
    """A number literal."""

    value: float | int
    line: int


class Text(Value):
    """A string literal."""

    value: str
    line: int


class Truth(Value):
    """A Boolean literal."""

    value: bool
    line: int


class Nothing(Value):
    """The literal None."""

    line: int


class Name(Value):
    """A variable."""

    name: str
    line: int


class ListOf(Value):
    """URScript's list ``[...]``, or pose ``p[...]`` if the field ``pose`` is true."""

    items: tuple[Expression, ...]
    pose: bool
    line: int


class StructOf(Value):
    """``struct(name=value, ...)``."""

    fields: tuple[tuple[str, Expression], ...]
    line: int


class Member(Value):
    """``value.name``: a field of a struct."""

    value: Expression
    name: str
    line: int


class Item(Value):
    """Element of a list or matrix, ``value[index]``; ``value[row, column]`` is parsed as ``value[row][column]``."""

    value: Expression
    index: Expression
    line: int


class Unary(Value):
    """An operator before its operand."""

    operator: str
    operand: Expression
    line: int


class Binary(Value):
    """An operator between two operands."""

    operator: str
    left: Expression
    right: Expression
    line: int


class Call(Value):
    """``function(arguments, name=value)``."""

    function: str
    arguments: tuple[Expression, ...]
    named: tuple[tuple[str, Expression], ...]
    line: int


class Method(Value):
    """``value.name(arguments, name=value)``: a call on a handle, such as ``rpc_factory`` gives."""

    value: Expression
    name: str
    arguments: tuple[Expression, ...]
    named: tuple[tuple[str, Expression], ...]
    line: int


class Run(Value):
    """Expression ``run thread()``, which starts a thread; its value is the thread's handle."""

    call: Call
    line: int


Expression = (
    Number | Text | Truth | Nothing | Name | ListOf | StructOf | Item | Member | Unary | Binary | Call | Method | Run
)


class Assign(Value):
    """``[local|global] target = value``; ``scope`` is "local", "global" or "" (found by the rules of scope)."""

    target: Name | Item | Member
    value: Expression
    scope: str
    line: int


class Evaluate(Value):
    """An expression as a statement: a call."""

    value: Expression
    line: int


class If(Value):
    """Statement ``if``: a condition with its statements for ``if`` and each ``elif``, then the statements of ``else``."""

    branches: tuple[tuple[Expression, tuple[Statement, ...]], ...]
    otherwise: tuple[Statement, ...]
    line: int


class While(Value):
    """``while condition``."""

    condition: Expression
    body: tuple[Statement, ...]
    line: int


class Jump(Value):
    """``break`` or ``continue``."""

    word: str
    line: int


class Return(Value):
    """``return value``; None without a value."""

    value: Expression | None
    line: int


class ThreadOrder(Value):
    """URScript statement that ends a thread or waits for its end: ``kill handle`` or ``join handle``."""

    word: str
    handle: Expression
    line: int


class Critical(Value):
    """``enter_critical`` or ``exit_critical``."""

    word: str
    line: int


class Function(Value):
    """Definition of a URScript function, thread or secondary program (``def``, ``thread`` or ``sec``).

    Each parameter has a name, and a default or None. A whole script file is a function without a name.
    """

    word: str
    name: str
    parameters: tuple[tuple[str, Expression | None], ...]
    body: tuple[Statement, ...]
    line: int


Statement = Assign | Evaluate | If | While | Jump | Return | ThreadOrder | Critical | Function
