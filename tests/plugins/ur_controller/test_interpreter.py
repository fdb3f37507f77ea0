"""URScript: parser, checks, threads and limits."""

from __future__ import annotations

import random
import re
from collections.abc import Iterator
from typing import Any

import pytest
from helpers.properties import examples
from hypothesis import given
from hypothesis import strategies as st

from cramlite.plugin import UserError
from cramlite_plugins.backends.urscript.parts import FUNCTIONS
from cramlite_plugins.ur_controller.urscript.builtins import PURE
from cramlite_plugins.ur_controller.urscript.interpreter import Limits, Machine, Stopped, load


def sync() -> Iterator[None]:
    yield


LIBRARY = {**PURE, "sync": sync}


def run(body: str, cycles: int = 100, limits: Limits | None = None) -> dict[str, Any]:
    machine = Machine(load(f"def program():\n{body}\nend\n", LIBRARY), LIBRARY, limits)
    for _ in range(cycles):
        if machine.finished:
            break
        machine.cycle()
    return machine.variables


@pytest.mark.parametrize(
    ("expression", "value"),
    [
        ("1 + 2 * 3 - 4 / 2", 5),
        ("-2 * -(3)", 6),
        ("7 % 4", 3),
        ("not 1 > 2 and (2 <= 2 or False)", True),
        ("True xor True", False),
        ("[1, 2.5, -3][1]", 2.5),
        ("norm([3, 4]) + norm(-2)", 7.0),
        ("length([1, 2, 3])", 3),
        ('str_cat("a", 1.5)', "a1.5"),
        ("pose_trans(p[1, 0, 0, 0, 0, 3.141592653589793], p[1, 0, 0, 0, 0, 0])[0]", 0.0),
        ("pose_add(p[1, 0, 0, 0, 0, 1], p[1, 2, 0, 0, 0, 0])[1]", 2.0),
        ("0x1F", 31),
        ("1e-3", 0.001),
    ],
)
def test_expressions(expression: str, value: Any) -> None:
    result = run(f"x = {expression}")["x"]
    assert result == pytest.approx(value) if isinstance(value, float) else result == value
    assert type(result) is type(value) or isinstance(value, int)


def test_newlines_are_blanks_inside_expressions() -> None:
    variables = run("global a = # a comment\n0    global b = [1,\n 2\n ] c = b[\n1] +\n 1")
    assert (variables["a"], variables["b"], variables["c"]) == (0, [1, 2], 3)


def test_control_flow_and_functions() -> None:
    variables = run("""
  def fib(n, one=1):
    if n < 2:
      return n
    elif n == 2:
      return one
    else:
      return fib(n - 1) + fib(n - 2)
    end
  end
  x = fib(12)
  i = 0
  while True:
    i = i + 1
    if i % 2 == 0: continue end
    if i > 6: break end
  end""")
    assert (variables["x"], variables["i"]) == (144, 7)


def test_lists_are_values_and_locals_are_local() -> None:
    variables = run("""
  global a = [1, 2]
  def f():
    local a = 5
    free = 7
    return a + free
  end
  b = a
  b[0] = 9
  x = f()""")
    assert (variables["a"], variables["b"], variables["x"]) == ([1, 2], [9, 2], 12)
    assert "free" not in variables


def test_threads_share_globals_and_run_in_step() -> None:
    body = """
  global n = 0
  thread count():
    while n < 5:
      n = n + 1
      sync()
    end
  end
  handle = run count()
  {}"""
    assert run(body.format("join handle"))["n"] == 5
    assert run(body.format("sync() sync() kill handle sync() sync() sync() sync()"))["n"] == 1
    assert run(body.format(""))["n"] == 0  # the program's end ends its threads


def test_a_critical_section_runs_alone() -> None:
    body = """
  global n = 0
  thread count():
    while True:
      n = n + 1
      sync()
    end
  end
  handle = run count()
  sync()
  {}
  before = n
  sync() sync() sync()
  gained = n - before
  {}"""
    assert run(body.format("enter_critical", "exit_critical"))["gained"] == 0
    assert run(body.format("", ""))["gained"] >= 2


