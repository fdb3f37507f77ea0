"""How long interpretation takes: 100, 1,000 and 10,000 actions against all shipped rules, and what others need.

Run with ``python tests/benchmarks/interpretation.py [ACTIONS ...] [--compare N] [--out growth.png]``. Facts and
rules are loaded before the clock starts. To reach: 1,000 actions in 0.3 s, linear growth, 5 times as fast as
SWI-Prolog on the same facts.
"""

from __future__ import annotations

import argparse
import os
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1]))

from interpretation_samples import SHOP, episode, state, track
from rule_translations import Fact, clingo_facts, clingo_program, facts_of, prolog_facts, prolog_program

from cramlite.decision import DecisionTree
from cramlite.episode import Episode
from cramlite.interpretation import interpret
from cramlite.ontology import Taxonomy, load_taxonomy
from cramlite.phases import Timeline
from cramlite.resources import data_folder
from cramlite.rules import RuleBook, load_rules
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


def compared(size: int, rules: RuleBook, taxonomy: Taxonomy) -> None:
    """The same facts through clingo and SWI-Prolog; prints seconds, ratios, and whether the matches are the same."""
    sample = many_actions(size)
    timeline = Timeline(sample, taxonomy)
    segments = timeline.segments()
    tree = DecisionTree(rules, timeline)
    begin = time.process_time()
    columns = [timeline.phases(s) for s in segments]
    solved = tree.solve_all(columns)
    ours = time.process_time() - begin
    begin = time.process_time()
    tree.solve_all(columns)
    known = time.process_time() - begin
    roles = {r.task: tuple(r.roles) for r in rules}
    matches = {(k, t, *(str(b[r]) for r in roles[t])) for k, f in enumerate(solved) for t, bs in f.items() for b in bs}
    names = [e.name for e in sample.entities]
    begin = time.process_time()
    facts = [facts_of(rules, timeline.phases(s), names) for s in segments]
    made = time.process_time() - begin
    print(f"{len(segments)} actions: ours {ours:.3f} s from states and poses, {known:.3f} s from known rows")
    print(f"facts for the others, which cannot work out predicates: {made:.3f} s, not counted below")
    for name, solve in (("clingo", by_clingo), ("SWI-Prolog", by_prolog)):
        theirs = solve(rules, facts, names)
        if theirs is None:
            print(f"{name}: absent, left out")
            continue
        seconds, found = theirs
        print(
            f"{name}: {seconds:.3f} s, {seconds / ours:.1f} times ours with predicates, {seconds / known:.1f} times "
            f"ours without; {'the same' if found == matches else 'OTHER'} {len(found)} matches"
        )


def by_clingo(rules: RuleBook, facts: list[list[Fact]], names: list[str]) -> tuple[float, set[tuple[Any, ...]]] | None:
    """CPU seconds to ground and solve; reading the facts is not counted."""
    try:
        import clingo
    except ImportError:
        return None
    control = clingo.Control(["--warn=none"])
    lines = [line for k, known in enumerate(facts) for line in clingo_facts(known, [], f"{k}, ")]
    lines += [*clingo_facts([], names), f"act(0..{len(facts) - 1})."]
    control.add("base", [], "\n".join([*clingo_program(rules, ("A",)), *lines]))
    begin = time.process_time()
    control.ground([("base", [])])
    with control.solve(yield_=True) as handle:
        symbols = next(iter(handle)).symbols(atoms=True)
    seconds = time.process_time() - begin
    found = [s.arguments for s in symbols if s.name.startswith("match")]
    return seconds, {(a[0].number, *(x.string for x in a[1:])) for a in found}


def by_prolog(rules: RuleBook, facts: list[list[Fact]], _names: list[str]) -> tuple[float, set[tuple[Any, ...]]] | None:
    """CPU seconds of a second run over all matches, so that its just-in-time indices exist; loading is not counted."""
    if shutil.which("swipl") is None:
        return None
    with tempfile.TemporaryDirectory() as folder:
        lines = sorted(line for k, known in enumerate(facts) for line in prolog_facts(known, k))
        lines += [f"act({k})." for k in range(len(facts))]
        path = Path(folder) / "rules.pl"
        path.write_text("\n".join([*prolog_program(rules), *lines]))
        goal = (
            "findall(x, match(_,_,_), _), statistics(cputime, B), findall(m(A,T,R), match(A,T,R), L), "
            "statistics(cputime, E), S is E - B, writeln(S), sort(L, U), "
            "forall(member(m(A,T,R), U), (atomic_list_concat([A,T|R], ' ', W), writeln(W))), halt"
        )
        done = subprocess.run(["swipl", "-q", "-g", goal, str(path)], capture_output=True, text=True, check=True)
    first, *rows = done.stdout.splitlines()
    return float(first), {(int(k), *others) for k, *others in (row.split() for row in rows)}


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
    arguments = parser.parse_args()
    taxonomy = load_taxonomy([data_folder("ontologies")])
    rules = load_rules([data_folder("task_rules")], all_predicates(), taxonomy)
    print(f"load of the machine: {os.getloadavg()[0]:.2f}; {len(rules)} rules")
    rows = []
    for size in arguments.sizes:
        actions, alone, joined = row = measured(size, rules, taxonomy)
        rows.append(row)
        each = 1000 * joined / actions
        print(f"{actions} actions: judged in {alone:.3f} s, with joining in {joined:.3f} s ({each:.3f} ms an action)")
    if arguments.compare:
        compared(arguments.compare, rules, taxonomy)
    if arguments.out:
        plot(rows, arguments.out)


if __name__ == "__main__":
    main()
