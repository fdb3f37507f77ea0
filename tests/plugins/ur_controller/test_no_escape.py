# ruff: noqa: E501 (texts that would mean something else in two lines)
"""URScript becomes Python that is executed: no text gets out of it, fills the memory or runs for ever."""

from __future__ import annotations

import random
import tracemalloc
from collections.abc import Iterator
from typing import Any

import pytest
from helpers.audited import audited, beyond
from helpers.hostile_programs import BOMBS, ESCAPES, hostile_program

from cramlite.plugin import UserError
from cramlite_plugins.simulation.controller.halted import Halted
from cramlite_plugins.ur_controller.urscript.builtins import PURE
from cramlite_plugins.ur_controller.urscript.interpreter import _NAMES, Limits, Machine, Stopped, Thread, load
from cramlite_plugins.ur_controller.urscript.python_subset import OtherPython, compiled


def sync() -> Iterator[None]:
    yield


LIBRARY = {**PURE, "sync": sync}
FEW = Limits(slice=3000, statements=10_000, threads=5)
MEMORY = 100_000_000
"""Bytes that a program may take with a hundredth of the statements that it has otherwise."""


def outcome(text: str, limits: Limits = FEW, cycles: int = 5) -> tuple[str, dict[str, Any]]:
    """What became of a program, and its variables; events beyond its own values while it runs are an error."""
    try:
        program = load(text, LIBRARY)
    except UserError as refused:
        return "refused" if str(refused).startswith("URScript") and "\n" not in str(refused) else f"refused unclearly: {refused}", {}
    machine = Machine(program, LIBRARY, limits)
    end = "ended"
    with audited() as heard:
        try:
            for _ in range(cycles):
                if not machine.finished:
                    machine.cycle()
        except (Halted, Stopped):
            end = "stopped"
        machine.close()
    assert not beyond(heard), (text, beyond(heard))
    return end, machine.variables


def of_urscript(value: Any) -> bool:
    if isinstance(value, list | dict):
        return all(of_urscript(v) for v in (value.values() if isinstance(value, dict) else value))
    return value is None or type(value) in (bool, int, float, str, Thread)


@pytest.fixture(scope="module", autouse=True)
def warm() -> None:
    """What is imported at a first call is imported."""
    outcome("def program():\n  x = inv([[1, 0], [0, 1]])\n  sync()\nend\n")


@pytest.mark.parametrize("body", ESCAPES.values(), ids=ESCAPES)
def test_known_ways_out_are_closed(body: str) -> None:
    end, variables = outcome(f"def program():\n  thread t():\n    sync()\n  end\n  {body}\nend\n")
    assert all(of_urscript(v) for v in variables.values()), (end, variables)


def test_most_known_ways_out_are_not_even_urscript() -> None:
    ends = [outcome(f"def program():\n  {body}\nend\n")[0] for body in ESCAPES.values()]
    assert ends.count("refused") > 0.8 * len(ends)


def survives(count: int, seed: int) -> dict[str, int]:
    draw, ends = random.Random(seed), dict.fromkeys(("refused", "stopped", "ended"), 0)
    for _ in range(count):
        text = hostile_program(draw)
        end, variables = outcome(text)
        assert all(of_urscript(v) for v in variables.values()), text
        ends[end] += 1
    return ends


def test_no_program_of_a_sample_gets_out() -> None:
    ends = survives(1000, seed=1)
    assert min(ends.values()) > 30, ends


@pytest.mark.heavy
@pytest.mark.parametrize("seed", range(10))
def test_no_program_of_a_hundred_thousand_gets_out(seed: int) -> None:
    assert sum(survives(10_000, seed=100 + seed).values()) == 10_000


@pytest.mark.parametrize("body", BOMBS.values(), ids=BOMBS)
def test_bombs_end_in_bounded_memory(body: str) -> None:
    tracemalloc.start()
    try:
        end, _ = outcome(f"def program():\n  {body}\nend\n", Limits(slice=20_000, statements=1_000_000), cycles=50)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert end == "stopped"
    assert peak < MEMORY


PYTHON = (
    "import os", "from os import system", "__import__('os')", "eval('1')", "v_x = ().__class__", "m.__class__", "m.at.__globals__", "m.coroutine",
    "m.at = 1", "v_x = m.variables", "v_x.kept(1)", "v_x[0]", "v_x[0] = 1", "g[v_x] = 1", "g[0:1]", "v_x = lambda: 0", "v_x = [i for i in v_y]",
    "v_x = {1}", "v_x = f'{v_y}'", "v_x = b'a'", "v_x = 1j", "v_x = v_y = 1", "v_x, v_y = 1", "v_x += 1", "v_x: int = 1", "(v_x := 1)", "del v_x", "global v_x",
    "b_sin(*v_x)", "b_sin(**v_x)", "m.at(1)(2)", "assert v_x", "raise v_x", "try:\n  pass\nexcept v_x:\n  pass", "with v_x:\n  pass", "for v_x in v_y:\n  pass",
    "class f_x:\n  pass", "async def f_x():\n  pass", "@m.at\ndef f_x():\n  pass", "def f_x() -> v_x:\n  pass", "def f_x(*v_a):\n  pass", "def f_x(v_a: v_b):\n  pass",
    "def copied():\n  pass", "copied = 1", "v_x = v_y if v_z else 1", "v_x = v_y + 1", "v_x = v_y < 1", "v_x = v_y is 1", "v_\uff58.a", "...",
    "match v_x:\n  case 1:\n    pass",
)  # fmt: skip


@pytest.mark.parametrize("source", PYTHON)
def test_python_outside_of_the_subset_is_not_compiled(source: str) -> None:
    with pytest.raises(OtherPython):
        compiled(source, _NAMES)


def test_python_of_the_subset_is_compiled() -> None:
    source = "def f_a(v_x, v_y=1):\n    m.at(1)\n    while True:\n        if not truth((v_x == 1)): break\n    g['a'] = m.kept(b_sin(f=v_y))\n    return\n    yield\n"
    assert compiled(source, _NAMES).co_filename == "<urscript>"
