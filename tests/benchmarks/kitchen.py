"""Prove kitchens of ``scenarios/kitchen`` for many seeds, nominal proofs without twins: the share that is proven, with its interval.

Each seed varies where things are. With a camera a seed counts only if the first execution in the real world succeeds, too. A search
that takes longer than ``--seconds`` counts as failed. With ``--siblings`` the kitchens that must be refused are asked instead; one whose
search is cut short was not refused.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Iterable
from pathlib import Path
from statistics import median

from figure import add_figure, rate, value, write
from msgspec.structs import replace

from cramlite import Engine, Trace, data_folder, read_scenario
from cramlite.base.errors import CramliteError
from cramlite.base.rate import wilson_interval
from cramlite.experiment.figure import Number
from cramlite.planning.search.budget import budget_of

SIBLING = "_fails"
"""How the names of kitchens end that must be refused."""


def sibling_refused(engine: Engine, path: Path, seed: int, seconds: int) -> str:
    """Empty where a search that was not cut short proves no program, or none that succeeds in the real world."""
    scenario, trace = read_scenario(path), Trace()
    try:
        setting = engine.setting(scenario, seed=seed, twins=0)
        budget = replace(budget_of(scenario), seconds=seconds)
        solution = next(engine.resolve(scenario, setting=setting, seed=seed, budget=budget, trace=trace), None)
    except CramliteError:
        return ""
    if any(e.kind == "budget" and "seconds" in e.numbers for e in trace.entries):
        return f"the search was cut short after {seconds} s"
    if solution is not None and setting.real is not None:
        return "proven, and succeeds" if engine.execute(solution).succeeded else ""
    return "proven" if solution is not None else ""


def solved(engine: Engine, path: Path, seed: int, seconds: int) -> str:
    """Return "" where a program is proven and, with a real world, succeeds there; else the reason."""
    scenario = read_scenario(path)
    try:
        setting = engine.setting(scenario, seed=seed, twins=0)
        budget = replace(budget_of(scenario), seconds=seconds)
        solution = next(engine.resolve(scenario, setting=setting, seed=seed, budget=budget), None)
    except CramliteError as error:
        return str(error)
    if solution is None:
        return "no solution"
    if setting.real is not None:
        solution = engine.execute(solution)
        assert solution.execution is not None
        return "" if solution.succeeded else solution.execution.verdict.reason
    return ""


def table_row(engine: Engine, path: Path, seeds: Iterable[int], seconds: int) -> tuple[Number, Number]:
    """Print a row of the table and why seeds failed; return how many were proven, or siblings refused, and the CPU time."""
    wrong = sibling_refused if path.stem.endswith(SIBLING) else solved
    reasons, times = dict[int, str](), list[float]()
    for seed in seeds:
        begin = time.process_time()
        reasons[seed] = wrong(engine, path, seed, seconds)
        times.append(time.process_time() - begin)
    good = sum(not why for why in reasons.values())
    low, high = wilson_interval(good, len(reasons))
    took = f"{median(times):.0f} s | {max(times):.0f} s"
    print(f"| `{path.stem}` | {good} of {len(reasons)} | {low:.3f} to {high:.3f} | {took} |", flush=True)
    for seed, why in reasons.items():
        if why:
            print(f"  seed {seed}: {why[:300]}", flush=True)
    what = "refused" if wrong is sibling_refused else "proven"
    return rate(path.stem, good, len(reasons), what), value(path.stem, median(times), "s", "CPU, median")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("kitchens", nargs="*", help="names; all that must succeed by default")
    parser.add_argument("--siblings", action="store_true", help="those that must be refused, instead")
    parser.add_argument("--first", type=int, default=1)
    parser.add_argument("--count", type=int, default=10)
    parser.add_argument("--seconds", type=int, default=120, help="of the search, for each seed; 0 for no limit")
    add_figure(parser)
    arguments = parser.parse_args()
    folder, engine = data_folder("scenarios") / "kitchen", Engine()
    names = arguments.kitchens or sorted(p.stem for p in folder.glob("*.yaml") if p.stem.endswith(SIBLING) == arguments.siblings)
    said = "refused" if arguments.siblings else "proven"
    seeds = range(arguments.first, arguments.first + arguments.count)
    print(f"| kitchen | {said} | 95 % interval (Wilson) | processor time, median | longest |\n|---|---|---|---|---|", flush=True)
    rows = [table_row(engine, folder / f"{name}.yaml", seeds, arguments.seconds) for name in names]
    good, runs = sum(r.hits or 0 for r, _ in rows), sum(r.of or 0 for r, _ in rows)
    low, high = wilson_interval(good, runs)
    print(f"| together | {good} of {runs} | {low:.3f} to {high:.3f} | | |")
    write(arguments, [n for row in rows for n in row] + [rate("together", good, runs, said)], seeds)


if __name__ == "__main__":
    main()
