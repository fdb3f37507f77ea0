# ruff: noqa: E501 (texts that would mean something else in two lines)
"""URScript of somebody who wants out of it: known ways out of Python sandboxes, and programs made of their words at random."""

from __future__ import annotations

import random

NAMES = (
    "__import__", "__class__", "__builtins__", "__globals__", "__dict__", "__subclasses__", "__mro__", "eval", "exec", "open", "import",
    "lambda", "yield", "m", "g", "self", "os", "f_program", "v_x", "b_sin", "copied", "truth", "gi_frame", "f_back", "print", "x", "y",
    "help", "breakpoint", "async", "await", "del", "class", "with", "from", "nonlocal", "p", "None_", "_", "__", "f_", "v_", "at", "kept",
)  # fmt: skip
TEXTS = (
    '"\\\\"', "'\"'", '"x\\"', '"{0.__class__}"', '"%s%n"', '"\\u0027"', "'''", '"""', '"\\N{QUOTATION MARK}"', "'__import__(\\'os\\')'",
    '"); import os; ("', '"]; m.at = 1; g["', '"#"', '"$ 1"', '"\x00"', '"\u2028import os"', '"\\\nimport os"', '"a"',
)  # fmt: skip
NUMBERS = ("0", "1", "-1", "2147483647", "1e300", "0x7FFFFFFF", "1.5", "1e999", "99999999999999999999", "1_000", "0b1", "1j", "007")
OPERATORS = ("+", "-", "*", "/", "%", "==", "!=", "<", ">", "<=", ">=", " and ", " or ", " xor ", "**", "//", "@", ":=", ".", "->", "|")
STRANGE = (
    "\uff45val", "\u1d49xec", "__\uff43lass__", "\u017fin", "\uff3f\uff3fimport\uff3f\uff3f", "\u200b", "\u2028", "\ufeff", "\x0c", "\x0b", "\\", "`", "?",
    ";", "{", "}", "@", "~", "^", "&", "\t", "\r", "$ 1 \"x\"",
)  # fmt: skip
ONE = ("to_str", "to_num", "length", "norm", "size", "transpose", "inv", "normalize", "str_len", "floor", "sin", "pose_inv")
"""URScript functions of one argument."""

ESCAPES = {
    "attribute": "x = [1].__class__", "attribute of a text": 'x = "".__class__.__mro__', "method": "x = [1].append(2)",
    "method of the machine": "m.kill(1)", "class of a struct": "x = struct(a=1).__class__", "keys of a struct": "x = struct(a=1).keys()",
    "field with a dunder": "x = struct(__class__=1)\n  y = x.__class__\n  z = y.__subclasses__()", "builtins": "x = __builtins__",
    "import": "import os", "import function": '__import__("os")', "eval": 'eval("1")', "exec": 'exec("import os")', "open": 'open("/etc/passwd")',
    "getattr": 'getattr(1, "real")', "globals": "x = globals()", "lambda": "x = lambda: 1", "comprehension": "x = [y for y in [1]]",
    "generator": "x = (y for y in [1])", "frame": "x = run t()\n  y = x.gi_frame", "f-string": 'x = f"{1}"', "walrus": "x = (y := 1)",
    "format": 'x = "{0.__class__}".format(1)', "percent": 'x = "%s" % 1', "try": "try:\n    x = 1\n  except:\n  end", "raise": "raise x",
    "traceback": "x = e.__traceback__", "default": 'def f(a=__import__("os")):\n  end\n  f()', "star": "f(*[1])", "two stars": "f(**x)",
    "decorator": "@exec\n  def f():\n  end", "annotation": "def f(a: eval):\n  end", "class": "class A:\n  end", "del": "del x", "with": "with x:\n  end",
    "fullwidth letters": 'x = \uff45val("1")', "fullwidth underscore": "x = \uff3f\uff3fclass\uff3f\uff3f", "long s": "x = \u017fin(1)",
    "modifier letter": "x = \u1d49xec", "line separator": 'x = "a\u2028import os"', "quote in a text": "x = 'a\"]; import os; g[\"'",
    "backslash in a text": 'x = "\\"\n  y = "); import os #"', "line end in a text": 'x = "a\nimport os"', "label": '$ 1 "\nimport os"',
    "comment": "x = 1 #\\\n  import os", "form feed": "x = 1 \x0cimport os", "carriage return": "x = 1\rimport os", "zero": "x = 1\x00import os",
    "name of a helper": "x = copied", "call of a helper": "copied(1)", "name of the machine": "x = m", "name of the globals": "x = g",
    "generated name": "x = b_sin", "function as a value": "x = sin", "named argument": "x = sin(f=1, __class__=2)", "keyword as an argument": "x = sin(if=1)",
    "parameter twice": "def f(a, a):\n  end", "assignment to a call": "sin(1) = 2", "assignment to a helper": "copied = 1\n  x = copied",
    "handle": "x = run t()\n  y = x.coroutine", "index of a text": 'x = "abc"[0]', "slice": "x = [1, 2][0:1]", "power": "x = 9**9**9", "semicolon": "x = 1; import os",
    "return of a thread": "x = run sin(1)", "name without anything": "_ = 1\n  x = _", "dunder variable": "__class__ = 1\n  x = __class__",
}  # fmt: skip
"""Bodies of URScript programs that try to escape from the interpreter. Each is refused, stopped, or harmless: then x, y and z are
URScript's values."""

