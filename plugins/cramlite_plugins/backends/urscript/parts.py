"""The parts of every URScript program: the header with its preconditions, and the functions that steps call."""

from __future__ import annotations

import re
from collections.abc import Sequence

from cramlite.model import Program, Robot

from .controllers import CB3, controller_of
from .literals import plain, pose, vector

# Contact is decided by the force along the motion, watched while a thread moves: the documented pattern.
FUNCTIONS = """
# ---- functions ----
global motion_done = True
global motion_thread = 0
global force_limit = 0.0
global catching = False
global failure = ""
global tripped = 0

# Stop, say why, end the program.
def abort(reason):
  end_force_mode()
  stopj(2.0)
  textmsg("cramlite abort: ", reason)
  halt
end

# A step has failed: inside a control step that is a value for it to judge, elsewhere it ends the program.
def fail(reason):
  if not catching:
    abort(reason)
  end
  failure = reason
  return False
end

# The force limit of the whole program: halt ends every thread and stops the arm.
thread watchdog():
  while True:
    if force() > force_limit:
      textmsg("cramlite abort: ", str_cat(str_cat("force ", force()), str_cat(" N > ", str_cat(force_limit, " N"))))
      halt
    end
    sync()
  end
end

def check_start(start, tolerance):
  local actual = get_actual_joint_positions()
  local i = 0
  while i < 6:
    if norm(actual[i] - start[i]) > tolerance:
      local where = str_cat("joint ", str_cat(i, str_cat(" is at ", str_cat(actual[i], " rad"))))
      abort(str_cat(where, str_cat(", the program starts from ", str_cat(start[i], " rad"))))
    end
    i = i + 1
  end
end

# Robotiq's server answers SET with "ack".
def set_gripper(name, value):
  socket_set_var(name, value, "gripper")
  local answer = socket_read_byte_list(3, "gripper", 2.0)
  if answer[0] != 3:
    abort(str_cat("the gripper does not acknowledge SET ", name))
  end
end

def connect_gripper():
  if not socket_open("127.0.0.1", 63352, "gripper"):
    abort("no gripper server at 127.0.0.1:63352")
  end
  if socket_get_var("STA", "gripper") != 3:
    set_gripper("ACT", 1)
    local waited = 0.0
    while socket_get_var("STA", "gripper") != 3:
      if waited > 10.0:
        abort("the gripper was not activated within 10 s")
      end
      sleep(0.05)
      waited = waited + 0.05
    end
  end
  set_gripper("GTO", 1)
end

# OBJ: 0 moving, 1 and 2 stopped on an object (opening, closing), 3 at the position.
def move_gripper(position, speed, grip, expect, timeout, step):
  set_gripper("SPE", speed)
  set_gripper("FOR", grip)
  set_gripper("POS", position)
  local waited = 0.0
  # OBJ belongs to this order only after PRE, the echo of the order, has changed.
  while socket_get_var("PRE", "gripper") != position or socket_get_var("OBJ", "gripper") == 0:
    if tripped != 0:
      return False
    end
    if waited > timeout:
      return fail(str_cat(step, str_cat(": the gripper still moved after ", str_cat(timeout, " s"))))
    end
    sleep(0.02)
    waited = waited + 0.02
  end
  local object = socket_get_var("OBJ", "gripper")
  if expect == "object" and object == 3:
    return fail(str_cat(step, ": no object between the fingers"))
  elif expect == "none" and object != 3:
    return fail(str_cat(step, ": an object stopped the fingers"))
  end
  return True
end

global contact_target = p[0.0, 0.0, 0.0, 0.0, 0.0, 0.0]
global contact_speed = 0.0
thread contact_move():
  movel(contact_target, a=0.25, v=contact_speed)
  motion_done = True
end

# Move along a direction of the base frame until the environment pushes back with the force [N].
def move_until_contact(direction, distance, speed, threshold, timeout, expect, step):
  local here = get_actual_tcp_pose()
  local way = p[direction[0] * distance, direction[1] * distance, direction[2] * distance, 0.0, 0.0, 0.0]
  contact_target = pose_add(here, way)
  contact_speed = speed
  motion_done = False
  motion_thread = run contact_move()
  local waited = 0.0
  local reaction = 0.0
  local found = False
  while not found and not motion_done and waited < timeout and tripped == 0:
    sync()
    waited = waited + get_steptime()
    local f = get_tcp_force()
    reaction = -(f[0] * direction[0] + f[1] * direction[1] + f[2] * direction[2])
    found = reaction > threshold
  end
  kill motion_thread
  stopl(3.0)
  if tripped != 0:
    return False
  end
  if found:
    textmsg(step, str_cat(": contact, ", str_cat(reaction, " N")))
  elif not motion_done:
    return fail(str_cat(step, str_cat(": no contact within ", str_cat(timeout, " s"))))
  elif expect == "contact":
    return fail(str_cat(step, str_cat(": no contact within ", str_cat(distance, " m"))))
  end
  return True
end

# Watch the running force move: its end, the force and the time.
def watch_force_move(limit, timeout, step):
  local waited = 0.0
  while not motion_done and force() <= limit and waited < timeout and tripped == 0:
    sync()
    waited = waited + get_steptime()
  end
  local measured = force()
  kill motion_thread
  stopl(3.0)
  end_force_mode()
  if tripped != 0:
    return False
  end
  if not motion_done and measured > limit:
    return fail(str_cat(step, str_cat(": force ", str_cat(measured, str_cat(" N > ", str_cat(limit, " N"))))))
  elif not motion_done:
    return fail(str_cat(step, str_cat(": not done within ", str_cat(timeout, " s"))))
  end
  return True
end
"""


