"""Fast Downward (Helmert 2006, "The Fast Downward planning system"), run in a process of its own on PDDL texts."""

from __future__ import annotations

import contextlib
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path

from ...base.errors import NoSolution, PluginError, UserError
from ...base.process_group import end_group
from ...base.pulse import ASKED, checkpoint, working
from ...base.value import Value
from .pddl import PddlText
from .translator_room import is_full

PACKAGE = "up-fast-downward"
SHORT = ("--evaluator", "h=ff()", "--search", "lazy_wastar([h],preferred=[h],w=2)")
"""Options of Fast Downward to find a short plan for any number of things: weighted A* with the heuristic of relaxed plans (Hoffmann and
Nebel 2001), which is deterministic. Greedy search (lama-first) put things into baskets and took them out again on the way, which no leaving
out of steps mends."""

SHORTEST = ("--search", "astar(blind())")
"""Options of Fast Downward to find a shortest plan, for small problems."""

FEW_INVARIANTS = ("--translate-options", "--invariant-generation-max-candidates", "300")
"""Options of Fast Downward that limit its search for invariants. With the default of 100000 candidates it takes 9 s among the many
conditional effects of blockings, with these 0.03 s, and finds the same variables; the search for a plan takes some milliseconds either
way."""

DRIVER_PROCESS = Path(__file__).with_name("driver_process.py")

ROOM = "64M"
"""Memory limit of Fast Downward's search, which bounds the number of states: 40 goals among 100 things take 17M, of which 11M are the
program. Where blockings leave no plan, a search through all that could be done with six things went on for ten minutes."""

TRANSLATOR_ROOM = "1G"
"""Memory limit of Fast Downward's translator, which bounds the number of grounded actions: 40 goals among 100 things take 51M. All that 100
things allow takes more, after 13 s."""

LONGEST = 600.0
"""Time after which a planner that has found nothing is ended [s]."""

LOOK, STUCK = 1.0, 3
"""Interval between checks of the translator's memory [s], and the largest number of checks in a row that may find it used up."""

SOLVED, UNSOLVABLE, FULL, TOO_LARGE = range(4), (10, 11, 12), 22, 20
"""Exit codes of Fast Downward: a plan was found; no plan exists or none was found; the search, or the translator, used up its memory. The
three codes without a plan come from the translator, from the search, and for an incomplete search."""


class PlannerAnswer(Value):
    """Answer of a symbolic planner: its plan, or that it found none.

    Args:
        plan: its text, one action a line; None where there is none.
        seconds: that it took [s].
    """

    plan: str | None
    seconds: float


def fast_downward(
    text: PddlText,
    shortest: bool = False,
    progress: Callable[[str], None] = lambda _: None,
) -> PlannerAnswer:
    """Solve a planning problem.

    Args:
        shortest: whether no shorter plan may exist; else any will do, which is quicker with many things.
        progress: called with a line for people where the planner's memory is used up.

    Raises:
        UserError: Fast Downward is not installed.
        NoSolution: it found no plan in ``LONGEST``, or the problem's translation takes more than ``TRANSLATOR_ROOM``.
        PluginError: it failed; with the end of what it said.
    """
    began = time.monotonic()
    with tempfile.TemporaryDirectory() as folder:
        files = [Path(folder) / name for name in ("domain.pddl", "problem.pddl", "plan", "log")]
        for file, content in zip(files, (text.domain, text.problem), strict=False):
            file.write_text(content, encoding="utf-8")
        *inputs, plan, log = files
        sas = str(Path(folder) / "sas")
        command = [sys.executable, str(DRIVER_PROCESS), str(_driver()), "--plan-file", str(plan), "--sas-file", sas, *_room()]
        few = FEW_INVARIANTS if ":derived" in text.domain else ()
        behind = (*few, "--search-options", *(SHORTEST if shortest else SHORT))
        with log.open("w", encoding="utf-8") as said:
            process = subprocess.Popen(
                [*command, *map(str, inputs), *behind], stdin=subprocess.PIPE, stdout=said, stderr=said, cwd=folder,
                start_new_session=True,
            )  # fmt: skip
            with working("planning which tasks achieve the goal"):
                code = _wait(process, began)
        seconds = time.monotonic() - began
        if code in SOLVED and plan.is_file():
            return PlannerAnswer(plan.read_text(encoding="utf-8"), seconds)
        if seconds > LONGEST:
            raise NoSolution(f"Fast Downward found no plan within {LONGEST:.0f} s; ask for less at a time, or name tasks under 'tasks'.")
        if code == TOO_LARGE:
            raise NoSolution(_too_large())
        if code == FULL:
            progress(f"no plan among the states that fit into {ROOM} of memory")
        if code is None or code in (*UNSOLVABLE, FULL):
            return PlannerAnswer(None, seconds)
        end = " ".join(log.read_text(encoding="utf-8", errors="replace").split()[-60:])
        raise PluginError(f"Fast Downward ended with code {code}: {end}")


