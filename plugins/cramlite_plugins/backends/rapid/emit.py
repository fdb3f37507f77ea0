"""ABB RAPID: one module, with tool, work object, named targets, loads, a routine for each task, and main.

Units are ABB's: mm, degrees. Motions stop at their targets (``fine``) unless the corner was checked, where the largest
predefined zone within the checked radius is taken. Force control is an option of the controller: without it, programs with
force-controlled steps are refused.
"""

from __future__ import annotations

from collections.abc import Iterable

from msgspec import Struct, field

from cramlite.model import (
    AnyStep,
    CompliantSlide,
    Fallback,
    ForceExtract,
    ForceInsert,
    ForceMove,
    Monitor,
    MoveJoints,
    MoveLinear,
    MoveUntilContact,
    Parallel,
    Program,
    Repeat,
    Robot,
    SetGripper,
    SetPayload,
    SpiralSearch,
    Wait,
    ZeroSensor,
)
from cramlite.plugin import Code, UserError

from ..unsupported import refuse_drives, unsupported_step
from ..urscript.steps import count
from .literals import identifier, jointtarget, mm, number, plain, quat, robtarget, way_of, zone
from .parts import FORCE, NO_FORCE, ROUTINES, header

NATIVE = ("rapid", "rapid_fc")  # what ABB's arms declare as their backend
START_TOLERANCE = 0.6  # degrees, 0.01 rad
ORI, LONGEST = 60.0, 30  # reorientation speed [deg/s]; letters of an identifier, of 32


class _Writer(Struct):
    """Writer of a RAPID module: the declarations and lines that were written so far.

    Args:
        zero: where ABB's axes are zero, in the angles of typed programs [rad].
        forces: whether the controller has Force Control.
        data: declarations by name.
        lines: of the routines, each with the origin of the step that begins with it, or "".
        later: routines of branches, which stand after the one that calls them.
    """

    robot: Robot
    zero: tuple[float, ...]
    forces: bool
    data: dict[str, str] = field(default_factory=dict)
    lines: list[tuple[str, str]] = field(default_factory=list)
    depth: int = 1
    number: int = 0
    load: str = "load0"
    at: tuple[float, ...] = ()
    later: list[tuple[str, str]] = field(default_factory=list)

    def add(self, *texts: str, origin: str = "") -> None:
        for text in texts:
            self.lines.append(("  " * self.depth + text if text else "", origin))
            origin = ""

    def declare(self, kind: str, prefix: str, origin: str, value: str) -> str:
        """Declare a constant and return its name; equal values with the same origin share one constant."""
        base = name = prefix + identifier(origin)[: LONGEST - len(prefix) - 3]
        text, k = f"CONST {kind} {{}} := {value};", 1
        while self.data.get(name, text.format(name)) != text.format(name):
            k += 1
            name = f"{base}_{k}"
        self.data[name] = text.format(name)
        return name

    def routine(self, name: str, steps: Iterable[AnyStep], title: str = "") -> None:
        outer, self.lines = self.lines, []
        depth, self.depth = self.depth, 1
        self.add(*([f"! {plain(title)}"] if title else []), f"PROC {name}()")
        self.depth = 2
        for step in steps:
            self.step(step)
        self.depth = 1
        self.add("ENDPROC", "")
        self.lines, self.depth = [*outer, *self.lines], depth

    def step(self, step: AnyStep) -> None:
        if said := ": ".join(c for c in (step.origin, step.comment) if c):
            self.add(f"! {plain(said)}")
        match step:
            case Repeat():
                self.add(f"FOR i FROM 1 TO {step.count} DO")
                self.depth += 1
                for inner in step.steps:
                    self.step(inner)
                self.depth -= 1
                self.add("ENDFOR")
            case Fallback() | SetPayload():
                self.add(*(self.attempts(step) if isinstance(step, Fallback) else self.payload(step)), origin=step.origin)
            case Monitor() | Parallel():
                why = f"RAPID has no {type(step).__name__} here: the one task that moves the arm can do nothing else meanwhile"
                raise unsupported_step(step, "RAPID", why)
            case _:
                self.add(*leaf(step, self), origin=step.origin)

    def payload(self, step: SetPayload) -> list[str]:
        """Write the GripLoad instruction for the payload alone: its mass and centre in the tool frame,
        without the gripper."""
        gripper, mass = self.robot.gripper, step.mass - self.robot.gripper.mass
        self.load = "load0"
        if mass > 1e-3:
            own = gripper.tcp.position[2] / 2
            z = (step.mass * step.center[2] - gripper.mass * own) / mass
            center = (step.mass * step.center[0] / mass, step.mass * step.center[1] / mass, z)
            held = gripper.tcp.inverse().apply(center)
            value = f"[{number(mass)}, {mm(tuple(float(v) for v in held))}, [1, 0, 0, 0], 0, 0, 0]"
            self.load = self.declare("loaddata", "ld", step.origin or "held", value).replace("CONST", "PERS")
        return [f"GripLoad {self.load};"]

    def attempts(self, step: Fallback) -> list[str]:
        """Write a routine for each branch of a fallback; when one of its steps fails, its error handler
        starts the next branch."""
        self.number += 1
        n, count_ = self.number, len(step.branches)
        body, self.lines = self.lines, []
        for k, branch in enumerate(step.branches, 1):
            self.routine(f"Attempt_{n}_{k}", branch)
        for k in range(1, count_):
            self._handler(n, k, count_)
        self.later.extend(self.lines)
        self.lines = body
        return [f"Try_{n}_1;" if count_ > 1 else f"Attempt_{n}_1;"]

    def _handler(self, n: int, k: int, last: int) -> None:
        following = f"Try_{n}_{k + 1}" if k + 1 < last else f"Attempt_{n}_{k + 1}"
        depth, self.depth = self.depth, 1
        self.add(f"PROC Try_{n}_{k}()", f"  Attempt_{n}_{k};", "ERROR", "  IF ERRNO = errStep THEN")
        self.add(f'    TPWrite "cramlite failed: attempt {k}";', f"    {following};", "    TRYNEXT;", "  ENDIF", "  RAISE;")
        self.add("ENDPROC", "")
        self.depth = depth


