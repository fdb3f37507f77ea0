"""Inverse kinematics of arms: all branches where a closed form is known, else many solutions.

Poses are of the tcp in the robot's base frame. Joint positions are tuples in the order of
``robot.joints`` [rad].
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
from .forward import (
    Joints,
    Table,
    conditioning,
    forward,
    frames,
    from_root,
    jacobian,
    jacobian_of,
    table,
    twist,
    well_conditioned,
)
from .reach import out_of_limits, reach_shortfall

TURN = 2 * math.pi
POLISH_M = 1e-9  # the Newton step stops below this position and rotation error [m, rad]
EXACT = 1e-6  # a branch whose error stays above this is no solution [m, rad]
SAME = 1e-5  # two branches nearer than this are one [rad]
NEAR = math.pi / 4  # Newton's method that ends within this of its seed stayed on the branch [rad]
SETTLING, SETTLED, FURTHEST = 40, 1e-3, 0.15
"""Largest number of steps of a self-motion, the size of a step below which the self-motion ends, and the
largest size of a step [rad]."""
LEADING = (0.1, 0.4)
"""Step between the poses through which inverse kinematics leads the tool along a straight line [m, rad]."""
STEPS = (0.48, 0.06)
"""Steps between the values at which the last of seven joints is locked [rad]: the second one is used where
the first one finds no solution."""


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
        columns = jacobian_of(chain, end)
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


def _analytic(robot: Robot, target: Pose) -> list[Joints]:
    wrist = from_root(robot, target).matrix
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
    wrist = from_root(robot, target).matrix
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