ARRIVE = PddlText(
    "(define (domain way) (:predicates (there)) (:action go :parameters () :precondition (and) :effect (there)))",
    "(define (problem arrive) (:domain way) (:init) (:goal (there)))", {}, {},
)  # fmt: skip
"""Test problem in PDDL that one action solves."""


def examine_planner() -> None:
    """Solve a problem of one action, to see that Fast Downward runs on this machine.

    Raises:
        UserError: it is not installed.
        PluginError: it is, and found no plan.
    """
    if fast_downward(ARRIVE).plan is None:
        raise PluginError("Fast Downward found no plan for a test problem that one action solves")


def has_planner() -> bool:
    """Check whether Fast Downward is installed: not all platforms have it."""
    return find_spec(PACKAGE.replace("-", "_")) is not None


def _too_large() -> str:
    """Explain that the translation of a planning problem takes too much memory."""
    return (
        f"the planning problem takes more than {TRANSLATOR_ROOM} of memory before any plan is searched: too many tasks are possible with "
        "its things. Ask for less at a time, leave things out of the scenario that the goal does not need, or name tasks under 'tasks'."
    )


def _room() -> tuple[str, ...]:
    """Return the command-line options that limit Fast Downward's memory; none on macOS and Windows, where it has no
    such limit.

    There, ``LONGEST`` ends a search (notes in the driver's ``limits.py``).
    """
    return () if sys.platform in ("darwin", "win32") else ("--translate-memory-limit", TRANSLATOR_ROOM, "--search-memory-limit", ROOM)


def _driver() -> Path:
    """Path of Fast Downward's driver in the wheel; the package itself is not imported."""
    found = find_spec(PACKAGE.replace("-", "_"))
    places = found.submodule_search_locations if found is not None else None
    driver = Path(next(iter(places or ()), "")) / "downward" / "fast-downward.py"
    if not driver.is_file():
        raise UserError(
            "Goals are planned by Fast Downward, which is not installed: pip install up-fast-downward (61 MB). "
            "Or name the tasks under 'tasks' instead of a goal."
        )
    return driver


def _wait(process: subprocess.Popen[bytes], began: float) -> int | None:
    """Wait for the planner and return its exit code; ``TOO_LARGE`` if the translator used up its memory,
    None after the time limit."""
    full, looked = 0, began
    try:
        while (now := time.monotonic()) - began < LONGEST:
            with contextlib.suppress(subprocess.TimeoutExpired):
                return process.wait(ASKED)
            checkpoint()
            if now - looked > LOOK:
                full, looked = full + 1 if is_full(process.pid, TRANSLATOR_ROOM) else 0, now
            if full > STUCK:
                return TOO_LARGE
        return None
    finally:
        _end(process)


def _end(process: subprocess.Popen[bytes]) -> None:
    """End the planner with its child processes, unless it has ended by itself."""
    if process.poll() is None or process.returncode < 0:
        with contextlib.suppress(OSError):
            end_group(process.pid)
        process.wait()
    if process.stdin is not None:
        process.stdin.close()
