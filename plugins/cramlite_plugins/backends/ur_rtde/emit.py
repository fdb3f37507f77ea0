"""Python programs for ur_rtde: a program that runs on a computer beside the robot, and drives it over the network.

The text is one file: the header with its preconditions, what every program carries (``ur_rtde_arm`` and, where needed,
``ur_rtde_forces`` and ``ur_rtde_flow``), named poses, a function for each task, and a main function.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from importlib.resources import files

from msgspec import Struct, field

from cramlite.model import (  # fmt: skip
    AnyStep,
    CompliantSlide,
    Control,
    Fallback,
    ForceExtract,
    ForceInsert,
    ForceMove,
    Monitor,
    MoveJoints,
    MoveLinear,
    MoveUntilContact,
    Parallel,
    Pose,
    Program,
    Repeat,
    Robot,
    SetGripper,
    SetPayload,
    SpiralSearch,
    Wait,
    ZeroSensor,
    branch_conflict,
    uses_arm,
    walk,
)
from cramlite.plugin import Code, UserError

from ..names import Names, identifier
from ..unsupported import refuse_drives, unsupported_step
from ..urscript.controllers import E_SERIES, check_arm, controller_of
from ..urscript.literals import label, number, plain, vector
from ..urscript.parts import header
from ..urscript.steps import HEIGHT, count

START_TOLERANCE = 0.01  # how far each joint may be from the start posture [rad]
FORCES = (ForceMove, SpiralSearch, ForceInsert, ForceExtract, CompliantSlide)
IMPORTS = (
    "from __future__ import annotations", "", "import contextlib", "import copy", "import math", "import os", "import socket",
    "import sys", "import threading", "import time", "from collections.abc import Callable, Sequence", "",
    "from rtde_control import RTDEControlInterface", "from rtde_io import RTDEIOInterface",
    "from rtde_receive import RTDEReceiveInterface", "",
)  # fmt: skip


class _Writer(Struct):
    """Writer of a generated Python program without its runtime modules: the values and lines that were written so far.

    Args:
        robot: that it is for.
        poses: name -> value, as text.
        body: lines of the task functions, each with the origin of the step that begins with it, or "".
        depth: of indentation.
        number: of control steps so far.
    """

    robot: Robot
    poses: Names = field(default_factory=Names)
    body: list[tuple[str, str]] = field(default_factory=list)
    depth: int = 0
    number: int = 0

    def add(self, *lines: str, origin: str = "") -> None:
        for line in lines:
            self.body.append(("    " * self.depth + line if line else "", origin))
            origin = ""

    def name(self, origin: str, value: str) -> str:
        """Name, in capitals, of the constant that holds a value in the generated Python program."""
        return self.poses.name(identifier(origin or "pose").upper(), value)

    def steps(self, steps: Iterable[AnyStep]) -> None:
        for step in steps:
            if said := ": ".join(plain(c) for c in (step.origin, step.comment) if c):
                self.add(f"# {said}")
            if isinstance(step, Control):
                self.control(step)
            else:
                self.add(call(step, self), origin=step.origin)

    def function(self, name: str, steps: Iterable[AnyStep], title: str = "") -> str:
        self.add(f"def {name}(arm: Arm) -> None:")
        self.depth += 1
        begin = len(self.body)
        if title:
            self.add(f'"""{plain(title)}"""')
        self.steps(steps)
        if len(self.body) == begin:
            self.add("pass")
        self.depth -= 1
        self.add("", *([""] if self.depth == 0 else []))
        return name

    def control(self, step: Control) -> None:
        self.number += 1
        name = f'"{label(step.origin or type(step).__name__)}"'
        match step:
            case Repeat():
                self.add(f"for _ in range({step.count}):")
                self.depth += 1
                self.steps(step.steps)
                self.depth -= 1
            case Fallback():
                n = self.number
                tries = [self.function(f"attempt_{n}_{k}", b) for k, b in enumerate(step.branches, 1)]
                self.add(f"fallback(arm, {name}, [{', '.join(tries)}])", origin=step.origin)
            case Monitor():
                inner = self.function(f"monitored_{self.number}", step.steps)
                self.add(f"monitored(arm, {name}, {inner}{_watched(step, self.robot)})", origin=step.origin)
            case Parallel():
                self.parallel(step, name)

    def parallel(self, step: Parallel, name: str) -> None:
        if wrong := branch_conflict(step.branches):
            raise UserError(f"{name}: {wrong}")
        n = self.number
        main = next((k for k, b in enumerate(step.branches) if uses_arm(b)), 0)
        names = [self.function(f"branch_{n}_{k}", b) for k, b in enumerate(step.branches, 1)]
        sides = ", ".join(names[:main] + names[main + 1 :])
        self.add(f'parallel(arm, {name}, {names[main]}, [{sides}], until="{step.until}")', origin=step.origin)


def emit(program: Program, robot: Robot) -> Code:
    """Write the program as Python text.

    Raises:
        UserError: the program's name is no identifier, the robot is not the program's, or its controller is none that
            programs are written for.

    Returns:
        Code whose ``origins`` lead from the line of a step's call back to the step's origin.
    """
    if not re.fullmatch(r"[A-Za-z][A-Za-z0-9_]*", program.name):
        raise UserError(f"program name '{program.name}': Python needs a letter, then letters, digits and underscores")
    check_arm(program, robot, "ur_rtde")
    refuse_drives(program, "ur_rtde")
    if program.late:
        things = ", ".join(t.thing for t in program.late)
        asked = f"late poses ({things}), which the program would ask for when it starts,"
        raise UserError(f"{asked} cannot be written in Python for ur_rtde yet; take the backend urscript")
    out = _Writer(robot)
    tasks = [out.function(name, steps, title) + "(arm)" for name, title, steps in _tasks(program)]
    _main(out, program, robot, tasks)
    lines = [*_head(program, robot), *IMPORTS, *_carried(program), "", *_values(program, out)]
    lines += ["", "", "# ---- tasks ----", "BEGINS = sys._getframe().f_lineno", "", ""]
    origins = {len(lines) + k: origin for k, (_, origin) in enumerate(out.body, 1) if origin}
    return Code("python", "\n".join([*lines, *(line for line, _ in out.body)]) + "\n", origins, ".py")


def _head(program: Program, robot: Robot) -> list[str]:
    """Docstring of the generated Python program: its usage, and the preconditions that URScript programs
    state, too."""
    said = [line.removeprefix("# ").removeprefix("#") for line in header(program, robot)]
    said[0] = f"{program.name}, for ur_rtde. Generated by cramlite from a typed program."
    use = "Usage: python THIS_FILE ROBOT_ADDRESS (needs the package ur-rtde 1.6; the robot in remote control mode)"
    text = "\n".join([said[0], "", use, "", *said[1:]])
    return [*('"""' + text.replace("\\", "/").replace('"""', "'''")).split("\n"), '"""', ""]


