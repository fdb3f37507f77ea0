"""Comparison of a real arm's log with the run that was proven: where, by how much and when they diverge.

Both are put on one time: the offset is that at which joints differ least, where a difference of more than twice what is allowed
counts as twice (a grid over all offsets, then around the best one ever finer). So what agrees lies on one another, however far the
rest is off. Nothing is stretched: a program that runs slower than proven parts.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...base.errors import UserError
from ...base.value import Value
from ...model.geometry import Floats
from ...model.run.rollout import Rollout
from .rtde_log import RtdeLog

STEP = 0.02
"""Step of the time grid on which log and run are aligned and compared [s]. It is as dense as the samples of rollouts."""
PARTS = 0.02
"""Difference of a joint's position beyond which log and run diverge [rad]: 20 mm at the tool of an arm that reaches 1 m. A real arm follows
within a tenth of that."""


class Compared(Value):
    """Quantity that is compared, with its values in the log and in the run.

    Args:
        name: of the quantity, with its unit.
        logged, ran: (N,) over the common times.
        worst: the largest difference, and when it was.
    """

    name: str
    unit: str
    logged: Floats
    ran: Floats
    worst: tuple[float, float]


class RunComparison(Value):
    """Comparison of a real arm's log with a simulated run, on one time axis.

    Args:
        times: (N,) of the run [s].
        offset: time of the log at the run's start [s].
        lasts: how long the arm moves, in the log and in the run [s].
        compared: joints, joint speeds, and what else both have.
        parts: when a joint first differs by more than is allowed [s], which one, by how much [rad], and the program's line;
            None where none does.
        within: what is allowed [rad].
    """

    times: Floats
    offset: float
    lasts: tuple[float, float]
    compared: tuple[Compared, ...]
    parts: tuple[float, str, float, int] | None
    within: float


def compare_run(log: RtdeLog, rollout: Rollout, names: Sequence[str], within: float = PARTS) -> RunComparison:
    """Compare a recording of a robot's RTDE data with a simulated run: joints, speeds and forces over time.

    Args:
        names: of the joints.
        within: by how much joints may differ [rad].

    Raises:
        UserError: they are of different arms, or the log is too short.
    """
    if log.joints.shape[1] != rollout.joints.shape[1]:
        raise UserError(f"The log has {log.joints.shape[1]} joints, the run's robot {rollout.joints.shape[1]}; are both of one arm?")
    begin, end = moving(rollout.times, rollout.joints)
    if log.times[-1] < 0.5 * (end - begin):
        raise UserError(f"The log lasts {log.times[-1]:.1f} s, the run moves for {end - begin:.1f} s; log the whole program.")
    offset = _offset(log, rollout, (begin, end), 2 * within)
    times = _common(log, rollout, offset)
    joints = [_both(f"'{n}'", "rad", times, log.joints[:, k], rollout.joints[:, k], log, rollout, offset) for k, n in enumerate(names)]
    speeds = [_speed(c, times) for c in joints]
    more = []
    if log.force is not None:
        more.append(_both("force at the tool", "N", times, log.force, rollout.contact_force(), log, rollout, offset))
    first, last = moving(log.times, log.joints)
    lasts = (last - first, end - begin)
    return RunComparison(times, offset, lasts, (*joints, *speeds, *more), _parts(joints, times, rollout, within), within)


def moving(times: Floats, joints: Floats) -> tuple[float, float]:
    """Return when an arm leaves its first joint position, and when it reaches its last one [s]; first and
    last time if it stands still."""
    first = np.flatnonzero(np.abs(joints - joints[0]).max(axis=1) > 1e-3)
    last = np.flatnonzero(np.abs(joints - joints[-1]).max(axis=1) > 1e-3)
    return (float(times[first[0]]), float(times[last[-1]])) if first.size and last.size else (float(times[0]), float(times[-1]))


def _offset(log: RtdeLog, rollout: Rollout, moves: tuple[float, float], most: float) -> float:
    """Return the time in the real arm's log that matches the start of the simulated run [s]."""
    begin, end = moves
    moments = np.arange(begin, end, STEP)
    wanted = _at(rollout.times, rollout.joints, moments)

    def misses(offset: float) -> float:
        far = np.abs(_at(log.times, log.joints, moments + offset) - wanted).max(axis=1)
        return float(np.minimum(far, most).mean())

    tried = np.arange(-end, log.times[-1] - begin + STEP, STEP)
    best = float(min(tried, key=misses))
    for step in (STEP / 5, STEP / 25):
        best = float(min((best + step * k for k in range(-6, 7)), key=misses))
    return best


def _common(log: RtdeLog, rollout: Rollout, offset: float) -> Floats:
    """Return the times since the simulated run's start that the real arm's log covers, too (N,) [s]."""
    first, last = max(0.0, -offset), min(float(rollout.times[-1]), float(log.times[-1]) - offset)
    return np.arange(first, max(last, first + STEP), STEP)


def _at(times: Floats, rows: Floats, moments: Floats) -> Floats:
    """Interpolate joint positions (N, J) at other times; outside the given times the first or last position holds."""
    return np.column_stack([np.interp(moments, times, rows[:, k]) for k in range(rows.shape[1])])


def _both(
    name: str, unit: str, times: Floats, logged: Floats, ran: Floats, log: RtdeLog, rollout: Rollout, offset: float
) -> Compared:  # fmt: skip
    return _compared(name, unit, times, np.interp(times + offset, log.times, logged), np.interp(times, rollout.times, ran))


def _speed(joint: Compared, times: Floats) -> Compared:
    """Speed of a joint in the log and in the run, computed from differences of its positions."""
    return _compared(f"speed of {joint.name}", "rad/s", times, np.gradient(joint.logged, STEP), np.gradient(joint.ran, STEP))


def _compared(name: str, unit: str, times: Floats, logged: Floats, ran: Floats) -> Compared:
    far = np.abs(logged - ran)
    worst = int(far.argmax())
    return Compared(name, unit, logged, ran, (float(far[worst]), float(times[worst])))


def _parts(joints: Sequence[Compared], times: Floats, rollout: Rollout, within: float) -> tuple[float, str, float, int] | None:
    """Time at which a joint in the real arm's log first differs by more than is allowed from the proven run,
    with the joint, the difference and the program's line."""
    far = np.array([np.abs(c.logged - c.ran) for c in joints])
    over = np.flatnonzero(far.max(axis=0) > within)
    if not over.size:
        return None
    k = int(over[0])
    joint = int(far[:, k].argmax())
    sample = min(int(np.searchsorted(rollout.times, times[k])), len(rollout.times) - 1)
    return float(times[k]), joints[joint].name, float(far[joint, k]), int(rollout.lines[sample])
