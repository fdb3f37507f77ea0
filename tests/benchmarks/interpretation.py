"""How long interpretation takes: 1,000 and 10,000 actions against all shipped rules.

Run with ``python tests/benchmarks/interpretation.py [ACTIONS ...]``; prints one line a size. Facts and
rules are loaded before the clock starts. Figures to reach (issue 3): 1,000 actions in 0.3 s, linear growth.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1]))

from interpretation_samples import SHOP, episode, state, track

from cramlite.episode import Episode
from cramlite.interpretation import interpret
from cramlite.ontology import load_taxonomy
from cramlite.resources import data_folder
from cramlite.rules import load_rules
from cramlite_plugins.experts.predicates import all_predicates


def many_actions(actions: int) -> Episode:
    """A hand that takes a product off a hanger and drops it, again and again: eight actions a round."""
    events, hand, product, opening = [], [], [], []
    for k in range(max(actions // 8, 1)):
        t = 8.0 * k
        events += [
            state("contact", "hanger/peg", "product", t, t + 3.6),
            state("support", "hanger/peg", "product", t, t + 3.5),
            state("contact", "hand", "product", t + 2.3, t + 6.15),
            state("grasp", "hand", "product", t + 2.8, t + 6.0),
            state("contact", "product", "basket", t + 6.3, t + 8.0),
            state("support", "basket", "product", t + 6.4, t + 8.0),
        ]
        hand += [(t, 0.1, 0, 1.2), (t + 2, 0.4, 0, 0.95), (t + 4, 0.22, 0, 0.97), (t + 6, 0.32, 0.5, 0.9)]
        product += [(t, 0.5, 0, 0.95), (t + 3, 0.5, 0, 0.95), (t + 4, 0.3, 0, 0.97), (t + 6, 0.4, 0.5, 0.9)]
        opening += [(t, 0.09), (t + 2.2, 0.09), (t + 2.7, 0.02), (t + 5.9, 0.02), (t + 6.3, 0.08)]
    return episode(SHOP, events, {"hand": track(*hand), "product": track(*product)}, np.array(opening))


def main(sizes: list[int]) -> None:
    """Prints: actions, CPU seconds to interpret, CPU seconds to explain every rejection, milliseconds an action."""
    taxonomy = load_taxonomy([data_folder("ontologies")])
    rules = load_rules([data_folder("task_rules")], all_predicates(), taxonomy)
    for size in sizes:
        sample = many_actions(size)
        begin = time.process_time()
        found = interpret(sample, rules, taxonomy, merge=False)
        judged = time.process_time() - begin
        begin = time.process_time()
        merged = interpret(sample, rules, taxonomy)
        joined = time.process_time() - begin
        begin = time.process_time()
        refused = sum(len(a.rejections) for a in found.actions)
        explained = time.process_time() - begin
        begin = time.process_time()
        first = next(merged.sequences())
        ranked = time.process_time() - begin
        print(
            f"{len(found.actions)} actions x {len(rules)} rules: interpreted in {judged:.3f} s "
            f"({1000 * judged / len(found.actions):.3f} ms an action), with merging in {joined:.3f} s; "
            f"{refused} rejections explained in {explained:.3f} s; best of {len(str(merged.count()))}-digit "
            f"number of sequences, {len(first.matches)} tasks, in {ranked:.3f} s"
        )


if __name__ == "__main__":
    main([int(a) for a in sys.argv[1:]] or [1000, 10000])
