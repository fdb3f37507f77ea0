"""Shaking learned again from a real recording of a person, with the shipped rule hidden, and done by a robot.

A person shakes salt over a plate four times (``SHAKES``; recorded in virtual reality, 10 poses a second). From two of the shakes a task
is learned, and asked about the other two, about all other actions of that recording, and about those of a recording in which a person
pours. A robot does the task in worlds of the scenario that is written with the learned package, each with the block elsewhere; a run
counts if its program was proven (so the learned rule holds while the task is done), and this file's own look at the poses says that the
block went up and down twice or more.

    python tests/benchmarks/learned_real.py [--data FOLDER] [--first SEED] [--count N]
"""

from __future__ import annotations

import argparse
import shutil
import tempfile
import time
from pathlib import Path

import numpy as np
from figure import add_figure, rate, value, write

from cramlite import Engine, read_scenario
from cramlite.base.resources import data_folder
from cramlite.interpretation.timeline import Timeline
from cramlite.learning.from_episodes import learn_task
from cramlite.learning.learner import covers
from cramlite.learning.package import thing_name, write_package
from cramlite.learning.proposal import Proposal
from cramlite.learning.span import Span
from cramlite.model import Episode
from cramlite.scenario.scenario import Scenario

DATA = Path(__file__).resolve().parents[3] / "shared" / "data" / "neem_real"
SHAKES = ((4.0, 6.3), (6.2, 8.5))
"""Two shakes each, from lowest to lowest place, by eye [s from the beginning of the recording]."""
NAME, THING, BLOCK = "sprinkling", "salt_container", thing_name("Patient")
DOWN = 0.03
"""Way down and up that counts as a shake [m]: half of the person's."""
VARY = f"vary:\n  - {{thing: {BLOCK}, position: 50 mm, yaw: 30 deg}}\n"


def without_shaking(folder: Path) -> Engine:
    """The engine without the rule of shaking."""
    rules = folder / "rules"
    shutil.copytree(data_folder("task_rules"), rules, ignore=shutil.ignore_patterns("shaking.yaml"))
    engine = Engine(rules=rules)
    assert not any("cram:Shaking" in (r.task, *(c.text for c in r.clauses)) for r in engine.knowledge.rules)
    return engine


def found(engine: Engine, proposal: Proposal, episode: Episode, start: float, end: float) -> bool:
    """Whether the learned rule recognises a stretch of an episode, in seconds from its beginning."""
    first = episode.span[0]
    return bool(covers(proposal.learned, Span(Timeline(episode, engine.knowledge.taxonomy), first + start, first + end)))


def others(engine: Engine, episode: Episode) -> list[tuple[float, float]]:
    """Actions of an episode but for those in which the salt is shaken, in seconds from its beginning."""
    first, shaken = episode.span[0], (SHAKES[0][0], SHAKES[-1][1])
    each = [(a.start - first, a.end - first) for a in engine.interpret(episode).actions]
    return [(a, b) for a, b in each if THING not in episode.tracks or b <= shaken[0] + 0.1 or a >= shaken[1] - 0.4]


def shaken(heights: np.ndarray) -> int:
    """How often a thing that was lifted goes up, and down again, by ``DOWN`` each."""
    from scipy.signal import find_peaks

    return len(find_peaks(heights, prominence=DOWN)[0])


def robot_does(engine: Engine, scenario: Scenario, seed: int) -> bool:
    """Whether a robot shakes the block in the world of a seed."""
    solution = next(engine.resolve(scenario, setting=engine.setting(scenario, seed=seed, twins=0), seed=seed), None)
    if solution is None or solution.candidate.episode is None:
        print(f"seed {seed}: no program", flush=True)
        return False
    often = shaken(solution.candidate.episode.tracks[BLOCK].poses[:, 2])
    print(f"seed {seed}: {often} shakes", flush=True)
    return often >= 2


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--data", type=Path, default=DATA, help=f"folder of the recordings (default {DATA})")
    parser.add_argument("--first", type=int, default=1)
    parser.add_argument("--count", type=int, default=10)
    add_figure(parser)
    arguments = parser.parse_args()
    seeds = range(arguments.first, arguments.first + arguments.count)
    right = false = of = done = 0
    times = []
    with tempfile.TemporaryDirectory() as name:
        engine = without_shaking(Path(name))
        salt, pouring = (engine.read_episode(arguments.data / f"{kind}NEEM") for kind in ("ShakingMotion", "KitchenLab"))
        for k, (start, end) in enumerate(SHAKES):
            begun = time.process_time()
            proposal = learn_task(NAME, [(salt, salt.span[0] + start, salt.span[0] + end)], engine.knowledge)
            times.append(time.process_time() - begun)
            print({phase: list(texts) for phase, texts in proposal.rule.items()}, flush=True)
            right += found(engine, proposal, salt, *SHAKES[1 - k])
            asked = [(salt, *s) for s in others(engine, salt)]
            asked += [(pouring, *s) for s in (*others(engine, pouring), (0.0, pouring.span[1] - pouring.span[0]))]
            false, of = false + sum(found(engine, proposal, *one) for one in asked), of + len(asked)
            written = write_package(proposal, NAME, Path(name) / f"package_{k}")
            module, file = (next(p for p in written if p.name == n) for n in ("__init__.py", f"try_{NAME}.yaml"))
            file.write_text(file.read_text(encoding="utf-8") + VARY, encoding="utf-8")
            robots = Engine(files=[module])
            done += sum(robot_does(robots, read_scenario(file), seed) for seed in seeds)
    numbers = [
        rate("pairs of shakes recognised that were not learned from", right, len(SHAKES)),
        rate("other actions that are recognised, those of pouring among them", false, of),
        rate("worlds in which a ur5e shakes a block", done, len(SHAKES) * len(seeds)),
        value("longest time of learning [s of CPU]", round(max(times), 1)),
    ]
    write(arguments, numbers, seeds)
    print(numbers)


if __name__ == "__main__":
    main()
