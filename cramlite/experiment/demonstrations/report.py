"""Report of demonstrations: text for the terminal, JSON, HTML, and the comparison with a stored baseline."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from msgspec.structs import asdict

from ...base.errors import UserError
from ...base.rate import Rate
from ..figure import Number
from ..measured import rates
from ..page import page
from .results import DemonstrationResult
from .spec import ThresholdSpec
from .tables import STAGES, Confusion, ObjectRow, ObjectTables, Share

BASELINE = "baseline.json"
HEADINGS = {"planned": "plan", "simulated": "simulation", "executed": "execution"}


def text(tables: ObjectTables, title: str) -> str:
    """Return the tables of an experiment with demonstrations as text for a terminal."""
    scales = [c.scale for c in tables.confusions]
    harder = [f"at {k:g} x errors" for k in scales[1:]]
    cells = [["", "came off", "gave candidates", "candidates", *HEADINGS.values(), *harder, "solved", "first solved"]]
    cells += [_row(r) for r in tables.rows]
    if tables.whole.executed.published:
        cells.append(["paper", "", *("" if s is None else s for s in _paper(tables.whole)), *[""] * len(harder), "", ""])
    lines = [title, "", *_aligned(cells)]
    lines += ["", "rates are over all candidates that were tried, with 95 % Wilson intervals"]
    lines += ["the paper executed on a real robot, we in simulated twins"] if tables.whole.executed.published else []
    lines += [f"proof against execution at {c.scale:g} x errors: {of_filter(c)}" for c in tables.confusions]
    lines += [f"  {n} x {reason}" for reason, n in tables.reasons[:12]]
    lines += [f"  lost: {name}: {why[:200]}" for name, why in tables.lost]
    total = sum(tables.seconds.values()) or 1.0
    lines.append("CPU time: " + ", ".join(f"{k} {v:.0f} s ({v / total:.0%})" for k, v in tables.seconds.items()))
    return "\n".join(lines)


def _aligned(rows: list[list[str]]) -> list[str]:
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return ["  ".join(f"{c:<{w}}" for c, w in zip(row, widths, strict=True)).rstrip() for row in rows]


def _row(row: ObjectRow) -> list[str]:
    count = str(row.candidates) if row.tried == row.candidates else f"{row.candidates} ({row.tried} tried)"
    shares = [share(s) for s in (*(getattr(row, s) for s in STAGES), *row.harder)]
    return [row.object, plain(row.came_off), plain(row.gave), count, *shares, plain(row.solved), plain(row.first)]


def numbers(tables: ObjectTables) -> list[Number]:
    """Return the success rates of each object's demonstrations and candidates, as numbers for a figure's YAML
    file."""
    scales = [c.scale for c in tables.confusions]
    return [number for row in tables.rows for number in rates(row.object, _columns(row, scales))]


def _columns(row: ObjectRow, scales: Sequence[float]) -> dict[str, Rate]:
    stages = {HEADINGS[s]: getattr(row, s) for s in STAGES}
    harder = {f"execution, {k:g} x": s for k, s in zip(scales[1:], row.harder, strict=False)}
    return {"came off": row.came_off, "gave candidates": row.gave, **stages, **harder, "solved": row.solved, "by the first": row.first}


def _paper(row: ObjectRow) -> list[str | None]:
    published = [s.published for s in (row.gave, *(getattr(row, s) for s in STAGES))]
    said = [f"{p[0]} of {p[1]} ({p[0] / p[1]:.0%})" if p else None for p in published]
    return [said[0], str(published[1][1]) if published[1] else None, *said[1:]]


def of_filter(c: Confusion) -> str:
    """Format how well the proof predicted which programs succeed in execution."""
    return (
        f"of the accepted programs {share(c.wrongly_accepted)} failed, of the refused ones {share(c.wrongly_refused)} succeeded; "
        f"area under the ROC curve: {area(c)}; refused by twins but not by the nominal run: {against_nominal(c)}"
    )


def area(c: Confusion) -> str:
    """Format the area under the ROC curve of the proof's confidence, with its 95 % interval."""
    found = c.area_under_curve
    return f"{found[0]:.2f} ({found[1]:.2f} to {found[2]:.2f})" if found else "all ended alike"


def against_nominal(c: Confusion) -> str:
    """Format how often twins are right to refuse programs that the nominal run accepts, with the P value
    of McNemar's test."""
    if c.mcnemar is None:
        return "never"
    return f"{c.doubted_failed} rightly, {c.doubted_succeeded} wrongly, McNemar p {c.mcnemar:.2g}"


def plain(value: Share) -> str:
    """Format a share as "27 of 29"."""
    return f"{value.hits} of {value.total}"


def share(value: Share) -> str:
    """Format a share with its rate and interval: "27 of 29 (93 %, 78 to 98)"."""
    low, high = value.interval
    return f"{value.hits} of {value.total} ({100 * value.rate:.0f} %, {100 * low:.0f} to {100 * high:.0f})"


def to_json(tables: ObjectTables, results: Sequence[DemonstrationResult], key: dict[str, Any]) -> dict[str, Any]:
    """Return the tables, the results, and the key that identifies the run's inputs as JSON values."""
    return {"run": key, **asdict(tables), "demonstrations": results}


def html(
    title: str, about: list[str], tables: ObjectTables, results: Sequence[DemonstrationResult], changes: list[str], folder: Path
) -> str:
    """Render the report of demonstrations as HTML.

    Args:
        about: what was run, in lines for people.
        changes: against the baseline.
        folder: of the demonstrations' files, where the pictures are.
    """
    return page(
        __package__, title, about=about, tables=tables, results=results, changes=changes, stages=STAGES, headings=HEADINGS,
        share=_share, plain=plain, area=area, nominal=against_nominal, folder=folder,
    )  # fmt: skip


def _share(value: Share) -> str:
    """Format a rate for a table cell as counts and interval, with a line break allowed only between these two."""
    counts, _, rest = share(value).partition(" (")
    return counts.replace(" ", "\u00a0") + " (" + rest.replace(" ", "\u00a0")


def baseline(tables: ObjectTables) -> dict[str, Any]:
    """Return the counts of the tables that are stored as the baseline for comparing later runs."""
    rows = {}
    for row in tables.rows:
        counts = {s: [getattr(row, s).hits, getattr(row, s).total] for s in (*STAGES, "solved", "first", "gave", "came_off")}
        rows[row.object] = {"candidates": row.candidates, **counts}
    cells = [[c.accepted_succeeded, c.accepted_failed, c.refused_succeeded, c.refused_failed] for c in tables.confusions]
    return {"rows": rows, "confusions": cells}


def against_baseline(tables: ObjectTables, path: Path, key: str) -> list[str]:
    """Return in words how the counts of the tables differ from the stored baseline; a note if they do not,
    or if no baseline is stored.

    Raises:
        UserError: the file is damaged.
    """
    try:
        stored = json.loads(path.read_text(encoding="utf-8")) if path.is_file() else {}
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


def missed_thresholds(tables: ObjectTables, limits: ThresholdSpec) -> list[str]:
    """Return a sentence for each success rate that is below its threshold."""
    shares = {name: getattr(tables.whole, name) for name in ("solved", *STAGES)}
    return [
        f"{name}: {plain(value)} is less than {getattr(limits, name):.0%}"
        for name, value in shares.items()
        if value.rate < getattr(limits, name)
    ]
