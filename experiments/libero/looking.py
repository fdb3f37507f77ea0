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


def taken(model: Any, data: Any, base: str) -> dict[str, Any]:
    """Take a picture with depth by the benchmark's fixed camera.

    Returns:
        ``rgb`` and ``depth`` (16 bits, tenths of a millimetre, 0 where nothing is) as PNG in base64, ``intrinsics`` (fx, fy, cx, cy) in
        pixels, and the pose of the optical frame in that of the body ``base``: ``position`` [m] and ``rotation``, row by row.
    """
    model.vis.global_.offwidth = max(int(model.vis.global_.offwidth), PIXELS)
    model.vis.global_.offheight = max(int(model.vis.global_.offheight), PIXELS)
    seen = mujoco.MjvOption()
    seen.geomgroup[0] = 0  # what bodies collide with; robosuite draws group 1
    seen.sitegroup[:] = 0
    renderer = mujoco.Renderer(model, PIXELS, PIXELS)
    renderer.update_scene(data, CAMERA, seen)
    rgb = renderer.render().copy()
    renderer.enable_depth_rendering()
    depth = renderer.render().copy()
    focal = PIXELS / 2 / math.tan(math.radians(float(model.camera(CAMERA).fovy[0])) / 2)
    middle = (PIXELS - 1) / 2
    turn, place = data.body(base).xmat.reshape(3, 3), data.body(base).xpos
    camera = data.camera(CAMERA)
    steps = np.where(depth * TENTHS < 65535, np.rint(depth * TENTHS), 0).astype(np.uint16)
    return {
        "rgb": _png(rgb), "depth": _png(steps), "intrinsics": [focal, focal, middle, middle],
        "position": (turn.T @ (camera.xpos - place)).tolist(),
        "rotation": (turn.T @ camera.xmat.reshape(3, 3) @ FLIPPED).reshape(-1).tolist(),
    }  # fmt: skip


def _png(pixels: Any) -> str:
    from PIL import Image

    Image.fromarray(pixels).save(buffer := io.BytesIO(), "png")
    return base64.b64encode(buffer.getvalue()).decode()
