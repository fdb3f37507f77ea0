"""Force-controlled steps of URScript programs: search, insertion, extraction and sliding.

As for the other functions, a thread moves while the program watches force, way and time, and only the documented
combination of movel and force_mode is used; an insertion needs no motion at all.
"""

from __future__ import annotations

from cramlite.model import ForceExtract, ForceInsert, Pose, SpiralSearch

from ..names import Names
from .literals import label, number, pose, vector

FUNCTIONS = """
# ---- functions of force-controlled search, insertion, extraction and sliding ----
# How far the tool has come from a pose along a direction of the base frame [m].
def way_along(start, direction):
  local here = get_actual_tcp_pose()
  local x = (here[0] - start[0]) * direction[0]
  return x + (here[1] - start[1]) * direction[1] + (here[2] - start[2]) * direction[2]
end

global spiral_center = p[0.0, 0.0, 0.0, 0.0, 0.0, 0.0]
global spiral_frame = p[0.0, 0.0, 0.0, 0.0, 0.0, 0.0]
global spiral_pitch = 0.0
global spiral_radius = 0.0
global spiral_speed = 0.0
# An Archimedean spiral, radius = pitch * angle / (2 pi), in chords of 1 mm.
thread spiral_move():
  local angle = 0.0
  local radius = 0.0
  while radius < spiral_radius:
    angle = angle + 0.001 / (radius + 0.001)
    radius = spiral_pitch * angle / 6.283185
    local out = pose_trans(spiral_frame, p[radius * cos(angle), radius * sin(angle), 0.0, 0.0, 0.0, 0.0])
    movel(pose_add(spiral_center, p[out[0], out[1], out[2], 0.0, 0.0, 0.0]), a=0.25, v=spiral_speed)
  end
  motion_done = True
end

# The force across a direction of the base frame [N].
def force_across(direction):
  local f = get_tcp_force()
  local along = f[0] * direction[0] + f[1] * direction[1] + f[2] * direction[2]
  return norm([f[0] - along * direction[0], f[1] - along * direction[1], f[2] - along * direction[2]])
end

# Press along z of a frame and move across it on a spiral until the tool gives way, or a rim holds it: a force across
# of more than twice the pressing force is more than the friction of a face.
def spiral_search(frame, direction, press, pitch, radius, speed, advance, limit, timeout, step):
  spiral_center = get_target_tcp_pose()
  spiral_frame = frame
  spiral_pitch = pitch
  spiral_radius = radius
  spiral_speed = speed
  local start = get_actual_tcp_pose()
  local waited = 0.0
  local way = 0.0
  local across = 0.0
  motion_done = False
  force_mode(frame, [0, 0, 1, 0, 0, 0], [0.0, 0.0, press, 0.0, 0.0, 0.0], 2, [0.15, 0.15, 0.02, 0.35, 0.35, 0.35])
  motion_thread = run spiral_move()
  while way < advance and across < 2.0 * press and not motion_done and force() <= limit and waited < timeout and tripped == 0:
    sync()
    waited = waited + get_steptime()
    way = way_along(start, direction)
    across = force_across(direction)
  end
  local measured = force()
  kill motion_thread
  stopl(3.0)
  end_force_mode()
  if tripped != 0:
    return False
  elif way >= advance:
    textmsg(step, str_cat(": it gave way after ", str_cat(waited, " s")))
  elif across >= 2.0 * press:
    textmsg(step, str_cat(": a rim holds it after ", str_cat(waited, str_cat(" s, ", str_cat(across, " N")))))
  elif measured > limit:
    return fail(str_cat(step, str_cat(": force ", str_cat(measured, str_cat(" N > ", str_cat(limit, " N"))))))
  elif motion_done:
    return fail(str_cat(step, str_cat(": nothing gave way within a radius of ", str_cat(radius, " m"))))
  else:
    return fail(str_cat(step, str_cat(": nothing gave way within ", str_cat(timeout, " s"))))
  end
  return True
end

# Press along z of a frame, giving way sideways, until the tool has come far enough; "wrench" has the forces on x, y, z.
def force_along(frame, direction, wrench, goal, speed, limit, timeout, done, how, step):
  local start = get_actual_tcp_pose()
  local waited = 0.0
  local way = 0.0
  force_mode(frame, [1, 1, 1, 0, 0, 0], [wrench[0], wrench[1], wrench[2], 0.0, 0.0, 0.0], 2, [speed, speed, speed, 0.35, 0.35, 0.35])
  while way < goal and force() <= limit and waited < timeout and tripped == 0:
    sync()
    waited = waited + get_steptime()
    way = way_along(start, direction)
  end
  local measured = force()
  end_force_mode()
  stopl(3.0)
  if tripped != 0:
    return False
  elif way >= goal:
    textmsg(step, str_cat(": ", str_cat(done, str_cat(" after ", str_cat(waited, " s")))))
  elif measured > limit:
    return fail(str_cat(step, str_cat(": force ", str_cat(measured, str_cat(" N > ", str_cat(limit, " N"))))))
  else:
    return fail(str_cat(step, str_cat(": only ", str_cat(way, str_cat(how, str_cat(timeout, " s"))))))
  end
  return True
end

def force_insert(frame, direction, push, depth, speed, limit, timeout, step):
  return force_along(frame, direction, [0.0, 0.0, push], depth, speed, limit, timeout, "inserted", " m deep within ", step)
end

def force_extract(frame, direction, wrench, goal, speed, limit, timeout, step):
  return force_along(frame, direction, wrench, goal, speed, limit, timeout, "out", " m out within ", step)
end

# Watch the running slide: its end, the contact, the force and the time.
def watch_slide(direction, least, patience, limit, timeout, step):
  local waited = 0.0
  local lost = 0.0
  while not motion_done and force() <= limit and lost <= patience and waited < timeout and tripped == 0:
    sync()
    waited = waited + get_steptime()
    local f = get_tcp_force()
    lost = lost + get_steptime()
    if -(f[0] * direction[0] + f[1] * direction[1] + f[2] * direction[2]) >= least:
      lost = 0.0
    end
  end
  local measured = force()
  kill motion_thread
  stopl(3.0)
  end_force_mode()
  if tripped != 0:
    return False
  elif motion_done:
    return True
  elif measured > limit:
    return fail(str_cat(step, str_cat(": force ", str_cat(measured, str_cat(" N > ", str_cat(limit, " N"))))))
  elif lost > patience:
    return fail(str_cat(step, str_cat(": no contact for ", str_cat(lost, " s"))))
  end
  return fail(str_cat(step, str_cat(": not done within ", str_cat(timeout, " s"))))
end
"""


