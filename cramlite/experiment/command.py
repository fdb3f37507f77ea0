"""``cramlite experiment``: run the trials that have no result yet, print the tables, write the files."""

from __future__ import annotations

from pathlib import Path

from ..base.errors import NoSolution
from ..base.json_text import as_json
from ..base.run_directory import write_whole
from .figure import Seen, write_figure
from .measured import check_figure_file, figure_now, this_command
from .order import Order, Report
from .run import run_experiment, speak

TABLES = "tables.json"


def experiment_command(order: Order, *, json_output: bool = False, figure: Path | None = None, seen: Seen | None = None) -> int:
    """Run an experiment to its end.

    Args:
        figure: the file of a figure, to be written with the rates of all results that the directory holds.
        seen: whether these seeds or states had been run before, for the figure.

    Returns:
        0, unless what must be reached is not.

    Raises:
        NoSolution: a threshold is not reached.
        UserError: the experiment or its directory cannot be used.
    """
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
    made = figure_now(report.title, this_command(), report.numbers, seeds=report.seeds, seen=seen, cpu_s=report.cpu_s)
    write_figure(path, made.model_copy(update={"given": report.given, "beside": report.beside}))
