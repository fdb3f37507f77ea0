"""``cramlite experiment``: run what is left, print the tables, write the files."""

from __future__ import annotations

import json
from importlib.util import find_spec
from pathlib import Path

from msgspec.structs import replace

from ..base.errors import NoSolution
from ..base.json_text import as_json
from ..base.run_directory import write_whole
from ..plugin.selection import INSTALLED, PluginChoice
from .candidates_table import PARQUET, to_csv, to_parquet
from .cluster import LOCAL, check_executor
from .figure import Seen, write_figure
from .measured import check_figure_file, figure_now, this_command
from .page import page
from .report import BASELINE, against_baseline, baseline, missed_thresholds, numbers, text, to_json
from .results import DemonstrationResult
from .run import Order, check_workers, run_experiment, run_key, speak
from .spec import Experiment, find_experiment, read_experiment
from .tables import Tables, tables


def experiment_command(
    name: str,
    *,
    set_name: str = "main",
    short: bool = False,
    without: str | None = None,
    workers: int = 2,
    out: Path | None = None,
    pictures: bool = True,
    keep_baseline: bool = False,
    json_output: bool = False,
    plugins: PluginChoice = INSTALLED,
    executor: str = LOCAL,
    figure: Path | None = None,
    seen: Seen | None = None,
) -> int:
    """Run an experiment to its end.

    Args:
        executor: as ``cluster.check_executor`` has it.
        figure: the file of a figure, to be written with the rates.
        seen: whether these seeds had been run before, for the figure.

    Returns:
        0; with ``short`` only if the thresholds are reached.

    Raises:
        NoSolution: a threshold of ``--short`` is not reached.
        UserError: the experiment or its directory cannot be used.
    """
    check_figure_file(figure)
    experiment = read_experiment(find_experiment(name))
    experiment.ablation(without)
    own = replace(plugins, files=tuple(p.resolve() for p in plugins.files))
    what = _what(set_name, short, without)
    place = out or Path("runs") / f"{experiment.spec.experiment}-{what}"
    order = Order(experiment, set_name, place, check_workers(workers), short, without, pictures, own, check_executor(executor))
    results = run_experiment(order, speak)
    whole = tables(results, experiment.spec.published if set_name == "main" and not short else None)
    stored = experiment.beside(BASELINE)
    changes = against_baseline(whole, stored, what)
    data = _write(order, whole, results, changes)
    _write_figure(figure, seen, order, whole, _title(experiment, what))
    print(data if json_output else text(whole, _title(experiment, what)) + "\n" + "\n".join(["baseline:", *changes]))
    parquet = " candidates.parquet," if (place / PARQUET).is_file() else ""
    print(f"Files: {place}/tables.json, candidates.csv,{parquet} report.html") if not json_output else None
    if keep_baseline:
        _store(stored, what, whole)
    missed = missed_thresholds(whole, experiment.spec.thresholds) if short and without is None else []
    if missed:
        raise NoSolution(f"'{name}' --short misses what it must reach: {'; '.join(missed)}. See {place}/report.html.")
    return 0


def _what(set_name: str, short: bool, without: str | None) -> str:
    return "-".join([set_name, *(["short"] if short else []), *([f"without_{without}"] if without else [])])


def _title(experiment: Experiment, what: str) -> str:
    return f"{experiment.spec.title} ({what})"


def _write(order: Order, whole: Tables, results: tuple[DemonstrationResult, ...], changes: list[str]) -> str:
    """The files; gives the JSON."""
    spec = order.experiment.spec
    data = as_json(to_json(whole, results, run_key(order)))
    what = _what(order.set_name, order.short, order.without)
    about = [
        f"{len(results)} demonstrations, set '{order.set_name}': {order.experiment.choose(order.set_name).about}",
        f"Taken away: {order.experiment.ablation(order.without).about}.",
    ]
    if spec.published:
        about.append(f"Published figures: {spec.published.source}")
    write_whole(order.out / "tables.json", data)
    write_whole(order.out / "candidates.csv", to_csv(results))
    if find_spec("pyarrow"):  # of the extra 'distributed'
        write_whole(order.out / PARQUET, to_parquet(results))
    html = page(_title(order.experiment, what), about, whole, results, changes, order.out)
    write_whole(order.out / "report.html", html)
    return data


def _write_figure(path: Path | None, seen: Seen | None, order: Order, whole: Tables, title: str) -> None:
    if path is not None:
        seeds = [d.seed for d in order.experiment.demonstrations(order.set_name, short=order.short)]
        said = f"{min(seeds)} to {max(seeds)}, {len(seeds)} demonstrations"
        write_figure(path, figure_now(title, this_command(), numbers(whole), seeds=said, seen=seen, cpu_s=sum(whole.seconds.values())))


def _store(path: Path, what: str, whole: Tables) -> None:
    known = json.loads(path.read_text(encoding="utf-8")) if path.is_file() else {}
    write_whole(path, as_json(known | {what: baseline(whole)}) + "\n")
