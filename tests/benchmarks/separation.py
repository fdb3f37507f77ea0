"""Does the proof tell good programs from bad ones? Programs of several runs of ``cramlite experiment``, put together.

    cramlite experiment hang_onto_hanger --set separation --without tuning --out runs/tuning
    cramlite experiment hang_onto_hanger --set separation --without search --out runs/search
    python tests/benchmarks/separation.py runs/tuning runs/search

For each run and for all together, at each scale of errors in execution: what the proof accepted and refused, how often wrongly (Wilson
intervals), the area under the ROC curve of the share of its runs that succeeded, and McNemar's exact test of twins against the nominal
run alone. Programs for one demonstration are no independent cases, so the interval of the area comes from drawing demonstrations, with
all their programs, with replacement (2,000 times, percentiles; seed 0).
"""

from __future__ import annotations

import argparse
import json
import random
from collections.abc import Iterator, Sequence
from pathlib import Path

import msgspec

from cramlite.experiment.report import against_nominal, share
from cramlite.experiment.results import DemonstrationResult
from cramlite.experiment.tables import area_under_curve, tables

DRAWS = 2000
HEAD = ("programs of", "errors", "accepted", "of these failed", "refused", "of these succeeded", "area under the curve",
        "twins refuse what the nominal run accepts")  # fmt: skip

Results = Sequence[DemonstrationResult]


def read(run: Path) -> tuple[str, Results]:
    """What was run, and what came of it."""
    data = json.loads((run / "tables.json").read_text())
    key = data["run"]
    name = f"{key['experiment']}, {key['set']}" + (f", without {key['without']}" if key["without"] else "")
    return name, msgspec.convert(data["demonstrations"], tuple[DemonstrationResult, ...])


def cases(results: Results, scale: float) -> dict[int, list[tuple[float, bool]]]:
    """Seed of the demonstration -> confidence in each of its programs, and whether that succeeded."""
    found: dict[int, list[tuple[float, bool]]] = {}
    for one in results:
        made = [(a.confidence, e.succeeded) for c in one.results for a in c.attempts for e in a.executions if e.scale == scale]
        found.setdefault(one.seed, []).extend(made)
    return found


def area(results: Results, scale: float) -> str:
    """The area and its interval."""
    clusters = list(cases(results, scale).values())
    whole = area_under_curve([case for cluster in clusters for case in cluster])
    if whole is None:
        return "all ended alike"
    draw = random.Random(0)
    drawn = [area_under_curve([case for cluster in draw.choices(clusters, k=len(clusters)) for case in cluster]) for _ in range(DRAWS)]
    areas = sorted(found[0] for found in drawn if found is not None)
    low, high = areas[round(0.025 * (len(areas) - 1))], areas[round(0.975 * (len(areas) - 1))]
    return f"{whole[0]:.2f} ({low:.2f} to {high:.2f})"


def rows(name: str, results: Results) -> Iterator[tuple[str, ...]]:
    """A row for each scale."""
    for c in tables(results).confusions:
        accepted, refused = c.wrongly_accepted, c.wrongly_refused
        yield (name, f"{c.scale:g} x", str(accepted.total), share(accepted), str(refused.total), share(refused),
               area(results, c.scale), against_nominal(c))  # fmt: skip


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("runs", nargs="+", type=Path, help="directories of finished runs")
    runs = [read(run) for run in parser.parse_args().runs]
    together = [one for _, results in runs for one in results]
    print("\n".join("| " + " | ".join(row) + " |" for row in (HEAD, ("---",) * len(HEAD))))
    for name, results in [*runs, ("all together", together)]:
        print("\n".join("| " + " | ".join(row) + " |" for row in rows(name, results)))
    whole = tables(together).whole
    print(f"\nComplete programs, of the candidates that were tried: {share(whole.planned)}; the others never reached simulation.")


if __name__ == "__main__":
    main()
