"""Kinematics of arms: forward, Jacobian, and the inverse: all branches where a closed form is known, else
many solutions.

Frames: poses are of the tool centre point (tcp, the pinch point of the gripper) in the
robot's base frame. Joint positions are tuples in the order of ``robot.joints`` [rad].

The model is the standard Denavit-Hartenberg table of the robot plugin (Denavit and
Hartenberg 1955; Siciliano et al., Robotics, 2009, section 2.8.2):
T_i = Rz(q_i) Tz(d_i) Tx(a_i) Rx(alpha_i), behind ``Robot.root``.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator, Sequence
from functools import lru_cache
from operator import sub
from typing import Any

import numpy as np
from msgspec.structs import replace

from cramlite.model import Floats, Pose, Robot

from . import numeric_inverse
from .arm_inertia import inertia

Joints = tuple[float, ...]
Table = tuple[tuple[float, float, float], ...]

TURN = 2 * math.pi
POLISH_M = 1e-9  # the Newton step stops below this position and rotation error [m, rad]
EXACT = 1e-6  # a branch whose error stays above this is no solution [m, rad]
SAME = 1e-5  # two branches nearer than this are one [rad]
NEAR = math.pi / 4  # Newton's method that ends within this of its seed stayed on the branch [rad]
SETTLING, SETTLED, FURTHEST = 40, 1e-3, 0.15
"""Largest number of steps of a self-motion, the size of a step below which the self-motion ends, and the
largest size of a step [rad]."""
BEYOND = -0.5
"""Cosine of a rotation's angle below which the rotation vector is computed by a quaternion, in three times
the time."""
ASTRAY = 0.05
"""Largest difference of a joint from the value at which the arm settles, for controllers that are given TCP
poses [rad]: it was the worst of 100 rests in LIBERO."""
LEADING = (0.1, 0.4)
"""Step between the poses through which inverse kinematics leads the tool along a straight line [m, rad]."""
STEPS = (0.48, 0.06)
"""Steps between the values at which the last of seven joints is locked [rad]: the second one is used where
the first one finds no solution."""


def table(robot: Robot) -> Table:
    """Return the Denavit-Hartenberg rows of a robot.

    Raises:
        ValueError: the robot has none: its inverse has to be found numerically.
    """
    if robot.dh is None:
        raise ValueError(
            f"robot '{robot.type}' has no Denavit-Hartenberg table, so it has no analytic kinematics"
        )
    return robot.dh


def frames(robot: Robot, q: Sequence[float] | Floats) -> list[Floats]:
    """Compute the (4, 4) frames 0 (``Robot.root``) to n (flange) in the base frame."""
    still = _links(table(robot))
    x, y, links = still[:, 0], still[:, 1], still.copy()
    angles = np.asarray(q, dtype=float)[:, None]
    cos, sin = np.cos(angles), np.sin(angles)
    links[:, 0], links[:, 1] = cos * x - sin * y, sin * x + cos * y
    result = [robot.root.matrix]
    for link in links:
        result.append(result[-1].dot(link))  # half the time of @
    return result


@lru_cache(maxsize=512)
def _links(rows: Table) -> Floats:
    """Return the transform of each link in the frame of the link before it, with all joints at 0: (n, 4, 4).

    A joint's angle turns the first two rows.
    """
    found = np.zeros((len(rows), 4, 4))
    for link, (a, d, alpha) in zip(found, rows, strict=True):
        ca, sa = math.cos(alpha), math.sin(alpha)
        link[:] = ((1.0, 0.0, 0.0, a), (0.0, ca, -sa, 0.0), (0.0, sa, ca, d), (0.0, 0.0, 0.0, 1.0))
    return found


def flange(robot: Robot, q: Sequence[float]) -> Pose:
    """Solve forward kinematics: the pose of the flange in the base frame."""
    return Pose.from_matrix(frames(robot, q)[-1])


def forward(robot: Robot, q: Sequence[float]) -> Pose:
    """Solve forward kinematics: the pose of the tcp in the base frame."""
    return Pose.from_matrix(frames(robot, q)[-1] @ robot.gripper.tcp.matrix)


def jacobian(robot: Robot, q: Sequence[float]) -> Floats:
    """Compute the geometric Jacobian (6, n) at the tcp in the base frame: rows linear [m/rad], then angular
    [rad/rad].

    Column i is (z_i x (p - p_i), z_i) (Siciliano et al., 2009, equation 3.30).
    """
    chain = np.array(frames(robot, q))
    return _jacobian(chain, chain[-1] @ robot.gripper.tcp.matrix)


def _jacobian(chain: Floats, end: Floats) -> Floats:
    x, y, z = axes = chain[:-1, :3, 2].T
    u, v, w = (end[:3, 3] - chain[:-1, :3, 3]).T
    return np.vstack([y * w - z * v, z * u - x * w, x * v - y * u, axes])  # np.cross takes five times as long


def twist(from_: Floats, to: Floats) -> Floats:
    """Compute the twist from one (4, 4) frame to another: (6,) translation [m] and rotation vector [rad],
    parent axes."""
    (a, b, c), (d, e, f), (g, h, i) = (to[:3, :3] @ from_[:3, :3].T).tolist()
    x, y, z, cosine = (h - f) / 2, (c - g) / 2, (d - b) / 2, (a + e + i - 1) / 2
    sine = math.hypot(x, y, z)
    if cosine < BEYOND:
        turn = Pose.from_matrix(
            to[:3, :3] @ from_[:3, :3].T
        ).rotvec  # near half a turn the axis is not in these
    else:
        scale = math.atan2(sine, cosine) / sine if sine > 1e-12 else 1.0
        turn = (scale * x, scale * y, scale * z)
    return np.array((*(to[:3, 3] - from_[:3, 3]).tolist(), *turn))


def smallest_singular_value(robot: Robot, q: Sequence[float]) -> float:
    """Return the smallest singular value of the Jacobian, lengths in units of the robot's reach: 0 at a
    singularity."""
    scaled = jacobian(robot, q) / np.array([robot.reach] * 3 + [1.0] * 3)[:, None]
    return float(np.linalg.svd(scaled, compute_uv=False)[-1])


def conditioning(robot: Robot, q: Sequence[float]) -> float:
    """Return the smallest singular value of the arm's Jacobian; it is 0 at a singularity.

    For a seven-axis arm whose controller is given TCP poses, it is the smallest value within ``ASTRAY`` along
    the null space.
    """
    if robot.posture is None or len(q) < 7:
        return smallest_singular_value(robot, q)
    beside = np.linalg.svd(jacobian(robot, q))[2][6]
    beside *= ASTRAY / np.abs(beside).max()
    return min(smallest_singular_value(robot, near) for near in (q, q + beside, q - beside))


def well_conditioned(robot: Robot, q: Sequence[float]) -> bool:
    """Check whether joint positions are as far from a singularity as the robot must stay
    (``Robot.conditioning``)."""
    return not robot.conditioning or conditioning(robot, q) >= robot.conditioning


def refine(
    robot: Robot, target: Pose, q: Sequence[float], steps: int = 6, held: int | None = None
) -> Joints | None:
    """Refine a near inverse kinematics solution by Newton's method: q += J^+ twist, the least-norm step if
    redundant.

    Args:
        held: a joint that stays where it is.

    Returns:
        Joint positions with an error below 1e-6 m and 1e-6 rad; None where they do not converge.
    """
    goal, tool, joints = target.matrix, robot.gripper.tcp.matrix, np.array(q, dtype=float)
    for step in range(steps + 1):
        chain = np.array(frames(robot, joints))
        end = chain[-1] @ tool
        error = twist(end, goal)
        if (size := float(np.abs(error).max())) < POLISH_M or step == steps:
            return tuple(map(float, joints)) if size < EXACT else None
        columns = _jacobian(chain, end)
        if held is not None:
            columns[:, held] = 0.0
        joints = joints + np.linalg.lstsq(columns, error, rcond=1e-6)[0]
    return None


@lru_cache(maxsize=512)
def _solver(rows: Table, last: float | None = None) -> Any:
    """Return the analytic inverse kinematics of a Denavit-Hartenberg table (EAIK: Ostermeier et al., IEEE
    RA-L 2024).

    Of seven joints, the last one is locked at the angle ``last``.
    """
    from eaik.IK_DH import DhRobot

    a, d, alpha = np.array(rows, dtype=float).T
    return DhRobot(alpha, a, d, [] if last is None else [(len(rows) - 1, last)])


def has_closed_form(robot: Robot) -> bool:
    """Check whether the inverse is known in closed form: of six joints whose axes meet or are parallel in a
    way that EAIK knows.

    Raises:
        ValueError: the robot has no DH table.
    """
    rows = table(robot)
    return len(rows) == 6 and bool(_solver(rows).hasKnownDecomposition())


def inverse(robot: Robot, target: Pose, *, seed: Sequence[float] | None = None) -> tuple[Joints, ...]:
    """Solve inverse kinematics for the tcp: all solutions where a closed form is known, else many.

    Of an arm that its controller leads by the tool (``Robot.posture``) it is the one that it takes, and no
    other.

    Else every branch of the analytic solution is polished below 1e-6 m, and every whole turn that stays
    inside the joint limits is a solution of its own. Of seven joints the last is locked at every value of a
    grid, where a closed form is known for the others (``numeric_inverse`` for other arms), and the position
    nearest to the seed is looked for as well. Solutions nearer to a singularity than the robot's
    ``conditioning`` are left out.

    Args:
        target: of the tcp in the base frame.
        seed: joint positions; the solutions come sorted by their distance to it (largest joint
            difference first). None sorts by the distance to the robot's home.

    Returns:
        Solutions, nearest first; empty when there is none (see ``why_no_inverse``).

    Raises:
        ValueError: the robot has no DH table.
    """
    near = robot.home if seed is None else tuple(seed)
    if robot.posture is not None:
        branches = [
            q
            for q in (held_posture(robot, target),)
            if q and numeric_inverse.inside(robot, q) and well_conditioned(robot, q)
        ]
    elif has_closed_form(robot):
        branches = [q for q in _analytic(robot, target) if well_conditioned(robot, q)]
    else:
        own = refine(robot, target, near, steps=12)
        held = own is not None and numeric_inverse.inside(robot, own) and well_conditioned(robot, own)
        branches = [*_many(robot, target), *([own] if own and held else [])]
    turned = [w for branch in branches for w in _turns(robot, branch)]
    far = np.abs(np.array(turned).reshape(-1, len(near)) - near).max(axis=1)
    return tuple(turned[k] for k in np.argsort(far, kind="stable"))


@lru_cache(maxsize=4096)
def held_posture(robot: Robot, target: Pose) -> Joints | None:
    """Solve inverse kinematics as a controller does that is given TCP poses and keeps the arm near
    ``Robot.posture``.

    The posture task acts in the dynamically consistent null space of the tool's (Khatib, IEEE J-RA 1987), so
    the arm comes to rest where no self-motion n has a share of what is left: n^T M (posture - q) = 0. Limits
    are not checked.

    Returns:
        Joint positions; None where the tool cannot be led there from the posture.
    """
    assert robot.posture is not None
    if reach_shortfall(robot, target):
        return None
    q, share, before = refine(robot, target, robot.posture, steps=12), 1.0, np.zeros(len(robot.joints))
    if q is None or not numeric_inverse.inside(robot, q):
        q = _led(robot, target, robot.posture)
    for _ in range(SETTLING if len(robot.joints) > 6 else 0):
        if q is None:
            return None
        way = _self_motion(robot, q, np.subtract(robot.posture, q))
        if (size := float(np.abs(way).max())) < SETTLED:
            break
        share, before = share / 2 if way @ before < 0 else share, way  # it went too far
        q = refine(robot, target, tuple(q + min(share, FURTHEST / size) * way), steps=8)
    return q


def _led(robot: Robot, target: Pose, posture: Joints) -> Joints | None:
    """Lead the tool from a posture straight to a pose, in steps of least norm, and return the joint positions
    at the end; None if a step has no solution."""
    start = forward(robot, posture)
    q: Joints | None = posture
    shift, turn = np.subtract(target.position, start.position), np.asarray((start.inverse() * target).rotvec)
    count = max(
        1, math.ceil(np.linalg.norm(shift) / LEADING[0]), math.ceil(np.linalg.norm(turn) / LEADING[1])
    )
    for part in np.arange(1, count) / count:
        turned = Pose.at((0.0, 0.0, 0.0), start) * Pose.from_rotvec((0.0, 0.0, 0.0), part * turn)
        q = q and refine(robot, Pose.at(start.position + part * shift, turned), q)
    return q and refine(robot, target, q, steps=12)


def _self_motion(robot: Robot, q: Joints, way: Floats) -> Floats:
    """Return the part of a joint-space displacement that leaves the tool where it is, found with the arm's
    inertia as weight."""
    null = np.linalg.svd(jacobian(robot, q))[2][6:]
    weighted = null @ inertia(robot, q)
    return np.asarray(np.linalg.solve(weighted @ null.T, weighted @ way) @ null)


def _from_root(robot: Robot, target: Pose) -> Pose:
    """Pose of the flange in frame 0 of the Denavit-Hartenberg table, for a pose of the TCP in the base
    frame."""
    return robot.root.inverse() * target * robot.gripper.tcp.inverse()


def _analytic(robot: Robot, target: Pose) -> list[Joints]:
    wrist = _from_root(robot, target).matrix
    branches: list[Joints] = []
    for raw in np.atleast_2d(_solver(table(robot)).IK(wrist).Q):
        found = refine(robot, target, raw) if raw.size else None
        if found is not None and not any(_same(found, b) for b in branches):
            branches.append(found)
    return branches


@lru_cache(maxsize=1024)
def _many(robot: Robot, target: Pose) -> tuple[Joints, ...]:
    """Inverse solutions of an arm without a closed form, cached: a search asks for the same few poses
    again and again, from different seeds."""
    rows = table(robot)
    if len(rows) == 7 and _solver(rows, 0.0).hasKnownDecomposition():
        grids = (
            []
            if reach_shortfall(robot, target)
            else [numeric_inverse.grid(robot.limits[-1], step) for step in STEPS]
        )
        return _well(
            robot, next((found for values in grids if (found := tuple(_locked(robot, target, values)))), ())
        )

    def exact(q: Sequence[float], held: int | None) -> Joints | None:
        return refine(robot, target, q, steps=8, held=held)

    return _well(robot, numeric_inverse.solutions(robot, target * robot.gripper.tcp.inverse(), exact))


def _well(robot: Robot, found: Iterable[Joints]) -> tuple[Joints, ...]:
    return tuple(q for q in found if well_conditioned(robot, q))


def _locked(robot: Robot, target: Pose, values: Iterable[float]) -> Iterator[Joints]:
    """All solutions inside the limits for given values of the last joint. The solver's least-squares
    answers are dropped: none of 497, over 120 poses of a Panda, could be refined to a solution."""
    wrist = _from_root(robot, target).matrix
    for last in values:
        here: list[Joints] = []
        solved = _solver(table(robot), last).IK(wrist)
        exact = (
            []
            if not np.size(solved.Q)
            else np.atleast_2d(solved.Q)[~np.atleast_1d(np.array(solved.is_LS, dtype=bool))]
        )
        for raw in exact:
            for turned in _turns(robot, tuple(raw.tolist())):
                found = refine(robot, target, turned, held=len(turned) - 1)
                if (
                    found
                    and numeric_inverse.inside(robot, found)
                    and not any(_same(found, other) for other in here)
                ):
                    here.append(found)
        yield from here


def nearest_branch(robot: Robot, target: Pose, seed: Sequence[float]) -> Joints | None:
    """Solve inverse kinematics on the branch of joint position ``seed``, by Newton's method from it; None if
    that does not converge. Joint limits are not checked."""
    return refine(robot, target, seed, steps=12)


def nearest_solution(robot: Robot, target: Pose, seed: Sequence[float]) -> Joints | None:
    """Solve inverse kinematics as near to joint position ``seed`` as possible, on any branch; singular
    positions are solutions, too.

    Newton's method finds what is near; from farther away it ends on any branch or on none, and the closed
    form is asked.
    """
    own = nearest_branch(robot, target, seed)
    if not has_closed_form(robot) or (own is not None and max(map(abs, map(sub, own, seed))) < NEAR):
        return own
    return next(iter(inverse(replace(robot, conditioning=0.0), target, seed=seed)), own)


def _same(a: Joints, b: Joints) -> bool:
    return all(abs(math.remainder(x - y, TURN)) < SAME for x, y in zip(a, b, strict=True))


def unturned(q: Sequence[float]) -> Joints:
    """Return joint positions with the same posture, each nearest to 0 [rad]: the same ones, to 1e-12, for all
    that differ by whole turns."""
    return tuple(round(math.remainder(v, TURN), 12) for v in q)


def postures(found: Iterable[Joints]) -> dict[Joints, Joints]:
    """Return of joint positions that differ by whole turns the first, by what ``unturned`` makes of them."""
    first = dict[Joints, Joints]()
    for q in found:
        first.setdefault(unturned(q), q)
    return first


def _turns(robot: Robot, q: Joints) -> list[Joints]:
    """Joint positions that differ from the given one by whole turns, wherever the limits allow it; the
    given one included."""
    choices = []
    for value, (low, high) in zip(q, robot.limits, strict=True):
        first, last = math.ceil((low - value) / TURN - 1e-12), math.floor((high - value) / TURN + 1e-12)
        choices.append([min(max(value + TURN * k, low), high) for k in range(first, last + 1)])  # rounding
    return list(itertools.product(*choices))


def why_no_inverse(robot: Robot, target: Pose) -> str:
    """Explain in words and numbers why ``inverse`` has no solution for a pose."""
    if short := reach_shortfall(robot, target):
        return short
    if (
        robot.posture is not None
        and (q := held_posture(robot, target))
        and (outside := out_of_limits(robot, q))
    ):
        return f"with the tool led there, {outside}"
    found = inverse(replace(robot, conditioning=0.0), target) if robot.conditioning else ()
    if not found:
        return "no inverse solution: the wrist cannot be turned that way there"
    best = max(conditioning(robot, q) for q in found)
    return (
        f"all {len(found)} inverse solutions are near a singularity (smallest singular value {best:.3f}, "
        f"limit {robot.conditioning})"
    )


def reach_shortfall(robot: Robot, target: Pose) -> str:
    """Explain in words and numbers why a pose is out of reach; "" if the wrist centre is within reach."""
    return reach_gap(robot, target)[1]


def reach_gap(robot: Robot, target: Pose) -> tuple[float, str]:
    """Return by how much a pose is out of reach [m], negative if it is too near, with an explanation in
    numbers.

    It is (0, "") for a pose within reach.

    For a six-axis arm whose joints 2 to 4 are parallel, the wrist centre (the origin of frame 5, on the axis
    of joint 6 behind the flange) lies within the annulus that both links and the offset along joint 4 span
    around the shoulder (Hawkins, Analytic Inverse Kinematics for the Universal Robots UR-5/UR-10 Arms, 2013).
    For other arms the root of the last axis lies within what the joints before it span around joint 2
    (``numeric_inverse.span``).
    """
    rows = table(robot)
    wrist = _from_root(robot, target) * Pose((0.0, 0.0, -rows[-1][1]))
    x, y, z = wrist.position
    if len(rows) != 6 or not _parallel(rows):
        out, most = math.hypot(x, y, z - rows[0][1]), abs(rows[0][0]) + numeric_inverse.span(robot)
        return (
            (out - most, f"wrist at {out:.3f} m > {most:.3f} m from the shoulder of '{robot.type}'")
            if out > most
            else (0.0, "")
        )
    around, side = math.hypot(x, y), abs(rows[1][1] + rows[2][1] + rows[3][1])
    if around < side:
        return (
            around - side,
            f"wrist centre {around:.3f} m < {side:.3f} m from the base axis of '{robot.type}'",
        )
    out = math.hypot(math.sqrt(around**2 - side**2), z - rows[0][1])
    links, elbow = abs(rows[1][0]) + abs(rows[2][0]), abs(rows[4][1])
    if out > links + elbow:
        return (
            out - links - elbow,
            f"wrist centre at {out:.3f} m > {links + elbow:.3f} m of arm '{robot.type}'",
        )
    return 0.0, ""


def _parallel(rows: Table) -> bool:
    """Whether the axes of joints 2, 3 and 4 are parallel and all other neighbouring axes intersect, as on a
    UR arm."""
    return rows[1][2] == rows[2][2] == 0.0 and rows[0][0] == rows[3][0] == rows[4][0] == 0.0


def out_of_limits(robot: Robot, q: Sequence[float]) -> str:
    """Name the first joint outside its limits, with value and limits; "" if all joints are inside."""
    for name, value, (low, high) in zip(robot.joints, q, robot.limits, strict=True):
        if not low <= value <= high:
            return f"joint '{name}' at {value:.3f} rad is outside {low:.3f} .. {high:.3f} rad"
    return ""