BOMBS = {
    "loop": "while True:\n    x = 1\n  end", "text": 'x = "a"\n  while True:\n    x = x + x\n  end', "number": "x = 2\n  while True:\n    x = x * x\n  end",
    "float": "x = 2.5\n  while True:\n    x = x * x\n  end\n", "recursion": "def f():\n    f()\n  end\n  f()",
    "threads": "thread t():\n    while True:\n      sync()\n    end\n  end\n  while True:\n    x = run t()\n  end",
    "threads of threads": "thread t():\n    x = run t()\n    y = run t()\n    while True:\n      sync()\n    end\n  end\n  x = run t()\n  while True:\n    sync()\n  end",
    "struct": "x = struct(a=1, b=2)\n  while True:\n    x.a = x\n    x.b = x\n  end", "struct of structs": "x = struct(a=1)\n  while True:\n    x = struct(a=x, b=x)\n  end",
    "matrix": f"x = [{', '.join(['[1]'] * 1200)}] * [[{', '.join(['1'] * 1200)}]]", "rows": f"x = [{', '.join(['0'] * 9000)}]\n  y = x\n  local i = 0\n"
    "  while i < 9000:\n    y[i] = x\n    i = i + 1\n  end",
    "copies": f"x = [{', '.join(['0'] * 9000)}]\n" + "".join(f"  v{k} = x\n" for k in range(300)), "list": f"x = [{', '.join(['0'] * 11_000)}]",
    "shown": f"x = [{', '.join(['1.5'] * 9000)}]\n  while True:\n    y = to_str(x)\n  end",
}  # fmt: skip
"""Bodies of URScript programs that would take all memory or never end."""


TAME = {NAMES: ("x", "y", "v_x", "m", "g", "__class__", "_"), TEXTS: ("'a'", '"{0.__class__}"', '"%s"'), NUMBERS: ("0", "1", "2.5"),
        OPERATORS: ("+", "-", "*", "==", "!=", " + ")}  # fmt: skip
"""Words for URScript programs that are accepted: assigned names, and known operators only."""


def hostile_program(draw: random.Random) -> str:
    """Make a random URScript program with hostile words as names, strings and operators; half of the programs are harmless."""
    words = _Words(draw, draw.choice((0.0, 0.0, 0.02, 0.3)))
    start = "".join(f"  {name} = {value}\n" for name, value in zip(TAME[NAMES], ("1", "[1, 2]", "'ab'", "2.5", "struct(x=1, y=[2])"), strict=False))
    body = "\n".join(f"  {words.statement(2)}" for _ in range(draw.randint(1, 5)))
    text = f"def {draw.choice(('program', 'program', 'program', draw.choice(NAMES)))}():\n{start}  __class__ = 3\n  _ = 4\n{body}\nend\n"
    if draw.random() < words.wild:
        at = draw.randrange(len(text))
        text = text[:at] + draw.choice((*STRANGE, *TEXTS, *OPERATORS)) + text[at + draw.randint(0, 2) :]
    return text


class _Words:
    """Generator of random URScript statements and values; ``wild`` is the share of hostile words."""

    def __init__(self, draw: random.Random, wild: float) -> None:
        self.draw, self.wild = draw, wild

    def word(self, kind: tuple[str, ...]) -> str:
        return self.draw.choice(kind if self.draw.random() < self.wild else TAME[kind])

    def statement(self, depth: int) -> str:
        name = self.word(NAMES)
        kind = self.draw.randrange(8 if depth else 4)
        if kind < 3:
            return f"{self.draw.choice(('', '', '', 'global '))}{name} = {self.value(2)}"
        if kind == 3:
            after = ("[0]", ".x", f"[{self.word(NUMBERS)}]") if self.draw.random() >= self.wild else (f".{self.word(NAMES)}()", "[0].x", "[")
            return f"{name}{self.draw.choice(after)} = {self.value(2)}"
        inner = f"\n  {self.statement(depth - 1)}\n  end"
        own = f"f{self.draw.randrange(10**6)}" if self.draw.random() >= self.wild else name
        heads = (f"if {self.value(1)} == {self.value(1)}:", f"while {self.value(1)} != {self.value(1)}:", f"def {own}({name}={self.value(1)}):")
        return self.draw.choice((*heads, f"thread {own}():")) + inner

    def value(self, depth: int) -> str:
        kind = self.draw.randrange(8 if depth else 3)
        if kind < 3:
            return self.word((NAMES, TEXTS, NUMBERS)[kind])
        left = self.value(depth - 1)
        if kind == 3:
            return f"{left}{self.word(OPERATORS)}{self.value(depth - 1)}"
        if kind == 4:
            return f"{self.draw.choice(ONE) if self.draw.random() >= self.wild else self.word(NAMES)}({left})"
        if kind == 5:
            return f"[{left}, {self.value(depth - 1)}]"
        if kind == 6:
            return f"struct({self.word(NAMES)}={left})"
        wild = (f"{left}.{self.word(NAMES)}()", f"run {left}", f"p{left}", f"({left}", f"{left}[0:1]")
        return self.draw.choice((f"{left}.x", f"-{left}", f"({left})", "y[0]") if self.draw.random() >= self.wild else wild)
