"""How many sentences of a stranger are understood as exactly the goal that was written beside them, and how many are asked back.

    python tests/benchmarks/sentences_strangers.py [--sentences FILE] [--figure NAME --seen no|yes]

FILE is YAML: a mapping from names of shipped scenarios (in scenarios/, such as kitchen/tidy_ten) to lists of sentences. Each
has `say`, the sentence, and either `goal`, the list of all that should hold in the end, in the words of goals
(docs/reference/scenarios/goals.md), or `refused`, why it is to be asked back: false of the scene, or ambiguous in it.

    kitchen/kitchen_of_thirteen:
      - {say: "Could you put the tin in the drawer and shut it?", goal: ["tin in drawer", "drawer closed"]}
      - {say: "Put the spoon on the tray.", refused: "there is no spoon"}

`also` may list further goals that are as right. On and in mean the same, as goals have it, `off` is `not on`, and a class of things is all
their names. Left is +y and far is +x, as the robot at the origin sees it. What is read besides the goal counts as a miss.

sentences_strangers.yaml, sentences_second.yaml, sentences_third.yaml, sentences_eight_a.yaml, sentences_eight_b.yaml, sentences_ten.yaml,
sentences_latest.yaml, sentences_five.yaml and sentences_ordinary.yaml are by people who had not read the grammar;
sentences_development.yaml is by one who had,
and is for its development. The grammar has been learned from all of them, so that none measures any more what it does with a stranger's
sentence. Before
that, each was read once: the third at a5664a22, 48 of 80 exactly the goal, 0 misread, 18 of 20 asked back; eight_a (four persons: chatty,
in telegrams, in the order of German, a child) at f8bfc82d, 16 of 128, 2 misread, 32 of 32; eight_b (four persons) at f8bfc82d, 46 of 128,
1 misread, 32 of 32; sentences_ten.yaml, by ten persons, at 318cb90c, 62 of 80, 2 misread, 20 of 20; sentences_latest.yaml, by ten others
(stories, reasons and conditions around the request), at c089b958, 26 of 80, 1 misread, 19 of 20; sentences_five.yaml, by five others, at
495f8bf9, 7 of 40, 1 misread, 10 of 10; sentences_ordinary.yaml, everyday instructions by three others, at 6457a69f, 144 of 160, 3 misread,
39 of 40 (docs/figures/sentences_*.yaml); the second at c769349e, 54 of 80, 2 misread, 20 of 20.
"""

from __future__ import annotations

import argparse
import re
import sys
import time
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import yaml
from figure import add_figure, rate, value, write

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

from cramlite import Engine, NotUnderstood, read_scenario  # noqa: E402
from cramlite.base.resources import find_scenario  # noqa: E402
from cramlite.interpretation.fluents import SymbolicWorld  # noqa: E402
from cramlite.planning.spoken_goals import understand  # noqa: E402

SENTENCES = Path(__file__).with_suffix(".yaml")


def plain(goals: Iterable[str], scene: SymbolicWorld) -> set[str]:
    """Goals with names only, with one word for on and in, and one for off and not on."""
    return {g for goal in goals for g in _named(goal.replace(" in ", " on "), scene)}


def _named(goal: str, scene: SymbolicWorld) -> list[str]:
    words = re.sub(r"(\d+) cm", lambda found: f"{found[1]}0 mm", goal).split()
    if "off" in words:
        words = ["not", *("on" if w == "off" else w for w in words)]
    if words[0] == "any":
        return [" or ".join(sorted(_named(" ".join(("each", *words[1:])), scene)))]
    if words[0] != "each":
        return [" or ".join(sorted(" ".join(words).split(" or ")))]
    class_, rest = f"cram:{words[1].removeprefix('cram:')}", words[2:]
    things = (t.name for t in scene.world.things if scene.is_a(t.name, class_) and t.name not in rest)
    return [" ".join((name, *rest)) for name in things]


def read(sentence: str, scene: SymbolicWorld, engine: Engine) -> tuple[list[str] | None, str]:
    """The goals that a sentence is understood as, or none and what is asked back."""
    try:
        return list(understand(sentence, scene, engine.knowledge).goals), ""
    except NotUnderstood as error:
        return None, str(error)


def right(entry: dict[str, Any], goals: list[str] | None, scene: SymbolicWorld) -> bool:
    """Whether a sentence was understood as its author means it, or refused as it had to be."""
    if "refused" in entry or goals is None:
        return "refused" in entry and goals is None
    return any(plain(goals, scene) == plain(meant, scene) for meant in (entry["goal"], *entry.get("also", ())))


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    options.add_argument("--sentences", type=Path, default=SENTENCES)
    add_figure(options)
    asked = options.parse_args()
    hits: dict[str, list[bool]] = {"goal": [], "refused": []}
    misread, cpu = 0, 0.0
    for name, entries in yaml.safe_load(asked.sentences.read_text()).items():
        engine = Engine()
        scene = engine.setting(read_scenario(find_scenario(name))).symbolic(engine.knowledge.taxonomy)
        for entry in entries:
            kind, before = "refused" if "refused" in entry else "goal", time.process_time()
            goals, why = read(entry["say"], scene, engine)
            cpu += time.process_time() - before
            hits[kind].append(right(entry, goals, scene))
            misread += kind == "goal" and goals is not None and not hits[kind][-1]
            if not hits[kind][-1]:
                print(f"{name}: {entry['say']}\n  understood: {goals or why}\n  {kind}: {entry[kind]}")
    meant, refused = hits["goal"], hits["refused"]
    print(f"{sum(meant)} of {len(meant)} exactly the goal, {misread} misread; {sum(refused)} of {len(refused)} rightly asked back")
    numbers = [
        rate("sentences understood as exactly the goal", sum(meant), len(meant)),
        rate("sentences read as another goal", misread, len(meant)),
        rate("false or ambiguous sentences asked back", sum(refused), len(refused)),
        value("CPU time of a sentence", cpu / (len(meant) + len(refused)), "s"),
    ]
    write(asked, numbers, seeds="seed 0 of each scenario")


if __name__ == "__main__":
    main()
