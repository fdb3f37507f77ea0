"""Share of sentences of LIBERO's tasks that are understood as exactly the goal of their problem file, in the scene of their
first state.

    python tests/benchmarks/sentences.py --kept FOLDER [--tasks odd|even|all] [--environment DIR] [--suites libero_90 ...]

The sentences are those that the benchmark has (`language`); its environment is installed as docs/how-to/libero.md says. Scenes are kept in
``--kept``, so that a second run takes seconds. Tasks with odd numbers are for development, even ones are measured once a grammar is done.
A region stands for its thing where it is the only one, and on and in mean the same of a region, as goals have it; "within 30 mm" is
LIBERO's own and nobody says it. What a sentence asks for beyond the goal (a drawer that is opened and filled) counts as a miss.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import yaml
from figure import add_figure, rate, value, write
from msgspec import json

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

from cramlite import Engine, NotUnderstood  # noqa: E402
from cramlite.interpretation.fluents import SymbolicWorld, symbolic_world  # noqa: E402
from cramlite.model import Value, World  # noqa: E402
from cramlite.planning.spoken_goals import understand  # noqa: E402
from experiments.libero.connection import Libero, connect  # noqa: E402
from experiments.libero.episode import prepare  # noqa: E402

SUITES = {"libero_spatial": 10, "libero_object": 10, "libero_goal": 10, "libero_10": 10, "libero_90": 90}
AMID = " within 30 mm"


class Task(Value):
    """A task in its scene.

    Args:
        sentence: of the task.
        goal: of its problem file, in the words of goals.
        view: where the benchmark's camera stands.
    """

    sentence: str
    goal: tuple[str, ...]
    view: str
    world: World
    relations: tuple[tuple[str, str, str], ...]


def task_of(benchmark: Libero, engine: Engine, suite: str, number: int, kept: Path) -> Task:
    """A task as the benchmark gives it, or as it was stored."""
    path = kept / f"{suite}_{number}.json"
    if path.is_file():
        return json.decode(path.read_bytes(), type=Task)
    benchmark.reset(suite, number, 0)
    scene: dict[str, Any] = benchmark.scene()
    with tempfile.TemporaryDirectory() as folder:
        scenario, setting = prepare(engine, scene, benchmark.hello(), Path(folder), 0)
        goal = tuple(yaml.safe_load(scenario.read_text())["goal"])
    view = ", ".join(f"{v:.3f}" for v in scene["agentview"][:2])
    found = Task(scene["language"], goal, view, setting.world, setting.relations)
    kept.mkdir(parents=True, exist_ok=True)
    path.write_bytes(json.encode(found))
    return found


def plain(goal: str, scene: SymbolicWorld) -> str:
    """A goal without what people leave out: the only region of a thing, and how near a middle."""
    thing, *words = goal.removesuffix(AMID).split()
    if words[-1].count("/") == 1:
        whole, _, region = words[-1].partition("/")
        words[0] = "at"
        own = [f.name for f in scene.world.thing(whole).features if not f.name.startswith(("surface", "floor", "handle"))]
        words[-1] = whole if own == [region] else words[-1]
        words[0] = "on" if words[-1] == whole else words[0]
    return " ".join((thing, *words))


def tasks_asked(suites: list[str], which: str) -> Iterator[tuple[str, int]]:
    """Suites with the numbers of tasks that are asked for."""
    for suite in suites:
        for number in range(SUITES[suite]):
            if which == "all" or (number % 2 == 1) == (which == "odd"):
                yield suite, number


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    options.add_argument("--kept", type=Path, required=True, help="folder of scenes that were read before")
    options.add_argument("--tasks", choices=("odd", "even", "all"), default="odd")
    options.add_argument("--suites", nargs="+", choices=sorted(SUITES), default=list(SUITES))
    options.add_argument("--environment", type=Path, help="of LIBERO, if not in its usual place")
    add_figure(options)
    asked = options.parse_args()
    engine, benchmark = Engine(files=[ROOT / "experiments" / "libero" / "panda.py"]), connect(asked.environment)
    right = tried = 0
    cpu = 0.0
    for suite, number in tasks_asked(asked.suites, asked.tasks):
        task = task_of(benchmark, engine, suite, number, asked.kept)
        scene = symbolic_world(task.world, engine.knowledge.taxonomy, task.relations)
        tried, before = tried + 1, time.process_time()
        try:
            said: tuple[str, ...] = understand(task.sentence, scene, engine.knowledge, task.view).goals
            got = {plain(g, scene) for g in said}
        except NotUnderstood as error:
            got = {str(error)}
        cpu += time.process_time() - before
        if got == {plain(g, scene) for g in task.goal}:
            right += 1
        else:
            print(f"{suite} {number}: {task.sentence}\n  understood: {sorted(got)}\n  goal: {list(task.goal)}")
    print(f"{right} of {tried} exactly the goal; {1000 * cpu / max(tried, 1):.0f} ms CPU a sentence")
    numbers = [rate("sentences understood as exactly the goal", right, tried), value("CPU time of a sentence", cpu / max(tried, 1), "s")]
    write(asked, numbers, seeds=f"tasks {asked.tasks}, state 0")


if __name__ == "__main__":
    main()
