"""Table of candidates: a row for each that was tried, as CSV and as Parquet."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator
from typing import Any

from .results import CandidateResult, DemonstrationResult
from .tables import STAGES

PARQUET = "candidates.parquet"
COLUMNS = ("demonstration", "object", "seed", "candidate", "tasks", *STAGES, "confidence", "peak_force_N", "cpu_s", "reason")


def rows(results: tuple[DemonstrationResult, ...]) -> Iterator[dict[str, Any]]:
    """Generate a row for each candidate, and one for each demonstration without any; keys are ``COLUMNS``."""
    for one in results:
        about = {"demonstration": one.name, "object": one.object, "seed": one.seed}
        for c in one.results:
            yield about | _row(c)
        if not one.results:
            nothing = {"planned": False, "simulated": False, "executed": (), "reason": one.reason}
            yield dict.fromkeys(COLUMNS) | about | nothing


def _row(c: CandidateResult) -> dict[str, Any]:
    forces = [e.peak_force for a in c.attempts for e in a.executions]
    return {
        "candidate": c.number, "tasks": " -> ".join(c.tasks), "planned": c.planned, "simulated": c.simulated, "executed": c.executed,
        "confidence": max((a.confidence for a in c.attempts if a.accepted), default=0.0),
        "peak_force_N": max(forces, default=0.0), "cpu_s": sum(c.seconds.values()), "reason": c.reason,
    }  # fmt: skip


def to_csv(results: tuple[DemonstrationResult, ...]) -> str:
    """Return the table as CSV: true is 1, executions stand side by side, numbers are rounded for reading."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(COLUMNS)
    for row in rows(results):
        writer.writerow([_cell(name, row[name]) for name in COLUMNS])
    return out.getvalue()


def _cell(name: str, value: Any) -> Any:
    if value is None:
        return ""
    if name == "executed":
        return " ".join(str(int(e)) for e in value) or 0
    if isinstance(value, bool):
        return int(value)
    return f"{value:.{1 if name == 'cpu_s' else 2}f}" if isinstance(value, float) else value


def to_parquet(results: tuple[DemonstrationResult, ...]) -> bytes:
    """Return the table as a Parquet file, with the columns of the CSV; ``executed`` is a list, what there is not is null."""
    import pyarrow
    from pyarrow import parquet

    kinds = {
        "seed": pyarrow.int64(), "candidate": pyarrow.int64(), "planned": pyarrow.bool_(), "simulated": pyarrow.bool_(),
        "executed": pyarrow.list_(pyarrow.bool_()), "confidence": pyarrow.float64(), "peak_force_N": pyarrow.float64(),
        "cpu_s": pyarrow.float64(),
    }  # fmt: skip
    schema = pyarrow.schema([(name, kinds.get(name, pyarrow.string())) for name in COLUMNS])
    out = pyarrow.BufferOutputStream()
    parquet.write_table(pyarrow.Table.from_pylist(list(rows(results)), schema), out)
    data: bytes = out.getvalue().to_pybytes()
    return data
