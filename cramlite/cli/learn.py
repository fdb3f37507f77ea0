"""``cramlite learn``: learns a task from demonstrations, and writes it as a folder with a task plugin."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from ..base.errors import UserError
from .arguments import Add, plugin_choice

if TYPE_CHECKING:
    from ..learning.proposal import Proposal

MOST = 10
"""Largest number of demonstrations of one task: nobody shows a thing more often."""


def add_commands(add: Add) -> None:
    """Add the command ``learn``, with its arguments, to the command line."""
    learn = add("learn", _learn)
    learn.add_argument("episodes", nargs="+", type=Path, metavar="EPISODE", help="demonstrations of the task, 1 to 10")
    learn.add_argument("--task", required=True, metavar="NAME", help="name of the task, in small letters, e.g. stirring")
    learn.add_argument(
        "--interval", action="append", default=[], metavar="A:B",
        help="when the task was done [s]; once for all episodes, or once for each, in their order; the whole episodes if left out",
    )  # fmt: skip
    learn.add_argument(
        "--not", dest="refused", nargs="+", type=Path, default=[], metavar="EPISODE",
        help="episodes in which the task was not done: the rule may hold of nothing in them",
    )  # fmt: skip
    learn.add_argument(
        "--known", nargs="+", type=Path, default=[], metavar="EPISODE",
        help="episodes of other tasks: what known tasks explain in them, or the recording names, is no example",
    )  # fmt: skip
    learn.add_argument(
        "--compare", nargs="+", type=Path, default=[], metavar="EPISODE",
        help="further demonstrations to compare: which of their steps are missing, in another order, or new",
    )  # fmt: skip
    learn.add_argument(
        "--try", dest="scenario", metavar="SCENARIO",
        help="let a robot do it in this scenario's world, and read its runs by the learned rule; exit code 1 if one fails",
    )  # fmt: skip
    learn.add_argument("--worlds", type=int, default=2, metavar="N", help="seeds that are tried, from 1 on (default 2)")
    learn.add_argument("--out", type=Path, help="folder of the package (default: cramlite-NAME)")


def _learn(arguments: argparse.Namespace) -> int:
    from ..engine.engine import Engine
    from ..learning.from_episodes import compared, learn_task
    from ..learning.motion_text import force_said, said
    from ..learning.package import write_package
    from ..testing.skeleton import vacant_folder

    if len(arguments.episodes) > MOST:
        count = len(arguments.episodes)
        raise UserError(f"{count} demonstrations were given; a task is learned from 1 to {MOST}. Leave out those that are alike.")
    vacant_folder("task", arguments.task, arguments.out)
    engine = Engine.with_plugins(plugin_choice(arguments))
    intervals = [_interval(text) for text in arguments.interval]
    marked = _marked(len(arguments.episodes), intervals)
    examples = [(engine.read_episode(path), *span) for path, span in zip(arguments.episodes, marked, strict=True)]
    refused, known = ([engine.read_episode(path) for path in paths] for paths in (arguments.refused, arguments.known))
    proposal = learn_task(arguments.task, examples, engine.knowledge, refused=refused, known=known)
    others = [(path, compared(proposal, (engine.read_episode(path), None, None), engine.knowledge)) for path in arguments.compare]
    folder, *written = write_package(proposal, arguments.task, arguments.out)
    print(f"Learned {proposal.task}, a kind of {proposal.above}, from {len(examples)} example{'s' if len(examples) > 1 else ''}:")
    for phase, texts in proposal.rule.items():
        for text in texts:
            print(f"  {phase:4} {text}")
    for text in (*(f"taken to be wrong: {w}" for w in proposal.wrong), *(f"open: {u}" for u in proposal.undecided)):
        print(text)
    print("how it is done: " + _how(proposal))
    for text in filter(None, (said(proposal), force_said(proposal))):
        print(text)
    for path, found in others:
        print(f"{path}: {'; '.join(map(str, found)) or 'same steps as in the examples'}")
    print("\n".join([f"Wrote a task plugin to '{folder}':", *(f"  {path.relative_to(folder)}" for path in written)]))
    return _tried(arguments, proposal, next(p for p in written if p.name == "__init__.py")) if arguments.scenario else 0


def _how(proposal: Proposal) -> str:
    """Format how a learned task is carried out, in order: known tasks, a learned motion, and a pause at the end."""
    learned = (("a motion that was learned", proposal.moving), ("rest", proposal.rest))
    parts = [*(s.task for s in proposal.steps), *(name for name, found in learned if found)]
    return " -> ".join(parts) if proposal.done else "not learned; write 'decompose'"


def _tried(arguments: argparse.Namespace, proposal: Proposal, module: Path) -> int:
    """Print how each trial of the learned task in other worlds ended; return exit code 1 if one failed."""
    from ..base.resources import find_scenario
    from ..learning.trial import trials
    from ..scenario.scenario import read_scenario

    done = []
    for trial in trials(proposal, module, read_scenario(find_scenario(arguments.scenario)), range(1, 1 + arguments.worlds)):
        print(f"seed {trial.seed}: {trial.reason}", flush=True)
        done.append(trial.passed)
    return 0 if all(done) else 1


def _interval(text: str) -> tuple[float, float]:
    first, _, last = text.partition(":")
    try:
        return float(first), float(last)
    except ValueError:
        raise UserError(f"'--interval {text}' is no interval: write two times in seconds with a colon, such as 3.2:7.5.") from None


def _marked(count: int, intervals: list[tuple[float, float]]) -> list[tuple[float, float] | tuple[None, None]]:
    if len(intervals) not in (0, 1, count):
        raise UserError(f"There are {count} episodes and {len(intervals)} intervals: give --interval once for all, or once for each.")
    if not intervals:
        return [(None, None)] * count
    return [*(intervals * count if len(intervals) == 1 else intervals)]
