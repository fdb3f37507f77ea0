"""URScript: a parser with positions, a checker, and an interpreter with threads.

    >>> from cramlite_plugins.ur_controller.urscript.interpreter import Machine, load
    >>> program = load("def double():\\n  global answer = 2 * 21\\nend\\n")
    >>> machine = Machine(program)
    >>> machine.cycle()
    >>> machine.variables["answer"]
    42
"""

from __future__ import annotations

from ...simulation.controller.halted import Halted
from .builtins import PURE, Library
from .interpreter import Limits, Loaded, Machine, Stopped, load
from .parser import parse
from .values import ScriptError

__all__ = ["PURE", "Halted", "Library", "Limits", "Loaded", "Machine", "ScriptError", "Stopped", "load", "parse"]
