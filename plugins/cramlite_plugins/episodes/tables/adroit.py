"""Plugin that reads people's demonstrations of opening a door with a lever, as hand_dapg publishes them (``adroit_door``).

A recording is an ``.npz``: ``observations`` (N, 39) of the hand's joints, of the lever and the hinge, and ``door``, where the frame stood.
The poses of palm, door and lever follow from the scene's kinematics (DAPG_door.xml of hand_dapg, adroit_door.xml of gymnasium-robotics;
lengths there in metres, angles in radians); the mapping says what they are, as for any table of poses. What the hand touches follows from
a replay of its fingers, and nothing counts as grasped: a human hand is no gripper.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from cramlite.model import Episode, Event, Floats, Pose
from cramlite.plugin import UserError, hookimpl, read_arrays

from .adroit_scene import DOOR, LATCH, PIVOT, distances

NUMBERS = 39
"""Observations at a time: 27 joints of the hand without the forearm's slide, lever, hinge, palm, handle, their difference, open or not."""
LEVER, HINGE, PALM, HANDLE = 27, 28, slice(29, 32), slice(32, 35)
STEP = 0.01
"""Time between two observations [s]: five simulation steps of 2 ms."""
FOREARM = (((1, 0, 0), -1.57), ((0, 0, 1), 3.14))
"""Rotations of the forearm, one after the other: axis and angle [rad]."""
WRIST = ((1, 0, 0), (0, 1, 0), (0, 0, 1), (0, 1, 0), (1, 0, 0))
"""Axes of the joints from the forearm to the palm, which are the first observations."""
FINGERS = slice(len(WRIST), LEVER)
"""Observed joints of the fingers."""
GRIP = (0.15, -0.15, 0.0)
"""The observed point of the handle, from the lever's axis [m]."""
EXACT = 0.01
"""Largest distance between the observed and the computed position of the handle [m]: observed positions are one step older than the
joints."""
TOUCH = (0.002, 0.005)
"""Distances of the hand from a thing below which a touch starts and above which it ends [m]: a hand that turns a lever is up to 1.5 mm from
it."""
MOST_BYTES = 100_000_000
"""Largest size of a recording [bytes]: ten minutes have 20 MB."""
_COLUMNS = tuple(f"{{name}}.{part}" for part in ("x", "y", "z", "qw", "qx", "qy", "qz"))
MAPPING = {
    "recording": "", "length": "m", "up": "z", "handedness": "right", "rotation": "wxyz",
    "time": {"column": "time"}, "columns": {"position": _COLUMNS[:3], "rotation": _COLUMNS[3:]},
    "hands": {"hand": {}},
    "things": {
        "door": {"class": "soma:Door", "shape": {"box": [0.4, 0.1, 0.5]}, "opens": {"turns": 90}},
        "lever": {"class": "soma:DesignedHandle", "shape": {"box": [0.2, 0.04, 0.04], "at": [0.1, -0.15, 0.0]},
                  "opens": {"turns": 103, "on": "door"}},
    },
}  # fmt: skip
"""Mapping of ``adroit_door`` recordings, with the content of a mapping file: joint ranges and sizes are those of the scene."""


@hookimpl
def read_episode(path: Path) -> Episode | None:
    """Read a demonstration of ``adroit_door``; None if the path is something else."""
    if path.suffix.lower() != ".npz" or not path.is_file():
        return None
    data = read_arrays(path, MOST_BYTES)
    if not {"observations", "door"} <= set(data):
        return None
    seen, frame = data["observations"], data["door"]
    if seen.ndim != 2 or seen.shape[1] != NUMBERS or not len(seen) or frame.shape != (3,):
        return None
    if not {seen.dtype.kind, frame.dtype.kind} <= set("fiu"):
        return None
    return _episode(path, seen.astype(float), frame.astype(float))


def _episode(path: Path, seen: Floats, frame: Floats) -> Episode:
    from .assembly import episode_of
    from .mapping import Mapping
    from .table import Table

    if not (finite := np.isfinite(seen).all(axis=1)).all():
        step = int(np.argmin(finite))
        raise UserError(f"{path}: the observations of step {step} contain NaN or infinity; cut the recording before this step.")
    poses = {"hand": _palm(seen), "door": [_door(frame, row[HINGE]) for row in seen]}
    poses["lever"] = [door * Pose(LATCH) * _turn((0, 1, 0), row[LEVER]) for door, row in zip(poses["door"], seen, strict=True)]
    off = max(np.linalg.norm(np.array((p * Pose(GRIP)).position) - r[HANDLE]) for p, r in zip(poses["lever"], seen, strict=True))
    if not off < EXACT:
        raise UserError(
            f"{path}: the recorded handle is up to {1000 * off:.0f} mm from where the angles of lever and hinge put it, and "
            f"motion within a time step explains at most {1000 * EXACT:.0f} mm; is this another scene than that of hand_dapg?"
        )
    columns = {"time": [f"{STEP * k:.2f}" for k in range(len(seen))]}
    for name, track in poses.items():
        values = np.array([[*p.position, *p.quaternion] for p in track])
        columns |= {c.replace("{name}", name): [f"{v:.9g}" for v in values[:, k]] for k, c in enumerate(_COLUMNS)}
    table = Table(path, columns, list(range(1, len(seen) + 1)))
    touches = _touches(distances(poses["hand"], seen[:, FINGERS], seen[:, LEVER], seen[:, HINGE], frame))
    return episode_of(path, Mapping.model_validate({**MAPPING, "recording": path.name}), table, touches)


def _touches(distance: dict[str, Floats]) -> tuple[Event, ...]:
    """Contact states of the hand with each thing that it has a distance from at each step (N,) [m]."""
    from ..detection.signals import hysteresis, spans

    found = []
    for name, away in distance.items():
        times = np.round(STEP * np.arange(len(away)), 2)
        near = spans(hysteresis(-away, -TOUCH[0], -TOUCH[1]), times)
        found += [(start, min(end, float(times[-1])), name) for start, end in near if start < times[-1]]
    each = enumerate(sorted(found), 1)
    return tuple(Event(f"contact_{k}", "soma:ContactState", "state", s, e, {"a": "hand", "b": name}, True) for k, (s, e, name) in each)


def _palm(seen: Floats) -> list[Pose]:
    """Poses of the palm: its observed position, and its orientation from the joint angles of forearm and wrist."""
    start = _turn(*FOREARM[0]) * _turn(*FOREARM[1])
    found = []
    for row in seen:
        turned = start
        for axis, angle in zip(WRIST, row, strict=False):
            turned = turned * _turn(axis, angle)
        found.append(Pose(tuple(row[PALM]), turned.quaternion))
    return found


def _door(frame: Floats, angle: float) -> Pose:
    """Pose of the door when its hinge is turned by an angle [rad] about the vertical."""
    hinge = np.add(np.add(frame, DOOR), PIVOT)
    return Pose(tuple(hinge)) * _turn((0, 0, 1), angle) * Pose(tuple(np.negative(PIVOT)))


def _turn(axis: tuple[float, float, float], angle: float) -> Pose:
    cosine, sine = float(np.cos(0.5 * angle)), float(np.sin(0.5 * angle))
    return Pose((0.0, 0.0, 0.0), (cosine, sine * axis[0], sine * axis[1], sine * axis[2]))