def header(program: Program, robot: Robot) -> list[str]:
    """Write the preconditions of the program, as a comment."""
    speeds = ", ".join(f"{v:.2f}" for v in robot.velocity)
    lines = [
        "# Generated by cramlite from a typed program; this text was executed in simulation before it was offered.",
        "# PRECONDITIONS",
        f"#   robot: {robot.type} '{program.robot}', {_controller(robot)}",
        f"#   gripper: {robot.gripper.type} with Robotiq's URCap (server at 127.0.0.1:63352), activated",
        f"#   TCP in the flange: {pose(program.tcp)}",
        f"#   payload: {program.mass:.3f} kg, centre of gravity {vector(program.center)} m",
        f"#   safety configuration: joint speeds up to {speeds} rad/s, TCP force {program.force_limit:.0f} N or more",
        f"#   start posture: {vector(program.start)} rad, checked to 0.01 rad",
        "# Poses that were bound when this was planned (base frame); move one of these things, and plan anew:",
    ]
    lines += [f"#   {plain(s.thing)}: {pose(s.pose)}, {plain(s.source)}, {s.age:.1f} s old" for s in program.snapshots]
    lines = lines if program.snapshots else lines[:-1]
    late = [
        f"#   {plain(t.thing)}: planned at {pose(t.pose)}, up to {1000 * t.tolerance[0]:.0f} mm and {t.tolerance[1]:.3f} rad off"
        for t in program.late
    ]
    asked = "# Poses that are asked for when this runs, of the perception server at 127.0.0.1:50010 (see ask_pose):"
    return [*lines, asked, *late] if late else lines


def _controller(robot: Robot) -> str:
    """Return the precondition on the controller: its PolyScope version, and where the arm's force readings
    come from."""
    controller, version = controller_of(robot)
    known = f"{'CB3, ' if controller == CB3 else ''}PolyScope {version} or later"
    if robot.sensor == "flange":
        return known
    known += "; no sensor in the flange" if controller == CB3 else ""
    if robot.sensor is None:
        return f"{known}; forces are estimated by the controller itself"
    return (
        f"{known}{':' if controller == CB3 else ';'} the {robot.sensor} between flange and gripper must be the"
        " controller's force source (enable_external_ft_sensor, by its URCap), with readings at the flange"
    )


HEADING = "# ---- "
DEFINED = re.compile(r"^(?:def|thread|global) (\w+)", re.MULTILINE)


def used(library: Sequence[str], text: str) -> list[str]:
    """Select those definitions of a URScript library that a program text uses, directly or through other definitions,
    in the library's order.

    Args:
        library: paragraphs, each a function or variables that belong together, with their comments; empty lines between them.
            A heading stays where anything below it, up to the next one, does.
        text: what calls them.
    """
    paragraphs = ["\n".join(part) for part in _paragraphs(library)]
    kept: set[int] = set()
    while True:
        known = text + "\n".join(paragraphs[k] for k in kept)
        words = set(re.findall(r"\w+", known))
        more = {k for k, p in enumerate(paragraphs) if k not in kept and words & set(DEFINED.findall(p))}
        if not more:
            return _joined(paragraphs, kept)
        kept |= more


def _paragraphs(lines: Sequence[str]) -> list[list[str]]:
    """Group lines of text into paragraphs, which end at empty lines; each heading is a paragraph of its own."""
    found: list[list[str]] = [[]]
    for line in lines:
        if line.startswith(HEADING):
            found += [[line], []]
        elif line:
            found[-1].append(line)
        elif found[-1]:
            found.append([])
    return [p for p in found if p]


def _joined(paragraphs: Sequence[str], kept: set[int]) -> list[str]:
    lines: list[str] = []
    heading = ""
    for k, paragraph in enumerate(paragraphs):
        if paragraph.startswith(HEADING):
            heading = paragraph
        elif k in kept:
            lines += ["", heading] if heading else [""]
            lines += paragraph.split("\n")
            heading = ""
    return lines[1:]
