"""URScript for Universal Robots arms (e-Series, and CB3 by ``urscript_cb3``) with a Robotiq gripper.

Facts about the language and the gripper's server: docs/reference and the URScript manual (e-Series 5.x). Only the
documented combination of threads, movel and force_mode is used: servoj inside force_mode and tool_contact with
speedl are open risks.

Signs: force_mode takes what the robot applies to its environment; get_tcp_force returns what the environment
applies to the tool, in the base frame. So pressing along +d reads as a force along -d.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field

from cramlite.errors import UserError
from cramlite.geometry import Pose
from cramlite.program import (
    AnyStep,
    Code,
    ForceInsert,
    ForceMove,
    MoveJoints,
    MoveLinear,
    MoveUntilContact,
    Program,
    Section,
    SetGripper,
    SetPayload,
    SpiralSearch,
    Wait,
    ZeroSensor,
)
from cramlite.robots import Gripper, Robot

from . import urscript_search
from .urscript_cb3 import PRELUDE, adapted
from .urscript_parts import FUNCTIONS, header
from .urscript_text import label, number, plain, pose, vector

# Acceleration of guarded and force-controlled motions [m/s2]: gentle, so that inertia stays below the thresholds.
GENTLE = 0.25
START_TOLERANCE = 0.01  # how far each joint may be from the start posture [rad]


@dataclass
class _Writer:
    """The text under construction."""

    robot: Robot
    lines: list[str] = field(default_factory=list)
    origins: dict[int, str] = field(default_factory=dict)
    threads: int = 0

    def add(self, *lines: str) -> None:
        self.lines += [f"  {line}" if line else "" for line in lines]


def emit(program: Program, robot: Robot) -> Code:
    """The program as URScript.

    The text is deterministic: numbers have fixed digits. Every wait has a time-out, and every error path
    stops the robot, logs its reason with textmsg and halts.

    Args:
        robot: the description of ``program.robot_type``; its gripper is driven through Robotiq's server.

    Raises:
        UserError: the program's name is no identifier, or the robot is not the program's.

    Returns:
        Code whose ``origins`` lead from the first line of a step back to the step's origin.
    """
    _check(program, robot)
    out = _Writer(robot)
    out.lines.append(f"def {program.name}():")
    out.add(*header(program, robot), "")
    cb3 = robot.sensor != "flange"
    out.add(*(PRELUDE.strip("\n").split("\n") if cb3 else ()))
    rest = len(out.lines)
    out.add(*FUNCTIONS.strip("\n").split("\n"), *urscript_search.functions(program), "")
    out.add(*_start(program, robot), "")
    sections = {s.first: s for s in program.sections}
    for i, step in enumerate(program.steps):
        if i in sections:
            out.add("", *_title(sections[i], len(program.steps)))
        _step(out, step, program)
    out.add("", "kill watchdog_thread", 'textmsg("cramlite: finished")')
    out.lines.append("end")
    lines = out.lines[:rest] + (adapted(out.lines[rest:]) if cb3 else out.lines[rest:])
    return Code("urscript", "\n".join(lines) + "\n", out.origins, ".script")


def _check(program: Program, robot: Robot) -> None:
    if not re.fullmatch(r"[A-Za-z][A-Za-z0-9_]*", program.name):
        raise UserError(f"program name '{program.name}': URScript needs a letter, then letters, digits and underscores")
    if program.robot_type != robot.type or robot.dh is None:
        raise UserError(f"program for '{program.robot_type}': URScript for '{robot.type}' cannot carry it out")


def _start(program: Program, robot: Robot) -> list[str]:
    low, high = robot.gripper.force
    return [
        "# ---- start ----",
        f"set_tcp({pose(program.tcp)})",
        f"set_target_payload({number(program.mass)}, {vector(program.center)})",
        f"global force_limit = {number(program.force_limit)}  # protective limit on the TCP force [N]",
        f"check_start({vector(program.start)}, {number(START_TOLERANCE)})",
        f"connect_gripper()  # grip force {low:.0f} .. {high:.0f} N, opening 0 .. {robot.gripper.opening[1]:.4f} m",
        "zero_ftsensor()",
        "global watchdog_thread = run watchdog()",
    ]


def _title(section: Section, count: int) -> list[str]:
    steps = f"steps {section.first + 1} to {min(section.last, count)}"
    return [f"# ---- {plain(section.task)}: {plain(section.title)} ({steps}) ----"]


def _step(out: _Writer, step: AnyStep, program: Program) -> None:
    comment = ": ".join(plain(c) for c in (step.origin, step.comment) if c)
    if comment:
        out.add(f"# {comment}")
    if step.origin:
        out.origins[len(out.lines) + 1] = step.origin
    out.add(*_lines(out, step))


def _lines(out: _Writer, step: AnyStep) -> list[str]:
    match step:
        case MoveJoints():
            rates = f"a={number(step.acceleration)}, v={number(step.speed)}"
            return [f"movej({vector(q)}, {rates})" for q in step.path]
        case MoveLinear():
            return [f"movel({pose(step.target)}, a={number(step.acceleration)}, v={number(step.speed)})"]
        case MoveUntilContact():
            return [_guarded(step)]
        case ForceMove():
            out.threads += 1
            return _forced(step, out.threads)
        case SpiralSearch() | ForceInsert():
            return [urscript_search.line(step)]
        case SetGripper():
            return [_grip(step, out.robot.gripper)]
        case SetPayload():
            return [f"set_target_payload({number(step.mass)}, {vector(step.center)})"]
        case ZeroSensor():
            return ["sleep(0.3)  # the sensor's filter and the arm settle", "zero_ftsensor()"]
        case Wait():
            return [f"sleep({number(step.duration)})"]


def _guarded(step: MoveUntilContact) -> str:
    values = [vector(step.direction), *map(number, (step.distance, step.speed, step.force, step.timeout))]
    return f'move_until_contact({", ".join(values)}, "{step.expect}", "{label(step.origin)}")'


def _forced(step: ForceMove, count: int) -> list[str]:
    name = f"force_move_{count}"
    frame = Pose((0.0, 0.0, 0.0), step.frame.quaternion)
    selection = "[" + ", ".join("1" if c else "0" for c in step.compliant) + "]"
    moves = [f"  movel({pose(w)}, a={number(GENTLE)}, v={number(step.speed)})" for w in step.waypoints]
    watch = f'{number(step.force_limit)}, {number(step.timeout)}, "{label(step.origin)}"'
    return [
        f"thread {name}():",
        *moves,
        "  motion_done = True",
        "end",
        "motion_done = False",
        f"force_mode({pose(frame)}, {selection}, {vector(step.wrench)}, 2, {vector(step.limits)})",
        f"motion_thread = run {name}()",
        f"watch_force_move({watch})",
    ]


def _grip(step: SetGripper, gripper: Gripper) -> str:
    low, high = gripper.opening
    position = _count((high - step.opening) / (high - low))
    # Robotiq 2F-85: pad speed 20 .. 150 mm/s, the instruction manual's "Specifications".
    speed = _count((step.speed - 0.020) / (0.150 - 0.020))
    force = _count((step.force - gripper.force[0]) / (gripper.force[1] - gripper.force[0]))
    wanted = f'"{step.expect}", {number(step.timeout)}, "{label(step.origin)}"'
    return f"move_gripper({position}, {speed}, {force}, {wanted})  # {step.opening * 1000:.1f} mm, {step.force:.0f} N"


def _count(share: float) -> int:
    """A share of a range as one of the gripper's registers 0 .. 255."""
    return min(255, max(0, round(255 * share)))