def _carried(program: Program) -> list[str]:
    """Return the lines of the runtime modules that the program's text carries: for the arm, and, where its
    steps need them, for forces and for control steps."""
    steps = list(walk(program.steps))
    needed = ["runtime_arm"]
    needed += ["runtime_forces"] if any(isinstance(s, FORCES) for s in steps) else []
    needed += ["runtime_flow"] if any(isinstance(s, Control) for s in steps) else []
    texts = [(files(__package__) / f"{name}.py").read_text(encoding="utf-8") for name in needed]
    own = ["# ---- " + text.split("\n# ---- ", 1)[1].rstrip() for text in texts]
    return [*"\n\n\n".join(own).split("\n"), ""]


def _values(program: Program, out: _Writer) -> list[str]:
    low = ["# ---- values: poses [x, y, z, rx, ry, rz] of the TCP in the base frame [m, rad], joints [rad] ----"]
    low += [f"TCP = {_pose(program.tcp)}  # in the flange frame", f"START = {vector(program.start)}"]
    low += [f"FORCE_LIMIT = {number(program.force_limit)}  # protective limit on the TCP force [N]"]
    return low + [f"{name} = {value}" for name, value in out.poses.values.items()]


def _tasks(program: Program) -> list[tuple[str, str, Sequence[AnyStep]]]:
    """Return name, title and steps of a Python function for each section of a program, and for the steps before the
    first section."""
    firsts = [s.first for s in program.sections]
    ends = [*firsts, len(program.steps)]
    before = program.steps[: ends.pop(0)]
    found: list[tuple[str, str, Sequence[AnyStep]]] = []
    found += [("begin", "What comes before the first task.", before)] if before else []
    for section, end in zip(program.sections, ends, strict=True):
        title = f"{section.task}: {section.title} (steps {section.first + 1} to {end})."
        found.append((identifier(section.task), title.replace('"""', "'''"), program.steps[section.first : end]))
    return found


def _main(out: _Writer, program: Program, robot: Robot, tasks: Sequence[str]) -> None:
    start = f"arm.prepare(TCP, {number(program.mass)}, {vector(program.center)}, START, {number(START_TOLERANCE)})"
    out.add("def program(arm: Arm) -> None:", f'    """{program.name}."""', f"    {start}")
    out.add(*(f"    {task}" for task in tasks))
    out.add("", "", 'if __name__ == "__main__":')
    out.add("    if len(sys.argv) != 2:", '        sys.exit("usage: python THIS_FILE ROBOT_ADDRESS")')
    out.add(f"    sys.exit(run_program(sys.argv[1], FORCE_LIMIT, program, zero={controller_of(robot)[0] == E_SERIES}))")


