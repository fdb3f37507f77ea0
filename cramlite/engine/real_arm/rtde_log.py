"""Logs of a real arm: RTDE outputs over time, as CSV."""

from __future__ import annotations

import csv
import re
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from ...base.errors import UserError, nearest
from ...base.value import Value
from ...model.geometry import Floats

TIME, JOINTS = "timestamp", "actual_q"
MOST_BYTES = 500_000_000
"""Largest size of a log [bytes]: an hour at 500 Hz with all fields has 400 MB."""


class RtdeLog(Value):
    """Log of a real arm, from RTDE outputs.

    Args:
        times: (N,) since its first row [s].
        joints: (N, J) [rad].
        force: (N,) magnitude of the force at the TCP [N]; None where it was not logged.
        tool: (N, 3) position of the TCP in the base frame [m]; None where it was not logged.
    """

    times: Floats
    joints: Floats
    force: Floats | None
    tool: Floats | None


def read_rtde_log(path: Path) -> RtdeLog:
    """Read a log: CSV with a header, columns such as ``timestamp`` and ``actual_q_0``, with commas or blanks between.

    ur_rtde's ``startFileRecording`` and Universal Robots' RTDE client write such files.

    Raises:
        UserError: it cannot be read, lacks times or joints, or has a row that is not one of numbers; with its line.
    """
    columns = _columns(path)
    joints = _many(columns, JOINTS)
    if TIME not in columns or joints is None:
        lacks = TIME if TIME not in columns else f"{JOINTS}_0 to {JOINTS}_5"
        raise UserError(f"{path}:1: the log has no column {lacks}; {nearest(lacks, columns)}. Record 'timestamp' and 'actual_q' by RTDE.")
    times = columns[TIME] - columns[TIME][0]
    if len(times) < 2 or (wrong := np.flatnonzero(np.diff(times) <= 0)).size:
        line = 2 if len(times) < 2 else int(wrong[0]) + 3
        raise UserError(f"{path}:{line}: the log's times do not grow from row to row; one recording is expected.")
    force, tool = _many(columns, "actual_TCP_force"), _many(columns, "actual_TCP_pose")
    return RtdeLog(times, joints, None if force is None else np.linalg.norm(force[:, :3], axis=1), None if tool is None else tool[:, :3])


def _columns(path: Path) -> Mapping[str, Floats]:
    """Read the columns of a log file, by name."""
    try:
        if path.stat().st_size > MOST_BYTES:
            raise UserError(f"'{path}' has more than {MOST_BYTES // 1_000_000} MB; cut the log to the run.")
        text = path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        raise UserError(f"The log '{path}' cannot be read: {error}.") from None
    first = text.partition("\n")[0]
    rows = list(csv.reader(text.splitlines(), delimiter="," if "," in first else ";" if ";" in first else " ", skipinitialspace=True))
    header = [name.strip() for name in rows[0] if name.strip()] if rows else []
    return dict(zip(header, _numbers(path, rows[1:], len(header)).T, strict=True))


def _numbers(path: Path, rows: Sequence[Sequence[str]], width: int) -> Floats:
    """Return the rows of a log file as numbers (N, width)."""
    found = []
    for line, row in enumerate(rows, 2):
        cells = [cell for cell in row if cell.strip()]
        if not cells:
            continue
        try:
            found.append([float(cell) for cell in cells])
        except ValueError as error:
            raise UserError(f"{path}:{line}: {error}; a row of numbers is expected.") from None
        if len(cells) != width or not np.isfinite(found[-1]).all():
            raise UserError(f"{path}:{line}: {len(cells)} numbers where the header names {width}, or one that is not finite.")
    return np.array(found, dtype=float).reshape(len(found), width)


def _many(columns: Mapping[str, Floats], name: str) -> Floats | None:
    """Return the columns of a log field with several numbers, such as ``actual_q_0``, as an array (N, n);
    None if any is missing."""
    numbers = sorted(int(found[1]) for c in columns if (found := re.fullmatch(rf"{name}_(\d+)", c)))
    if not numbers or numbers != list(range(len(numbers))):
        return None
    return np.column_stack([columns[f"{name}_{k}"] for k in numbers])
