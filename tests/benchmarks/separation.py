"""Does the proof tell good programs from bad ones? Programs of several runs of ``cramlite experiment``, put together.

    cramlite experiment hang_onto_hanger --set separation --without tuning --out runs/tuning
    cramlite experiment hang_onto_hanger --set separation --without search --out runs/search
    python tests/benchmarks/separation.py runs/tuning runs/search

For each run and for all together, at each scale of errors in execution: what the proof accepted and refused, how often wrongly (Wilson
intervals), the area under the ROC curve of the share of its runs that succeeded (Newcombe's interval), and McNemar's exact test of
twins against the nominal run alone. Programs for one demonstration count as independent cases.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator, Sequence
from pathlib import Path

import msgspec
from figure import add_figure, write

from cramlite.experiment.demonstrations.report import against_nominal, area, share
from cramlite.experiment.demonstrations.results import DemonstrationResult
from cramlite.experiment.demonstrations.tables import tables
from cramlite.experiment.figure import Number
from cramlite.experiment.measured import rates

HEAD = ("programs of", "errors", "accepted", "of these failed", "refused", "of these succeeded", "area under the curve",
        "twins refuse what the nominal run accepts")  # fmt: skip

Results = Sequence[DemonstrationResult]


def read(run: Path) -> tuple[str, Results]:
    """Settings of a run, and its results."""
    data = json.loads((run / "tables.json").read_text())
    key = data["run"]
    name = f"{key['experiment']}, {key['set']}" + ", short" * key["short"] + (f", without {key['without']}" if key["without"] else "")
    return name, msgspec.convert(data["demonstrations"], tuple[DemonstrationResult, ...])


def rows(name: str, results: Results) -> Iterator[tuple[str, ...]]:
    """A row for each scale."""
    for c in tables(results).confusions:
        accepted, refused = c.wrongly_accepted, c.wrongly_refused
        yield (name, f"{c.scale:g} x", str(accepted.total), share(accepted), str(refused.total), share(refused),
               area(c), against_nominal(c))  # fmt: skip


def numbers(name: str, results: Results) -> Iterator[Number]:
    """The rates of a run at each scale."""
    for c in tables(results).confusions:
        columns = {"accepted, of these failed": c.wrongly_accepted, "refused, of these succeeded": c.wrongly_refused}
        yield from rates(f"{name}, {c.scale:g} x", dict(columns))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("runs", nargs="+", type=Path, help="directories of finished runs")
    add_figure(parser)
    options = parser.parse_args()
    runs = [read(run) for run in options.runs]
    together = [one for _, results in runs for one in results]
    print("\n".join("| " + " | ".join(row) + " |" for row in (HEAD, ("---",) * len(HEAD))))
    for name, results in [*runs, ("all together", together)]:
        print("\n".join("| " + " | ".join(row) + " |" for row in rows(name, results)))
    whole = tables(together).whole
    print(f"\nComplete programs, of the candidates that were tried: {share(whole.planned)}; the others never reached simulation.")
    write(options, (n for name, results in [*runs, ("all together", together)] for n in numbers(name, results)))


if __name__ == "__main__":
    main()
