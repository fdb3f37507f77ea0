"""``cramlite preflight``: one page about a program for the person beside the arm."""

from __future__ import annotations

import argparse
import math
import textwrap
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from ..base.errors import NoSolution, UserError, nearest
from ..base.json_text import as_json
from ..base.run_directory import write_whole
from ..engine.real_arm.preflight import (
    OWN,
    Check,
    Flight,
    checks,
    covered,
    dry_run,
    flight_of_run,
    flight_of_text,
    heaviest,
    strongest_grip,
)
from ..model.program.program import LatePose
from ..model.twins.error_model import SOURCES
from ..plugin.catalogue import Knowledge
from .arguments import Add, add_seed, plugin_choice
from .program_input import naming, read_text, robots_world

WIDTH = 110
LEFT_OUT = (
    "safety planes, reduced mode, limits of tool direction, power, momentum, elbow speed and stopping distance: the model has none, "
    "so the program was never tried against yours",
    "people, cables, hoses, and whatever the world file does not have",
    "how far arm, hand and things bend; wear, dirt, light",
    "how your controller rounds corners and times motions, beyond what its manual says",
    "the fingers' own controller: its delays, and what it does when it loses its connection",
)
"""Real effects that the simulation leaves out for any program; docs/reference/robot_code.md lists those of the robot's language."""
NEVER_DRAWN = (
    "a tool centre point or payload that is set otherwise on the controller", "a thing that is missing, turned over, or another one",
    "a base that stands elsewhere or is not level", "a fault of power, network or air",
)  # fmt: skip
"""Errors of the real world that no twin contains."""


def _preflight(arguments: argparse.Namespace) -> int:
    """Print one page about a program: settings of the controller, values that its runs reached, and the
    errors that its proof did and did not cover.

    Raises:
        NoSolution: a limit is exceeded or a validator objects; the page was printed.
        UserError: a file, limit or speed that cannot be used.
    """
    program, world, seed = arguments.program, arguments.world, arguments.seed
    own, share = _own(arguments.limit), _share(arguments.speed, arguments.out)
    knowledge = Knowledge(plugin_choice(arguments).registry())
    flight = _flight(program, world, knowledge, seed)
    if share is not None:
        place = robots_world(world, program, knowledge, seed) if world else flight.rollout.world
        with naming(program):
            flight = dry_run(flight, share, place, knowledge, seed)
        _write(arguments.out, flight.text.text)
    found = list(checks(flight, own))
    objections = list(_objections(flight, found))
    print(as_json(_json(program, flight, found, objections)) if arguments.json else page(program, flight, found, objections))
    if objections:
        raise NoSolution(f"'{program}' is not ready for a real arm: {'; '.join(objections)}.")
    return 0


def _flight(program: Path, world: str, knowledge: Knowledge, seed: int) -> Flight:
    if program.is_dir():
        return flight_of_run(program, knowledge)
    text = read_text(program)
    if not world:
        raise UserError(
            f"'{program}' is the text of a program, which does not say in which world it runs. Name the world with --world (a scenario, "
            "run directory or world.json); or give the program's run directory, which holds it."
        )
    with naming(program):
        return flight_of_text(text, robots_world(world, program, knowledge, seed), knowledge, seed)


def _own(limits: Sequence[str]) -> dict[str, float]:
    found = {}
    for limit in limits:
        name, _, value = limit.partition("=")
        name = name.strip().replace("-", "_").replace(" ", "_")
        if name not in OWN:
            raise UserError(f"--limit {limit}: there is no limit '{name}'; {nearest(name, OWN)}. Write for example tool_speed=0.25.")
        try:
            found[name] = float(value)
        except ValueError:
            found[name] = math.nan
        if not 0 < found[name] < math.inf:
            raise UserError(f"--limit {limit}: '{value}' is no number above 0; {', '.join(f'{n} is in {u}' for n, u in OWN.items())}.")
    return found


def _share(speed: float | None, out: Path | None) -> float | None:
    if speed is None:
        if out is not None:
            raise UserError(f"--out {out}: the text of a dry run is written there, so give its speed, such as --speed 0.2.")
        return None
    if not 0 < speed <= 1:
        raise UserError(f"--speed {speed:g}: the speed of a dry run is a share of the program's own, above 0 and up to 1, such as 0.2.")
    return speed


def _write(out: Path | None, text: str) -> None:
    if out is None:
        return
    if out.exists():
        raise UserError(f"--out {out}: it exists already, and nothing was written. Choose another name.")
    write_whole(out, text)


