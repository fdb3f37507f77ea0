"""Check of a robot that was read from a file against the file itself."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np

from cramlite.model import ImportedRobot, Pose, RobotFile

from ...kinematics.forward import flange, forward
from ..scenes.source import read_source
from .chain import pose_of


def largest_error(file: RobotFile, read: ImportedRobot, count: int = 1000, seed: int = 0) -> float:
    """Compare forward kinematics in random postures: of a robot's Denavit-Hartenberg table, of its MuJoCo model,
    and of the file that both were made from.

    Args:
        file: it is compiled anew.
        read: what was read from it.
        count: of postures, uniform within the joints' limits.

    Returns:
        the largest difference of a position [m] or an angle [rad].
    """
    robot, zeros = read.robot, np.array(read.robot.axis_zeros)
    source = read_source(Path(file.path), {name: Path(folder) for name, folder in file.stated.packages}).model
    model = mujoco.MjModel.from_xml_string(robot.mjcf())
    theirs, ours, worst = mujoco.MjData(source), mujoco.MjData(model), 0.0
    addresses = [int(source.joint(j).qposadr[0]) for j in robot.joints]
    place = getattr(theirs, read.flange[0])(read.flange[1])
    low, high = np.array(robot.limits).T
    for q in np.random.default_rng(seed).uniform(low, high, (count, len(zeros))):
        own = tuple(float(v) for v in q)
        theirs.qpos[addresses], ours.qpos[: len(own)] = q - zeros, own
        mujoco.mj_kinematics(source, theirs)
        mujoco.mj_kinematics(model, ours)
        root = theirs.body(read.root)
        real = pose_of(root.xpos, root.xmat).inverse() * pose_of(place.xpos, place.xmat)
        pairs: list[tuple[Pose, Pose]] = [(flange(robot, own) * read.tool, real)]
        pairs += [(flange(robot, own), _site(ours, "flange")), (forward(robot, own), _site(ours, "tcp"))]
        worst = max(worst, *(v for a, b in pairs for v in a.distance(b)))
    return worst


def _site(data: mujoco.MjData, name: str) -> Pose:
    site = data.site(name)
    return pose_of(site.xpos, site.xmat)