def call(step: SpiralSearch | ForceInsert | ForceExtract, poses: Names) -> str:
    """Write the URScript call of a force-controlled step; the call returns True if the step succeeded."""
    frame = Pose((0.0, 0.0, 0.0), step.frame.quaternion)
    match step:
        case SpiralSearch():
            name = "spiral_search"
            own = [*map(number, (step.force, step.pitch, step.radius, step.speed, step.advance))]
            said = f"press {step.force:g} N, radius up to {1000 * step.radius:.1f} mm, until it gives way by {1000 * step.advance:g} mm"
        case ForceInsert():
            name = "force_insert"
            own = [*map(number, (step.force, step.depth, step.speed))]
            said = f"push {step.force:g} N, {1000 * step.depth:.1f} mm deep"
        case ForceExtract():
            name = "force_extract"
            own = [vector((*step.across, step.force)), *map(number, (step.way, step.speed))]
            said = f"pull {step.force:g} N, {1000 * step.way:.1f} mm out"
    own_frame = poses.of(step.origin, "frame", pose(frame))
    values = [own_frame, vector(along(frame)), *own, *map(number, (step.force_limit, step.timeout))]
    return f'{name}({", ".join(values)}, "{label(step.origin)}")  # {said}, at most {step.force_limit:g} N'


def along(frame: Pose) -> tuple[float, float, float]:
    """Return the z axis of a frame in the base frame (3,), a unit vector."""
    x, y, z = (float(v) for v in frame.rotate((0.0, 0.0, 1.0)))
    return x, y, z
