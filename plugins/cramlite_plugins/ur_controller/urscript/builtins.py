"""URScript's built-in functions that need no robot: arithmetic, lists, strings and poses.

Names, parameters and meanings: the URScript manual (Universal Robots, e-Series 5.x), chapter
"Module urmath". A library maps names to functions; a function that is a generator blocks its thread
and yields once every control cycle until it is done.
"""

from __future__ import annotations

import builtins
import inspect
import math
import re
from collections.abc import Callable, Mapping
from typing import Any

from cramlite.model import Pose, Vector3

from .arithmetic import matrix
from .lists_and_strings import LISTS_AND_STRINGS
from .values import PoseValue, ScriptError, as_pose, from_pose, numbers, real, show, text, whole

Library = Mapping[str, Callable[..., Any]]


def blocks(function: Callable[..., Any]) -> bool:
    """Check whether a built-in function of URScript blocks the thread that calls it, for a control cycle or longer."""
    return inspect.isgeneratorfunction(function)


def norm(a: Any) -> float:
    """Return the norm of a list, the distance of a pose from the origin [m], or an absolute value."""
    if isinstance(a, PoseValue):
        a = list(a)[:3]
    return math.hypot(*(real(v, "norm") for v in a)) if isinstance(a, list) else abs(real(a, "norm"))


def length(v: Any) -> int:
    """Return the length of a list or a string."""
    if not isinstance(v, list | str):
        raise ScriptError(f"length needs a list or a string, not {show(v)}")
    return len(v)


def pose_trans(p_from: Any, p_from_to: Any) -> PoseValue:
    """Compose two poses: ``p_from_to`` is in the frame of ``p_from``."""
    return from_pose(as_pose(p_from, "pose_trans") * as_pose(p_from_to, "pose_trans"))


def pose_inv(p_from: Any) -> PoseValue:
    """Invert a pose."""
    return from_pose(as_pose(p_from, "pose_inv").inverse())


def pose_add(p_1: Any, p_2: Any) -> PoseValue:
    """Add two poses: positions are added, rotations composed, each in the base frame."""
    a, b = as_pose(p_1, "pose_add"), as_pose(p_2, "pose_add")
    return from_pose(Pose(_along(a, b.position, 1.0), (_turn(a) * _turn(b)).quaternion))


def pose_sub(p_to: Any, p_from: Any) -> PoseValue:
    """Subtract two poses: positions are subtracted, rotations relative, each in the base frame."""
    a, b = as_pose(p_to, "pose_sub"), as_pose(p_from, "pose_sub")
    return from_pose(Pose(_along(a, b.position, -1.0), (_turn(a) * _turn(b).inverse()).quaternion))


def pose_dist(pose_from: Any, pose_to: Any) -> float:
    """Return the distance of two poses' positions [m]."""
    return as_pose(pose_from, "pose_dist").distance(as_pose(pose_to, "pose_dist"))[0]


def point_dist(p_from: Any, p_to: Any) -> float:
    """Return the distance of two poses' positions [m]."""
    return as_pose(p_from, "point_dist").distance(as_pose(p_to, "point_dist"))[0]


def interpolate_pose(p_from: Any, p_to: Any, alpha: Any) -> PoseValue:
    """Interpolate linearly between two poses; ``alpha`` is 0 at the first, 1 at the second."""
    a, b, part = as_pose(p_from, "interpolate_pose"), as_pose(p_to, "interpolate_pose"), real(alpha, "interpolate_pose")
    way = _along(b, a.position, -1.0)
    step = Pose.from_rotvec((0, 0, 0), [part * v for v in (_turn(a).inverse() * _turn(b)).rotvec])
    return from_pose(Pose(_along(a, way, part), (_turn(a) * step).quaternion))


def inv(m: Any) -> Any:
    """Invert a pose, or a square matrix."""
    import numpy as np

    if isinstance(m, PoseValue):
        return pose_inv(m)
    rows = np.array(matrix(m, "inv"), float)
    if rows.shape[0] != rows.shape[1] or np.linalg.matrix_rank(rows) < len(rows):
        raise ScriptError(f"inv needs a pose or a square matrix that has an inverse, not {show(m)}")
    return np.linalg.inv(rows).tolist()