def emit(program: Program, robot: Robot, *, forces: bool) -> Code:
    """Write the program as RAPID text.

    Args:
        robot: an arm whose native language is RAPID, and that declares its ``axis_zeros``.
        forces: the controller has the option Force Control.

    Raises:
        UserError: the robot is not ABB's or does not say where its axes are zero, or a step has no counterpart: says which and
            what would help.

    Returns:
        Code whose ``origins`` lead from the first line of a step back to the step's origin.
    """
    zeros = _axis_zeros(program, robot)
    if program.late:
        things = ", ".join(t.thing for t in program.late)
        asked = f"late poses ({things}), which the program would ask for when it starts,"
        raise UserError(f"{asked} cannot be written in RAPID yet; take the backend urscript")
    refuse_drives(program, "RAPID")
    out = _Writer(robot, zeros, forces, at=program.start)
    start = jointtarget(program.start, out.zero)
    tasks = []
    for name, title, steps in _tasks(program):
        out.routine(name, steps, title)
        tasks.append(name)
    out.lines += out.later
    _main(out, tasks)
    module = identifier(program.name)[:LONGEST]
    lines = [f"MODULE {module}", *(f"  ! {plain(h)}".rstrip() for h in header(program, robot, forces)), ""]
    lines += [f"  {d}" for d in _tool(program)]
    lines += [f"  CONST jointtarget jStart := {start};", f"  CONST num START_TOLERANCE := {number(START_TOLERANCE)};"]
    lines += [f"  {d}" for d in out.data.values()]
    lines += [*(ROUTINES + (FORCE if forces else NO_FORCE)).rstrip().split("\n"), "", "  ! ---- tasks ----"]
    origins = {len(lines) + k: origin for k, (_, origin) in enumerate(out.lines, 1) if origin}
    return Code("rapid", "\n".join([*lines, *(line for line, _ in out.lines), "ENDMODULE"]) + "\n", origins, ".mod")


def _axis_zeros(program: Program, robot: Robot) -> tuple[float, ...]:
    """Return the joint angles at which ABB's axes are zero; refuse robots that are no ABB arms, or do not
    state these."""
    if program.robot_type != robot.type or robot.backend not in NATIVE:
        said = f"RAPID is for ABB arms (backend 'rapid'), not for '{robot.type}' (backend '{robot.backend}')"
        raise UserError(f"program for '{program.robot_type}': {said}")
    if robot.axis_zeros is None:
        raise UserError(
            f"robot '{robot.type}' does not declare where its axes are zero, and RAPID counts their angles from there; set "
            "'axis_zeros' of the Robot (all 0 if they are zero where its Denavit-Hartenberg table is)"
        )
    return robot.axis_zeros


def _tool(program: Program) -> list[str]:
    tcp, center = program.tcp, program.center
    frame = f"[{mm(tcp.position)}, {quat(tcp)}]"
    load = f"[{number(program.mass)}, {mm(center)}, [1, 0, 0, 0], 0, 0, 0]"
    return [
        f"PERS tooldata tGripper := [TRUE, {frame}, {load}];",
        'PERS wobjdata wBase := [FALSE, TRUE, "", [[0, 0, 0], [1, 0, 0, 0]], [[0, 0, 0], [1, 0, 0, 0]]];',
    ]


