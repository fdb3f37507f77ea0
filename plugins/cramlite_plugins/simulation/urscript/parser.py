"""URScript text to a syntax tree, by recursive descent.

Newlines are blanks, as in the real controller: ``global a = # comment`` may go on
in the next line. Grammar: the URScript manual (Universal Robots, e-Series 5.x), chapter 1.
"""

from __future__ import annotations

from cramlite.errors import UserError

from .lexer import Token, complaint, tokens
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
    Name,
    Number,
    Return,
    Run,
    Statement,
    Text,
    ThreadOrder,
    Truth,
    Unary,
    While,
)

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
_LARGEST = 5_000_000  # characters


def parse(text: str) -> Function:
    """The program: one ``def`` or ``sec`` in column 0 up to its ``end`` in column 0.

    Raises:
        UserError: the text is not URScript; says the line, what stands there and what would be right.
    """
    if len(text) > _LARGEST:
        raise UserError(f"URScript: the program has {len(text)} characters, more than {_LARGEST}")
    parser = _Parser(list(tokens(text)))
    return parser.program()


class _Parser:
    def __init__(self, words: list[Token]) -> None:
        self.words, self.at, self.depth, self.loops = words, 0, 0, 0

    # Tokens

    @property
    def word(self) -> Token:
        return self.words[self.at]

    def take(self) -> Token:
        token = self.word
        self.at = min(self.at + 1, len(self.words) - 1)
        return token

    def sees(self, *values: str) -> bool:
        return self.word.kind in ("operator", "keyword") and self.word.value in values

    def accept(self, *values: str) -> bool:
        return self.sees(*values) and bool(self.take())

    def expect(self, value: str, where: str) -> Token:
        if not self.sees(value):
            raise self.unexpected(f"'{value}' {where}")
        return self.take()

    def identifier(self, what: str) -> Token:
        if self.word.kind != "name":
            raise self.unexpected(what)
        return self.take()

    def unexpected(self, wanted: str) -> UserError:
        found = f"'{self.word.value}'" if self.word.value else "the end of the text"
        return complaint(self.word.line, f"expected {wanted}, found {found}")

    def deeper(self) -> None:
        self.depth += 1
        if self.depth > _DEEPEST:
            raise complaint(self.word.line, f"nested more than {_DEEPEST} deep")

    # Blocks and statements

    def program(self) -> Function:
        first = self.word
        if not self.sees("def", "sec"):
            raise self.unexpected("a program: 'def name():' or 'sec name():' in column 0")
        if first.column != 0:
            raise complaint(first.line, f"the '{first.value}' of a program must be in column 0, not {first.column}")
        program = self.function()
        end = self.words[self.at - 1]
        if end.column != 0:
            raise complaint(end.line, f"the 'end' of program '{program.name}' (line {first.line}) must be in column 0")
        if self.word.kind == "name" and self.word.value == program.name:
            self.expression()
        if self.word.kind != "end of text":
            raise self.unexpected(f"nothing after the end of program '{program.name}'")
        return program

    def function(self) -> Function:
        word = self.take()
        name = self.identifier(f"a name after '{word.value}'").value
        self.expect("(", f"after the name '{name}'")
        parameters = []
        while not self.accept(")"):
            parameter = self.identifier("a parameter name or ')'").value
            parameters.append((parameter, self.expression() if self.accept("=") else None))
            if not self.sees(")"):
                self.expect(",", "between parameters")
        self.expect(":", f"after '{name}(...)'")
        loops, self.loops = self.loops, 0
        body = self.block(word, "end")
        self.loops = loops
        self.take()
        return Function(word.value, name, tuple(parameters), body, word.line)

    def block(self, opener: Token, *closers: str) -> tuple[Statement, ...]:
        """Statements up to one of the closers, which is left standing."""
        self.deeper()
        body: list[Statement] = []
        while not self.sees(*closers):
            if self.word.kind == "end of text":
                raise complaint(self.word.line, f"'{opener.value}' of line {opener.line} has no 'end'")
            body.append(self.statement())
        self.depth -= 1
        return tuple(body)

    def statement(self) -> Statement:
        word = self.word
        if word.kind == "name":
            return self.assignment_or_call("")
        match word.value if word.kind == "keyword" else "":
            case "def" | "thread" | "sec":
                return self.function()
            case "if":
                return self.conditional()
            case "while":
                return self.loop()
            case "local" | "global":
                return self.assignment_or_call(self.take().value)
            case "run":
                return Evaluate(self.expression(), word.line)
            case "return":
                return self.returned()
            case "break" | "continue":
                if not self.loops:
                    raise complaint(word.line, f"'{word.value}' outside of a while loop")
                return Jump(self.take().value, word.line)
            case "kill" | "join":
                return ThreadOrder(self.take().value, self.expression(), word.line)
            case "enter_critical" | "exit_critical":
                return Critical(self.take().value, word.line)
        raise self.unexpected("a statement")

    def returned(self) -> Return:
        line = self.take().line
        # A value starts on the same line: after a bare return the next statement follows.
        bare = self.word.line != line or self.sees("end", "elif", "else")
        return Return(None if bare else self.expression(), line)

    def conditional(self) -> If:
        opener = self.take()
        branches, otherwise = [self.branch(opener)], ()
        while self.accept("elif"):
            branches.append(self.branch(opener))
        if self.accept("else"):
            self.expect(":", "after 'else'")
            otherwise = self.block(opener, "end")  # type: ignore[assignment]
        self.expect("end", f"of the 'if' of line {opener.line}")
        return If(tuple(branches), otherwise, opener.line)

    def branch(self, opener: Token) -> tuple[Expression, tuple[Statement, ...]]:
        condition = self.expression()
        self.expect(":", f"after the condition of '{opener.value}'")
        return condition, self.block(opener, "elif", "else", "end")

    def loop(self) -> While:
        opener = self.take()
        condition = self.expression()
        self.expect(":", "after the condition of 'while'")
        self.loops += 1
        body = self.block(opener, "end")
        self.loops -= 1
        self.take()
        return While(condition, body, opener.line)

    def assignment_or_call(self, scope: str) -> Statement:
        line = self.word.line
        if self.word.kind == "name" and self.word.value == "halt" and self.words[self.at + 1].value != "(":
            self.take()
            return Evaluate(Call("halt", (), (), line), line)
        target = self.postfix()
        if self.accept("="):
            if not isinstance(target, Name | Item):
                raise complaint(line, "only a variable or an element of a list can be assigned to")
            return Assign(target, self.expression(), scope, line)
        if scope or not isinstance(target, Call):
            raise self.unexpected("'=' of an assignment" if scope else "'=' or a call")
        return Evaluate(target, line)

    # Expressions

    def expression(self, level: int = 0) -> Expression:
        self.deeper()
        value = self.operation(level)
        self.depth -= 1
        return value

    def operation(self, level: int) -> Expression:
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
        line = self.word.line
        if self.sees("-", "+"):
            self.deeper()
            negative = self.take().value == "-"
            operand = self.unary()
            self.depth -= 1
            return Unary("-", operand, line) if negative else operand
        return self.postfix()

    def postfix(self) -> Expression:
        value = self.atom()
        while self.sees("["):
            line = self.take().line
            value = Item(value, self.expression(), line)
            self.expect("]", "after the index")
        return value

    def atom(self) -> Expression:
        token = self.word
        if token.kind == "name":
            return self.named()
        if token.kind == "number":
            return Number(_number(self.take()), token.line)
        if token.kind == "text":
            return Text(self.take().value[1:-1], token.line)
        if self.accept("True", "true", "False", "false"):
            return Truth(token.value in ("True", "true"), token.line)
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

    def call(self, function: Token) -> Call:
        arguments: list[Expression] = []
        named: list[tuple[str, Expression]] = []
        while not self.accept(")"):
            if self.word.kind == "name" and self.words[self.at + 1].value == "=":
                name = self.take().value
                self.take()
                named.append((name, self.expression()))
            elif named:
                raise complaint(self.word.line, "an argument without a name follows one with a name")
            else:
                arguments.append(self.expression())
            if not self.sees(")"):
                self.expect(",", f"or ')' in the arguments of '{function.value}'")
        return Call(function.value, tuple(arguments), tuple(named), function.line)

    def items(self) -> tuple[Expression, ...]:
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
