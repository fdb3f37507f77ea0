"""``cramlite experiment``: runs an experiment."""

from __future__ import annotations

import argparse
from pathlib import Path

from ..base.errors import UserError
from .arguments import Add, plugin_choice

JUDGED = ("suite", "tasks", "states", "twins", "judge", "attempt_refused", "fail")
"""Options of experiments that somebody else judges; the others have ``OWN``, and both the rest."""
OWN = ("set", "short", "without", "executor", "keep_baseline")


def _experiment(arguments: argparse.Namespace) -> int:
    from ..experiment.judged.spec import is_judged
    from ..experiment.spec import find_experiment

    path = find_experiment(arguments.experiment)
    if is_judged(path):
        _refuse(arguments, OWN, "somebody else judges its episodes; choose them by --suite, --tasks and --states")
        return _judged(path, arguments)
    _refuse(arguments, JUDGED, "its demonstrations are recorded and judged here; choose them by --set")
    return _own(arguments)


def _refuse(arguments: argparse.Namespace, options: tuple[str, ...], why: str) -> None:
    """Refuse the options of the other kind of experiment."""
    given = [name for name in options if getattr(arguments, name)]
    if given:
        raise UserError(f"--{given[0].replace('_', '-')} does not suit the experiment '{arguments.experiment}': {why}.")


def _judged(path: Path, arguments: argparse.Namespace) -> int:
    from ..experiment.judged.command import judged_command

    return judged_command(
        path,
        arguments.suite,
        arguments.tasks,
        arguments.states or "0",
        out=arguments.out,
        workers=arguments.workers,
        twins=arguments.twins,
        environment=arguments.judge,
        attempt_refused=arguments.attempt_refused,
        pictures=not arguments.no_pictures,
        json_output=arguments.json,
        plugins=plugin_choice(arguments),
        fail=arguments.fail,
        figure=arguments.figure,
        seen=arguments.seen,
    )


def _own(arguments: argparse.Namespace) -> int:
    from ..experiment.command import experiment_command

    return experiment_command(
        arguments.experiment,
        set_name=arguments.set or "main",
        short=arguments.short,
        without=arguments.without,
        workers=arguments.workers,
        out=arguments.out,
        pictures=not arguments.no_pictures,
        keep_baseline=arguments.keep_baseline,
        json_output=arguments.json,
        plugins=plugin_choice(arguments),
        executor=arguments.executor or "local",
        figure=arguments.figure,
        seen=arguments.seen,
    )


def add_commands(add: Add) -> None:
    """Declare ``experiment`` with its arguments."""
    experiment = add("experiment", _experiment)
    experiment.add_argument("experiment", help="a file, its folder, or the name of a shipped one")
    experiment.add_argument("--set", default="", metavar="NAME", help="which demonstrations (default main)")
    experiment.add_argument("--short", action="store_true", help="only the first of each object, against thresholds")
    experiment.add_argument("--without", metavar="ABLATION", help="take something away, e.g. force_control or search")
    experiment.add_argument("--workers", type=int, default=2, help="processes of this machine (default 2)")
    experiment.add_argument(
        "--executor", default="", metavar="WHERE",
        help="local (default), dask for a cluster of its own, or dask://HOST:PORT for that of a scheduler (extra distributed)",
    )  # fmt: skip
    experiment.add_argument("--out", type=Path, help="run directory; default runs/EXPERIMENT-SET, or runs/EXPERIMENT")
    experiment.add_argument("--no-pictures", action="store_true", help="draw no pictures of the outcomes")
    experiment.add_argument(
        "--keep-baseline", action="store_true", help="store these tables to compare later ones with"
    )
    experiment.add_argument("--json", action="store_true")
    experiment.add_argument("--figure", type=Path, metavar="FILE", help="write the rates with commit, seeds and machine to this YAML file")
    experiment.add_argument("--seen", choices=("no", "partly", "yes"), help="for the figure: had these seeds been run before?")
    judged = experiment.add_argument_group("where somebody else judges")
    judged.add_argument("--suite", action="append", default=[], metavar="NAME", help="play its tasks; can be given several times")
    judged.add_argument("--tasks", default="", metavar="NUMBERS", help="such as 0,2,8:12, which ends with 11; default all")
    judged.add_argument("--states", default="", metavar="NUMBERS", help="initial states, such as 0:5; default 0")
    judged.add_argument("--twins", type=int, default=0, help="worlds that a program must stand before it is played (default 0)")
    judged.add_argument("--judge", type=Path, metavar="DIR", help="the judge's Python environment, if not in its usual place")
    judged.add_argument(
        "--attempt-refused", action="store_true", help="play the best refused program where none is proven; counted apart"
    )
    judged.add_argument("--fail", action="store_true", help="exit code 1 if an episode is not true at rest within its budget")
