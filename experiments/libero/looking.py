"""Picture with depth of the benchmark's fixed camera, with its calibration: all data that a robot cell's
sensors would give.

Nothing of cramlite is imported here.
"""

from __future__ import annotations

import base64
import io
import math
from typing import Any

import mujoco
import numpy as np

PIXELS = 512
CAMERA = "agentview"
TENTHS = 1e4
"""Steps of depth in a metre: tenths of a millimetre, in 16 bits up to 6.5 m."""
FLIPPED = np.diag((1.0, -1.0, -1.0))
"""MuJoCo's cameras look along -z with y up, an optical frame along z with y down."""


def calibrated(model: Any, data: Any, base: str) -> dict[str, Any]:
    """Calibrate the benchmark's fixed camera: once, at the start of an episode.

    Returns:
        ``intrinsics`` (fx, fy, cx, cy) in pixels, and the pose of the optical frame in that of the body ``base``: ``position`` [m] and
        ``rotation``, row by row.
    """
    focal = PIXELS / 2 / math.tan(math.radians(float(model.camera(CAMERA).fovy[0])) / 2)
    middle = (PIXELS - 1) / 2
    turn, place = data.body(base).xmat.reshape(3, 3), data.body(base).xpos
    camera = data.camera(CAMERA)
    return {
        "intrinsics": [focal, focal, middle, middle],
        "position": (turn.T @ (camera.xpos - place)).tolist(),
        "rotation": (turn.T @ camera.xmat.reshape(3, 3) @ FLIPPED).reshape(-1).tolist(),
    }


class Eye:
    """Benchmark's fixed camera in one episode.

    Args:
        model, data: of the simulation that it sees.
        base: body in whose frame it is calibrated, once, at the start.
    """

    def __init__(self, model: Any, data: Any, base: str) -> None:
        model.vis.global_.offwidth = max(int(model.vis.global_.offwidth), PIXELS)
        model.vis.global_.offheight = max(int(model.vis.global_.offheight), PIXELS)
        self.data, self.calibration, self.renderer = data, calibrated(model, data, base), mujoco.Renderer(model, PIXELS, PIXELS)
        self.shown = mujoco.MjvOption()
        self.shown.geomgroup[0] = 0  # what bodies collide with; robosuite draws group 1
        self.shown.sitegroup[:] = 0

    def taken(self, colour: bool = True) -> dict[str, Any]:
        """Take a picture with depth.

        Returns:
            ``rgb``, if asked for, and ``depth`` (16 bits, tenths of a millimetre, 0 where nothing is) as PNG in base64, and the
            calibration.
        """
        self.renderer.update_scene(self.data, CAMERA, self.shown)
        said = {"rgb": _png(self.renderer.render())} if colour else {}
        self.renderer.enable_depth_rendering()
        depth = self.renderer.render()
        self.renderer.disable_depth_rendering()
        steps = np.where(depth * TENTHS < 65535, np.rint(depth * TENTHS), 0).astype(np.uint16)
        return {**said, "depth": _png(steps), **self.calibration}


def _png(pixels: Any) -> str:
    from PIL import Image

    Image.fromarray(pixels).save(buffer := io.BytesIO(), "png")
    return base64.b64encode(buffer.getvalue()).decode()
