"""``cramlite experiment``: runs an experiment."""

from __future__ import annotations

import argparse
from pathlib import Path

from .arguments import Add, plugin_choice


def _experiment(arguments: argparse.Namespace) -> int:
    from ..experiment.command import experiment_command

    return experiment_command(
        arguments.experiment,
        set_name=arguments.set,
        short=arguments.short,
        without=arguments.without,
        workers=arguments.workers,
        out=arguments.out,
        pictures=not arguments.no_pictures,
        keep_baseline=arguments.keep_baseline,
        json_output=arguments.json,
        plugins=plugin_choice(arguments),
        executor=arguments.executor,
    )


def add_commands(add: Add) -> None:
    """Declare ``experiment`` with its arguments."""
    experiment = add("experiment", _experiment)
    experiment.add_argument("experiment", help="a file, its folder, or the name of a shipped one")
    experiment.add_argument("--set", default="main", metavar="NAME", help="which demonstrations (default main)")
    experiment.add_argument("--short", action="store_true", help="only the first of each object, against thresholds")
    experiment.add_argument("--without", metavar="ABLATION", help="take something away, e.g. force_control or search")
    experiment.add_argument("--workers", type=int, default=2, help="processes of this machine (default 2)")
    experiment.add_argument(
        "--executor", default="local", metavar="WHERE",
        help="local (default), dask for a cluster of its own, or dask://HOST:PORT for that of a scheduler (extra distributed)",
    )  # fmt: skip
    experiment.add_argument("--out", type=Path, help="run directory; default runs/EXPERIMENT-SET")
    experiment.add_argument("--no-pictures", action="store_true", help="draw no pictures of the outcomes")
    experiment.add_argument(
        "--keep-baseline", action="store_true", help="store these tables to compare later ones with"
    )
    experiment.add_argument("--json", action="store_true")
