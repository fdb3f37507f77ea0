"""A parser of URScript expressions, by recursive descent.

Newlines are blanks here, as in the real controller: ``global a = # comment`` may go on in the next line.
Grammar: the URScript manual (Universal Robots, e-Series 5.x), chapter 1. It writes ``not`` also as ``!``, which binds like a
sign: ``if (! camera.initialize("RGB")):``.
"""

from __future__ import annotations

from cramlite.plugin import UserError

from .lexer import Token, complaint
from .syntax import (
    Binary,
    Call,
    Expression,
    Item,
    ListOf,
    Member,
    Method,
    Name,
    Nothing,
    Number,
    Run,
    StructOf,
    Text,
    Truth,
    Unary,
)

Given = tuple[tuple[Expression, ...], tuple[tuple[str, Expression], ...]]  # arguments by place and by name

# Loosest first; each level is left associative.
_LEVELS: tuple[tuple[str, ...], ...] = (
    ("or", "xor"),
    ("and",),
    ("not",),
    ("==", "!=", "<", ">", "<=", ">="),
    ("+", "-"),
    ("*", "/", "%"),
)
_DEEPEST = 40  # nested blocks or brackets; far above real programs, far below Python's own limits


class ExpressionParser:
    """A recursive-descent parser of expressions over a list of tokens.

    Raises:
        UserError: the tokens are no expression; says the line, what was found and what would be right.
    """

    def __init__(self, words: list[Token]) -> None:
        self.words, self.at, self.depth = words, 0, 0

    # Tokens

    @property
    def word(self) -> Token:
        """Return the present token."""
        return self.words[self.at]

    def take(self) -> Token:
        """Consume the present token."""
        token = self.word
        self.at = min(self.at + 1, len(self.words) - 1)
        return token

    def sees(self, *values: str) -> bool:
        """Check whether the present token is one of the given operators or keywords."""
        return self.word.kind in ("operator", "keyword") and self.word.value in values

    def accept(self, *values: str) -> bool:
        """Consume the present token if it is one of the given operators or keywords; return whether it was."""
        return self.sees(*values) and bool(self.take())

    def expect(self, value: str, where: str) -> Token:
        """Read the next token, which must be the given operator or keyword; else raise an error that says
        where it is missing."""
        if not self.sees(value):
            raise self.unexpected(f"'{value}' {where}")
        return self.take()

    def identifier(self, what: str) -> Token:
        """Read the next token, which must be a name; else raise an error that ``what`` was expected."""
        if self.word.kind != "name":
            raise self.unexpected(what)
        return self.take()

    def unexpected(self, wanted: str) -> UserError:
        """Make the error of an unexpected token."""
        found = f"'{self.word.value}'" if self.word.value else "the end of the text"
        return complaint(self.word.line, f"expected {wanted}, found {found}")

    def deeper(self) -> None:
        """Count a level of nesting, and refuse too many."""
        self.depth += 1
        if self.depth > _DEEPEST:
            raise complaint(self.word.line, f"nested more than {_DEEPEST} deep")

    # Expressions

    def expression(self, level: int = 0) -> Expression:
        """Parse an expression from a level of precedence upwards."""
        self.deeper()
        value = self.operation(level)
        self.depth -= 1
        return value

    def operation(self, level: int) -> Expression:
        """Parse the operators of a level of precedence, the lowest first."""
        if level == len(_LEVELS):
            return self.unary()
        operators = _LEVELS[level]
        if operators == ("not",):
            line = self.word.line
            return Unary("not", self.expression(level), line) if self.accept("not") else self.operation(level + 1)
        left = self.operation(level + 1)
        while self.sees(*operators):
            operator = self.take()
            left = Binary(operator.value, left, self.operation(level + 1), operator.line)
        return left

    def unary(self) -> Expression:
        """Parse signs before an operand."""
        line = self.word.line
        if self.sees("-", "+", "!"):
            self.deeper()
            sign = self.take().value
            operand = self.unary()
            self.depth -= 1
            return operand if sign == "+" else Unary("not" if sign == "!" else sign, operand, line)
        return self.postfix()

    def postfix(self) -> Expression:
        """Parse an operand with its indices, fields and method calls."""
        value = self.atom()
        while self.sees("[", "."):
            line = self.word.line
            value = self.member(value, line) if self.accept(".") else self.indexed(value, line)
        return value

    def indexed(self, value: Expression, line: int) -> Expression:
        """Parse an index, or the row and column of a matrix."""
        indices = self.items()
        if not indices:
            raise complaint(line, "an index is missing between '[' and ']'")
        for index in indices:
            value = Item(value, index, line)
        return value

    def member(self, value: Expression, line: int) -> Expression:
        """Parse a field or a method call, behind the dot."""
        if self.word.kind not in ("name", "keyword"):
            raise self.unexpected("a name after '.'")
        name = self.take().value
        return Method(value, name, *self.given(name), line) if self.accept("(") else Member(value, name, line)

    def atom(self) -> Expression:
        """Parse a literal, a name, a call, a list or a parenthesis."""
        token = self.word
        if token.kind == "name":
            return self.named()
        if token.kind == "number":
            return Number(_number(self.take()), token.line)
        if token.kind == "text":
            return Text(self.take().value[1:-1], token.line)
        if self.accept("True", "true", "False", "false"):
            return Truth(token.value in ("True", "true"), token.line)
        if self.accept("None"):
            return Nothing(token.line)
        if self.accept("("):
            value = self.expression()
            self.expect(")", "that closes the '('")
            return value
        if self.sees("["):
            return ListOf(self.items(), False, token.line)
        if self.accept("run"):
            call = self.named()
            if not isinstance(call, Call):
                raise complaint(token.line, "'run' needs a call of a thread, as in 'run watch()'")
            return Run(call, token.line)
        raise self.unexpected("a value")

    def named(self) -> Expression:
        """Parse a variable, a call or a pose."""
        token = self.identifier("a name")
        if self.accept("("):
            return self.call(token)
        if token.value == "p" and self.sees("["):
            items = self.items()
            if len(items) == 6:
                return ListOf(items, True, token.line)
            if len(items) == 1:
                return Item(Name("p", token.line), items[0], token.line)
            raise complaint(token.line, f"a pose p[x, y, z, rx, ry, rz] has 6 numbers, this one {len(items)}")
        return Name(token.value, token.line)

    def call(self, function: Token) -> Call | StructOf:
        """Parse a call, or the making of a struct."""
        arguments, named = self.given(function.value)
        if function.value != "struct":
            return Call(function.value, arguments, named, function.line)
        if arguments or len(dict(named)) < len(named):
            raise complaint(function.line, "a struct needs a name of its own for each field: struct(width=0.05, closed=False)")
        return StructOf(named, function.line)

    def given(self, function: str) -> Given:
        """Parse the arguments of a call, and the parenthesis that closes them."""
        arguments: list[Expression] = []
        named: list[tuple[str, Expression]] = []
        while not self.accept(")"):
            if self.word.kind in ("name", "keyword") and self.words[self.at + 1].value == "=":
                name = self.take().value
                self.take()
                named.append((name, self.expression()))
            elif named:
                raise complaint(self.word.line, "an argument without a name follows one with a name")
            else:
                arguments.append(self.expression())
            if not self.sees(")"):
                self.expect(",", f"or ')' in the arguments of '{function}'")
        return tuple(arguments), tuple(named)

    def items(self) -> tuple[Expression, ...]:
        """Parse a list in brackets."""
        self.expect("[", "that opens a list")
        items: list[Expression] = []
        while not self.accept("]"):
            items.append(self.expression())
            if not self.sees("]"):
                self.expect(",", "or ']' in a list")
        return tuple(items)


def _number(token: Token) -> float | int:
    hexadecimal = token.value[:2] in ("0x", "0X")
    if not hexadecimal and not token.value.isdigit():
        value = float(token.value)
        if value > 1e300:
            raise complaint(token.line, f"the number {token.value[:12]} is too large")
        return value
    if len(token.value) > 12 or (whole := int(token.value, 16 if hexadecimal else 10)) >= 2**31:
        raise complaint(token.line, f"the integer {token.value[:12]} does not fit into 32 bits")
    return whole
