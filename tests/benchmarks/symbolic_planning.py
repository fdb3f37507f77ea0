"""Symbolic planning of goals: 5 to 40 goals in worlds of 10 to 100 things, against lama-first on the exported PDDL.

    python tests/benchmarks/symbolic_planning.py [--goals 5 10 20 40] [--things 10 40 100] [--all]

A world has a floor, a shelf, a tray and blocks, some of them in stacks of three; goals put blocks on the tray, in a fixed order
that a seed chooses. "ours" is CPU time from the goal to the first plan with its reasons, export included; "lama-first" is that of Fast
Downward's driver on the exported files. Child processes count on both sides. The limit is 1.2 times lama-first and 1 s. ``--all``
exports whole worlds.
"""

from __future__ import annotations

import argparse
import os
import random
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path

from figure import add_figure, value, write

from cramlite import Engine, Goal
from cramlite.interpretation.fluents import symbolic_world
from cramlite.model import Pose, Thing, World
from cramlite.planning.symbolic.plan_stream import task_plans
from cramlite.planning.symbolic.planning_problem import PlanningProblem, Scope, planning_problem
from cramlite_plugins.objects.products_and_fixtures import block, table


def room(things: int) -> World:
    """A floor with a shelf, a tray, and blocks: every third place has a stack of three."""
    fixed = [
        table("floor", Pose((0.0, 0.0, -0.005)), size=(4.0, 4.0, 0.02)),
        table("shelf", Pose((0.45, 1.5, 0.15)), size=(0.3, 2.0, 0.02)),
        table("tray", Pose((0.45, -1.5, 0.15)), size=(1.5, 0.5, 0.02)),
    ]
    return World((*fixed, *_blocks(things - len(fixed))), ())


def _blocks(count: int) -> Iterator[Thing]:
    made = 0
    for place in range(count):
        for level in range(3 if place % 3 == 0 else 1):
            if made < count:
                x, y = -1.0 + 0.12 * (place % 16), -0.6 + 0.12 * (place // 16)
                yield block(f"b{made}", Pose((x, y, 0.0355 + 0.061 * level)))
                made += 1


def spent() -> float:
    """CPU time of this process and of its child processes that have ended [s]."""
    return sum(os.times()[:4])


def ours(engine: Engine, world: World, goal: Goal, whole: bool) -> tuple[float, int, PlanningProblem]:
    """CPU seconds to the first plan, its tasks, and the problem."""
    began = spent()
    problem = planning_problem(goal, symbolic_world(world, engine.knowledge.taxonomy), engine.knowledge)
    if whole:
        problem = problem_of_everything(problem)
    plan = next(task_plans(problem))
    return spent() - began, len(plan.steps), problem


class WholeWorld(PlanningProblem):
    """A problem with all things at once."""

    def scopes(self) -> Iterator[Scope]:
        yield Scope(frozenset(self.grounder.things))


def problem_of_everything(problem: PlanningProblem) -> PlanningProblem:
    return WholeWorld(problem.says, problem.facts, problem.wanted, problem.grounder, problem.knowledge)


def reference(problem: PlanningProblem) -> tuple[float, int]:
    """CPU seconds of lama-first on the exported files, and the length of its plan."""
    text = problem.pddl(next(iter(problem.scopes())))
    found = find_spec("up_fast_downward")
    assert found is not None and found.submodule_search_locations
    driver = Path(found.submodule_search_locations[0]) / "downward" / "fast-downward.py"
    with tempfile.TemporaryDirectory() as folder:
        files = [Path(folder) / "domain.pddl", Path(folder) / "problem.pddl"]
        files[0].write_text(text.domain)
        files[1].write_text(text.problem)
        began = spent()
        command = [sys.executable, str(driver), "--plan-file", "plan", "--alias", "lama-first", *map(str, files)]
        subprocess.run(command, cwd=folder, capture_output=True, check=True)
        seconds = spent() - began
        return seconds, sum(line.startswith("(") for line in (Path(folder) / "plan").read_text().splitlines())


def main() -> int:
    """Print a table; 1 where a limit is exceeded."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--goals", type=int, nargs="+", default=[5, 10, 20, 40])
    parser.add_argument("--things", type=int, nargs="+", default=[10, 40, 100])
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--all", action="store_true")
    add_figure(parser)
    chosen = parser.parse_args()
    engine, late, numbers = Engine(), 0, []
    print(f"{'things':>6} {'goals':>5} {'ours [s]':>9} {'tasks':>5} {'lama-first [s]':>14} {'tasks':>5} {'limit [s]':>9}")
    for things in chosen.things:
        world = room(things)
        blocks = [t.name for t in world.things if t.movable]
        for goals in (g for g in chosen.goals if g <= len(blocks)):
            names = random.Random(chosen.seed).sample(blocks, goals)
            goal = Goal(tuple(f"{n} on tray" for n in names))
            mine, tasks, problem = ours(engine, world, goal, chosen.all)
            theirs, length = reference(problem)
            limit = 1.2 * theirs + 1.0
            late += mine > limit
            pair = (("ours", mine), ("lama-first", theirs))
            numbers += [value(f"{things} things, {who}", t, "s", f"{goals} goals", x=goals) for who, t in pair]
            said = f"{mine:9.2f} {tasks:5} {theirs:14.2f} {length:5} {limit:9.2f}"
            print(f"{things:6} {goals:5} {said}{'  LATE' if mine > limit else ''}", flush=True)
    write(chosen, numbers, f"seed {chosen.seed}")
    return 1 if late else 0


if __name__ == "__main__":
    sys.exit(main())
