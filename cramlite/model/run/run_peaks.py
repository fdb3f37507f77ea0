"""Peak values of a run: how fast, how strongly and how far a program moves a robot."""

from __future__ import annotations

import numpy as np

from ...base.value import Value
from ..geometry import Floats
from .rollout import Rollout


class RunPeaks(Value):
    """Peak values of a run: speeds, forces and joint positions as measured, not as commanded.

    Args:
        seconds: until the last line ended.
        tool_speed: highest speed of the TCP [m/s], and ``tool_speed_line``, the line of the text that ran then.
        joint_speeds: highest of each joint [rad/s].
        lowest, highest: positions of each joint [rad].
        force: largest contact force at the TCP while the program ran [N], and ``force_line``.
        commanded: largest force that the program told the arm to apply in force mode [N]; 0 for none.
    """

    seconds: float
    tool_speed: float
    tool_speed_line: int
    joint_speeds: tuple[float, ...]
    lowest: tuple[float, ...]
    highest: tuple[float, ...]
    force: float
    force_line: int
    commanded: float = 0.0


def peaks_of(rollout: Rollout) -> RunPeaks | None:
    """Return the peak speeds, forces and joint positions of a run; None where it has no two samples, or no arm."""
    if len(rollout.times) < 2 or not rollout.joints.shape[1]:
        return None
    tool = np.linalg.norm(_rates(rollout.poses["effector"][:, :3], rollout.times), axis=1)
    joints = np.abs(_rates(rollout.joints, rollout.times))
    force, lines = force_while_running(rollout), np.asarray(rollout.lines)
    fastest, hardest, running = int(tool.argmax()), int(force.argmax()), np.flatnonzero(lines)
    commanded = 0.0 if rollout.commanded is None else float(rollout.commanded.max())
    return RunPeaks(
        float(rollout.times[running[-1]]) if len(running) else float(rollout.times[-1]),
        float(tool[fastest]), int(lines[fastest + 1]), tuple(joints.max(axis=0).tolist()),
        tuple(rollout.joints.min(axis=0).tolist()), tuple(rollout.joints.max(axis=0).tolist()),
        float(force[hardest]), int(lines[hardest]), commanded,
    )  # fmt: skip


def _rates(values: Floats, times: Floats) -> Floats:
    """Return the rates of change of values (N, n), each over two sampling periods.

    A sample is up to a control cycle late, which is 20 % of one period at 50 samples and 125 cycles a second;
    two periods are a whole number of cycles.
    """
    span = min(2, len(times) - 1)
    rates: Floats = (values[span:] - values[:-span]) / (times[span:] - times[:-span])[:, None]
    return rates


def force_while_running(rollout: Rollout) -> Floats:
    """Return the contact force at each sample (N,) [N]; 0 at samples at which the program was not running.

    A sample states the peak since the sample before, so the first sample after the program's end counts, too.
    """
    running = np.asarray(rollout.lines) > 0
    force: Floats = np.where(running | np.roll(running, 1), rollout.contact_force(), 0.0)
    return force
