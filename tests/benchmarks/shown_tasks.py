"""Whether the first reading of a demonstration is right, for each task type that the simulated person can show and that shows.

Run with ``python tests/benchmarks/shown_tasks.py [--first SEED] [--seeds N] [--distractors N]``: each task by N people in N worlds, with
as many further things within reach as asked for. What is right was written down before (``tests/helpers/shown_cases.py``). To reach:
0.95, and 0.9 with distractors. Figures: docs/explanation/interpretation.md.
"""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path

from figure import add_figure, rate, write

sys.path.insert(0, str(Path(__file__).parents[1]))

from helpers.shown_cases import CASES, reading

from cramlite import Engine


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*", default=[*CASES], help="cases; all by default")
    parser.add_argument("--first", type=int, default=300, help="first seed (default 300)")
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--distractors", type=int, default=0)
    add_figure(parser)
    arguments = parser.parse_args()
    engine, total, begin = Engine(), [0, 0, 0], time.process_time()
    for name in arguments.names:
        right = failed = 0
        wrong = []
        for seed in range(arguments.first, arguments.first + arguments.seeds):
            said, missed = reading(engine, CASES[name], seed, arguments.distractors)
            right += said == CASES[name].said
            failed += bool(missed)
            wrong += [f"  {seed}: {', '.join(said)}{f' ({missed})' if missed else ''}"] if said != CASES[name].said else []
        total = [t + n for t, n in zip(total, (right, failed, arguments.seeds), strict=True)]
        print(f"{name}: {right} of {arguments.seeds} right, {failed} did not come off")
        print("\n".join(wrong), end="\n" if wrong else "", flush=True)
    write(arguments, [rate("first reading right", total[0], total[2])], range(arguments.first, arguments.first + arguments.seeds))
    share = total[0] / total[2]
    print(f"all: {total[0]} of {total[2]} ({share:.3f}), {total[1]} did not come off; {time.process_time() - begin:.0f} s of CPU")


if __name__ == "__main__":
    main()
