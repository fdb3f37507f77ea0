"""Whether a door with a lever is learned from people's hands: ``adroit_door`` of hand_dapg, which does not belong to the repository.

Run with ``python tests/benchmarks/adroit_door.py FOLDER [--first SEED] [--seeds N]``. From the first three recordings a rule is
learned; known besides are three demonstrations of each task that a hand can show. It is then asked about the other recordings, each as a
whole, of which all are the task; and about stretches and actions of people who show each other task, and about those episodes as wholes,
of which none is. Of each recording, the share of the lever's turn is measured in which the hand touches the lever.
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path

import numpy as np
from figure import add_figure, rate, value, write
from learning import KNOWN, Asked, _text
from learning_demonstrations import all_shown, named

from cramlite import Engine
from cramlite.interpretation.timeline import Timeline
from cramlite.learning.from_episodes import learn_task
from cramlite.learning.learner import covers
from cramlite.learning.span import Span


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--first", type=int, default=600, help="first seed of those who show other tasks (default 600)")
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--cache", type=Path, default=Path("build/learning"), help="folder of recorded episodes")
    add_figure(parser)
    arguments = parser.parse_args()
    engine = Engine()
    hands = [engine.read_episode(path) for path in sorted(arguments.folder.glob("*.npz"))]
    known = [named(s) for _, s in all_shown(engine, KNOWN, arguments.cache)]
    start = time.process_time()
    found = learn_task("unlatching", [(h, None, None) for h in hands[:3]], engine.knowledge, known=known)
    spent = time.process_time() - start
    print(_text(found.learned), found.fillers)
    recognised = [bool(covers(found.learned, _whole(h, engine))) for h in hands[3:]]
    seeds = range(arguments.first, arguments.first + arguments.seeds)
    others = list(all_shown(engine, seeds, arguments.cache))
    asked = Asked(engine, others)
    wrong = [str(s) for s, f in zip(asked.tables.spans, asked.fillings(found.learned), strict=True) if f]
    wrong += [s.name for _, s in others if covers(found.learned, _whole(s.episode, engine))]
    touched = min(_touched(h) for h in hands)
    print(f"{sum(recognised)} of {len(recognised)}; {len(wrong)} false: {wrong[:8]}; {spent:.1f} s of CPU; {touched:.1%} touched")
    numbers = [
        rate("other recordings recognised", sum(recognised), len(recognised)),
        rate("stretches and episodes of other tasks that are recognised", len(wrong), len(asked.of) + len(others)),
        value("least share of a lever's turn in which the hand touches it", round(touched, 3)),
        value("time of learning [s of CPU]", round(spent, 1)),
    ]
    write(arguments, numbers, seeds)


def _touched(episode) -> float:  # noqa: ANN001
    """Share of the lever's way, in either direction, in which the hand touches the lever."""
    times, turned = episode.extras["times"][1:], np.abs(np.diff(episode.extras["joint:lever"]))
    touches = [e for e in episode.events if e.type == "soma:ContactState" and e.roles == {"a": "hand", "b": "lever"}]
    on = np.any([(times > e.start) & (times <= e.end) for e in touches], axis=0)
    return float(turned[on].sum() / turned.sum())


def _whole(episode, engine: Engine) -> Span:  # noqa: ANN001
    return Span(Timeline(episode, engine.knowledge.taxonomy), *episode.span)


if __name__ == "__main__":
    main()
