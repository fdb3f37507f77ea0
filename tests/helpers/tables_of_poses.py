"""Recordings of poses as other programs write them: tables at 120 Hz with noise and gaps, in any convention, scripted with NumPy alone.

A person puts a bottle into a crate, pours from a jug into a bowl, and opens a drawer. The poses are metres, right-handed, z up; a
``Style`` says how a table is written, and what the mapping file has to say of it.
"""

from __future__ import annotations

import csv
import json
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from scipy.spatial.transform import Rotation

from cramlite.model import Floats, Value

RATE = 120
"""Rows per second of a recorded table [Hz]."""
TABLE = 0.72
"""Height of the table's top [m]."""
Tracks = dict[str, Floats]
"""Name of a track -> (N, 7) position [m] and quaternion (w, x, y, z), at ``RATE``; NaN where the tracker lost it."""


class Style(Value):
    """Convention of a recorded table: units, axes, order of numbers, and format.

    Args:
        unit: metres that 1 stands for, and its name.
        axes: our x, y and z in the table's axes.
        order: of a quaternion's numbers.
        seconds: that 1 stands for in the column of times, and its name.
        json: one document a line, instead of CSV.
        long: a row for each pose, instead of one for each instant.
    """

    unit: tuple[float, str] = (1.0, "m")
    axes: tuple[str, str, str] = ("x", "y", "z")
    order: str = "xyzw"
    seconds: tuple[float, str] = (1.0, "s")
    json: bool = False
    long: bool = False

    @property
    def matrix(self) -> Floats:
        """Return the rotation matrix (3, 3) from the table's axes to those of cramlite."""
        rows = np.zeros((3, 3))
        for row, axis in zip(rows, self.axes, strict=True):
            row["xyz".index(axis[-1])] = -1.0 if axis[0] == "-" else 1.0
        return rows

    def written(self, poses: Floats) -> Floats:
        """Convert poses (N, 7) to the table's convention by matrices, which is independent of the reader's code."""
        into = self.matrix.T
        positions = poses[:, :3] @ into.T / self.unit[0]
        seen = np.isfinite(poses).all(axis=1)
        quaternions = np.full((len(poses), 4), np.nan)
        turned = into @ Rotation.from_quat(poses[seen, 3:], scalar_first=True).as_matrix() @ into.T
        quaternions[seen] = Rotation.from_matrix(turned).as_quat(scalar_first=self.order == "wxyz")
        return np.hstack([positions, quaternions])


def poses_of(positions: Floats, tilt: Floats | float = 0.0) -> Floats:
    """Return poses (N, 7) at positions, tilted about cramlite's y axis [rad]."""
    half = np.broadcast_to(np.asarray(tilt) / 2, len(positions))
    zero = np.zeros(len(positions))
    return np.column_stack([positions, np.cos(half), zero, np.sin(half), zero])


def through(points: list[tuple[float, ...]], times: list[float]) -> tuple[Floats, Floats]:
    """Return times (N,) and values (N, D) that interpolate points, at rest at each (least jerk: Flash and Hogan, 1985)."""
    at = np.arange(times[0], times[-1], 1 / RATE)
    where = np.clip(np.searchsorted(times, at, side="right") - 1, 0, len(times) - 2)
    first, last = np.asarray(times)[where], np.asarray(times)[where + 1]
    share = (at - first) / (last - first)
    smooth = (share**3 * (10 - 15 * share + 6 * share**2))[:, None]
    known = np.asarray(points)
    return at, known[where] + smooth * (known[where + 1] - known[where])


def into_a_crate() -> Tracks:
    """Return the tracks of a bottle that is taken from the table and put into a crate."""
    home, stand, crate = (0.2, -0.3, 1.0), (0.55, 0.2, TABLE + 0.1), (0.55, -0.25, TABLE + 0.105)
    ways = [home, stand, stand, (0.55, 0.2, 1.05), (0.55, -0.25, 1.05), crate, crate, (0.55, -0.25, 1.15), home]
    t, hand = through(ways, [0, 1.5, 2.0, 3.0, 4.2, 5.2, 5.6, 6.4, 7.6])
    bottle = np.where((t < 2.0)[:, None], stand, np.where((t < 5.4)[:, None], hand, crate))
    return {"right_hand": poses_of(hand - [0.04, 0, 0]), "bottle": poses_of(bottle)}


def pouring() -> Tracks:
    """Return the tracks of a jug that is lifted, tilted over a bowl, and put back."""
    home, stand, over = (0.2, -0.3, 1.0, 0.0), (0.5, 0.2, TABLE + 0.08, 0.0), (0.4, -0.2, 1.0, 0.0)
    poured = (0.4, -0.2, 1.0, 1.9)
    ways = [home, stand, stand, (0.5, 0.2, 1.0, 0.0), over, poured, poured, over, (0.5, 0.2, 1.0, 0.0), stand, stand, home]
    t, hand = through(ways, [0, 1.5, 2.0, 2.8, 4.0, 5.0, 6.2, 7.0, 8.2, 9.2, 9.6, 11.0])
    jug = np.where(((t < 2.0) | (t > 9.2))[:, None], stand, hand)
    grip = 0.05 * np.column_stack([np.cos(hand[:, 3]), np.zeros(len(t)), -np.sin(hand[:, 3])])
    return {"right_hand": poses_of(hand[:, :3] - grip, hand[:, 3]), "jug": poses_of(jug[:, :3], jug[:, 3])}


