"""Episodes of LIBERO, one after another: ``python experiments/libero/run.py --suite S --tasks A,B --states A:B --out DIR``.

One line of ``results.jsonl`` an episode; episodes that are there already are left out.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from pathlib import Path

from connection import PLACE, Judge
from episode import Result, play
from msgspec import json

from cramlite import CramliteError


def done(path: Path) -> set[tuple[str, int, int]]:
    """Episodes that were played."""
    lines = path.read_bytes().splitlines() if path.exists() else []
    return {(r.suite, r.task, r.state) for r in (json.decode(line, type=Result) for line in lines)}


def numbers(text: str) -> Iterator[int]:
    """The numbers of "0,2,8:12": from 8 to 11."""
    for part in text.split(","):
        first, _, end = part.partition(":")
        yield from range(int(first), int(end) if end else int(first) + 1)


def main() -> int:
    """Play episodes; the exit code is 2 where the judge cannot be used."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--suite", required=True)
    parser.add_argument("--tasks", required=True, help="such as 0,2,8:12")
    parser.add_argument("--states", default="0", help="such as 0:5")
    parser.add_argument("--twins", type=int, default=0, help="worlds that a program must stand before it is streamed (default 0)")
    parser.add_argument("--judge", type=Path, default=PLACE, help=f"folder of LIBERO's environment (default {PLACE})")
    parser.add_argument("--out", type=Path, required=True)
    options = parser.parse_args()
    results = options.out / "results.jsonl"
    options.out.mkdir(parents=True, exist_ok=True)
    before = done(results)
    try:
        with Judge(options.judge) as judge, results.open("ab") as file:
            for task in numbers(options.tasks):
                for state in numbers(options.states):
                    if (options.suite, task, state) in before:
                        continue
                    result = play(judge, options.suite, task, state, options.out / f"{options.suite}-{task}-{state}", options.twins)
                    file.write(json.encode(result) + b"\n")
                    file.flush()
                    print(said(result), flush=True)
    except CramliteError as error:
        print(f"libero: {error}", file=sys.stderr)
        return error.exit_code
    return 0


def said(r: Result) -> str:
    """An episode in one line."""
    truth = f"first {r.first}, at rest {r.rest}, {r.steps} of {r.budget} steps" if r.proven else "not attempted"
    why = f"; {r.reason.splitlines()[0]}" if r.reason else ""
    return f"{r.suite} {r.task} {r.state} {r.name}: {r.outcome}; {truth}; {r.resolving:.1f} s to prove{why}"


if __name__ == "__main__":
    sys.exit(main())
