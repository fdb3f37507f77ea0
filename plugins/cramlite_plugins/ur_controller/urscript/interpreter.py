"""A URScript interpreter: threads in lockstep with the control cycle, and limits that stop them.

``load`` turns text into a program that was checked; ``Machine`` runs it. Each ``cycle`` resumes every
thread once, in the order in which they were started, until it waits: for sync(), sleep(), a motion, a socket.
"""

from __future__ import annotations

from collections.abc import Callable, Generator
from types import CodeType
from typing import Any

from msgspec.structs import replace

from cramlite.model import Value
from cramlite.plugin import UserError

from ...simulation.controller.halted import Halted
from . import arithmetic, values
from .builtins import PURE, Library
from .check import Lack, check, refuse_lacks
from .generate import generate
from .parser import parse
from .python_subset import compiled
from .syntax import Function
from .values import ScriptError

Coroutine = Generator[None, None, Any]

_HELPERS = (
    arithmetic.add, arithmetic.subtract, arithmetic.multiply, arithmetic.divide, arithmetic.modulo, arithmetic.negative,
    arithmetic.less, arithmetic.greater, values.truth, values.item, values.set_item, values.member, values.set_member,
    values.copied, values.pose_value, values.list_value, values.struct_value,
)  # fmt: skip


class Limits(Value):
    """Execution limits that stop a program which would never end.

    Args:
        slice: statements of one thread within one control cycle: more is an endless loop without sync().
        statements: of the whole program.
        threads: that live at one time.
    """

    slice: int = 1_000_000
    statements: int = 100_000_000
    threads: int = 50


class Loaded(Value):
    """A program that was parsed and checked: its tree and its compiled form."""

    tree: Function
    code: CodeType


class Stopped(Exception):
    """Raised when the program is stopped, with the program's line and the reason."""

    def __init__(self, line: int, reason: str) -> None:
        super().__init__(f"line {line}: {reason}")
        self.line, self.reason = line, reason


TOO_DEEP = (RecursionError, MemoryError, SyntaxError)
"""Python's messages on code that is nested too deep."""


def load(text: str, library: Library = PURE) -> Loaded:
    """Parse, check and compile a program.

    Args:
        library: the built-in functions that it may call.

    Raises:
        UserError: it is no URScript, calls what there is not, or would come upon what cannot run here; says the line.
    """
    loaded, lacks = examine(text, library)
    if lacks or not loaded.tree.name:
        refuse_lacks(loaded.tree, library)
    return loaded


def examine(text: str, library: Library = PURE) -> tuple[Loaded, list[Lack]]:
    """Parse, check and compile a program, also one that the controller model cannot run; list its calls that
    the model lacks.

    Raises:
        UserError: it is no URScript, or calls what there is not; says the line.
    """
    tree = parse(text)
    try:
        lacks = check(tree, library)
        return Loaded(tree, _compiled(tree, library)), lacks
    except TOO_DEEP:
        line = _too_deep(tree, library)
        raise UserError(f"URScript, line {line}: an expression or block is too long or nested too deeply; split it") from None


def _compiled(tree: Function, library: Library) -> CodeType:
    return compiled(generate(tree, library), _NAMES)


def _too_deep(part: Function, library: Library) -> int:
    """Line of a function's first statement that is nested too deeply for Python; the line of the function
    itself if no statement alone is."""
    for statement in part.body:
        try:
            _compiled(replace(part, body=(statement,)), library)
        except TOO_DEEP:
            return _too_deep(statement, library) if isinstance(statement, Function) else statement.line
    return part.line


def _lacking(name: str) -> None:
    """Stop a program at the call of a missing function; ``load`` refuses programs that could reach one."""
    raise ScriptError(f"the controller model does not have '{name}'")


_NAMES = frozenset((*(f.__name__ for f in _HELPERS), "lacking"))
"""Functions that generated code names without a prefix."""


class _Globals(dict[str, Any]):
    def __missing__(self, name: str) -> Any:
        raise ScriptError(f"variable '{name}' is read before it is assigned")


class Thread:
    """A running thread; URScript's handle of it."""

    def __init__(self, name: str, coroutine: Coroutine) -> None:
        self.name, self.coroutine, self.alive, self.line = name, coroutine, True, 0