def _tasks(program: Program) -> Iterable[tuple[str, str, tuple[AnyStep, ...]]]:
    """Yield for each section of a program, which is one task, its RAPID routine's name, a title and its
    steps; steps before the first section form a routine of their own."""
    ends = [*(s.first for s in program.sections), len(program.steps)]
    if before := program.steps[: ends.pop(0)]:
        yield "Begin", "What comes before the first task", before
    for section, end in zip(program.sections, ends, strict=True):
        title = f"{section.task}: {section.title} (steps {section.first + 1} to {end})"
        yield identifier(section.task)[:LONGEST], title, program.steps[section.first : end]


def _main(out: _Writer, tasks: list[str]) -> None:
    out.add("PROC main()", "  BookErrNo errStep;", "  ConfL \\Off;", "  CheckStart;", "  GripLoad load0;", "  Tare load0;")
    out.add(*(f"  {task};" for task in tasks), '  TPWrite "cramlite: finished";')
    out.add("ERROR", "  StopMove;", "  ClearPath;", "  StartMove;", "  ReleaseForce;", '  TPWrite "cramlite abort";', "  EXIT;")
    out.add("ENDPROC")


def leaf(step: AnyStep, out: _Writer) -> list[str]:
    """Write the RAPID lines of a step without inner steps."""
    name = f'"{plain(step.origin)[:60]}"'
    tool = "tGripper \\WObj:=wBase"
    match step:
        case MoveJoints():
            return _joint_moves(step, out)
        case MoveLinear():
            target = out.declare("robtarget", "p", step.origin, robtarget(step.target, step.joints, out.zero))
            out.at = step.joints or out.at
            return [f"MoveL {target}, {_speed(step.speed, out)}, fine, {tool};"]
        case MoveUntilContact():
            way = ", ".join(number(1000 * step.distance * d) for d in step.direction)
            needed = "TRUE" if step.expect == "contact" else "FALSE"
            return [f"MoveToContact {way}, {number(step.force)}, {_speed(step.speed, out)}, {needed}, {name};"]
        case SetGripper():
            return [_grip(step, out.robot, name)]
        case ZeroSensor():
            return [f"Tare {out.load};"]
        case Wait():
            return [f"WaitTime {number(step.duration)};"]
    return [_forced(step, out, name)]


def _forced(step: AnyStep, out: _Writer, name: str) -> str:
    if isinstance(step, ForceMove | CompliantSlide):
        raise unsupported_step(step, "RAPID")
    if not out.forces:
        raise UserError(
            f"{step.origin or type(step).__name__}: {type(step).__name__} needs ABB's option Force Control; where it is licensed, use "
            "--backend rapid_fc"
        )
    match step:
        case ForceInsert() | ForceExtract():
            goal = step.depth if isinstance(step, ForceInsert) else step.way
            x, y = step.across if isinstance(step, ForceExtract) else (0.0, 0.0)
            forces = ", ".join(number(v) for v in (x, y, step.force))
            ends = f"{way_of(step.frame, goal)}, {number(step.force_limit)}, {number(step.timeout)}"
            return f"PushAlong {quat(step.frame)}, {forces}, {ends}, {name};"
        case SpiralSearch():
            spiral = ", ".join(number(v) for v in (step.force, 1000 * step.pitch, 1000 * step.radius, 1000 * step.speed))
            ends = f"{way_of(step.frame, step.advance)}, {number(step.force_limit)}, {number(step.timeout)}"
            return f"SearchSpiral {quat(step.frame)}, {spiral}, {ends}, {name};"
    raise unsupported_step(step, "RAPID")


def _joint_moves(step: MoveJoints, out: _Writer) -> list[str]:
    """Write one MoveAbsJ for each joint target, with a duration that suits the joint that turns farthest."""
    lines, here = [], out.at
    radii = [*(step.radii or (0.0,) * (len(step.path) - 1)), 0.0]
    for q, radius in zip(step.path, radii, strict=True):
        target = out.declare("jointtarget", "j", step.origin, jointtarget(q, out.zero))
        way = max((abs(a - b) for a, b in zip(here, q, strict=True)), default=0.0)
        time = way / step.speed + step.speed / step.acceleration
        lines.append(f"MoveAbsJ {target}, v1000 \\T:={number(time)}, {zone(radius)}, tGripper \\WObj:=wBase;")
        here = q
    out.at = here
    return lines


def _grip(step: SetGripper, robot: Robot, name: str) -> str:
    gripper = robot.gripper
    (low, high), (slow, fast), (weak, strong) = gripper.opening, gripper.speed, gripper.force
    position, speed = count((high - step.opening) / (high - low)), count((step.speed - slow) / (fast - slow))
    values = f"{position}, {speed}, {count((step.force - weak) / (strong - weak))}"
    return f'Grip {values}, "{step.expect}", {number(step.timeout)}, {name};'


def _speed(speed: float, out: _Writer) -> str:
    """A speeddata constant for a TCP speed [m/s]."""
    value = f"[{number(1000 * speed)}, {number(ORI)}, 5000, 1000]"
    return out.declare("speeddata", "v", f"{1000 * speed:g}".replace(".", "_"), value)
