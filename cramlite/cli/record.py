"""``cramlite record``: a simulated person demonstrates a scenario."""

from __future__ import annotations

import argparse
from pathlib import Path

from ..base.resources import find_scenario
from ..base.run_directory import require_vacant
from ..engine.engine import make_engine
from ..engine.recording import record_episode, tasks_in_words
from ..scenario.scenario import read_scenario
from .arguments import Add, plugin_choice
from .texts import counted, warn_of


def _record(arguments: argparse.Namespace) -> int:
    """Record a demonstration of a scenario, or of the tasks that are given in words, and write it as a NEEM.

    Raises:
        UserError: nothing says what to record, or the folder is not empty.
    """
    out, tasks = arguments.out, arguments.tasks
    scenario = read_scenario(find_scenario(arguments.scenario))
    require_vacant(out, "written")
    engine = make_engine(scenario, plugin_choice(arguments))
    chosen = tasks_in_words(tasks, engine.knowledge.tasks) if tasks else ()
    recorded = record_episode(scenario, engine, seed=arguments.seed, out=out, tasks=chosen)
    episode = recorded.episode
    if recorded.failure:
        print(f"The demonstration failed: {recorded.failure}. Its recording is kept.")
    begin, end = episode.span
    print(f"{out}: {counted(len(episode.events), 'event')} in {end - begin:.1f} s; see 'cramlite interpret {out}'")
    warn_of(engine.registry.faults)
    return 0


def add_commands(add: Add) -> None:
    """Add the command ``record``, with its arguments, to the command line."""
    record = add("record", _record)
    record.add_argument("scenario", help="a scenario file, or the name of a shipped one")
    record.add_argument("--seed", type=int, default=0, help="how the person moves, and the changes of vary; default 0")
    record.add_argument("--out", type=Path, required=True, help="folder for the episode; must not exist or be empty")
    record.add_argument(
        "--tasks", default="",
        help="tasks with commas between, each with what fills its roles in order, or as Role=thing: "
            "'PickingUp cup, Pouring cup bowl'",
    )
