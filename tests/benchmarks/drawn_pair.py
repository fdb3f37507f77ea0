"""Two versions of cramlite on the same drawn problems, paired: docs/how-to/drawn_problems.md.

    python tests/benchmarks/drawn_pair.py file CHECKOUT --out old.yaml    # the experiment's file for another version's checkout
    python tests/benchmarks/drawn_pair.py compare OLD_RUN NEW_RUN         # their run directories

An episode without a program is a failure; one whose benchmark died, in either version, is left out and told.
"""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from collections.abc import Iterable, Mapping
from math import comb
from pathlib import Path

import yaml
from figure import add_figure, rate, write
from msgspec import json

from cramlite.base.rate import wilson_interval
from cramlite.experiment.benchmark.results import EpisodeResult
from cramlite.experiment.figure import Number

LIBERO = Path(__file__).parents[2] / "experiments" / "libero"
SUITE = "drawn"
Pair = tuple[EpisodeResult, EpisodeResult]


def experiment_for(checkout: Path) -> str:
    """Return the experiment's file for a checkout that does not know the suite: all its paths are those of the checkout."""
    folder = checkout.resolve() / "experiments" / "libero"
    found = yaml.safe_load((folder / "experiment.yaml").read_text(encoding="utf-8"))
    here = yaml.safe_load((LIBERO / "experiment.yaml").read_text(encoding="utf-8"))
    found["suites"][SUITE] = here["suites"][SUITE]
    key = next(k for k in ("benchmark", "judge") if k in found)  # the old name of the key
    found[key], found["plugins"] = str(folder / found[key]), [str(folder / name) for name in found["plugins"]]
    return yaml.safe_dump(found, sort_keys=False, width=140)


def results(run: Path) -> dict[int, EpisodeResult]:
    """Read the results of drawn problems in a run directory, by seed."""
    paths = (run / "episodes").glob(f"{SUITE}-*/result.json")
    found = (json.decode(p.read_bytes(), type=EpisodeResult) for p in paths)
    return {r.task: r for r in found}


def paired(old: Mapping[int, EpisodeResult], new: Mapping[int, EpisodeResult]) -> list[Pair]:
    """Return the episodes of two versions, by seed.

    Raises:
        SystemExit: they did not play the same problems.
    """
    if sorted(old) != sorted(new):
        sys.exit(f"The versions did not play the same seeds; only one of them has {sorted(set(old) ^ set(new))}.")
    wrong = [s for s in old if not _same(old[s], new[s])]
    if wrong:
        sys.exit(f"The problems of seeds {wrong} are not the same files; their digests differ.")
    return [(old[s], new[s]) for s in sorted(old)]


def _same(one: EpisodeResult, other: EpisodeResult) -> bool:
    """Return the key by which equal tasks are found: the digest of the benchmark's files, and the goal."""
    return one.name == other.name


def kind_of(result: EpisodeResult) -> str:
    """Return the kind of a problem's goal, from its name: "1a2b3c4d In + Open: put ..."."""
    return result.name.partition(" ")[2].partition(":")[0]


def chance(only_old: int, only_new: int) -> float:
    """Return how likely a difference as large is among discordant pairs if the versions are equal: McNemar's exact test, two-sided."""
    most, all_of = max(only_old, only_new), only_old + only_new
    tail = sum(comb(all_of, k) for k in range(most, all_of + 1)) / 2**all_of
    return min(1.0, 2.0 * tail)


def numbers(pairs: Iterable[Pair]) -> list[Number]:
    """Print the table, and return the numbers of a figure."""
    kept = [p for p in pairs if not any(r.apart for r in p)]
    found = list[Number]()
    kinds = sorted({kind_of(new) for _, new in kept})
    groups = [("all", kept), *((k, [p for p in kept if kind_of(p[1]) == k]) for k in kinds)]
    for kind, among in groups:
        for version, place in (("old", 0), ("new", 1)):
            hits = sum(p[place].rest() for p in among)
            low, high = wilson_interval(hits, len(among))
            print(f"| {kind} | {version} | {hits} of {len(among)} | {low:.3f} to {high:.3f} |")
            found.append(rate(kind, hits, len(among), f"true at rest, {version}"))
    for version, place in (("old", 0), ("new", 1)):
        if passed := [p[place] for p in kept if p[place].proven]:
            found.append(rate("a passing verdict was right", sum(r.rest(unlimited=True) for r in passed), len(passed), version))
    both = Counter((old.rest(), new.rest()) for old, new in kept)
    print(f"both {both[True, True]}, only old {both[True, False]}, only new {both[False, True]}, neither {both[False, False]}; "
          f"McNemar, exact: p = {chance(both[True, False], both[False, True]):.3g}")  # fmt: skip
    return found


def main() -> None:
    """Write a file, or compare two runs."""
    parser = argparse.ArgumentParser(description=__doc__)
    asked = parser.add_subparsers(dest="asked", required=True)
    file = asked.add_parser("file")
    file.add_argument("checkout", type=Path)
    file.add_argument("--out", type=Path, required=True)
    compare = asked.add_parser("compare")
    compare.add_argument("old", type=Path)
    compare.add_argument("new", type=Path)
    add_figure(compare)
    asked = parser.parse_args()
    if asked.asked == "file":
        asked.out.write_text(experiment_for(asked.checkout), encoding="utf-8")
        return
    pairs = paired(results(asked.old), results(asked.new))
    apart = [p[0].task for p in pairs if any(r.apart for r in p)]
    print(f"{len(pairs)} problems; the benchmark died in {apart}" if apart else f"{len(pairs)} problems")
    cpu = sum(sum(r.seconds.values()) for pair in pairs for r in pair)
    seeds = [p[0].task for p in pairs]
    write(asked, numbers(pairs), f"{seeds[0]} to {seeds[-1]}", cpu)


if __name__ == "__main__":
    main()
