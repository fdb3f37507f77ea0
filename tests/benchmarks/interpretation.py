"""Time of interpretation: 100, 1,000 and 10,000 actions against all shipped rules, and the same in clingo and SWI-Prolog.

Run with ``python tests/benchmarks/interpretation.py [ACTIONS ...] [--compare N] [--out growth.png]``. Facts and
rules are loaded before the clock starts. To reach: 1,000 actions in 0.3 s, linear growth, 5 times as fast as
SWI-Prolog on the same facts.
"""

from __future__ import annotations

import argparse
import os
import sys
import time
from collections.abc import Callable
from operator import itemgetter
from pathlib import Path
from typing import Any

import numpy as np
from figure import add_figure, value, write

sys.path.insert(0, str(Path(__file__).parents[1]))

from helpers.interpretation_samples import SHOP, episode, state, track
from helpers.rule_translations import Fact, clingo_facts, clingo_program, facts_of, prolog_facts, prolog_program
from helpers.timeline_translation import (
    VARIANTS,
    absent,
    by_clingo,
    by_prolog,
    clingo_timeline,
    timeline_facts,
    timeline_program,
)

from cramlite import data_folder
from cramlite.interpretation.decision_tree import BindingsByTask, DecisionTree
from cramlite.interpretation.interpretation import interpret, paused_collector
from cramlite.interpretation.matching import Phases
from cramlite.interpretation.rules import RuleBook, load_rules
from cramlite.model import Episode
from cramlite.ontology.taxonomy import Taxonomy, load_taxonomy
from cramlite.plugin import Timeline
from cramlite_plugins.predicates.relations import all_predicates


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


def measured(size: int, rules: RuleBook, taxonomy: Taxonomy) -> tuple[int, float, float]:
    """Actions, and CPU seconds to judge them alone and with joining neighbours; the better of three runs."""
    sample = many_actions(size)
    seconds = []
    for merge in (False, True):
        runs = []
        for _ in range(3):
            begin = time.process_time()
            interpret(sample, rules, taxonomy, merge=merge)
            runs.append(time.process_time() - begin)
        seconds.append(min(runs))
    return len(Timeline(sample, taxonomy).segments()), seconds[0], seconds[1]


Matches = set[tuple[Any, ...]]


def compared(size: int, rules: RuleBook, taxonomy: Taxonomy) -> None:
    """The same facts through clingo and SWI-Prolog; prints CPU seconds, ratios, and whether the matches are the same."""
    sample = many_actions(size)
    timeline = Timeline(sample, taxonomy)
    segments = timeline.segments()
    columns = [timeline.phases(s) for s in segments]
    names = [e.name for e in sample.entities]
    loaded, matches = least([lambda: from_timeline(sample, rules, taxonomy)] * 5)
    known, _ = least([lambda: from_rows(timeline, columns, rules)] * 5)
    print(f"{len(segments)} actions: ours {loaded:.3f} s from the loaded episode, {known:.3f} s from known rows")
    print("from the loaded timeline:")
    line("clingo", by_clingo(clingo_timeline(rules, timeline, segments)), loaded, matches)
    facts = list(timeline_facts(timeline, segments))
    for variant in [] if absent() else VARIANTS:
        line(f"SWI-Prolog, {variant}", by_prolog(timeline_program(rules, variant), facts), loaded, matches)
    print("from facts that our predicates have judged, for each action and phase (making them is not counted):")
    judged = [facts_of(rules, p, names) for p in columns]
    line("clingo", by_clingo(judged_clingo(rules, judged, names)), known, matches)
    if not absent():
        facts = [fact for k, own in enumerate(judged) for fact in (*prolog_facts(own, k), f"act({k}).")]
        line("SWI-Prolog", by_prolog(prolog_program(rules), facts), known, matches)


