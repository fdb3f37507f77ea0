"""Control steps in URScript: attempts, repetition, parallel branches and monitors.

Everything runs in the program's own function, in sight of whoever asks which line it is at; only what goes on beside the
arm (a gripper's branch, a monitor) has a thread of its own. ``ok`` says whether all went well so far; a step runs only
while it does. ``tripped`` is the number of the control step that wants what runs to be stopped: every wait looks at it.
"""

from __future__ import annotations

from collections.abc import Iterable

from msgspec import Struct, field

from cramlite.model import AnyStep, Control, Fallback, Gripper, Monitor, Parallel, Repeat, branch_conflict, uses_arm
from cramlite.plugin import UserError

from ..names import Names
from .literals import label, number, plain
from .steps import leaf

FUNCTIONS = """
# ---- functions of control steps ----
global ok = True

# Wait for the running motion; stop it when something tripped.
def watch_move():
  local waited = 0.0
  while not motion_done and tripped == 0 and waited < 120.0:
    sync()
    waited = waited + get_steptime()
  end
  if not motion_done:
    kill motion_thread
    stopj(2.0)
    if tripped == 0:
      return fail("a motion was not done within 120 s")
    end
    return False
  end
  return True
end

def stand_still(duration):
  local waited = 0.0
  while waited < duration and tripped == 0:
    sync()
    waited = waited + get_steptime()
  end
  return tripped == 0
end

# The fingers stay where they are.
def stop_gripper():
  set_gripper("POS", socket_get_var("POS", "gripper"))
end

# A control step wants what runs inside it to be stopped; the first to say so is heard.
def trip(number, reason):
  if tripped == 0:
    failure = reason
    tripped = number
  end
end
"""
JOINED = 600.0  # how long a control step waits for its last branch at most [s]; the branches' own limits are shorter
GUARD = "if ok and tripped == 0:"


class CodeLine(Struct):
    """Line of a URScript function, with the origin of the step that begins at this line."""

    text: str
    origin: str = ""


class FlowWriter(Struct):
    """A writer of URScript for program steps that contain other steps, such as loops and parallel branches.

    Args:
        gripper: of the robot.
        poses: names of what motions lead to.
        number: of control steps and threads written so far; names are made of it.
        define: threads, to stand before the steps.
        body: the steps.
        depth: of blocks in the body.
    """

    gripper: Gripper
    poses: Names = field(default_factory=Names)
    number: int = 0
    define: list[str] = field(default_factory=list)
    body: list[CodeLine] = field(default_factory=list)
    depth: int = 0

    def add(self, *texts: str, origin: str = "") -> None:
        """Append lines at the present indentation; the first carries the step's origin."""
        for text in texts:
            self.body.append(CodeLine("  " * self.depth + text, origin))
            origin = ""

    def begin(self, condition: str) -> None:
        """Write the first line of a URScript block, such as ``if ok:``, and indent the lines after it."""
        self.add(condition)
        self.depth += 1

    def end(self) -> None:
        """Write the ``end`` of the innermost URScript block that is open."""
        self.depth -= 1
        self.add("end")

    def next(self) -> int:
        """Return the next number, which makes a generated name unique."""
        self.number += 1
        return self.number

    def thread(self) -> str:
        """Return a new name for a thread that moves the arm."""
        return f"motion_{self.next()}"

    def steps(self, steps: Iterable[AnyStep]) -> None:
        """Write steps one after the other."""
        for step in steps:
            self.step(step)

    def step(self, step: AnyStep) -> None:
        """Write a step, its comment before it."""
        if said := comment(step):
            self.add(said)
        match step:
            case Fallback():
                self.begin(GUARD)
                self.attempts(step, 0)
                self.end()
            case Repeat():
                self.repeat(step)
            case Parallel():
                self.parallel(step)
            case Monitor():
                self.monitor(step)
            case _:
                self.leaf(step)

    def leaf(self, step: AnyStep) -> None:
        """Write a step without inner steps; it runs only while all steps before it have succeeded."""
        text = leaf(step, self.gripper, self.thread, self.poses, watched=True)
        self.define += text.thread
        self.begin(GUARD)
        self.add(*text.lines, *([f"ok = {text.call}"] if text.call else []), origin=step.origin)
        self.end()

    def attempts(self, step: Fallback, k: int) -> None:
        """Write the branches of a fallback from number ``k`` (from 0) on, each of which runs only if the one before
        it has failed."""
        self.steps(step.branches[k])
        if k + 1 < len(step.branches):
            self.begin("if not ok and tripped == 0:")
            self.add(f'textmsg("{FAILED}{label(_label(step))}, attempt {k + 1}: ", failure)', "ok = True")
            self.attempts(step, k + 1)
            self.end()

    def repeat(self, step: Repeat) -> None:
        """Write a repetition as a counting loop."""
        counter = f"round_{self.next()}"
        self.add(f"{counter} = 0")
        self.begin(f"while ok and tripped == 0 and {counter} < {step.count}:")
        self.steps(step.steps)
        self.add(f"{counter} = {counter} + 1")
        self.end()

    def monitor(self, step: Monitor) -> None:
        """Write a monitor: its steps, and a thread that checks its limits while they run."""
        number_ = self.next()
        name = f"monitor_{number_}"
        self.define += _monitor(step, number_, self.gripper)
        self.begin(GUARD)
        self.add(f"{name}_thread = run {name}()", origin=step.origin)
        self.steps(step.steps)
        self.add(f"kill {name}_thread")
        self.begin(f"if tripped == {number_}:")
        self.add("tripped = 0", "ok = False")
        self.end()
        self.end()

    def parallel(self, step: Parallel) -> None:
        """Write parallel branches: the one that moves the arm in the main function, each other one as a thread.

        Raises:
            UserError: more than one branch moves the arm or the gripper.
        """
        if wrong := branch_conflict(step.branches):
            raise UserError(f"{_label(step)}: {wrong}")
        number_ = self.next()
        main = next((k for k, b in enumerate(step.branches) if uses_arm(b)), 0)
        names = [f"side_{number_}_{k}" for k in range(len(step.branches)) if k != main]
        for name, branch in zip(names, (b for k, b in enumerate(step.branches) if k != main), strict=True):
            self.define += self.side(name, branch, number_, step.until)
        self.begin(GUARD)
        for name in names:
            self.add(f"{name}_done = False", f"{name}_thread = run {name}()")
        self.steps(step.branches[main])
        self.join(step, names, number_)
        self.end()

    def join(self, step: Parallel, names: list[str], number_: int) -> None:
        """Write the code that waits for parallel branches, and stops the others at the first failure (until "all")
        or the first success ("first")."""
        running = " or ".join(f"not {n}_done" for n in names)
        going = "ok" if step.until == "all" else "not ok"
        if names:
            joined = f"joined_{number_}"
            self.add(f"{joined} = 0.0")
            self.begin(f"while {going} and tripped == 0 and {joined} < {JOINED} and ({running}):")
            self.add("sync()", f"{joined} = {joined} + get_steptime()")
            self.end()
            self.begin(f"if {joined} >= {JOINED}:")
            self.add(f'failure = "{label(_label(step))}: a branch was not done within {JOINED} s"')
            self.end()
        for name in names:
            self.begin(f"if not {name}_done:")
            self.add(f"kill {name}_thread", f"{name}_ok = False", "stop_gripper()")
            self.end()
        word = "and" if step.until == "all" else "or"
        self.add(f"ok = {f' {word} '.join(['ok', *(f'{n}_ok' for n in names)])}")
        self.begin(f"if tripped == {number_}:")
        self.add("tripped = 0")
        self.end()

    def side(self, name: str, branch: Iterable[AnyStep], number_: int, until: str) -> list[str]:
        """Write the thread of a branch that does not move the arm."""
        lines = [f"global {name}_ok = True", f"global {name}_done = False", f"thread {name}():", f"  {name}_ok = True"]
        for step in branch:
            text = leaf(step, self.gripper, self.thread, self.poses, watched=True)
            lines += [f"  if {name}_ok and tripped == 0:", *(f"    {line}" for line in text.lines)]
            lines += [f"    {name}_ok = {text.call}", "  end"]
        stops = f"not {name}_ok" if until == "all" else f"{name}_ok"
        lines += [f"  {name}_done = True", f"  if {stops}:", f"    trip({number_}, failure)", "  end", "end"]
        return lines


