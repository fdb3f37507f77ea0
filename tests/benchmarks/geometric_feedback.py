"""What geometry that talks back to the planner is worth: kitchens over seeds, and questions against a plain enumeration.

Run: python tests/benchmarks/geometric_feedback.py kitchens [--seeds 10] [NAME ...]
     python tests/benchmarks/geometric_feedback.py curve [--most 6]

``kitchens`` resolves the scenarios whose goals need tasks that no rule asks for, proven nominally, and prints how many of the seeds
were proven, and why the sibling of each is not. ``curve`` counts the questions about places and motions that plugins are asked until a
block that stands between 1 to 6 others is on a tray: with the planner told what was in the way, and with every set of the others put
aside in turn, the smallest first, without their orders.
"""

from __future__ import annotations

import argparse
import itertools
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from statistics import median

from figure import add_figure, rate, value, write

from cramlite import Engine, Scenario, Setting, Trace, find_scenario, nearest_miss, read_scenario
from cramlite.experiment.figure import Number
from cramlite.planning.trace import KNOWN

KITCHENS = ("boxed_in", "drawer_blocked", "regrasp")
WORLD = """
scenario: between
goal: [prize on tray]
robot: {type: ur5e}
things:
  - {name: floor, model: table, at: {position: [0.2, 0, -5 mm]}, with: {size: [1.6 m, 1.6 m, 20 mm]}}
  - {name: tray, model: table, at: {position: [0.45, -0.35, 0.15]}, with: {size: [0.25 m, 0.25 m, 20 mm]}}
  - {name: prize, model: block, at: {position: [0.5, 0.15, 31 mm]}}
"""
PLACES = ((0.5, 0.23), (0.5, 0.07), (0.58, 0.15), (0.42, 0.15), (0.58, 0.23), (0.42, 0.07))
"""Where the others stand [m]: on the four sides first, then at two corners."""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=("kitchens", "curve"))
    parser.add_argument("names", nargs="*", default=KITCHENS)
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--most", type=int, default=len(PLACES))
    add_figure(parser)
    given, engine, numbers = parser.parse_args(), Engine(), list[Number]()
    if given.what == "kitchens":
        for name in given.names or KITCHENS:
            numbers += kitchen(engine, name, given.seeds)
    else:
        print("| others | questions, told what was in the way | sequences | questions, plain enumeration | sequences |")
        for count in range(1, given.most + 1):
            found = (*told(engine, count), *plain(engine, count))
            print(f"| {count} | {' | '.join(map(str, found))} |", flush=True)
            rows = (("told what was in the way", *found[:2]), ("plain enumeration", *found[2:]))
            numbers += [value(w, n, "questions", f"{count} others", x=count, note="" if s else "no program") for w, n, s in rows]
    write(given, numbers, f"0 to {given.seeds - 1}" if given.what == "kitchens" else "0")


def kitchen(engine: Engine, name: str, seeds: int) -> list[Number]:
    """Print and return how many seeds of a scenario are proven, and how long each took."""
    scenario, seconds, proven = read_scenario(find_scenario(f"kitchen/{name}")), list[float](), 0
    for seed in range(seeds):
        begun = time.process_time()
        setting = engine.setting(scenario, seed=seed, twins=0)
        proven += next(engine.resolve(scenario, setting=setting, seed=seed), None) is not None
        seconds.append(time.process_time() - begun)
        print(f"{name} seed {seed}: {proven} of {seed + 1} proven, {seconds[-1]:.0f} s of work", flush=True)
    sibling, trace = read_scenario(find_scenario(f"kitchen/{name}_fails")), Trace()
    solution = next(engine.resolve(sibling, setting=engine.setting(sibling, twins=0), trace=trace), None)
    miss = nearest_miss(trace.entries)
    print(f"{name}_fails: {'PROVEN' if solution is not None else 'no program'}; {miss.reason if miss else 'no reason'}", flush=True)
    return [rate(name, proven, seeds, "proven"), value(name, median(seconds), "s", "CPU, median")]


def told(engine: Engine, count: int) -> tuple[int, int]:
    """Return the questions, and the task sequences, of the goal."""
    scenario = between(count, "")
    return asked(engine, scenario, engine.setting(scenario, twins=0))


def plain(engine: Engine, count: int) -> tuple[int, int]:
    """Return the questions, and the task sequences, of a search that puts sets of other things aside until the thing comes
    off."""
    questions = 0
    for tries, aside in enumerate(subsets(count), 1):
        tasks = [f"  - {{task: PickAndPlace, Locatum: other_{k}, Relatum: floor}}" for k in aside]
        listed = "\n".join(["tasks:", *tasks, "  - {task: PickAndPlace, Locatum: prize, Relatum: tray}"])
        scenario = between(count, listed)
        found, solved = asked(engine, scenario, engine.setting(scenario, twins=0))
        questions += found
        if solved:
            return questions, tries
    return questions, 0


def subsets(count: int) -> Iterator[tuple[int, ...]]:
    for size in range(count + 1):
        yield from itertools.combinations(range(count), size)


def between(count: int, tasks: str) -> Scenario:
    """Return the scenario with a number of other things; with tasks in the place of the goal where they are given."""
    others = [f"  - {{name: other_{k}, model: block, at: {{position: [{x}, {y}, 31 mm]}}}}" for k, (x, y) in enumerate(PLACES[:count])]
    text = WORLD.replace("goal: [prize on tray]", tasks) if tasks else WORLD
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "between.yaml"
        path.write_text(text + "\n".join(others) + "\n")
        return read_scenario(path)


def asked(engine: Engine, scenario: Scenario, setting: Setting) -> tuple[int, int]:
    """Return the questions about places and motions, and the number of the task sequence that was proven; 0 for none."""
    trace = Trace()
    solution = next(engine.resolve(scenario, setting=setting, trace=trace), None)
    new = (e for e in trace.entries if e.outcome == "asked" and e.reason != KNOWN)
    questions = sum(e.kind in ("location", "motion") for e in new)
    return questions, solution.number if solution is not None else 0


if __name__ == "__main__":
    main()
