"""Poses of the tracks in a table, in metres, right-handed, z up; implausible poses of hands and things are
refused."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from cramlite.model import Floats, Value
from cramlite.plugin import UserError, nearest

from ..tracks import Rows
from .convention import LONGEST, QUATERNIONS, Convention
from .mapping import ColumnsSpec, Mapping, TrackSpec
from .table import Table, names_of

COLUMNS = {
    "optitrack": ColumnsSpec(
        position=("{name}.Position.X", "{name}.Position.Y", "{name}.Position.Z"),
        rotation=("{name}.Rotation.X", "{name}.Rotation.Y", "{name}.Rotation.Z", "{name}.Rotation.W"),
    ),
    "vicon": ColumnsSpec(position=("{name}.TX", "{name}.TY", "{name}.TZ"), rotation=("{name}.RX", "{name}.RY", "{name}.RZ", "{name}.RW")),
}
"""Columns of the formats of motion capture."""
Flags = NDArray[np.bool_]
FARTHEST = 30.0
"""Largest extent of the positions in a recording [m]: people handle things within a room, so that a larger extent means another unit."""
NEAREST = 0.02
"""Least extent of a hand's positions in a recording in which something is done [m]."""
SLOWEST, FASTEST = 1.0, 1e-4
"""Longest and shortest time between the rows of a recording of motion [s]."""


class Recorded(Value):
    """Poses of all tracks of a recording, converted to metres, right-handed axes and z up.

    Args:
        convention: that it was written in.
        times: (N,) of the table's rows [s].
        rows: track -> its poses, where it was seen.
        unseen: track -> how many rows have no pose of it, in how many.
    """

    convention: Convention
    times: Floats
    rows: dict[str, Rows]
    unseen: dict[str, tuple[int, int]]


def recorded(table: Table, mapping: Mapping) -> Recorded:
    """Return the poses of all tracks.

    Raises:
        UserError: a column is missing, a cell is no number, time runs backwards, a quaternion is none, or a unit is wrong.
    """
    convention = mapping.conventional(table.unit, table.rotation)
    times = _times(table, mapping)
    rows: dict[str, Rows] = {}
    unseen: dict[str, tuple[int, int]] = {}
    for name, track in mapping.tracks.items():
        rows[name], unseen[name] = _track(table, mapping, convention, times, name, track)
    _check_sampling(table, times)
    _check_unit(table, rows, mapping)
    return Recorded(convention, times, rows, unseen)


def _times(table: Table, mapping: Mapping) -> Floats:
    spec, column = mapping.time, mapping.time.column if mapping.time is not None else table.time
    rate = spec.rate if spec is not None and spec.rate is not None else table.rate
    if column is not None:
        values = table.numbers(column, "the time") * (spec.seconds if spec is not None and spec.column is not None else 1.0)
    elif rate is not None and mapping.columns is not None and mapping.columns.track is not None:
        raise UserError("'time: {rate: ...}' counts rows, and here several rows are of one instant; give 'time: {column: NAME, unit: s}'.")
    elif rate is not None:
        values = np.arange(len(table.lines)) / rate
    else:
        raise UserError("nothing says when the rows were recorded; give 'time: {column: NAME, unit: s}' or 'time: {rate: 120}'.")
    return values


def _check_forward(table: Table, times: Floats, mine: Flags) -> None:
    rows = np.flatnonzero(mine)
    back = np.flatnonzero(np.diff(times[rows]) < 0)
    if len(back):
        before, after = times[rows[back[0]]], times[rows[back[0] + 1]]
        why = f"time runs backwards, from {before:g} s to {after:g} s; is this the column of times, or are two takes in one file?"
        raise table.wrong(int(rows[back[0] + 1]), why)


def _track(
    table: Table, mapping: Mapping, convention: Convention, times: Floats, name: str, track: TrackSpec
) -> tuple[Rows, tuple[int, int]]:
    position, rotation = _columns(mapping, convention, name, track)
    mine = rows_of(table, mapping, name)
    _check_forward(table, times, mine)
    gaps = frozenset(str(g) for g in mapping.gaps)
    values = np.column_stack([table.numbers(c, f"a column of '{name}'", gaps) for c in (*position, *rotation)])
    seen = np.isfinite(values).all(axis=1) & ~_marked(values, mapping) & _valid(table, mapping, name)
    chosen = np.flatnonzero(mine & seen)
    if len(chosen) < 2:
        raise UserError(
            f"{table.path}: '{name}' was seen in {len(chosen)} of {int(mine.sum())} rows, and motion needs two at least; leave the track "
            "out of the mapping, or say where it stands with 'at'."
        )
    _check_quaternions(table, convention, values[:, 3:], chosen, name)
    poses = np.hstack([convention.positions(values[chosen, :3]), convention.quaternions(values[chosen, 3:])])
    frames = (track.within,) if track.within is not None else ("world",)
    if track.within is not None and track.within not in mapping.tracks:
        raise UserError(f"'in: {track.within}' of '{name}' is no track of the mapping; {nearest(track.within, mapping.tracks)}")
    found = Rows(times[chosen], poses, np.zeros(len(chosen), dtype=np.int32), frames)
    return found, (int(mine.sum()) - len(chosen), int(mine.sum()))


