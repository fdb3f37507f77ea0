"""URScript for Universal Robots arms (e-Series, and CB3 by ``urscript_cb3``) with a Robotiq gripper.

Facts about the language and the gripper's server: docs/reference and the URScript manual (e-Series 5.x). Only the
documented combination of threads, movel and force_mode is used: servoj inside force_mode and tool_contact with
speedl are open risks.

Signs: force_mode takes what the robot applies to its environment; get_tcp_force returns what the environment
applies to the tool, in the base frame. So pressing along +d reads as a force along -d.
"""

from __future__ import annotations

import re

from msgspec import Struct, field

from cramlite.model import AnyStep, Control, Program, Robot, Section
from cramlite.plugin import Code, UserError

from ..names import Names
from ..unsupported import refuse_drives
from . import flow as urscript_flow
from . import late as urscript_late
from . import search as urscript_search
from .controllers import CB3, PRELUDE, adapted, check_arm, controller_of, lacking
from .flow import FlowWriter, comment, write
from .literals import number, plain, pose, vector
from .parts import FUNCTIONS, header, used
from .steps import leaf

POSES = "# ---- poses: p[x, y, z, rx, ry, rz] of the TCP in the base frame [m, rad]; joint positions [rad] ----"
START_TOLERANCE = 0.01  # how far each joint may be from the start posture [rad]


class _Writer(Struct, dict=True):
    """Writer of a URScript program: the lines that were written so far, with the steps that they come from."""

    robot: Robot
    lines: list[str] = field(default_factory=list)  # without the indentation of the program's function
    origins: dict[int, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.poses = Names()
        self.flow = FlowWriter(self.robot.gripper, self.poses)

    def add(self, *lines: str) -> None:
        self.lines += lines


def emit(program: Program, robot: Robot) -> Code:
    """Write the program as URScript.

    The text is deterministic: numbers have fixed digits. Every wait has a time-out, and every error path
    stops the robot, logs its reason with textmsg and halts.

    Args:
        robot: the description of ``program.robot_type``; its gripper is driven through Robotiq's server.

    Raises:
        UserError: the program's name is no identifier, the robot is not the program's, or its controller is none that
            programs are written for.

    Returns:
        Code whose ``origins`` lead from the first line of a step back to the step's origin.
    """
    _check(program, robot)
    controller, version = controller_of(robot)
    out = _Writer(robot)
    _body(out, program)
    head, carried = _head(program, robot, out, controller)
    lines = [*carried, *out.lines]
    lines = [*head, *(adapted(lines) if controller == CB3 else lines)]
    text = "\n".join([f"def {program.name}():", *(f"  {line}" if line else "" for line in lines), "end", ""])
    if wrong := list(lacking(text, controller, version)):
        raise UserError(f"the program cannot be written for '{robot.type}': {'; '.join(wrong)}")
    before = 1 + len(head) + len(carried)
    return Code("urscript", text, {before + k: origin for k, origin in out.origins.items()}, ".script")


def _body(out: _Writer, program: Program) -> None:
    """Write the statements of the program's main function: its preparation, its steps with titles, and its end."""
    out.add(*_start(program, out.robot), *urscript_late.asking(program), "")
    sections = {s.first: s for s in program.sections}
    for i, step in enumerate(program.steps):
        if i in sections:
            out.add("", *_title(sections[i], len(program.steps)))
        _step(out, step)
    out.add("", "kill watchdog_thread", 'textmsg("cramlite: finished")')


def _head(program: Program, robot: Robot, out: _Writer, controller: str) -> tuple[list[str], list[str]]:
    """Comment with the preconditions, and after it the functions and poses that the program's text uses."""
    prelude = PRELUDE.strip("\n").split("\n") if controller == CB3 else []
    library = "\n\n".join(
        t.strip("\n") for t in (FUNCTIONS, urscript_search.FUNCTIONS, urscript_flow.FUNCTIONS, urscript_late.FUNCTIONS)
    )
    carried = used(library.split("\n"), "\n".join(out.lines))
    poses = [f"global {name} = {value}" for name, value in out.poses.values.items()]
    return [*header(program, robot), "", *prelude], [*carried, "", *([POSES, *poses, ""] if poses else [])]


def _check(program: Program, robot: Robot) -> None:
    if not re.fullmatch(r"[A-Za-z][A-Za-z0-9_]*", program.name):
        raise UserError(f"program name '{program.name}': URScript needs a letter, then letters, digits and underscores")
    refuse_drives(program, "URScript")
    check_arm(program, robot, "URScript")


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
    first, last = section.first + 1, min(section.last, count)
    steps = f"step {first}" if last == first else f"steps {first} to {last}"
    about = plain(section.title).removeprefix(section.task.partition(".")[2]).removeprefix(":").strip()
    return [f"# ---- {plain(section.task)}{f': {about}' if about else ''} ({steps}) ----"]


def _step(out: _Writer, step: AnyStep) -> None:
    if isinstance(step, Control):
        threads, body = write(step, out.flow)
        out.add(*threads)
        for line in body:
            if line.origin:
                out.origins[len(out.lines) + 1] = line.origin
            out.add(line.text)
        return
    if said := comment(step):
        out.add(said)
    if step.origin:
        out.origins[len(out.lines) + 1] = step.origin
    text = leaf(step, out.robot.gripper, out.flow.thread, out.poses)
    out.add(*text.thread, *text.lines, *([text.call] if text.call else []))
