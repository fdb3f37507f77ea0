"""Procedures learned from sequences of jobs with a known partial order.

Ten jobs of 5 to 9 steps are drawn. Of each, a procedure is learned from sequences in which each exchangeable pair occurs both ways, and
another from five random sequences. Counted are the pairs of the order (F1), ten correct runs a job, and in ten a job one mistake: a step
left out, or two steps exchanged that have an order.

    python tests/benchmarks/procedures.py [--first SEED] [--jobs N]
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from itertools import combinations

import numpy as np
from figure import add_figure, rate, value, write

from cramlite.learning.procedure import Procedure, Step, deviations, procedure

Order = set[tuple[int, int]]
"""Pairs of steps, by their numbers, of which the first one comes before the second one."""
RUNS, RANDOM = 10, 5


def drawn(rng: np.random.Generator) -> tuple[list[Step], Order]:
    """Steps of a job, and a partial order of them, closed under transitivity."""
    count = int(rng.integers(5, 10))
    above = {(i, j) for i, j in combinations(range(count), 2) if rng.random() < 0.35}
    for k in range(count):
        above |= {(i, j) for i in range(count) for j in range(count) if (i, k) in above and (k, j) in above}
    return [Step("soma:Placing", (("Locatum", f"thing_{k}"),)) for k in range(count)], above


def run(steps: Sequence[Step], above: Order, rng: np.random.Generator, first: Sequence[int] = ()) -> list[Step]:
    """An order of the steps that the partial order allows, drawn; those of ``first`` and what they need as early as can be."""
    left, found = list(range(len(steps))), list[int]()
    early = {j for j in left if j in first or any((j, i) in above for i in first)}
    while left:
        ready = [j for j in left if not any((i, j) in above for i in left)]
        ready = [j for j in ready if j in early] or ready
        found.append(ready[int(rng.integers(len(ready)))])
        left.remove(found[-1])
    return [steps[k] for k in found]


def shown(steps: Sequence[Step], above: Order, rng: np.random.Generator) -> list[list[Step]]:
    """Demonstrations in which each exchangeable pair occurs both ways, and at least five."""
    free = [(i, j) for i, j in combinations(range(len(steps)), 2) if (i, j) not in above]
    found = [run(steps, above, rng) for _ in range(RANDOM)]
    for i, j in free:
        found += [run(steps, above, rng, (i,)), run(steps, above, rng, (j,))]
    return found


def learned(seed: int, steps: Sequence[Step], above: Order) -> Procedure:
    """The procedure of a job."""
    return procedure(shown(steps, above, np.random.default_rng([seed, 1])))


def f1(known: Procedure, steps: Sequence[Step], above: Order) -> float:
    """How well a learned order agrees with the true one."""
    true = {(steps[i], steps[j]) for i, j in above}
    return 2 * len(true & known.order) / (len(true) + len(known.order)) if true or known.order else 1.0


def missed(good: Sequence[Step], rng: np.random.Generator) -> tuple[list[Step], str, tuple[Step, ...]]:
    """A run without one step, and the deviation to be named."""
    gone = int(rng.integers(len(good)))
    return [*good[:gone], *good[gone + 1 :]], "step missing", (good[gone],)


def exchanged(
    good: Sequence[Step], steps: Sequence[Step], above: Order, rng: np.random.Generator
) -> tuple[list[Step], str, tuple[Step, ...]]:
    """A run with two steps exchanged that have an order, and the deviation to be named."""
    i, j = sorted(above)[int(rng.integers(len(above)))]
    bad = [steps[j] if s == steps[i] else steps[i] if s == steps[j] else s for s in good]
    return bad, "wrong order", (steps[j], steps[i])


def blamed(known: Procedure, done: Sequence[Step]) -> bool:
    """Whether a procedure finds a mistake in a run."""
    return any(d.mistake for d in deviations(known, done))


def named(known: Procedure, mistake: tuple[list[Step], str, tuple[Step, ...]]) -> bool:
    """Whether a procedure names the mistake of a run."""
    done, what, about = mistake
    return (what, about) in [(d.what, d.steps) for d in deviations(known, done) if d.mistake]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--jobs", type=int, default=10)
    add_figure(parser)
    arguments = parser.parse_args()
    seeds = range(arguments.first, arguments.first + arguments.jobs)
    numbers = []
    for said in ("each pair both ways", "five random sequences"):
        agreed, wrong, right = [], 0, 0
        for seed in seeds:
            steps, above = drawn(np.random.default_rng(seed))
            few = [run(steps, above, np.random.default_rng([seed, 3, k])) for k in range(RANDOM)]
            known = learned(seed, steps, above) if said.startswith("each") else procedure(few)
            agreed.append(f1(known, steps, above))
            rng = np.random.default_rng([seed, 2])
            for k in range(RUNS):
                good = run(steps, above, rng)
                wrong += blamed(known, good)
                right += named(known, missed(good, rng) if k % 2 or not above else exchanged(good, steps, above, rng))
        numbers += [
            value(f"{said}: least F1 of the order", round(min(agreed), 3)),
            value(f"{said}: mean F1 of the order", round(float(np.mean(agreed)), 3)),
            rate(f"{said}: correct runs in which a mistake is found", wrong, RUNS * len(seeds)),
            rate(f"{said}: mistakes that are named", right, RUNS * len(seeds)),
        ]
    write(arguments, numbers, seeds)
    print(*numbers, sep="\n")


if __name__ == "__main__":
    main()
