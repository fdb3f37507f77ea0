"""Snapshots of runs: text files with the numbers of a run that should not change unnoticed when the program changes."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..base.errors import UserError
from ..base.value import Value
from ..base.yaml_file import load_yaml
from ..model.run.rollout import Rollout

POINTS = 21
"""Number of points of the tool's path, at equal shares of the program's time."""


class Tolerances(Value):
    """Tolerances of a comparison of snapshots: forces [N], times [s], the tool's path [m], final positions of
    things [m]."""

    force: float
    time: float
    path: float
    places: float


def taken(rollout: Rollout, ends: float) -> dict[str, Any]:
    """Return the numbers of a run for a snapshot: outcome, duration, largest force, final positions, the
    tool's path.

    Args:
        ends: when the program ended [s].
    """
    moments = np.linspace(0.0, ends, POINTS)
    tool = rollout.poses["effector"][:, :3]
    path = np.column_stack([np.interp(moments, rollout.times, tool[:, k]) for k in range(3)])
    loose = [t.name for t in rollout.world.things if t.movable and t.name in rollout.poses]
    return {
        "outcome": rollout.outcome,
        "seconds": round(ends, 2),
        "peak_force_n": round(float(rollout.contact_force().max()), 1),
        "ends": {name: _rounded(rollout.poses[name][-1, :3]) for name in loose},
        "tool": [_rounded(p) for p in path],
    }


def compare(old: Mapping[str, Any], new: Mapping[str, Any], allowed: Tolerances) -> Sequence[str]:
    """Return the differences between two snapshots that are too large, in words with numbers."""
    return list(_differences(old, new, allowed))


def _differences(old: Mapping[str, Any], new: Mapping[str, Any], allowed: Tolerances) -> Iterator[str]:
    if new["outcome"] != old["outcome"]:
        yield f"the run ends by '{new['outcome']}', in the snapshot by '{old['outcome']}'"
    for key, most, unit in (("seconds", allowed.time, "s"), ("peak_force_n", allowed.force, "N")):
        if abs(new[key] - old[key]) > most:
            yield f"{key} {new[key]:g} {unit}, in the snapshot {old[key]:g}; a difference of {most:g} is allowed"
    for name in sorted({*old["ends"], *new["ends"]}):
        if name not in old["ends"] or name not in new["ends"]:
            yield f"'{name}' is in only one of the two, the run and the snapshot"
        elif (far := _distance(old["ends"][name], new["ends"][name])) > allowed.places:
            yield f"'{name}' ends {1000 * far:.0f} mm from where it ended in the snapshot, {1000 * allowed.places:g} are allowed"
    far_path = [_distance(a, b) for a, b in zip(old["tool"], new["tool"], strict=False)]
    if len(old["tool"]) != len(new["tool"]):
        yield f"the tool's path has {len(new['tool'])} points, in the snapshot {len(old['tool'])}"
    elif max(far_path, default=0.0) > allowed.path:
        k = int(np.argmax(far_path))
        share = k / max(1, len(far_path) - 1)
        off = f"{1000 * far_path[k]:.0f} mm off the snapshot's path at {share:.0%} of the time"
        yield f"the tool is {off}, {1000 * allowed.path:g} mm are allowed"


def _distance(one: Sequence[float], other: Sequence[float]) -> float:
    return float(np.linalg.norm(np.subtract(one, other)))


def _rounded(position: Any) -> list[float]:
    return [round(float(v), 4) + 0.0 for v in position]


def write_snapshot(file: Path, snapshot: Mapping[str, Any]) -> None:
    """Write a snapshot.

    Raises:
        UserError: it cannot be written.
    """
    import yaml

    text = yaml.safe_dump(dict(snapshot), sort_keys=False, default_flow_style=None, width=110)
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text, encoding="utf-8", newline="\n")
    except OSError as error:
        raise UserError(f"The snapshot '{file}' cannot be written: {error.strerror}.") from None


def read_snapshot(file: Path) -> Mapping[str, Any]:
    """Read a snapshot.

    Raises:
        UserError: it is none.
    """
    data = load_yaml(file)
    if not isinstance(data, dict) or not {"outcome", "seconds", "peak_force_n", "ends", "tool"} <= data.keys():
        raise UserError(f"'{file}' is no snapshot of a run; remove it, or write it anew with pytest --cramlite-accept.")
    return data