FAILED = "cramlite failed: "
"""Beginning of the message about a failed attempt, after which the program continues."""


def _monitor(step: Monitor, number_: int, gripper: Gripper) -> list[str]:
    """Thread that evaluates a monitor's conditions; it has a socket of its own to the gripper, so that no
    answers are mixed up."""
    name, said = f"monitor_{number_}", label(_label(step))
    lines = [f"thread {name}():", "  local waited = 0.0"]
    counts = (step.slip or 0.0) / (gripper.opening[1] - gripper.opening[0]) * 255
    if step.slip is not None:
        lines += [f'  socket_open("127.0.0.1", 63352, "{name}")', f'  local began = socket_get_var("POS", "{name}")']
    lines += ["  while True:", "    sync()", "    waited = waited + get_steptime()"]
    if step.force is not None:
        lines += ["    local measured = force()", f"    if measured > {number(step.force)}:"]
        lines += [_trip(number_, said, "force ", "measured", f" N > {number(step.force)} N"), "    end"]
    if step.slip is not None:
        lines += [f'    local closed = socket_get_var("POS", "{name}") - began', f"    if closed > {number(counts)}:"]
        lines += [_trip(number_, said, "the fingers closed further by ", "closed", f" of 255 > {number(counts)}: slip"), "    end"]
    if step.time is not None:
        lines += [f"    if waited > {number(step.time)}:"]
        lines += [_trip(number_, said, "not done after ", "waited", f" s > {number(step.time)} s"), "    end"]
    return [*lines, "  end", "end"]


def _trip(number_: int, said: str, before: str, value: str, after: str) -> str:
    return f'      trip({number_}, str_cat("{said}: {before}", str_cat({value}, "{after}")))'


def _label(step: AnyStep) -> str:
    return step.origin or type(step).__name__


def comment(step: AnyStep) -> str:
    """Return a step's comment line in URScript, made of its designator and its own comment; "" if it has
    neither."""
    said = ": ".join(plain(c) for c in (step.origin, step.comment) if c)
    return f"# {said}" if said else ""


def write(step: Control, writer: FlowWriter) -> tuple[list[str], list[CodeLine]]:
    """Return a step that contains others, such as a loop, as URScript: the threads to define in the main
    function, and the statements to put there.

    Inside, a failure is judged by the control steps; what is left of it ends the program.
    """
    writer.define, writer.body = [], []
    writer.add("catching = True", "ok = True")
    writer.step(step)
    writer.add("catching = False")
    writer.begin("if not ok:")
    writer.add("abort(failure)")
    writer.end()
    return writer.define, writer.body