def _objections(flight: Flight, found: Sequence[Check]) -> Iterator[str]:
    for check in found:
        if not check.passed:
            yield f"{check.name} {check.most:.3g} {check.unit} exceeds {check.limit:.3g} {check.unit} ({check.source})"
    if flight.rollout.outcome != "finished":
        yield f"the text ended by {flight.rollout.outcome}: {flight.rollout.reason}"
    verdict = flight.judged.verdict if flight.judged is not None else flight.verdict
    if verdict is not None and not verdict.passed:
        yield verdict.reason


def _json(program: Path, flight: Flight, found: Sequence[Check], objections: Sequence[str]) -> dict[str, Any]:
    return {
        "program": str(program), "robot": flight.robot.type, "speed": flight.speed, "ready": not objections, "objections": objections,
        "typed": flight.program is not None, "proven": flight.verdict is not None,
        "checks": [
            {
                "name": c.name, "unit": c.unit, "reaches": c.reaches, "in_twins": c.in_twins, "limit": c.limit, "source": c.source,
                "set": c.setting, "passed": c.passed,
            }
            for c in found
        ],
        "covered": covered(flight.draws), "not_covered": [s for s in SOURCES if s not in covered(flight.draws)],
        "left_out": LEFT_OUT, "never_drawn": NEVER_DRAWN,
    }  # fmt: skip


def page(program: Path, flight: Flight, found: Sequence[Check], objections: Sequence[str]) -> str:
    """Return the preflight page as text."""
    parts = (
        _head(program, flight, objections), _set(flight), _limits(flight, found), _places(flight), _left_out(), _doubts(flight),
    )  # fmt: skip
    return "\n\n".join("\n".join(part) for part in parts if part)


def _head(program: Path, flight: Flight, objections: Sequence[str]) -> list[str]:
    state = "NOT READY" if objections else "nothing stands against it here; what follows is for you to check"
    lines = [f"PREFLIGHT  {program}", f"{state}. No real robot has been driven by a program of cramlite."]
    lines += [f"  NO  {o}" for o in objections]
    peaks = flight.peaks
    ran = f"{peaks.seconds:.1f} s" if peaks is not None else "nothing moved"
    if flight.speed != 1.0:
        lines.append(f"Dry run in simulation at {100 * flight.speed:g} % of its speed: {ran}{_dry(flight)}.")
    elif flight.verdict is not None:
        twins = flight.verdict.twins
        said = f"runs that succeeded: {twins.text}" if twins else "it ran in no twin"
        lines.append(f"Proven: ran {ran}, and passed {len(flight.verdict.findings)} checks; {said}.")
    else:
        lines.append(f"Not proven: this text ran {ran} in simulation only to measure these numbers. 'cramlite judge' checks what it does.")
    return lines


def _dry(flight: Flight) -> str:
    if flight.judged is None:
        return ", not judged, since it is of no run directory"
    verdict = flight.judged.verdict
    return f", {len(verdict.findings)} checks passed" if verdict.passed else ", refused"


def _set(flight: Flight) -> list[str]:
    robot, program = flight.robot, flight.program
    tcp, mass = robot.gripper.tcp, robot.gripper.mass
    if program is not None:
        tcp, mass = program.tcp, program.mass
    x, y, z = (1000 * v for v in tcp.position)
    lines = [
        f"SET ON THE CONTROLLER of the {robot.type}{f' ({robot.controller})' if robot.controller else ''}",
        f"  tool centre point  {x:.1f} {y:.1f} {z:.1f} mm from the flange, turned {' '.join(f'{v:.4f}' for v in tcp.rotvec)} rad",
    ]
    if program is None:
        return [*lines, f"  payload            {mass:.3f} kg of the empty gripper '{robot.gripper.type}'",
                "  These are the model's. What the text itself sets, and what it carries, is not known here: compare them."]  # fmt: skip
    most, where = heaviest(program)
    centre = " ".join(f"{1000 * v:.0f}" for v in program.center)
    degrees = " ".join(f"{math.degrees(q):.1f}" for q in program.start)
    return [
        *lines,
        f"  payload            {mass:.3f} kg at {centre} mm from the flange with an empty gripper; up to {most:.3f} kg ({where})",
        f"  start posture      {degrees} deg, the first move goes from there",
        f"  grip force         up to {strongest_grip(program):.0f} N; '{robot.gripper.type}' can press with {robot.gripper.force[1]:.0f} N",
    ]


