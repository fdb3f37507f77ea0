"""Report of an experiment: text for the terminal, JSON, CSV, and the comparison with a stored baseline."""

from __future__ import annotations

import csv
import io
import json
from pathlib import Path
from typing import Any

from msgspec import to_builtins
from msgspec.structs import asdict

from ..base.errors import UserError
from .results import DemonstrationResult
from .spec import ThresholdSpec
from .tables import STAGES, Row, Share, Tables

BASELINE = "baseline.json"
HEADINGS = {"planned": "plan", "simulated": "simulation", "executed": "execution"}


def text(tables: Tables, title: str) -> str:
    """Return the tables as text for a terminal."""
    cells = [["", "gave candidates", "candidates", *HEADINGS.values(), "solved", "first solved"]]
    cells += [_row(r) for r in tables.rows]
    cells.append(["paper", *("" if s is None else s for s in _paper(tables.whole)), "", ""])
    lines = [title, "", *_aligned(cells)]
    c = tables.confusion
    lines += [
        "", "rates are over all candidates that were tried, with 95 % Wilson intervals",
        f"the filter: {c.accepted_succeeded} accepted and right, {c.accepted_failed} accepted and failed in execution, "
        f"{c.refused_failed} refused and right, {c.refused_succeeded} refused though execution succeeds",
    ]  # fmt: skip
    lines += [f"  {n} x {reason}" for reason, n in tables.reasons[:12]]
    lines += [f"  lost: {name}: {why[:200]}" for name, why in tables.lost]
    total = sum(tables.seconds.values()) or 1.0
    lines.append("CPU time: " + ", ".join(f"{k} {v:.0f} s ({v / total:.0%})" for k, v in tables.seconds.items()))
    return "\n".join(lines)


def _aligned(rows: list[list[str]]) -> list[str]:
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return ["  ".join(f"{c:<{w}}" for c, w in zip(row, widths, strict=True)).rstrip() for row in rows]


def _row(row: Row) -> list[str]:
    count = str(row.candidates) if row.tried == row.candidates else f"{row.candidates} ({row.tried} tried)"
    shares = [share(getattr(row, s)) for s in STAGES]
    return [row.object, plain(row.gave), count, *shares, plain(row.solved), plain(row.first)]


def _paper(row: Row) -> list[str | None]:
    published = [s.published for s in (row.gave, *(getattr(row, s) for s in STAGES))]
    said = [f"{p[0]} of {p[1]} ({p[0] / p[1]:.0%})" if p else None for p in published]
    return [said[0], str(published[1][1]) if published[1] else None, *said[1:]]


def plain(value: Share) -> str:
    """Format a share as "27 of 29"."""
    return f"{value.hits} of {value.total}"


def share(value: Share) -> str:
    """Format a share with its rate and interval: "27 of 29 (93 %, 78 to 98)"."""
    low, high = value.interval
    return f"{value.hits} of {value.total} ({100 * value.rate:.0f} %, {100 * low:.0f} to {100 * high:.0f})"


def to_json(tables: Tables, results: tuple[DemonstrationResult, ...], key: dict[str, Any]) -> dict[str, Any]:
    """Return tables, results and run key as JSON values."""
    rows = [_row_json(r) for r in tables.rows]
    return {
        "run": key, "rows": rows, "confusion": to_builtins(tables.confusion), "reasons": tables.reasons,
        "lost": tables.lost, "seconds": tables.seconds, "demonstrations": [to_builtins(r) for r in results],
    }  # fmt: skip


def _row_json(row: Row) -> dict[str, Any]:
    data: dict[str, Any] = to_builtins(row)
    for name, value in asdict(row).items():
        if isinstance(value, Share):
            data[name] |= {"rate": value.rate, "interval": value.interval, "reached": value.reached}
    return data


def to_csv(results: tuple[DemonstrationResult, ...]) -> str:
    """Return a CSV table with a line for each candidate."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(
        ["demonstration", "object", "seed", "candidate", "tasks", *STAGES, "peak_force_N", "cpu_s", "reason"]
    )
    for one in results:
        for c in one.results:
            forces = [a.execution.peak_force for a in c.attempts if a.execution]
            writer.writerow(
                [one.name, one.object, one.seed, c.number, " -> ".join(c.tasks), *(int(getattr(c, s)) for s in STAGES),
                 f"{max(forces, default=0.0):.2f}", f"{sum(c.seconds.values()):.1f}", c.reason]
            )  # fmt: skip
        if not one.results:
            writer.writerow([one.name, one.object, one.seed, "", "", 0, 0, 0, "", "", one.reason])
    return out.getvalue()


def baseline(tables: Tables) -> dict[str, Any]:
    """Return the counts of a run that are stored to compare later ones with."""
    rows = {}
    for row in tables.rows:
        counts = {s: [getattr(row, s).hits, getattr(row, s).total] for s in (*STAGES, "solved", "first", "gave")}
        rows[row.object] = {"candidates": row.candidates, **counts}
    return {"rows": rows, "confusion": to_builtins(tables.confusion)}


def against_baseline(tables: Tables, path: Path, key: str) -> list[str]:
    """Return the differences from the stored tables of the same set, in words; a note if there are none.

    Raises:
        UserError: the file is damaged.
    """
    try:
        stored = json.loads(path.read_text()) if path.is_file() else {}
        before = stored.get(key, {}).get("rows")
    except (OSError, ValueError, AttributeError) as error:
        raise UserError(
            f"The baseline '{path}' is damaged ({error}); delete it, or take it from version control."
        ) from error
    if before is None:
        return [f"no baseline of '{key}' is stored; --keep-baseline stores this one"]
    now = baseline(tables)["rows"]
    changes = [
        f"{name}, {column}: {_count(was)} before, {_count(now.get(name, {}).get(column))} now"
        for name, row in before.items()
        for column, was in row.items()
        if now.get(name, {}).get(column) != was
    ]
    return changes or ["as the baseline in every cell"]


def _count(value: Any) -> str:
    return f"{value[0]} of {value[1]}" if isinstance(value, list) else str(value)


def missed_thresholds(tables: Tables, limits: ThresholdSpec) -> list[str]:
    """Return the thresholds that are not reached, in words."""
    shares = {name: getattr(tables.whole, name) for name in ("solved", *STAGES)}
    return [
        f"{name}: {plain(value)} is less than {getattr(limits, name):.0%}"
        for name, value in shares.items()
        if value.rate < getattr(limits, name)
    ]
