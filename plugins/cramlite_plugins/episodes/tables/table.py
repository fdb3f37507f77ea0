"""Tables of a recording: columns of text by name, each row with the line that it stands in."""

from __future__ import annotations

import csv
import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from cramlite.model import Floats, Value
from cramlite.plugin import UserError, nearest

from ..formats.jsonframes import json_frames

MOST_CELLS = 100_000_000
"""Largest number of cells of a table: an hour of 30 rigid bodies at 120 Hz fits."""


class Table(Value):
    """Table of a recording: its columns as text, and the data in its header.

    Args:
        path: the file.
        columns: name -> its cells, text as written; "" for none.
        lines: line of each row in the file, from 1.
        unit, rotation, rate: that the file states in its header, if it does.
        time: column with the time in seconds that the format has, if it has one.
    """

    path: Path
    columns: Mapping[str, Sequence[str]]
    lines: Sequence[int]
    unit: str | None = None
    rotation: str | None = None
    rate: float | None = None
    time: str | None = None

    def cells(self, name: str, wanted: str) -> Sequence[str]:
        """Return the cells of a column of the table, as text.

        Raises:
            UserError: there is none of this name.
        """
        if name not in self.columns:
            raise UserError(f"{self.path}: there is no column '{name}', which the mapping names as {wanted}; {nearest(name, self.columns)}")
        return self.columns[name]

    def numbers(self, name: str, wanted: str, gaps: frozenset[str] = frozenset()) -> Floats:
        """Return a column as numbers (N,); empty or "nan" cells become NaN if ``gaps`` contains "empty" or
        "nan" respectively.

        Raises:
            UserError: there is no such column, or a cell is no number; names the line.
        """
        cells = self.cells(name, wanted)
        values = np.empty(len(cells))
        for k, cell in enumerate(cells):
            text = cell.strip()
            if text == "" and "empty" in gaps:
                values[k] = np.nan
                continue
            try:
                values[k] = float(text)
            except ValueError:
                raise self.wrong(k, f"'{cell}' in column '{name}' is no number" if text else f"column '{name}' is empty") from None
            if not np.isfinite(values[k]) and "nan" not in gaps:
                raise self.wrong(
                    k, f"column '{name}' is {text}; if that marks a pose that was not seen, say 'gaps: [empty, nan]' in the mapping"
                )
        return np.where(np.isfinite(values), values, np.nan)

    def wrong(self, row: int, what: str) -> UserError:
        """Return the error of a wrong row: its file and line, and ``what`` is wrong with it."""
        return UserError(f"{self.path}:{self.lines[row]}: {what}{'' if what.endswith('?') else '.'}")


def read_table(path: Path, kind: str) -> Table:
    """Read the table of a recording from its file.

    Args:
        kind: csv, jsonl, optitrack or vicon.

    Raises:
        UserError: it cannot be read, is empty, or is of another kind.
    """
    try:
        if path.stat().st_size == 0:
            raise UserError(f"{path}: the recording is empty; export it anew.")
        found = _from_json(path) if kind == "jsonl" else _from_rows(path, kind)
    except OSError as error:
        raise UserError(f"{path}: the recording cannot be read: {error.strerror or error}; 'recording' in the mapping names it.") from None
    except (UnicodeDecodeError, csv.Error) as error:
        raise UserError(f"{path}: this is no text of a table: {error}; export it as CSV in UTF-8.") from None
    if not found.lines:
        raise UserError(f"{path}: the recording has a header and no rows; export it anew.")
    return found


def _from_json(path: Path) -> Table:
    """Read a table from a file of JSON documents, a row for each; nested values become columns with dotted names: "cup.position.0"."""
    rows = [dict(_flat(document, "")) for document in json_frames(path)]
    names = dict.fromkeys(n for row in rows for n in row)
    columns = {n: [row.get(n, "") for row in rows] for n in names}
    return Table(path, columns, list(range(1, len(rows) + 1)))


def _flat(value: Any, name: str) -> Iterator[tuple[str, str]]:
    if isinstance(value, dict | list):
        for key, inner in value.items() if isinstance(value, dict) else enumerate(value):
            yield from _flat(inner, f"{name}.{key}" if name else str(key))
    else:
        yield name, "" if value is None else value if isinstance(value, str) else json.dumps(value)


def _from_rows(path: Path, kind: str) -> Table:
    with path.open(newline="", encoding="utf-8-sig") as file:
        sample = file.readline()
        file.seek(0)
        delimiter = max(",;\t", key=sample.count)
        reader = csv.reader(file, delimiter=delimiter)
        rows = [(reader.line_num, row) for row in reader]
    if sum(len(r) for _, r in rows) > MOST_CELLS:
        raise UserError(f"{path}: more than {MOST_CELLS} numbers; split the recording.")
    return {"csv": _plain, "optitrack": _optitrack, "vicon": _vicon}[kind](path, rows)


Rows = list[tuple[int, list[str]]]


