"""CSV tables of a run: one file for each kind of record, for spreadsheets, pandas and MATLAB.

Numbers have as many digits as they need, so that what is read back is equal. Lengths are in m, angles in rad, times in s, forces
in N, in the world frame; quaternions are w, x, y, z.
"""

from __future__ import annotations

import csv
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from cramlite.plugin import Exporter, hookimpl

if TYPE_CHECKING:
    from cramlite.model import RunRecord

POSE = ("x", "y", "z", "qw", "qx", "qy", "qz")
WRENCH = ("fx", "fy", "fz", "tx", "ty", "tz")
CsvRow = Sequence[float | int | str]


@hookimpl
def exporters() -> Iterable[Exporter]:
    """Declare the export format CSV."""
    return [Exporter("csv", "", "spreadsheets, pandas, MATLAB", write_tables)]


def write_tables(run: RunRecord, out: Path) -> None:
    """Write the tables of a run into a new folder."""
    out.mkdir(parents=True)
    for name, header, rows in tables(run):
        with (out / f"{name}.csv").open("w", newline="", encoding="utf-8") as file:
            csv.writer(file).writerows([header, *rows])


def tables(run: RunRecord) -> Iterator[tuple[str, CsvRow, Iterable[CsvRow]]]:
    """Yield the name, header and rows of every table."""
    rollout = run.rollout
    times = rollout.times.tolist()
    yield "poses", ("time", "frame", *POSE), _poses(run)
    yield "joints", ("time", *run.joints, "opening"), _with_column(times, rollout.joints.tolist(), rollout.opening.tolist())
    yield "wrench", ("time", *WRENCH, "felt"), _with_column(times, rollout.wrench.tolist(), rollout.contact_force().tolist())
    touches = zip(times, rollout.touches, strict=True)
    contacts = [(t, c.a, c.b, c.force, c.lift, "" if c.press is None else c.press) for t, all_ in touches for c in all_]
    yield "contacts", ("time", "a", "b", "force", "lift", "press"), contacts
    yield "tasks", ("start", "end", "task"), [(s.start, s.end, s.name) for s in run.tasks]
    yield "steps", ("start", "end", "step"), [(s.start, s.end, s.name) for s in run.steps]
    yield "events", ("start", "end", "type", "roles"), [(e.start, e.end, e.type, roles_text(e.roles)) for e in run.events]
    yield "messages", ("time", "line", "text"), [(m.time, m.line, m.text) for m in rollout.messages]


def roles_text(roles: dict[str, str]) -> str:
    """Return the roles of an event on one line: "gripper=arm object=coffee"."""
    return " ".join(f"{role}={entity}" for role, entity in roles.items())


def _poses(run: RunRecord) -> Iterator[CsvRow]:
    """Poses of every body at every sample; of a body at rest only once."""
    times = run.scene.times.tolist()
    for body, track in run.scene.poses.items():
        yield from ((time, body, *row) for time, row in zip(times, track.tolist(), strict=False))


def _with_column(times: list[float], rows: list[list[float]], column: list[float]) -> Iterator[CsvRow]:
    return ((time, *row, last) for time, row, last in zip(times, rows, column, strict=True))
