"""Safety rules of typed programs, independent of the robot's own safety configuration; checked before any
text is written.

Every rule gives the steps that break it, with numbers and units. Limits without a robot of their own:
TCP speed 1.5 m/s (Universal Robots' factory preset of the e-Series' safety configuration); 0.25 m/s while feeling (reduced
speed of ISO 10218-1, 3.22). The highest force limit is that of ``cramlite.model.robot``.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator

from ...base.value import Value
from ..robot import HIGHEST_FORCE_LIMIT, Robot
from .program import Program
from .steps import (
    AnyStep,
    CompliantSlide,
    Control,
    ForceExtract,
    ForceInsert,
    ForceMove,
    MoveJoints,
    MoveLinear,
    MoveUntilContact,
    Parallel,
    Repeat,
    SetGripper,
    SetPayload,
    SpiralSearch,
    branch_conflict,
    branches,
    walk,
)

TOOL_SPEED = 1.5
"""Highest speed of the tool [m/s]: the factory preset of the e-Series' safety configuration."""
FEELING = 0.25
LONGEST = 600.0  # no single step of a handling task waits longer [s]
MOST = 1000  # repetitions
SLACK = 1e-6
Felt = MoveUntilContact | ForceMove | SpiralSearch | ForceInsert | ForceExtract | CompliantSlide


class Violation(Value):
    """Violation of a safety rule: the rule, the step's origin ("" for the program), and an explanation with numbers."""

    rule: str
    origin: str
    reason: str


def violations(program: Program, robot: Robot) -> Iterator[Violation]:
    """Yield every violation of the safety rules by a program, rule by rule."""
    for rule, check in PROGRAM_RULES.items():
        yield from (Violation(rule, "", reason) for reason in check(program, robot))
    for step in walk(program.steps):
        for rule, of_step in STEP_RULES.items():
            yield from (Violation(rule, step.origin, reason) for reason in of_step(step, program, robot))


# Of the program


def _start(program: Program, robot: Robot) -> Iterator[str]:
    yield from _outside(program.start, robot, "the start posture")
    if not 0 < program.force_limit <= HIGHEST_FORCE_LIMIT:
        yield f"the force limit of {program.force_limit:g} N is not in 0 .. {HIGHEST_FORCE_LIMIT:g} N ({program.force_limit_source})"


def _first_load(program: Program, robot: Robot) -> Iterator[str]:
    yield from _load(program.mass, robot)


def _joint_speeds(program: Program, robot: Robot) -> Iterator[str]:
    """Yield a message for each joint motion in which a joint exceeds its speed limit.

    The joint with the longest way moves at the commanded speed, the others in proportion to their ways.
    """
    here = program.start
    for step in walk(program.steps):
        if isinstance(step, MoveJoints):
            for a, b in itertools.pairwise((here, *step.path)):
                if not len(a) == len(b) == len(robot.joints):
                    continue  # "joint limits" says so
                ways = [abs(y - x) for x, y in zip(a, b, strict=True)]
                for name, way, most in zip(robot.joints, ways, robot.velocity, strict=True):
                    if max(ways) > 0 and step.speed * way / max(ways) > most + SLACK:
                        yield f"{step.origin}: {name} at {step.speed * way / max(ways):.2f} rad/s > {most:.2f} rad/s"
            here = step.path[-1] if step.path else here
        else:
            here = getattr(step, "joints", ()) or here


# Of a step


def _joints(step: AnyStep, program: Program, robot: Robot) -> Iterator[str]:
    for q in (*getattr(step, "path", ()), *((step.joints,) if getattr(step, "joints", ()) else ())):  # type: ignore[union-attr]
        yield from _outside(q, robot, "a target")


def _outside(q: tuple[float, ...], robot: Robot, what: str) -> Iterator[str]:
    if len(q) != len(robot.joints):
        yield f"{what} has {len(q)} joints, the arm {len(robot.joints)}"
        return
    for name, value, (low, high) in zip(robot.joints, q, robot.limits, strict=True):
        if not low - SLACK <= value <= high + SLACK:
            yield f"{what} has {name} at {value:.3f} rad, outside {low:.3f} .. {high:.3f} rad"


