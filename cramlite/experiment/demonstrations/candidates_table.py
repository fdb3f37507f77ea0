"""Table of candidates: a row for each that was tried, as CSV."""

from __future__ import annotations

import csv
import io

from .results import CandidateResult, DemonstrationResult
from .tables import STAGES

COLUMNS = ("demonstration", "object", "seed", "candidate", "tasks", *STAGES, "confidence", "peak_force_N", "cpu_s", "reason")


def to_csv(results: tuple[DemonstrationResult, ...]) -> str:
    """Return results as CSV: a row for each candidate, with all executions of its program side by side.

    True is written as 1, and numbers are rounded for reading.

    A demonstration without any candidate has one row, with the reason.
    """
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(COLUMNS)
    for one in results:
        rows = [_cells(c) for c in one.results] or [("", "", 0, 0, 0, "", "", "", one.reason)]
        writer.writerows((one.name, one.object, one.seed, *row) for row in rows)
    return out.getvalue()


def _cells(c: CandidateResult) -> tuple[object, ...]:
    executed = " ".join(str(int(e)) for e in c.executed) or 0
    confidence = max((a.confidence for a in c.attempts if a.accepted), default=0.0)
    force = max((e.peak_force for a in c.attempts for e in a.executions), default=0.0)
    numbers = (f"{confidence:.2f}", f"{force:.2f}", f"{sum(c.seconds.values()):.1f}")
    return c.number, " -> ".join(c.tasks), int(c.planned), int(c.simulated), executed, *numbers, c.reason