class Machine:
    """A program in execution.

    Args:
        program: what ``load`` made with the same library.
        library: built-in functions; generators among them block the thread that calls them.
        last: what the program's own function waits for at its end.
    """

    def __init__(
        self,
        program: Loaded,
        library: Library = PURE,
        limits: Limits | None = None,
        last: Callable[[], Coroutine] | None = None,
    ) -> None:
        self.limits = limits or Limits()
        self.line = self.main_line = program.tree.line
        self.count = self.total = 0
        self.variables = _Globals()
        space: dict[str, Any] = {f.__name__: f for f in _HELPERS}
        space |= {"lacking": _lacking, "m": self, "g": self.variables, "__builtins__": {}}
        space |= {f"b_{name}": f for name, f in library.items()}
        exec(program.code, space)
        start: Callable[[], Coroutine] = space[f"f_{program.tree.name}"]
        self.root = Thread(program.tree.name, start() if last is None else _one_after_another(start(), last()))
        self.threads = [self.root]
        self.current: Thread | None = None
        self.held: Thread | None = None

    @property
    def finished(self) -> bool:
        """Check whether the program's own function has ended; its threads end with it."""
        return not self.root.alive

    def cycle(self) -> None:
        """Let each thread of the program run on until it waits for the next control cycle.

        Raises:
            Halted: the program called halt.
            Stopped: an error of the program, or a limit; the line and a reason.
        """
        for thread in list(self.threads):
            if thread.alive and self.held in (None, thread):
                self._resume(thread)
            if self.finished:
                self.close()
        self.threads = [t for t in self.threads if t.alive]

    def close(self) -> None:
        """End all threads."""
        for thread in self.threads:
            self.kill(thread)
        self.threads = []

    def _resume(self, thread: Thread) -> None:
        self.current, self.count, self.line = thread, 0, thread.line
        try:
            next(thread.coroutine)
        except StopIteration:
            thread.alive = False
            self.held = None if self.held is thread else self.held
        except Halted:
            raise
        except ScriptError as error:
            raise Stopped(self.line, str(error)) from None
        except UnboundLocalError as error:
            raise Stopped(self.line, f"variable {_variable(error)} is read before it is assigned") from None
        except NameError as error:
            raise Stopped(self.line, f"variable {_variable(error)} is not known in this function") from None
        except RecursionError:
            raise Stopped(self.line, "functions call each other too deeply: endless recursion") from None
        except (ArithmeticError, ValueError) as error:
            raise Stopped(self.line, f"arithmetic: {error}") from None
        finally:
            self.total += self.count
            self.current, thread.line = None, self.line
        if self.total > self.limits.statements:
            raise Stopped(self.line, f"more than {self.limits.statements} statements")

    # Called by generated code

    def at(self, line: int) -> None:
        """Count a statement that a thread runs; end the program with an error after too many within one control cycle."""
        self.line = line
        self.count += 1
        if self.count > self.limits.slice:
            self.check_slice()

    def check_slice(self) -> None:
        """Refuse more statements than a thread may do within one control cycle."""
        if self.count > self.limits.slice:
            raise ScriptError(f"{self.limits.slice} statements without sync(), sleep() or a motion: an endless loop")

    def kept(self, value: Any) -> Any:
        """Count the elements of a list or struct as statements, and check that they are not too many."""
        if isinstance(value, list | dict):
            self.count += values.sized(value)
            self.check_slice()
        return value

    def main(self, line: int) -> None:
        """Count one more executed statement of the program's outermost function, and record the statement's line."""
        self.main_line = line
        self.at(line)

    def run(self, name: str, coroutine: Coroutine) -> Thread:
        """Start a thread; it takes its first step in the next cycle."""
        self.threads = [t for t in self.threads if t.alive]
        if len(self.threads) >= self.limits.threads:
            raise ScriptError(f"more than {self.limits.threads} threads at one time")
        thread = Thread(name, coroutine)
        thread.line = self.line
        self.threads.append(thread)
        return thread

    def kill(self, thread: Any) -> None:
        """End a thread; a thread that has ended already stays so, and 0, which programs use for "no thread",
        is ignored."""
        if type(thread) is int and thread == 0:
            return
        if not isinstance(thread, Thread):
            raise ScriptError(f"kill needs a thread's handle, not {values.show(thread)}")
        if thread is self.current:
            raise ScriptError("a thread cannot kill itself: use return")
        thread.alive = False
        thread.coroutine.close()
        self.held = None if self.held is thread else self.held

    def join(self, thread: Any) -> Coroutine:
        """Wait for a thread's end."""
        if not isinstance(thread, Thread):
            raise ScriptError(f"join needs a thread's handle, not {values.show(thread)}")
        while thread.alive:
            yield

    def critical(self, enter: bool) -> None:
        """Enter or leave a critical section, inside which no other thread runs."""
        self.held = self.current if enter else None


def _one_after_another(first: Coroutine, then: Coroutine) -> Coroutine:
    yield from first
    yield from then


def _variable(error: NameError) -> str:
    return f"'{str(error.name or error).removeprefix('v_')}'" if error.name else _quoted(str(error))


def _quoted(message: str) -> str:
    parts = message.split("'")
    return f"'{parts[1].removeprefix('v_')}'" if len(parts) > 1 else message
