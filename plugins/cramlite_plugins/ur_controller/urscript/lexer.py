"""A lexer of URScript."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterator

from cramlite.model import Value
from cramlite.plugin import UserError

KEYWORDS = frozenset((
    "def", "thread", "sec", "end", "if", "elif", "else", "while", "local", "global", "return", "break", "continue",
    "and", "or", "not", "xor", "run", "kill", "join", "True", "False", "true", "false", "None", "enter_critical",
    "exit_critical",
))  # fmt: skip

_TOKEN = re.compile(
    r"""(?P<blank>[ \t\n\f]+|\#[^\n]*)
      | (?P<number>0[xX][0-9a-fA-F]+ | (?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?)
      | (?P<name>[A-Za-z_][A-Za-z0-9_]*)
      | (?P<text>"[^"\n]*"|'[^'\n]*')
      | (?P<operator>==|!=|<=|>=|[-+*/%<>=()\[\],:.!])
      | (?P<label>\$[ \t]*[0-9]+[ \t]*"[^\n]*)""",
    re.VERBOSE | re.ASCII,
)


class Token(Value):
    """A token of the text; ``kind`` is number, name, keyword, text, operator or end; ``column`` counts from 0."""

    kind: str
    value: str
    line: int
    column: int


def complaint(line: int, what: str) -> UserError:
    """Make the error of a program that cannot be run, beginning with the line."""
    return UserError(f"URScript, line {line}: {what}")


def tokens(text: str) -> Iterator[Token]:
    """Split a program into tokens, comments, blanks and PolyScope's labels left out, an "end of text" last.

    A label is a line of its own, ``$ 2 "Robot Program"``: PolyScope shows by it where the program is. All ends of lines
    (LF, CR LF, CR) are taken, and a byte order mark before the text.

    Raises:
        UserError: a character, a string or a label that is none of URScript's.
    """
    text = _lines(text)
    position, line, start = 0, 1, 0
    while position < len(text):
        match = _TOKEN.match(text, position)
        if match is None:
            raise complaint(line, _strange(text, position))
        kind, value = str(match.lastgroup), match.group()
        if kind == "label":
            if text[start:position].strip():
                raise complaint(line, "a label '$ 1 \"text\"' needs a line of its own")
        elif kind != "blank":
            yield Token("keyword" if value in KEYWORDS else kind, value, line, position - start)
        elif "\n" in value:
            line, start = line + value.count("\n"), position + value.rindex("\n") + 1
        position = match.end()
    yield Token("end of text", "", line, 0)


def _lines(text: str) -> str:
    text = text.removeprefix("\ufeff")
    return text.replace("\r\n", "\n").replace("\r", "\n") if "\r" in text else text


def _strange(text: str, position: int) -> str:
    character = text[position]
    if character in "\"'":
        return "this string has no closing quote on its line"
    if character == "$":
        return "a label is a number and a text: $ 2 \"Robot Program\""
    if character == "{":
        return "'{' is none of URScript's: a template, whose places are filled in before a robot gets it?"
    name = "" if character.isascii() else f" ({unicodedata.name(character, f'U+{ord(character):04X}')})"
    return f"unexpected character {character!r}{name}"
