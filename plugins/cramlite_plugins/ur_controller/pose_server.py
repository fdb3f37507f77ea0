"""The perception server of the simulation: programs ask it, on a socket, for a thing's present pose.

It stands for a camera with its software beside the robot. The controller model never reads where objects are; it only passes
questions on, as it does for the gripper's server. What is answered is the simulated pose plus noise.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from cramlite.model import Pose

from ..simulation.model.compile import Compiled

ADDRESS = ("127.0.0.1", 50010)  # backends/urscript_late.py
NOISE = 0.0005  # standard deviation of a registered position [m]: median error (docs/figures/perception_pose.yaml)


class PoseServer:
    """A server that answers "POSE name" with six floats [m, rad], in the robot's base frame.

    Args:
        base: where the robot stands.
        seed: of the noise.
    """

    def __init__(self, compiled: Compiled, data: Any, base: Pose, seed: int) -> None:
        self.compiled, self.data, self.base = compiled, data, base
        self.random = np.random.default_rng([seed, 50010])

    def answer(self, line: str) -> bytes:
        """Answer a request "POSE name" with the present pose of that thing; return nothing for any other request."""
        words = line.split(maxsplit=1)
        if len(words) != 2 or words[0] != "POSE":
            return b""
        if words[1] not in self.compiled.things:
            return b"()\n"
        seen = self.base.inverse() * self.compiled.pose(self.data, words[1])
        place = np.array(seen.position) + self.random.normal(0.0, NOISE, 3)
        return f"({', '.join(f'{v:.6f}' for v in (*place, *seen.rotvec))})\n".encode()
