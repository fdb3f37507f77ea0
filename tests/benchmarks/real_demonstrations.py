"""Recordings of people as demonstrations in worlds of one's own: how many give a proven program, and whether siblings are refused.

Run with ``python tests/benchmarks/real_demonstrations.py RECORDING ... [--first SEED] [--seeds N] [--siblings KIND ...]``: each
recording in N worlds (``tests/helpers/own_worlds.py``), and in each of them with the bowl or the vessel changed so that it cannot be
done. Programs are proven in the believed world alone with CRAMLITE_TWINS=0. Figure: docs/figures/real_demonstrations.yaml.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

from figure import add_figure, rate, write

sys.path.insert(0, str(Path(__file__).parents[1]))

from helpers.own_worlds import SIBLINGS, own_world

from cramlite import Engine, Trace, read_scenario
from cramlite.base.rate import wilson_interval


def resolved(engine: Engine, recording: Path, seed: int, kind: str) -> tuple[str, str]:
    """The tasks of the first proven program with their roles, "" for none; and all reasons of the search."""
    trace = Trace()
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "own.yaml"
        path.write_text(own_world(recording, seed, kind))
        solution = next(iter(engine.resolve(read_scenario(path), seed=seed, trace=trace)), None)
    if solution is None:
        return "", "; ".join(dict.fromkeys(e.reason for e in trace.entries if e.outcome in ("refused", "impossible", "failed")))
    said = (f"{a.task.split(':')[1]} {' '.join(r.entity or '' for r in a.roles.values())}" for a in solution.candidate.actions)
    return ", ".join(said), ""


def as_expected(kind: str, done: str, reasons: str) -> bool:
    """Whether there is a program that handles the jug, or none, for the reason that the sibling was made for."""
    if not kind:
        return done.startswith("Grasping jug,")
    return not done and any(words in reasons for words in SIBLINGS[kind])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("recordings", nargs="+", type=Path)
    parser.add_argument("--first", type=int, default=500, help="first seed (default 500)")
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--siblings", nargs="*", choices=list(SIBLINGS), default=list(SIBLINGS))
    add_figure(parser)
    arguments = parser.parse_args()
    engine, numbers = Engine(), []
    for recording in arguments.recordings:
        for kind in ("", *arguments.siblings):
            right, begin, lines = Counter[bool](), time.process_time(), list[str]()
            for seed in range(arguments.first, arguments.first + arguments.seeds):
                done, reasons = resolved(engine, recording.resolve(), seed, kind)
                fine = as_expected(kind, done, reasons)
                right[fine] += 1
                lines += [] if fine else [f"  {seed}: {done or reasons[-600:]}"]
                lines += [f"  {done}"] if done and fine and right[True] == 1 else []
            low, high = wilson_interval(right[True], arguments.seeds)
            said = f"{right[True]} of {arguments.seeds} ({100 * low:.0f} to {100 * high:.0f} %)"
            used = time.process_time() - begin
            print(f"{recording.name}, {kind or 'as drawn'}: {said}, {used:.0f} s of CPU", *lines, sep="\n", flush=True)
            numbers.append(rate(kind or "as drawn", right[True], arguments.seeds, recording.name))
    write(arguments, numbers, range(arguments.first, arguments.first + arguments.seeds))


if __name__ == "__main__":
    main()
