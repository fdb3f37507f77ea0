"""Whether rules of tasks that only a robot does are learned again from its runs: leave one out over the rules that a hand cannot show.

Run with ``python tests/benchmarks/learning_runs.py [--examples N] [--first SEED] [--seeds N]``. It is counted as in ``learning.py``. The
examples are the runs in which a scenario's first program was proven (without twins), recorded as ``cramlite resolve`` writes them; a task
was done from the first to the last sample in which its code ran, with the looks before it. Known besides, and asked about, are the runs
of the other tasks, and people who show what a hand can show. Runs in other scenes, none of which is shown, are asked about, too.
"""

from __future__ import annotations

import argparse
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from figure import add_figure, rate, write
from learning import CACHE, KNOWN, Lesson, Outcome, numbers, told
from learning_demonstrations import Done, Shown
from meaning import looks_included, spans

from cramlite import Engine, find_scenario, read_scenario
from cramlite.base.value import replace
from cramlite.experiment.figure import Number

SCENARIOS: Mapping[str, str] = {
    "soma:LookingAt": "tasks/looking_at",
    "soma:LookingFor": "tasks/looking_for",
    "soma:Navigating": "tasks/navigating",
    "soma:ParkingArms": "tasks/parking_arms",
}
"""Task with a rule file that no hand can show -> scenario in which a robot does it."""
ELSEWHERE = ("tasks/looking_at_mobile", "late_pose", "fetch_from_table", "take_off_hanger_tasks")
"""Other scenarios whose runs have these tasks among others. LookingFor has none."""


def run(engine: Engine, name: str, seed: int) -> Shown | None:
    """The first proven run of a scenario, with the tasks of its plan; None if nothing is proven."""
    scenario = read_scenario(find_scenario(name))
    solution = next(engine.resolve(scenario, setting=engine.setting(scenario, seed=seed, twins=0)), None)
    episode = solution.candidate.episode if solution is not None else None
    if solution is None or episode is None:
        print(f"{name}, seed {seed}: nothing is proven")
        return None
    candidate = solution.candidate
    when, done = spans(candidate), list[Done]()
    for action in candidate.actions:
        if action.name in when and not action.name.startswith("0."):  # these are looks before the plan
            start, end = looks_included(when, candidate, action)[action.name]
            done.append(Done(action.task, start, end, {k: o.entity for k, o in action.roles.items() if o.entity}))
    return Shown(f"{name}_{seed}", replace(episode, name=f"{name}_{seed}"), tuple(done))


class RunLesson(Lesson):
    """A lesson with runs of robots beside the people."""

    def demonstrations(self, seeds: range) -> Iterator[tuple[str, Shown]]:
        yield from super().demonstrations(seeds)
        elsewhere = {name: name for name in ELSEWHERE if seeds[0] != KNOWN[0]}
        for key, name in {**SCENARIOS, **elsewhere}.items():
            yield from ((key, shown) for seed in seeds if (shown := run(self.engine, name, seed)) is not None)

    def other_scenes(self, found: Sequence[Outcome]) -> list[Number]:
        """What was recognised of the runs elsewhere, and which rules have a role for the thing that the robot was told."""
        by = {one.task: one for one in found}
        asked = [(k, done.task, done.fillers) for k, _, done in self.asked.of if done]
        there = Counter((task, k) for k, task, _ in asked if k in ELSEWHERE and task in by)
        hits = sum(n - by[task].which.get(f"missed in {k}", 0) for (task, k), n in there.items() if by[task].right)
        with_thing = [one for one in found if any(task == one.task and fillers for _, task, fillers in asked)]
        return [
            rate("stretches recognised in scenes of which no run was shown", hits, there.total()),
            rate("rules with a role, where the robot was told a thing", sum(one.roles > 0 for one in with_thing), len(with_thing)),
        ]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("tasks", nargs="*", default=[*SCENARIOS], help="classes of tasks; all by default")
    parser.add_argument("--examples", type=int, default=len(KNOWN))
    parser.add_argument("--first", type=int, default=900, help="first seed of the runs and people that are asked about (default 900)")
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--cache", type=Path, default=CACHE, help=f"folder of recordings of people (default {CACHE})")
    parser.set_defaults(losses=0.0, wrong=False)
    add_figure(parser)
    arguments = parser.parse_args()
    lesson = RunLesson(arguments)
    found = [told(lesson.outcome(task)) for task in arguments.tasks]
    write(arguments, [*numbers(found), *lesson.other_scenes(found)], range(arguments.first, arguments.first + arguments.seeds))


if __name__ == "__main__":
    main()