def call(step: AnyStep, out: _Writer) -> str:
    """Write the call that carries out a step."""
    name = f'"{label(step.origin)}"'
    match step:
        case MoveJoints():
            path = ", ".join(out.name(step.origin, vector(q)) for q in step.path)
            radii = f", radii={vector(step.radii)}" if any(step.radii) else ""
            return f"arm.move_joints({name}, [{path}], {_rates(step)}{radii})"
        case MoveLinear():
            return f"arm.move_linear({name}, {out.name(step.origin, _pose(step.target))}, {_rates(step)})"
        case MoveUntilContact():
            way = f"{vector(step.direction)}, {_named(step, 'distance', 'speed', 'force', 'timeout')}"
            return f'arm.move_until_contact({name}, {way}, expect="{step.expect}")'
        case SetGripper():
            return _grip(step, out.robot, name)
        case SetPayload():
            return f"arm.payload({number(step.mass)}, {vector(step.center)})"
        case ZeroSensor():
            return "arm.zero()"
        case Wait():
            return f"arm.stand_still({number(step.duration)})"
    return _forced(step, out, name)


def _forced(step: AnyStep, out: _Writer, name: str) -> str:
    match step:
        case ForceMove():
            own = f"frame={_frame(step.frame, out, step.origin)}, selection=[{', '.join(str(int(c)) for c in step.compliant)}]"
            own += f", wrench={vector(step.wrench)}, limits={vector(step.limits)}, {_named(step, 'speed')}"
            return f"force_move(arm, {name}, [{_points(step, out)}], {own}, {_ends(step)})"
        case CompliantSlide():
            own = f"frame={_frame(step.frame, out, step.origin)}, height={number(HEIGHT)}, {_named(step, 'force', 'speed', 'lost')}"
            return f"slide(arm, {name}, [{_points(step, out)}], {own}, {_ends(step)})"
        case SpiralSearch():
            own = _named(step, "force", "pitch", "radius", "speed", "advance")
            return f"spiral_search(arm, {name}, frame={_frame(step.frame, out, step.origin)}, {own}, {_ends(step)})"
        case ForceInsert():
            wrench, way = (0.0, 0.0, step.force), step.depth
        case ForceExtract():
            wrench, way = (*step.across, step.force), step.way
        case _:
            raise unsupported_step(step, "ur_rtde")
    own = f"wrench={vector(wrench)}, way={number(way)}, {_named(step, 'speed')}"
    return f"force_along(arm, {name}, frame={_frame(step.frame, out, step.origin)}, {own}, {_ends(step)})"


def _points(step: ForceMove | CompliantSlide, out: _Writer) -> str:
    return ", ".join(out.name(step.origin, _pose(w)) for w in step.waypoints)


def _frame(frame: Pose, out: _Writer, origin: str) -> str:
    return out.name(f"{origin}_frame", _pose(Pose((0.0, 0.0, 0.0), frame.quaternion)))


def _ends(step: AnyStep) -> str:
    return _named(step, "force_limit", "timeout")


def _rates(step: MoveJoints | MoveLinear) -> str:
    return _named(step, "speed", "acceleration")


def _named(step: AnyStep, *names: str) -> str:
    return ", ".join(f"{n}={number(getattr(step, n))}" for n in names)


def _grip(step: SetGripper, robot: Robot, name: str) -> str:
    gripper = robot.gripper
    (low, high), (slow, fast), (weak, strong) = gripper.opening, gripper.speed, gripper.force
    position, speed = count((high - step.opening) / (high - low)), count((step.speed - slow) / (fast - slow))
    values = f"{position}, speed={speed}, force={count((step.force - weak) / (strong - weak))}"
    said = f"# {step.opening * 1000:.1f} mm, {step.force:.0f} N"
    return f'arm.grip({name}, {values}, expect="{step.expect}", timeout={number(step.timeout)})  {said}'


def _watched(step: Monitor, robot: Robot) -> str:
    low, high = robot.gripper.opening
    slip = None if step.slip is None else step.slip / (high - low) * 255
    given = {"force": step.force, "slip": slip, "time": step.time}
    return "".join(f", {k}={number(v)}" for k, v in given.items() if v is not None)


def _pose(pose: Pose) -> str:
    return vector((*pose.position, *pose.rotvec))
