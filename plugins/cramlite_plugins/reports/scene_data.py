"""Scene data for the page's own renderer (templates/scene.js): triangles once, poses at every tick of the
time axis."""

from __future__ import annotations

import base64
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from .shared import colour

if TYPE_CHECKING:
    from cramlite.model import Floats, Rollout, Scene, Solid

    from .shared import Span

FINE = 1e-4
"""Resolution of the coordinates of vertices [m]."""
TURN = 1 / 32767
"""Resolution of a quaternion's components."""


def scene_data(scene: Scene, rollout: Rollout, samples: Sequence[int], tasks: Sequence[Span]) -> dict[str, Any]:
    """Return the data that ``scene.js`` draws.

    Args:
        samples: of the rollout, one a tick; the scene's poses are those of these.
        tasks: when each ran, for the colour of the tool's path.
    """
    bodies = list(scene.poses)
    moving = [b for b in bodies if len(scene.poses[b]) > 1]
    tracks = np.stack([scene.poses[b] for b in moving], axis=1) if moving else np.zeros((len(samples), 0, 7))
    path = rollout.poses["effector"][list(samples), :3]
    places = np.concatenate([tracks[..., :3].reshape(-1, 3), path])
    low, high = places.min(axis=0), places.max(axis=0)
    unit = float(np.abs(places).max()) / 32767
    return {
        "middle": np.round((low + high) / 2, 3).tolist(), "size": round(float(np.linalg.norm(high - low)), 3),
        "solids": [_solid(s, bodies.index(s.body)) for s in scene.solids],
        "still": {bodies.index(b): np.round(scene.poses[b][0], 5).tolist() for b in bodies if b not in moving},
        "moving": [bodies.index(b) for b in moving],
        "unit": unit, "turn": TURN, "fine": FINE,
        "poses": _packed(np.concatenate([tracks[..., :3] / unit, tracks[..., 3:] / TURN], axis=-1)),
        "path": _packed(path / unit),
        "force": _packed(rollout.wrench[list(samples), :3] / 0.01),
        "colours": _colours(scene.times, tasks),
    }  # fmt: skip


def _solid(solid: Solid, body: int) -> dict[str, Any]:
    colour = [round(255 * c) for c in solid.colour[:3]]
    vertices = np.round(solid.vertices / FINE).astype(int).reshape(-1)
    return {"body": body, "colour": colour, "vertices": vertices.tolist(), "faces": solid.faces.reshape(-1).tolist()}


def _packed(numbers: Floats) -> str:
    """Base64 of 16-bit integers, little endian."""
    whole = np.clip(np.round(numbers), -32767, 32767).astype("<i2")
    return base64.b64encode(whole.tobytes()).decode()


def _colours(times: Floats, tasks: Sequence[Span]) -> list[int]:
    """Number of the colour at each tick of the time axis: that of the task that runs then."""
    numbers = np.zeros(len(times), int)
    for task in tasks:
        numbers[(times >= task.start) & (times <= task.end)] = int(colour(task.task)[1:])
    return [int(n) for n in numbers]