def rpy2rotvec(rpy_vector: Any) -> list[float]:
    """Convert roll, pitch and yaw [rad], turns about the fixed axes x, y and z in this order, to a rotation vector."""
    roll, pitch, yaw = numbers(rpy_vector, 3, "rpy2rotvec")
    about = [Pose.from_rotvec((0, 0, 0), v) for v in ((0, 0, yaw), (0, pitch, 0), (roll, 0, 0))]
    return list((about[0] * about[1] * about[2]).rotvec)


def rotvec2rpy(rotation_vector: Any) -> list[float]:
    """Convert a rotation vector to roll, pitch and yaw [rad] about the fixed axes.

    Yaw is 0 at a pitch of 90 degrees up or down, where it is not determined.
    """
    r = Pose.from_rotvec((0, 0, 0), numbers(rotation_vector, 3, "rotvec2rpy")).rotation
    along = math.hypot(r[0, 0], r[1, 0])
    pitch = math.atan2(-r[2, 0], along)
    if along < 1e-9:
        return [math.atan2(-r[1, 2], r[1, 1]), pitch, 0.0]
    return [math.atan2(r[2, 1], r[2, 2]), pitch, math.atan2(r[1, 0], r[0, 0])]


def _turn(pose: Pose) -> Pose:
    return Pose((0, 0, 0), pose.quaternion)


def _along(start: Pose, way: Vector3, share: float) -> Vector3:
    (x, y, z), (u, v, w) = start.position, way
    return (x + share * u, y + share * v, z + share * w)


def str_cat(op1: Any, op2: Any) -> str:
    """Concatenate two values as strings."""
    return text(show(op1) + show(op2))


def to_str(val: Any) -> str:
    """Convert a value to a string."""
    return show(val)


def to_num(str: Any) -> float | int:
    """Convert a string to a number."""
    if not isinstance(str, builtins.str) or not re.fullmatch(r"[+-]?\d+(\.\d*)?([eE][+-]?\d{1,2})?", str, re.ASCII):
        raise ScriptError(f"to_num: {show(str)!r} is no number")
    return whole(int(str)) if str.lstrip("+-").isdigit() else float(str)


def floor(f: Any) -> int:
    """Round down to an integer."""
    return math.floor(real(f, "floor"))


def ceil(f: Any) -> int:
    """Round up to an integer."""
    return math.ceil(real(f, "ceil"))


def pow(base: Any, exponent: Any) -> float:
    """Raise a base to an exponent."""
    return math.pow(real(base, "pow"), real(exponent, "pow"))


def _real_function(name: str, function: Callable[[float], float]) -> Callable[[Any], float]:
    def call(f: Any) -> float:
        return function(real(f, name))

    return call


_REAL = {
    "sqrt": math.sqrt, "sin": math.sin, "cos": math.cos, "tan": math.tan, "asin": math.asin, "acos": math.acos,
    "atan": math.atan, "d2r": math.radians, "r2d": math.degrees,
}  # fmt: skip


def atan2(x: Any, y: Any) -> float:
    """Return the arc tangent of x / y with the signs of both [rad]."""
    return math.atan2(real(x, "atan2"), real(y, "atan2"))


def log(b: Any, f: Any) -> float:
    """Return the logarithm of ``f`` to the base ``b``."""
    return math.log(real(f, "log"), real(b, "log"))


PURE: Library = {
    **{name: _real_function(name, function) for name, function in _REAL.items()},
    **{
        f.__name__: f
        for f in (
            norm, length, pose_trans, pose_inv, pose_add, pose_sub, pose_dist, point_dist, interpolate_pose,
            str_cat, to_str, to_num, floor, ceil, pow, atan2, log, inv, rpy2rotvec, rotvec2rpy,
        )
    },
    **LISTS_AND_STRINGS,
}  # fmt: skip
