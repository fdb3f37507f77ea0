"""``cramlite experiment``: runs an experiment."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from msgspec.structs import replace

from ..base.errors import NoSolution, UserError, nearest
from ..base.json_text import as_json
from ..base.run_directory import write_whole
from .arguments import Add, plugin_choice
from .texts import warn_of

if TYPE_CHECKING:
    from ..experiment.figure import Seen
    from ..experiment.order import Order, Report, Trials
    from ..plugin.selection import PluginChoice

TABLES = "tables.json"
BENCHMARK = ("suite", "tasks", "states", "twins", "benchmark", "attempt_refused", "fail")
"""Options that only experiments on benchmarks have; ``OWN`` are those that only experiments with demonstrations have."""
OWN = ("set", "short", "without", "executor", "keep_baseline")


def _experiment(arguments: argparse.Namespace) -> int:
    from ..experiment.experiment_file import find_experiment, is_benchmark, old_keys

    path = find_experiment(arguments.experiment)
    warn_of(old_keys(path))
    if is_benchmark(path):
        _refuse(arguments, OWN, "its episodes are those of a benchmark; choose them by --suite, --tasks and --states")
        order = _episodes(path, arguments)
    else:
        _refuse(arguments, BENCHMARK, "its demonstrations are recorded and judged here; choose them by --set")
        order = _demonstrations(path, arguments)
    return _run(order, json_output=arguments.json, figure=arguments.figure, seen=arguments.seen)


def _run(order: Order, *, json_output: bool, figure: Path | None, seen: Seen | None) -> int:
    """Run the trials that have no result yet, print the tables, and write the files.

    Args:
        figure: the file of a figure, to be written with the rates of all results that the directory holds.
        seen: whether these seeds or states had been run before, for the figure.

    Raises:
        NoSolution: a threshold is not reached.
        UserError: the experiment or its directory cannot be used.
    """
    from ..experiment.measured import check_figure_file
    from ..experiment.run import run_experiment, speak

    check_figure_file(figure)
    report = order.trials.report(run_experiment(order, speak), order.out)
    data = as_json(report.data)
    for name, content in ({TABLES: data} | report.files).items():
        write_whole(order.out / name, content)
    for path, content in report.kept.items():
        write_whole(path, content)
    if figure is not None:
        _write_figure(figure, seen, report)
    print(data if json_output else f"{report.text}\nFiles: {order.out}/{', '.join([TABLES, *report.files])}")
    if report.failure:
        raise NoSolution(report.failure)
    return 0


def _write_figure(path: Path, seen: Seen | None, report: Report) -> None:
    from ..experiment.figure import write_figure
    from ..experiment.measured import figure_now, this_command

    made = figure_now(report.title, this_command(), report.numbers, seeds=report.seeds, seen=seen, cpu_s=report.cpu_s)
    write_figure(path, made.model_copy(update={"given": report.given, "beside": report.beside}))


def _refuse(arguments: argparse.Namespace, options: tuple[str, ...], why: str) -> None:
    """Raise UserError if an option is given that does not suit this kind of experiment."""
    given = [name for name in options if getattr(arguments, name)]
    if given:
        raise UserError(f"--{given[0].replace('_', '-')} does not suit the experiment '{arguments.experiment}': {why}.")


def _episodes(path: Path, arguments: argparse.Namespace) -> Order:
    from ..experiment.benchmark.spec import read_benchmark
    from ..experiment.benchmark.trials import Episodes
    from ..model import ProofDoubts

    experiment = read_benchmark(path)
    ProofDoubts(twins=arguments.twins)  # a number of twins that is none is refused first
    if not arguments.suite and (arguments.out is None or not arguments.out.is_dir()):
        raise UserError(f"No suite of the experiment was chosen; add --suite NAME: {nearest('', experiment.spec.suites)}.")
    asked = tuple(e for suite in arguments.suite for e in experiment.episodes(suite, arguments.tasks, arguments.states or "0"))
    trials = Episodes(
        experiment, asked, arguments.benchmark, arguments.twins, arguments.attempt_refused, not arguments.no_pictures, _plugins(arguments),
        arguments.fail,
    )  # fmt: skip
    return _order(arguments, trials, experiment.spec.experiment)


def _demonstrations(path: Path, arguments: argparse.Namespace) -> Order:
    from ..experiment.demonstrations.trials import Demonstrations

    trials = Demonstrations(
        path, arguments.set or "main", arguments.short, arguments.without, not arguments.no_pictures, _plugins(arguments),
        arguments.keep_baseline,
    )  # fmt: skip
    return _order(arguments, trials, f"{trials.experiment.spec.experiment}-{trials.what}")


def _order(arguments: argparse.Namespace, trials: Trials, name: str) -> Order:
    from ..experiment.cluster import check_executor
    from ..experiment.order import Order

    return Order(trials, arguments.out or Path("runs") / name, arguments.workers, check_executor(arguments.executor or "local"))


def _plugins(arguments: argparse.Namespace) -> PluginChoice:
    """Return the chosen plugins, plugin files by absolute path, so that worker processes find them from any
    folder."""
    chosen = plugin_choice(arguments)
    return replace(chosen, files=tuple(p.resolve() for p in chosen.files))


def add_commands(add: Add) -> None:
    """Add the command ``experiment``, with its arguments, to the command line."""
    experiment = add("experiment", _experiment)
    experiment.add_argument("experiment", help="a file, its folder, or the name of a shipped one")
    experiment.add_argument("--set", default="", metavar="NAME", help="which demonstrations (default main)")
    experiment.add_argument(
        "--short", action="store_true",
        help="only the first demonstration of each object; exit code 1 if a threshold of the file is not reached",
    )
    experiment.add_argument(
        "--without", metavar="ABLATION",
        help="take something away: force_control, search, own_rules, other_candidates, twin_noise",
    )
    experiment.add_argument("--workers", type=int, default=2, help="processes of this machine (default 2)")
    experiment.add_argument(
        "--executor", default="", metavar="WHERE",
        help="local (default), dask for a cluster of its own here, or dask://HOST:PORT for that of a "
            "scheduler (extra distributed)",
    )
    experiment.add_argument(
        "--out", type=Path,
        help="run directory; default runs/EXPERIMENT-SET, or runs/EXPERIMENT for a benchmark",
    )
    experiment.add_argument("--no-pictures", action="store_true", help="draw no pictures of the outcomes")
    experiment.add_argument(
        "--keep-baseline", action="store_true",
        help="store these tables beside the experiment, to compare later ones with",
    )
    experiment.add_argument("--json", action="store_true", help="print everything as JSON")
    experiment.add_argument(
        "--figure", type=Path, metavar="FILE",
        help="write the rates with intervals, commit, seeds and machine to this YAML file; what was written "
            "by hand in it (title, introduction, published numbers) stays",
    )
    experiment.add_argument(
        "--seen", choices=("no", "partly", "yes"),
        help="for the figure: had these seeds been run before? no, partly or yes; default not recorded",
    )
    _add_benchmark(experiment)


def _add_benchmark(experiment: argparse.ArgumentParser) -> None:
    """Add the options of experiments on benchmarks, ``BENCHMARK``, as a group."""
    benchmark = experiment.add_argument_group("for a benchmark of others")
    benchmark.add_argument(
        "--suite", action="append", default=[], metavar="NAME",
        help="play episodes of this suite; may be given several times",
    )
    benchmark.add_argument(
        "--tasks", default="", metavar="NUMBERS",
        help="tasks of the suite, such as 0,2,8:12, which ends with 11; default all",
    )
    benchmark.add_argument(
        "--states", default="", metavar="NUMBERS", help="initial states of each task, such as 0:5; default 0"
    )
    benchmark.add_argument(
        "--twins", type=int, default=0, help="worlds that a program must stand before it is played; default 0"
    )
    benchmark.add_argument("--benchmark", type=Path, metavar="DIR", help="the benchmark's Python environment, if not in its usual place")
    benchmark.add_argument(
        "--attempt-refused", action="store_true",
        help="play the best refused program where none was proven; counted in a column of its own",
    )
    benchmark.add_argument("--fail", action="store_true", help="exit code 1 if an episode is not true at rest within its budget")