def _plain(path: Path, rows: Rows) -> Table:
    filled = [(n, r) for n, r in rows if any(c.strip() for c in r)]
    if not filled:
        raise UserError(f"{path}: the recording is empty; export it anew.")
    return _table(path, [c.strip() for c in filled[0][1]], filled[1:])


def _table(path: Path, names: Sequence[str], rows: Rows, **stated: Any) -> Table:
    twice = {a for a, b in pairwise(sorted(n for n in names if n)) if a == b}
    if twice:
        raise UserError(f"{path}: two columns are called '{min(twice)}'; give each its own name.")
    for line, row in rows:
        if len(row) < _last(names) or any(c.strip() for c in row[len(names) :]):
            raise UserError(f"{path}:{line}: this row has {len(row)} cells, and the header {len(names)}; is the recording cut off here?")
    columns = {n: [r[k] if k < len(r) else "" for _, r in rows] for k, n in enumerate(names) if n}
    return Table(path, columns, [n for n, _ in rows], **stated)


def _last(names: Sequence[str]) -> int:
    """Return the number of the last column that has a name in a table's header, counted from 1; 0 without one."""
    return max((k for k, n in enumerate(names, 1) if n), default=0)


def _header_end(path: Path, rows: Rows, kind: str) -> int:
    at = next((k for k, (_, r) in enumerate(rows) if r and r[0].strip() == "Frame"), None)
    if at is None or at < 1:
        raise UserError(f"{path}: no {kind} export: no row begins with 'Frame'; 'format: csv' reads tables with one header line.")
    return at


def _until_empty(rows: Rows) -> Rows:
    """Return the rows before the first empty one: behind it, Vicon writes other tables into the same file."""
    end = next((k for k, (_, r) in enumerate(rows) if not any(c.strip() for c in r)), len(rows))
    return rows[:end]


def _optitrack(path: Path, rows: Rows) -> Table:
    """Motive's export: properties in the first line, then type, name, id and kind of each column, above "Frame, Time (Seconds), X, ...".

    Columns become "NAME.Position.X", those of rigid bodies alone.
    """
    at = _header_end(path, rows, "OptiTrack")
    labelled = {r[1].strip(): r for _, r in rows[:at] if len(r) > 1}
    stated = dict(pairwise([c.strip() for c in rows[0][1]]))
    if "Name" not in labelled or not stated:
        raise UserError(f"{path}: no OptiTrack export: the row of names is missing; export rigid bodies with the header information.")
    types = labelled.get("Type", [])
    names = []
    for k, axis in enumerate(rows[at][1]):
        body = _cell(types, k) in ("Rigid Body", "") and _cell(labelled["Name"], k)
        names.append(f"{_cell(labelled['Name'], k)}.{_cell(rows[at - 1][1], k)}.{axis.strip()}" if body else axis.strip() if k < 2 else "")
    if stated.get("Rotation Type", "Quaternion") != "Quaternion":
        raise UserError(f"{path}: rotations are written as '{stated['Rotation Type']}'; export them as quaternions.")
    unit = {"Meters": "m", "Centimeters": "cm", "Millimeters": "mm"}.get(stated.get("Length Units", ""))
    return _table(path, names, _until_empty(rows[at + 1 :]), unit=unit, rotation="xyzw", time=names[1])


def _vicon(path: Path, rows: Rows) -> Table:
    """Tracker's export: rate, names of objects, "Frame, Sub Frame, RX, RY, RZ, RW, TX, TY, TZ, ..." and units.

    Columns become "NAME.TX". Without RW the mapping must say what the three angles are.
    """
    at = _header_end(path, rows, "Vicon")
    above = rows[at - 1][1]
    objects: list[str] = []
    for k in range(len(rows[at][1])):
        said = _cell(above, k).removeprefix("Global Angle ").split(":")[0]
        objects.append(said or (objects[-1] if objects else ""))
    axes = [c.strip() for c in rows[at][1]]
    names = [f"{o}.{a}" if o and k > 1 else a for k, (o, a) in enumerate(zip(objects, axes, strict=True))]
    units = rows[at + 1][1] if at + 1 < len(rows) else []
    unit = next((_cell(units, k) for k, a in enumerate(axes) if a == "TX"), None)
    rate = next((float(r[0]) for _, r in rows[:at] if r and _is_number(r[0])), None)
    quaternion = "xyzw" if "RW" in axes else None
    return _table(path, names, _until_empty(rows[at + 2 :]), unit=unit or None, rotation=quaternion, rate=rate)


def _cell(row: Sequence[str], k: int) -> str:
    return row[k].strip() if k < len(row) else ""


def _is_number(text: str) -> bool:
    try:
        return float(text) > 0
    except ValueError:
        return False


def names_of(values: Iterable[str]) -> str:
    """Return the first ten different names as text for a message."""
    listed = list(dict.fromkeys(values))
    return ", ".join(listed[:10]) + (", ..." if len(listed) > 10 else "")