def line(name: str, theirs: tuple[float, Matches], ours: float, matches: Matches) -> None:
    seconds, found = theirs
    same = f"the same {len(found)}" if found == matches else f"OTHER {len(found)}"
    print(f"  {name}: {seconds:.3f} s, {seconds / ours:.1f} times ours; {same} matches")


def least(runs: list[Callable[[], tuple[float, Matches]]]) -> tuple[float, Matches]:
    return min((run() for run in runs), key=itemgetter(0))


def from_timeline(sample: Episode, rules: RuleBook, taxonomy: Taxonomy) -> tuple[float, Matches]:
    """Time of phases, predicates (with all measuring) and rules; for Prolog its own work and the measuring."""
    begin = time.process_time()
    with paused_collector():  # as ``interpret`` does
        timeline = Timeline(sample, taxonomy)
        solved = DecisionTree(rules, timeline).solve_all([timeline.phases(s) for s in timeline.segments()])
    return time.process_time() - begin, filled(rules, solved)


def from_rows(timeline: Timeline, columns: list[Phases], rules: RuleBook) -> tuple[float, Matches]:
    """Time of the rules only: the values of predicates are known from a run before."""
    tree = DecisionTree(rules, timeline)
    tree.solve_all(columns)
    tree = DecisionTree(rules, timeline)
    begin = time.process_time()
    solved = tree.solve_all(columns)
    return time.process_time() - begin, filled(rules, solved)


def filled(rules: RuleBook, solved: list[BindingsByTask]) -> Matches:
    roles = {r.task: tuple(r.roles) for r in rules}
    return {(k, t, *(str(b[r]) for r in roles[t])) for k, f in enumerate(solved) for t, bs in f.items() for b in bs}


def judged_clingo(rules: RuleBook, judged: list[list[Fact]], names: list[str]) -> list[str]:
    facts = [text for k, known in enumerate(judged) for text in clingo_facts(known, [], f"{k}, ")]
    return [*clingo_program(rules, ("A",)), *facts, *clingo_facts([], names), f"act(0..{len(judged) - 1})."]


def plot(rows: list[tuple[int, float, float]], path: Path) -> None:
    """Seconds over actions, both axes logarithmic, with a line of slope one to compare with."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    actions, alone, joined = zip(*rows, strict=True)
    figure, axes = pyplot.subplots(figsize=(5, 4))
    axes.loglog(actions, alone, "o-", label="every action judged")
    axes.loglog(actions, joined, "s-", label="and neighbours joined")
    axes.loglog(actions, [joined[0] * a / actions[0] for a in actions], ":", color="grey", label="linear")
    axes.set(xlabel="actions", ylabel="CPU time [s]", title="Interpretation against all rules")
    axes.legend()
    figure.savefig(path, dpi=120, bbox_inches="tight")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("sizes", nargs="*", type=int, default=[100, 1000, 10000])
    parser.add_argument(
        "--compare", type=int, default=1000, help="actions for clingo and SWI-Prolog; 0 leaves them out"
    )
    parser.add_argument("--out", type=Path, help="a PNG of the growth")
    add_figure(parser)
    arguments = parser.parse_args()
    taxonomy = load_taxonomy([data_folder("ontologies")])
    rules = load_rules([data_folder("task_rules")], all_predicates(), taxonomy)
    print(f"load of the machine: {os.getloadavg()[0]:.2f}; {len(rules)} rules")
    rows, numbers = [], []
    for size in arguments.sizes:
        actions, alone, joined = row = measured(size, rules, taxonomy)
        rows.append(row)
        each = 1000 * joined / actions
        numbers.append(value("with neighbours joined", each, "ms an action", f"{actions} actions", x=actions))
        print(f"{actions} actions: judged in {alone:.3f} s, with joining in {joined:.3f} s ({each:.3f} ms an action)")
    if arguments.compare:
        compared(arguments.compare, rules, taxonomy)
    if arguments.out:
        plot(rows, arguments.out)
    write(arguments, numbers)


if __name__ == "__main__":
    main()
