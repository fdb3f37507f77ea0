"""How many sentences are understood of what a camera sees: as exactly the goal that was written beside them, or asked back.

    python tests/benchmarks/sentences_pictures.py [--sentences FILE] [--figure NAME --seen no|yes]

FILE is YAML: a mapping from pictures, as suite-task-state of LIBERO, to lists of sentences, each with `say`, and `goal` or `refused` as in
``sentences_strangers.py``; `also` lists further goals that are as right. Things are named as they are in the recognised scene, without a
trailing "_main". Left, right, in front of and behind are, in sentences and goals, those of the picture. Regions that a thing has one of
need not be named; on and in mean the same.

The writers saw the pictures, with the names of things in them, and the language of goals; of the grammar and of words for things they knew
nothing. sentences_pictures_first.yaml, 200 sentences for 20 pictures, was read at 9b4064e1: 102 of 160 exactly the goal, 1 misread, 38 of
40 asked back; looks of kinds, and much of the grammar, were learned from it (154 of 160, 37 of 40). sentences_pictures.yaml, by another
writer, was then read once (docs/figures/sentences_pictures.yaml).
"""

from __future__ import annotations

import argparse
import re
import sys
import tempfile
import time
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import yaml
from figure import add_figure, rate, value, write
from msgspec.structs import replace

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

from cramlite import Engine, NotUnderstood, Setting  # noqa: E402
from cramlite.interpretation.fluents import SymbolicWorld  # noqa: E402
from cramlite.planning.spoken_goals import understand  # noqa: E402
from experiments.libero.by_camera import LiberoByCamera, kinds_of, library_folder  # noqa: E402
from experiments.libero.picture_belief import with_looks  # noqa: E402

SENTENCES = Path(__file__).with_suffix(".yaml")
ONE = ("contain", "cook", "top", "middle", "bottom", "heating")
"""Regions that need not be named."""
SEEN = {"left of": "right of", "right of": "left of", "in front of": "behind", "behind": "in front of"}
"""Sides in a picture -> those of the robot, which looks towards the camera."""


class SeenError(Exception):
    """End of an episode whose scene was recognised."""


class Pictures(LiberoByCamera):
    """LIBERO by camera, of which only the first picture of an episode is looked at."""

    recognised: Setting

    def _understood(self, setting: Setting) -> list[str]:
        self.recognised = setting
        raise SeenError


def seen(bench: Pictures, name: str, engine: Engine) -> tuple[SymbolicWorld, str]:
    """The scene that the first picture of an episode shows, and the point from which it was taken."""
    suite, task, state = name.rsplit("-", 2)
    bench.reset(suite, int(task), int(state))
    try:
        with tempfile.TemporaryDirectory() as folder:
            bench.setting(engine, Path(folder), 0)
    except SeenError:
        pass
    scene = bench.recognised.symbolic(engine.knowledge.taxonomy)
    x, y, _ = bench.camera.position
    return replace(scene, world=with_looks(scene.world, kinds_of(library_folder()))), f"{x:.3f}, {y:.3f}"


def plain(goals: Iterable[str]) -> set[str]:
    """Goals in one way to say them."""
    region = rf"/(?:({'|'.join(ONE)})_region|top_side|surface2?|cavity|floor)\b"
    return {re.sub(region, "", g.replace("_main", "").replace(" in ", " on ")) for g in goals}


def of_robot(goals: Iterable[str]) -> set[str]:
    """Goals whose sides are those of a picture, with those of the robot."""
    swap = re.compile(r"(?<= )(left of|right of|in front of|behind)(?= )")
    return plain(swap.sub(lambda found: SEEN[found[1]], goal) for goal in goals)


def right(entry: Mapping[str, Any], goals: Iterable[str] | None) -> bool:
    """Whether a sentence was understood as its author means it, or refused as it had to be."""
    if "refused" in entry:
        return goals is None
    return goals is not None and plain(goals) in [of_robot(g) for g in (entry["goal"], *entry.get("also", ()))]


def main() -> None:
    """Read the sentences of each picture; print the rates and what went wrong."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sentences", type=Path, default=SENTENCES)
    add_figure(parser)
    options = parser.parse_args()
    engine, bench = Engine(files=[ROOT / "experiments" / "libero" / "panda.py"]), Pictures()
    done: list[tuple[bool, bool, bool]] = []  # whether a goal is wanted, whether it is right, whether any was understood
    seconds = 0.0
    for name, entries in yaml.safe_load(options.sentences.read_text(encoding="utf-8")).items():
        scene, view = seen(bench, name, engine)
        before = time.process_time()
        for entry in entries:
            try:
                goals, said = list(understand(entry["say"], scene, engine.knowledge, view).goals), ""
            except NotUnderstood as error:
                goals, said = None, str(error)
            done.append(("goal" in entry, right(entry, goals), goals is not None))
            if not done[-1][1]:
                asked = entry.get("goal", entry.get("refused"))
                print(f"{name}: {entry['say']}\n  understood: {goals or said[:300]}\n  {asked}", flush=True)
        seconds += time.process_time() - before
    meant, others = [d for d in done if d[0]], [d for d in done if not d[0]]
    exact, back = sum(d[1] for d in meant), sum(d[1] for d in others)
    other = sum(d[2] and not d[1] for d in meant)
    print(f"{exact} of {len(meant)} exactly the goal, {other} misread; {back} of {len(others)} rightly asked back")
    numbers = [
        rate("sentences understood as exactly the goal", exact, len(meant)), rate("sentences read as another goal", other, len(meant)),
        rate("false or ambiguous sentences asked back", back, len(others)), value("CPU time of a sentence", seconds / len(done), "s"),
    ]  # fmt: skip
    write(options, numbers, "the first picture of each episode")


if __name__ == "__main__":
    main()