def _speed(step: AnyStep, program: Program, robot: Robot) -> Iterator[str]:
    for name in ("speed", "acceleration"):
        value = getattr(step, name, 1.0)
        if not (value > 0 and math.isfinite(value)):
            yield f"{name} {value:g} is not positive"
    if isinstance(step, MoveLinear | Felt):
        most = TOOL_SPEED if isinstance(step, MoveLinear) else FEELING
        if step.speed > most:
            yield f"TCP speed {step.speed:g} m/s > {most:g} m/s" + ("" if isinstance(step, MoveLinear) else " while feeling")


def _workspace(step: AnyStep, program: Program, robot: Robot) -> Iterator[str]:
    """Yield a message for each target that is farther from the robot's base than arm and tool are long; a nearer
    target may still be out of reach."""
    high = math.hypot(*robot.root.position) + abs(robot.dh[0][1]) if robot.dh else 0.4
    longest = robot.reach + math.hypot(*program.tcp.position) + high
    targets = [step.target] if isinstance(step, MoveLinear) else getattr(step, "waypoints", ())
    for target in targets:
        if (far := math.hypot(*target.position)) > longest:
            yield f"a target is {far:.2f} m from the base, farther than {longest:.2f} m of arm and tool"


def _force(step: AnyStep, program: Program, robot: Robot) -> Iterator[str]:
    limit = getattr(step, "force_limit", program.force_limit)
    if not 0 < limit <= program.force_limit + SLACK:
        yield f"its force limit of {limit:g} N is not in 0 .. {program.force_limit:g} N, the program's ({program.force_limit_source})"
    if isinstance(step, Felt):
        wanted = math.hypot(*step.wrench[:3]) if isinstance(step, ForceMove) else abs(step.force)
        if wanted >= limit:
            yield f"it presses with {wanted:g} N, which is not below its force limit of {limit:g} N"


def _load_of(step: AnyStep, program: Program, robot: Robot) -> Iterator[str]:
    if isinstance(step, SetPayload):
        yield from _load(step.mass, robot)


def _load(mass: float, robot: Robot) -> Iterator[str]:
    if not 0 <= mass <= robot.payload:
        yield f"payload {mass:.3f} kg is outside 0 .. {robot.payload:g} kg of '{robot.type}'"


def _time(step: AnyStep, program: Program, robot: Robot) -> Iterator[str]:
    for name in ("timeout", "duration", "time"):
        value = getattr(step, name, None)
        if value is not None and not 0 < value <= LONGEST:
            yield f"{name} {value:g} s is not in 0 .. {LONGEST:g} s"
    if isinstance(step, MoveUntilContact) and step.speed > 0 and step.distance / step.speed > step.timeout:
        yield f"the motion takes {step.distance / step.speed:.1f} s, longer than its time-out of {step.timeout:g} s"
    if isinstance(step, Repeat) and not 0 < step.count <= MOST:
        yield f"{step.count} repetitions are not in 1 .. {MOST}"


def _gripper(step: AnyStep, program: Program, robot: Robot) -> Iterator[str]:
    if not isinstance(step, SetGripper):
        return
    hand = robot.gripper
    ranges = (("opening", hand.opening, "m"), ("speed", hand.speed, "m/s"), ("force", hand.force, "N"))
    for name, (low, high), unit in ranges:
        value = getattr(step, name)
        if not low - SLACK <= value <= high + SLACK:
            yield f"gripper {name} {value:g} {unit} is outside {low:g} .. {high:g} {unit}"


def _ends(step: AnyStep, program: Program, robot: Robot) -> Iterator[str]:
    """Yield what is wrong with a control step's branches: one has no steps, or parallel ones both need the arm or
    both the gripper."""
    if isinstance(step, Control):
        if not all(branches(step)) or not branches(step):
            yield "a branch has no steps"
        if isinstance(step, Parallel) and (wrong := branch_conflict(step.branches)):
            yield wrong


PROGRAM_RULES: dict[str, Callable[[Program, Robot], Iterator[str]]] = {
    "start": _start, "joint speeds": _joint_speeds, "payload": _first_load,
}  # fmt: skip
"""Safety rules on a program as a whole: name -> function that says what breaks the rule."""
STEP_RULES: dict[str, Callable[[AnyStep, Program, Robot], Iterator[str]]] = {
    "joint limits": _joints, "speed": _speed, "workspace": _workspace, "forces": _force, "payload": _load_of,
    "time-outs": _time, "gripper": _gripper, "paths": _ends,
}  # fmt: skip
"""Safety rules on single steps: name -> function that says what breaks the rule."""
