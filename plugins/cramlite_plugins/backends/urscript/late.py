"""Late-bound poses in URScript: asked of a perception server at the start, and refused outside the tolerance.

The server speaks text on a socket: "POSE name" is answered by the thing's pose in the base frame, six floats
"(x, y, z, rx, ry, rz)" [m, rad], as ``socket_read_ascii_float`` reads them (URScript manual); an unknown thing by "()".
"""

from __future__ import annotations

import re

from cramlite.model import LatePose, Program

from .literals import label, number, pose

PORT = 50010
FUNCTIONS = f"""
# ---- functions of late poses ----
# Where a thing is now, from the perception server; only so near to where it was planned that the motions were checked.
def ask_pose(thing, planned, distance, angle):
  if not socket_open("127.0.0.1", {PORT}, "perception"):
    abort("no perception server at 127.0.0.1:{PORT}")
  end
  socket_send_line(str_cat("POSE ", thing), "perception")
  local said = socket_read_ascii_float(6, "perception", 5.0)
  socket_close("perception")
  if said[0] != 6:
    abort(str_cat("the perception server does not see ", thing))
  end
  local found = p[said[1], said[2], said[3], said[4], said[5], said[6]]
  local off = point_dist(planned, found)
  if off > distance:
    abort(str_cat(str_cat(thing, str_cat(" is ", off)), str_cat(" m from where it was planned, more than ", str_cat(distance, " m"))))
  end
  local turn = pose_trans(pose_inv(planned), found)
  local turned = norm([turn[3], turn[4], turn[5]])
  if turned > angle:
    abort(str_cat(str_cat(thing, str_cat(" is turned by ", turned)), str_cat(" rad, more than ", str_cat(angle, " rad"))))
  end
  textmsg(thing, str_cat(" is ", str_cat(off, " m from where it was planned")))
  return pose_trans(found, pose_inv(planned))
end
"""


def asking(program: Program) -> list[str]:
    """Write the global variables that hold how each thing with a late-bound pose has moved since planning."""
    if not program.late:
        return []
    lines = ["", "# ---- late poses: how each thing has moved since this was planned, base frame ----"]
    return lines + [f"global {shift(late.thing)} = ask_pose({_asked(late)})" for late in program.late]


def _asked(late: LatePose) -> str:
    """Return the arguments of ``ask_pose`` for a late-bound pose, its tolerances widened by 1 mm and 0.01 rad
    for noise."""
    distance, angle = late.tolerance
    return f'"{label(late.thing)}", {pose(late.pose)}, {number(distance + 0.001)}, {number(angle + 0.01)}'


def shift(thing: str) -> str:
    """Return the name of the URScript variable that holds how far a thing is from where the plan has it."""
    return "moved_" + re.sub(r"\W", "_", thing)
