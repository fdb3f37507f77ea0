"""A parser of URScript: programs, script files, functions and statements (see expressions.py for the rest)."""

from __future__ import annotations

from typing import TypeGuard

from cramlite.plugin import UserError

from .expressions import ExpressionParser
from .lexer import Token, complaint, tokens
from .syntax import (
    Assign,
    Call,
    Critical,
    Evaluate,
    Expression,
    Function,
    If,
    Item,
    Jump,
    Member,
    Method,
    Name,
    Return,
    Statement,
    ThreadOrder,
    While,
)

_LARGEST = 5_000_000  # characters


def parse(text: str) -> Function:
    """Parse a program or a script file.

    A program, as a controller takes it over a socket, is one ``def`` or ``sec`` without parameters in column 0 up to its
    ``end`` in column 0; a call of itself may follow. Everything else (functions, and statements before, between and after
    them) is a script file, as PolyScope reads it into a program: a ``def`` without a name around all of it.

    Raises:
        UserError: the text is not URScript; says the line, what stands there and what would be right.
    """
    if len(text) > _LARGEST:
        raise UserError(f"URScript: the program has {len(text)} characters, more than {_LARGEST}")
    parser = _Parser(list(tokens(text)))
    return parser.program()


class _Parser(ExpressionParser):
    def __init__(self, words: list[Token]) -> None:
        super().__init__(words)
        self.loops = 0

    def program(self) -> Function:
        first = self.word
        if first.kind == "end of text":
            raise self.unexpected("a program: 'def name():' up to its 'end'")
        main = self.outermost()
        last = self.words[self.at - 1]
        after: list[Statement] = []
        while self.word.kind != "end of text":
            after.append(self.outermost())
        if first.column == last.column == 0 and _is_program(main, after):
            return main
        return Function("def", "", (), (main, *after), first.line)

    def outermost(self) -> Statement:
        if self.sees("end"):
            raise complaint(self.word.line, "this 'end' closes nothing: no def, thread, if or while is open here")
        return self.statement()

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
        """Parse statements up to one of the closing keywords, which is not consumed."""
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
            if not isinstance(target, Name | Item | Member):
                raise complaint(line, "only a variable, an element of a list or a field of a struct can be assigned to")
            return Assign(target, self.expression(), scope, line)
        if scope or not isinstance(target, Call | Method):
            raise self.unexpected("'=' of an assignment" if scope else "'=' or a call")
        return Evaluate(target, line)


def _is_program(main: Statement, after: list[Statement]) -> TypeGuard[Function]:
    """Whether a controller would start a text as a program: it holds one function, and at most a call of it.

    Such a call after the function has no effect.
    """
    if not isinstance(main, Function) or main.word == "thread" or main.parameters:
        return False
    return all(isinstance(s, Evaluate) and s.value == Call(main.name, (), (), s.line) for s in after[:1]) and len(after) < 2