@pytest.mark.parametrize(
    ("body", "reason"),
    [
        ("while True: end", "endless loop"),
        ("def f(): f() end\nf()", "endless recursion"),
        ("x = 1 / 0", "line 2: division by zero"),
        ("x = [1, 2][2]", "a list with 2 elements has no index 2"),
        ("x = 2147483647 + 1", "32 bits"),
        ("x = 1 < True", "'<' needs numbers"),
        ("if 1: x = 2 end", "True or False"),
        ("x = sqrt(-1)", "arithmetic"),
        ("thread t(): while True: sync() end end\nwhile True: run t() end", "threads"),
        ("s = \"ab\" while True: s = str_cat(s, s) end", "longest"),
        ("if False: local y = 1 end\nx = y", "'y' is read before"),
        ("kill 3", "needs a thread's handle"),
        ("a = [1, [2]]\nb = [a, a]", "no deeper"),
        ("a = [1, 2]\na[0] = [a, a]", "no deeper"),
        ('x = to_num("nan")', "is no number"),
    ],
)
def test_what_goes_wrong_stops_the_program_with_its_line(body: str, reason: str) -> None:
    with pytest.raises(Stopped, match=reason) as stopped:
        run(body, limits=Limits(slice=5000))
    assert stopped.value.line >= 2


def test_a_limit_on_all_statements() -> None:
    body = "while True: sync() end"
    with pytest.raises(Stopped, match="more than 50 statements"):
        run(body, limits=Limits(statements=50))
    run(body, limits=Limits(statements=500))


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("def p():\n  normm(1)\nend", "line 2: there is no function 'normm'; did you mean 'norm'"),
        ("def p():\n  x = norm()\nend", "line 2: 'norm.a.' takes 1 arguments, not 0"),
        ("def p():\n  x = norm(1, 2)\nend", "takes 1"),
        ("def p():\n  x = norm(b=2)\nend", "no parameter 'b'"),
        ("def p():\n  x = y + 1\nend", "line 2: 'y' is assigned nowhere"),
        ("def p():\n  run norm(1)\nend", "'norm' is none"),
        ("def p():\n  def f(): end\n  def f(): end\nend", "line 3: 'f' is defined twice, first in line 2"),
        ("def p():\n  x = [1, 2\nend", "line 3: expected ',' or"),
        ("def p():\n  if True:\n  x = 1\n", "'if' of line 2 has no 'end'"),
        ("def p():\n  x = \"abc\nend", "line 2: this string has no closing quote"),
        ("def p():\n  x = p[1, 2]\nend", "6 numbers, this one 2"),
        ("def p():\n  break\nend", "outside of a while loop"),
        ("  def p():\n  end", "column 0"),
        ("def p(x):\nend", "line 1: nothing would run: 'p' is only defined"),
        ("def p():\nend\nend", "line 3: this 'end' closes nothing"),
        ("def p():\n  x = 1 ; y\nend", "unexpected character ';'"),
        ("def p():\n  x = " + "(" * 500 + "\nend", "nested"),
        ("def p():\n  a = 1\n  x = 1" + " + 1" * 5000 + "\nend", "line 3: .* too long or nested"),
        ("def p():\n  def f():\n    y = 2\n" + "while True:\n" * 25 + "y = 3\n" + "end\n" * 27, "line 4: .* too long or nested"),
        ("def p():\n  x = 1\nif True:\n" + "elif True:\n" * 5000 + "end\nend", "line 3: .* too long or nested"),
        ("def p():\n  x = [1]\n  x = x" + "[0]" * 5000 + "\nend", "line 3: .* too long or nested"),
        ("def p():\n  x = 1e999\nend", "line 2: the number 1e999 is too large"),
        ("def p():\n  x = 4294967296\nend", "does not fit into 32 bits"),
        ("", "the end of the text"),
    ],
)
def test_bad_programs_are_refused_before_they_run(text: str, reason: str) -> None:
    with pytest.raises(UserError, match=reason):
        load(text, LIBRARY)


PIECES = ("", " ", "end", "(", ")", "[", ":", "=", '"', "if ", "p[", "\n", "9" * 12, "é")


def refusal(text: str) -> str:
    """The first word of the refusal of a program; empty if it loads. Any other error escapes."""
    try:
        load(text, LIBRARY)
    except UserError as error:
        return re.split(r"\W", str(error))[0]
    return ""


SEED = "def program():\n" + FUNCTIONS + "end\n"


@examples(150)
@given(st.integers(0, 2**32), st.integers(1, 6))
def test_mutated_programs_give_nothing_but_user_errors(seed: int, count: int) -> None:
    random_ = random.Random(seed)
    text = SEED
    for _ in range(count):
        i, j = sorted(random_.randrange(len(text)) for _ in range(2))
        piece = random_.choice((*PIECES, text[i : i + 9]))
        text = text[:i] + piece + text[min(j, i + random_.randrange(20)) :]
    assert refusal(text) in ("", "URScript")


@given(st.text(max_size=200))
def test_any_text_gives_nothing_but_user_errors(text: str) -> None:
    assert refusal(f"def p():\n{text}") in ("", "URScript")
