"""``cramlite compare``: compares a real arm's RTDE log with the simulated run in which its program was proven."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from ..base.errors import NoSolution, UserError
from ..base.json_text import as_json
from ..base.quantities import parse_quantity
from ..engine.real_arm.rtde_log import read_rtde_log
from ..engine.real_arm.run_comparison import PARTS, Compared, RunComparison, compare_run
from ..plugin.catalogue import Knowledge, pick
from ..report.comparison_page import write_comparison_page
from .arguments import Add, plugin_choice
from .program_input import program_of, recorded


def _compare(arguments: argparse.Namespace) -> int:
    """Print where a real arm's log and a simulated run diverge, and by how much they differ.

    Raises:
        NoSolution: a joint differs by more than it may; everything was printed.
        UserError: a file cannot be used, or log and run are of different arms.
    """
    run, log, within = arguments.run_folder, arguments.log, _within(arguments.within)
    knowledge = Knowledge(plugin_choice(arguments).registry())
    rollout = recorded(run, None, knowledge, 0)
    mount = rollout.world.robots[0]
    names = pick("robot", knowledge.robots_of(rollout.world), mount.type).joints
    found = compare_run(read_rtde_log(log), rollout, names, within)
    text = program_of(run, typed=True)
    print(as_json(_json(found)) if arguments.json else "\n".join(comparison_lines(found, text)))
    if arguments.html is not None:
        write_comparison_page(arguments.html, f"{log.name} beside {run.name}", comparison_lines(found, text), found)
    if found.parts is not None:
        raise NoSolution(f"'{log}' differs from the proven run '{run}': {_parting(found, text)}")
    return 0


def _within(angle: str | None) -> float:
    """Return the difference of joint angles at which log and simulation count as diverged [rad]; the default for None."""
    try:
        return PARTS if angle is None else parse_quantity(angle, "angle")
    except ValueError as error:
        raise UserError(f"--within: {error}.") from None


def comparison_lines(found: RunComparison, text: Sequence[str]) -> list[str]:
    """Return the comparison of a real arm's log with a simulated run as lines of text.

    Args:
        text: lines of the program; none where it is not known.
    """
    lines = [f"the run starts at {found.offset:.2f} s of the log; the arm moves for {found.lasts[0]:.2f} s in the log, "
             f"{found.lasts[1]:.2f} s in the run"]  # fmt: skip
    groups: dict[str, list[Compared]] = {}
    for c in found.compared:
        groups.setdefault(c.unit, []).append(c)
    for unit, many in groups.items():
        worst = max(many, key=lambda c: c.worst[0])
        lines.append(f"{worst.name} differs most: by {worst.worst[0]:.3g} {unit} at {worst.worst[1]:.2f} s")
    force = groups.get("N", [])
    if force:
        lines.append(f"largest force: {force[0].logged.max():.1f} N in the log, {force[0].ran.max():.1f} N in the run")
    return [*lines, _parting(found, text) if found.parts else f"no joint differs by more than {found.within:g} rad"]


def _parting(found: RunComparison, text: Sequence[str]) -> str:
    assert found.parts is not None
    time, name, far, line = found.parts
    ran = f", line {line}: {text[line - 1].strip()[:80]}" if 0 < line <= len(text) else ""
    return f"log and run diverge at {time:.2f} s{ran}: joint {name} is {far:.3f} rad off, {found.within:g} rad are allowed"


def _json(found: RunComparison) -> dict[str, Any]:
    parts = None
    if found.parts is not None:
        parts = dict(zip(("time", "joint", "difference", "line"), found.parts, strict=True))
    worst = [{"name": c.name, "unit": c.unit, "difference": c.worst[0], "time": c.worst[1]} for c in found.compared]
    return {"offset": found.offset, "seconds": {"log": found.lasts[0], "run": found.lasts[1]}, "worst": worst, "parts": parts}


def add_commands(add: Add) -> None:
    """Add the command ``compare``, with its arguments, to the command line."""
    compare = add("compare", _compare)
    compare.add_argument("run_folder", type=Path, metavar="run", help="a folder that resolve, or execute --out, wrote")
    compare.add_argument(
        "log", type=Path,
        help="CSV of RTDE outputs: timestamp, actual_q_0 to 5, if possible actual_TCP_force_0 to 5",
    )
    compare.add_argument("--within", metavar="ANGLE", help="by how much joints may differ (default 0.02 rad)")
    compare.add_argument("--html", type=Path, metavar="FILE", help="write a page with the curves")
    compare.add_argument(
        "--json", action="store_true", help="print as JSON: offset, seconds, worst of each quantity, parts"
    )
