"""Peaks of a run: how fast, how strongly and how far a program moves a robot."""

from __future__ import annotations

from ..base.value import Value
from .rollout import Rollout


class RunPeaks(Value):
    """Peaks of a run, as the robot moved and not as it was told to.

    Args:
        seconds: until the last line ended.
        tool_speed: highest speed of the TCP [m/s], and ``tool_speed_line``, the line of the text that ran then.
        joint_speeds: highest of each joint [rad/s].
        lowest, highest: positions of each joint [rad].
        force: largest contact force at the TCP [N], and ``force_line``.
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
    """Measure the peaks of a run; None where it has no two samples, or no arm."""
    import numpy as np

    if len(rollout.times) < 2 or not rollout.joints.shape[1]:
        return None
    steps = np.diff(rollout.times)
    tool = np.linalg.norm(np.diff(rollout.poses["effector"][:, :3], axis=0), axis=1) / steps
    joints = np.abs(np.diff(rollout.joints, axis=0)) / steps[:, None]
    force, lines = rollout.contact_force(), np.asarray(rollout.lines)
    fastest, hardest, running = int(tool.argmax()), int(force.argmax()), np.flatnonzero(lines)
    commanded = 0.0 if rollout.commanded is None else float(rollout.commanded.max())
    return RunPeaks(
        float(rollout.times[running[-1]]) if len(running) else float(rollout.times[-1]),
        float(tool[fastest]), int(lines[fastest]), tuple(joints.max(axis=0).tolist()),
        tuple(rollout.joints.min(axis=0).tolist()), tuple(rollout.joints.max(axis=0).tolist()),
        float(force[hardest]), int(lines[hardest]), commanded,
    )  # fmt: skip