def opening() -> Tracks:
    """Return the tracks of a drawer that is pulled open by 0.25 m."""
    home, handle, out = (0.2, 0.3, 1.0), (0.5, 0.0, 0.6), (0.25, 0.0, 0.6)
    t, hand = through([home, handle, handle, out, out, home], [0, 1.5, 2.0, 3.5, 3.8, 5.0])
    drawer = np.where((t < 2.0)[:, None], handle, np.where((t < 3.5)[:, None], hand, out)) + np.array([0.2, 0, 0])
    return {"right_hand": poses_of(hand), "drawer": poses_of(drawer)}


THINGS: dict[str, dict[str, Any]] = {
    "bottle": {"class": "cram:Product", "shape": {"cylinder": [0.03, 0.2]}},
    "jug": {"class": "cram:Jug", "shape": {"hollow": [0.1, 0.1, 0.16]}},
    "drawer": {"class": "soma:Drawer", "shape": {"hollow": [0.4, 0.4, 0.15]}, "opens": {"slides": 0.3}},
    "table": {"class": "cram:Table", "at": {"position": [0.55, 0.0, TABLE - 0.015]}, "shape": {"box": [0.6, 1.0, 0.03]}},
    "crate": {"class": "cram:Basket", "at": {"position": [0.55, -0.25, TABLE + 0.07]}, "shape": {"hollow": [0.24, 0.24, 0.14]}},
    "bowl": {"class": "soma:Bowl", "at": {"position": [0.45, -0.2, TABLE + 0.04]}, "shape": {"hollow": [0.18, 0.18, 0.08]}},
}
"""Things of the recordings as a mapping file describes them, in cramlite's units and axes."""


def worn(tracks: Tracks, seed: int, noise: float = 0.001, lost: float = 0.02, gap: int = 30) -> Tracks:
    """Add to tracks noise of position [m] and rotation, lose a share of the poses at random, and cut one gap of ``gap`` rows into each
    track."""
    rng = np.random.default_rng(seed)
    found = {}
    for name, poses in tracks.items():
        spoilt = poses + np.hstack([rng.normal(0, noise, (len(poses), 3)), rng.normal(0, 3 * noise, (len(poses), 4))])
        spoilt[:, 3:] /= np.linalg.norm(spoilt[:, 3:], axis=1, keepdims=True)
        spoilt[rng.random(len(poses)) < lost] = np.nan
        start = int(rng.integers(0, len(poses) - gap))
        spoilt[start : start + gap] = np.nan
        found[name] = spoilt
    return found


def mapping_of(tracks: Tracks, things: list[str], style: Style, file: str) -> dict[str, Any]:
    """Return the content of the mapping file of a table; sizes and places are in the table's unit and axes, too."""
    names = ["{name}." + a for a in ("px", "py", "pz", *(f"q{a}" for a in style.order))]
    names = [n.split(".")[1] for n in names] if style.long else names
    return {
        "recording": file, "length": style.unit[1], "axes": list(style.axes), "rotation": style.order,
        "time": {"column": "t", "unit": style.seconds[1]},
        "columns": {**({"track": "name"} if style.long else {}), "position": names[:3], "rotation": names[3:]},
        "hands": {n: {} for n in tracks if n.endswith("hand")},
        "things": {n: _thing(THINGS.get(n, {}), style) for n in [*(t for t in tracks if not t.endswith("hand")), *things]},
    }  # fmt: skip


def _thing(spec: dict[str, Any], style: Style) -> dict[str, Any]:
    into, unit = style.matrix.T, style.unit[0]
    said = dict(spec)
    shape = {k: (np.abs(into) @ v / unit).tolist() if len(v) == 3 else [x / unit for x in v] for k, v in spec.get("shape", {}).items()}
    if "at" in spec:
        said["at"] = {"position": (into @ spec["at"]["position"] / unit).tolist()}
    if "opens" in spec:
        said["opens"] = {k: v / unit for k, v in spec["opens"].items()}
    return {**said, "shape": shape} if shape else said


def write(folder: Path, tracks: Tracks, things: list[str], style: Style | None = None) -> Path:
    """Write a table and its mapping file, and return the path of the mapping file."""
    style = style or Style()
    file = "take.jsonl" if style.json else "take.csv"
    rows = list(_rows(tracks, style))
    with (folder / file).open("w", newline="") as out:
        if style.json:
            out.writelines(json.dumps({k: v for k, v in row.items() if v is not None}) + "\n" for row in rows)
        else:
            table = csv.DictWriter(out, list(dict.fromkeys(k for row in rows for k in row)))
            table.writeheader()
            table.writerows(rows)
    mapping = folder / "take.yaml"
    mapping.write_text(yaml.safe_dump(mapping_of(tracks, things, style, file), sort_keys=False))
    return mapping


def _rows(tracks: Tracks, style: Style) -> Any:
    columns = ["px", "py", "pz", *(f"q{a}" for a in style.order)]
    written = {n: style.written(p) for n, p in tracks.items()}
    for k in range(len(next(iter(written.values())))):
        instant = {"t": k / RATE / style.seconds[0]}
        poses = {n: [None if np.isnan(v) else float(v) for v in p[k]] for n, p in written.items()}
        if style.long:
            yield from ({**instant, "name": n, **dict(zip(columns, p, strict=True))} for n, p in poses.items())
        else:
            yield instant | {f"{n}.{c}": v for n, p in poses.items() for c, v in zip(columns, p, strict=True)}