def _limits(flight: Flight, found: Sequence[Check]) -> list[str]:
    peaks = flight.peaks
    if peaks is None:
        return []
    lines = ["SAFETY LIMITS", f"  {'':3}{'':28}{'set to':>12}{'reaches':>14}{'in twins':>14}   at most", *(_row(c, flight) for c in found)]
    for name, low, high, (least, most) in zip(flight.robot.joints, peaks.lowest, peaks.highest, flight.robot.limits, strict=False):
        a, b, c, d = (math.degrees(v) for v in (low, high, least, most))
        lines.append(f"  {'':3}{f'joint range {name}':28}{f'{a:.0f} .. {b:.0f} deg':>26}{'':14}   {c:.0f} .. {d:.0f} deg of the arm")
    if peaks.commanded:
        lines.append(f"  In force mode the program commands up to {peaks.commanded:.0f} N.")
    return lines


def _row(check: Check, flight: Flight) -> str:
    numbers = (check.setting, check.reaches, check.in_twins)
    set_to, reaches, in_twins = ("" if n is None else f"{n:.3g} {check.unit}" for n in numbers)
    task = flight.task_at(check.line) if check.line else ""
    at = f"; line {check.line}{f' of {task}' if task else ''}" if check.line else ""
    mark = "ok" if check.passed else "NO"
    return f"  {mark:3}{check.name:28}{set_to:>12}{reaches:>14}{in_twins:>14}   {check.limit:.3g} {check.unit} {check.source}{at}"


def _places(flight: Flight) -> list[str]:
    program = flight.program
    if program is None or not (program.snapshots or program.late):
        return []
    known = [(s.thing, s.pose, s.source) for s in program.snapshots]
    known += [(p.thing, p.pose, _late_tolerance(p)) for p in program.late]
    lines = ["PUT EVERYTHING where the program believes it, in the frame of the robot's base"]
    for thing, pose, said in known:
        x, y, z = (1000 * v for v in pose.position)
        lines.append(f"  {thing:20}{x:8.0f} {y:8.0f} {z:8.0f} mm   {said}")
    return lines


def _late_tolerance(late: LatePose) -> str:
    metres, radians = late.tolerance
    asks = "as planned; the program asks for the pose when it runs"
    return f"{asks}, and stops if it is more than {1000 * metres:.0f} mm or {math.degrees(radians):.0f} deg from the planned pose"


def _left_out() -> list[str]:
    return ["THE MODEL LEAVES OUT", *(_wrapped(said) for said in LEFT_OUT)]


def _doubts(flight: Flight) -> list[str]:
    known = covered(flight.draws)
    lines = ["DOUBTS THAT THE PROOF COVERED"]
    for source, drawn in known.items():
        lines.append(_wrapped(f"{source}: " + ", ".join(f"{most:.3g} of {size:.3g} {unit}" for most, size, unit in drawn)))
    if known:
        lines.append(_wrapped("(the largest that was drawn for any twin, of the largest that could have been)"))
    else:
        lines.append("  none: it ran in the believed world alone" if flight.verdict is not None else "  none: nothing was proven")
    others = [s for s in SOURCES if s not in known]
    lines.append("AND THOSE THAT IT DID NOT")
    if flight.speed != 1.0 and known:
        lines.append(_wrapped("all of them at this speed: the twins ran at the program's own"))
    undrawn = f"sources of error that this program's proof did not draw: {', '.join(others)}"
    return [*lines, *([_wrapped(undrawn)] if others else []), *map(_wrapped, NEVER_DRAWN)]


def _wrapped(text: str) -> str:
    return textwrap.fill(text, WIDTH, initial_indent="  - ", subsequent_indent="    ")


def add_commands(add: Add) -> None:
    """Add the command ``preflight``, with its arguments, to the command line."""
    command = add("preflight", _preflight)
    command.add_argument("program", type=Path, help="a run directory, or a text, of which less is known")
    command.add_argument(
        "--world", default="",
        help="world that a text runs in: a run directory, a scenario or a world.json; a run directory has its own",
    )
    command.add_argument(
        "--speed", type=float, metavar="SHARE",
        help="dry run in simulation at a share of the program's speed, above 0 and up to 1; needs a run "
            "directory or a typed program",
    )
    command.add_argument("--out", type=Path, metavar="FILE", help="write the text of the dry run there")
    command.add_argument(
        "--limit", action="append", default=[], metavar="NAME=VALUE",
        help="limit of your cell: tool_speed [m/s], tool_force [N], joint_speed [deg/s] or payload [kg]; may be given several times",
    )  # fmt: skip
    add_seed(command)
    command.add_argument(
        "--json", action="store_true",
        help="print as JSON: ready, objections, checks with reaches, in_twins, limit, source and set, "
            "covered, not_covered",
    )