def _columns(mapping: Mapping, convention: Convention, name: str, track: TrackSpec) -> tuple[Sequence[str], Sequence[str]]:
    """The columns of a track's position and rotation."""
    usual = mapping.columns or COLUMNS.get(mapping.kind)
    own = track.track or name
    position = track.position or (usual.position if usual is not None else None)
    rotation = track.rotation or (usual.rotation[: convention.numbers] if usual is not None else None)
    if position is None or rotation is None:
        raise UserError(
            f"nothing says which columns hold the poses of '{name}'; give 'columns' with 'position' and 'rotation', where {{name}} in a "
            "column's name stands for the track, or give both in the track."
        )
    if len(rotation) != convention.numbers:
        raise UserError(f"the rotation of '{name}' has {len(rotation)} columns, and '{convention.rotation}' needs {convention.numbers}.")
    return [c.replace("{name}", own) for c in position], [c.replace("{name}", own) for c in rotation]


def rows_of(table: Table, mapping: Mapping, name: str) -> Flags:
    """Return which rows (N,) belong to a track: all rows, or those whose track column has the track's name.

    Raises:
        UserError: none does.
    """
    if mapping.columns is None or mapping.columns.track is None:
        return np.ones(len(table.lines), dtype=bool)
    own = mapping.tracks[name].track or name
    cells = [c.strip() for c in table.cells(mapping.columns.track, "the name of the track")]
    mine = np.array([c == own for c in cells])
    if not mine.any():
        raise UserError(f"{table.path}: no row is of the track '{own}'; there are {names_of(cells)}.")
    return mine


def _marked(values: Floats, mapping: Mapping) -> Flags:
    """Rows (N,) whose position marks a gap: all three coordinates are zero, or the number that the mapping's
    'gaps' states."""
    marks = [0.0 if g == "zero" else float(g) for g in mapping.gaps if g not in ("empty", "nan")]
    return np.asarray(np.any([np.all(values[:, :3] == m, axis=1) for m in marks], axis=0)) if marks else np.zeros(len(values), dtype=bool)


def _valid(table: Table, mapping: Mapping, name: str) -> Flags:
    if mapping.valid is None:
        return np.ones(len(table.lines), dtype=bool)
    no = ("", "0", "0.0", "false", "no", "nan")
    return np.array([c.strip().lower() not in no for c in table.cells(mapping.valid.replace("{name}", name), "what was seen")])


def _check_quaternions(table: Table, convention: Convention, values: Floats, rows: NDArray[np.intp], name: str) -> None:
    if convention.rotation not in QUATERNIONS:
        return
    lengths = np.linalg.norm(values[rows], axis=1)
    wrong = np.flatnonzero(np.abs(lengths - 1.0) > LONGEST)
    if len(wrong):
        raise table.wrong(
            int(rows[wrong[0]]),
            f"the quaternion of '{name}' has the length {lengths[wrong[0]]:.3g} instead of 1 (so in {len(wrong)} of {len(rows)} rows); are "
            "these the columns of its rotation, and is it written as a quaternion ('rotation')?",
        )


def _check_sampling(table: Table, times: Floats) -> None:
    steps = np.diff(np.unique(times))
    step = float(np.median(steps)) if len(steps) else 0.0
    if step > SLOWEST or step < FASTEST:
        seen = f"{step:.3g} s lie between two rows" if len(steps) else "all rows are of one instant"
        raise UserError(f"{table.path}: {seen}, and motion is recorded 5 to 1000 times a second; is the unit of time ('time: unit') right?")


def _check_unit(table: Table, rows: dict[str, Rows], mapping: Mapping) -> None:
    points = np.vstack([r.poses[:, :3] for n, r in rows.items() if mapping.tracks[n].within is None])
    apart = float(np.max(np.ptp(points, axis=0)))
    if apart > FARTHEST:
        raise UserError(
            f"{table.path}: positions lie up to {apart:.4g} m apart, and a person reaches within a room; is the unit ('length') right? "
            "If the numbers are millimetres, say 'length: mm'; if it marks gaps by a number, say it under 'gaps'."
        )
    ways = {n: float(np.max(np.ptp(rows[n].poses[:, :3], axis=0))) for n in mapping.hands}
    if max(ways.values()) < NEAREST:
        raise UserError(
            f"{table.path}: no hand moves farther than {1000 * max(ways.values()):.2g} mm, so nothing was done; is the unit ('length') "
            f"right, and are {', '.join(ways)} the hands?"
        )
