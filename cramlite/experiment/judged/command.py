"""``cramlite experiment`` where somebody else judges: play what is left, print the tables, write the files."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from ...base.errors import NoSolution, UserError, nearest
from ...base.json_text import as_json
from ...base.run_directory import write_whole
from ...model.proof_doubts import ProofDoubts
from ...plugin.selection import INSTALLED, PluginChoice
from ..figure import Published, Seen, write_figure
from ..measured import check_figure_file, figure_now, this_command
from ..run import check_workers, speak
from .page import page
from .report import markdown, numbers
from .results import EpisodeResult
from .run import Order, run_judged, run_key, said
from .spec import Episode, read_judged
from .tables import tables, with_rates

TABLES = "tables.json"


def judged_command(
    path: Path, suites: Sequence[str], tasks: str, states: str, *, out: Path | None = None, workers: int = 2, twins: int = 0,
    environment: Path | None = None, attempt_refused: bool = False, pictures: bool = True, json_output: bool = False,
    plugins: PluginChoice = INSTALLED, fail: bool = False, figure: Path | None = None, seen: Seen | None = None,
) -> int:  # fmt: skip
    """Play episodes of a judged experiment, and write their tables.

    Args:
        suites: none for the tables of what the directory holds.
        tasks, states: as ``JudgedExperiment.episodes`` has them.
        figure: the file of a figure, to be written with the rates of all episodes that the directory holds.
        seen: whether these states had been played before, for the figure.

    Returns:
        0, whatever the judge says of the episodes, unless they must not ``fail``.

    Raises:
        NoSolution: with ``fail``, if one of the episodes that were asked for is not true at rest within its budget.
        UserError: the experiment, its judge or its directory cannot be used.
    """
    check_figure_file(figure)
    ProofDoubts(twins)  # what is wrong with it is said before any work
    experiment = read_judged(path)
    if not suites and (out is None or not out.is_dir()):
        raise UserError(f"Which suite is to be played is not said; add --suite NAME: {nearest('', experiment.spec.suites)}.")
    episodes = tuple(e for suite in suites for e in experiment.episodes(suite, tasks, states))
    own = PluginChoice(tuple(p.resolve() for p in plugins.files), plugins.blocked, plugins.preferred)
    place = out or Path("runs") / experiment.spec.experiment
    order = Order(experiment, episodes, place, check_workers(workers), environment, twins, attempt_refused, pictures, own)
    results = run_judged(order, speak)
    text = _write(order, results)
    _write_figure(figure, seen, order, results)
    print((place / TABLES).read_text(encoding="utf-8") if json_output else f"{text}\nFiles: {place}/{TABLES}, tables.md, report.html")
    asked = [r for r in results if Episode(r.suite, r.task, r.state) in episodes]
    lost = [said(r) for r in asked if not r.rest()]
    if fail and lost:
        raise NoSolution(f"{len(lost)} of {len(asked)} episodes are not true at rest within their budget: {'; '.join(lost)}.")
    return 0


def _write_figure(path: Path | None, seen: Seen | None, order: Order, results: tuple[EpisodeResult, ...]) -> None:
    if path is not None:
        found, spec = tables(results, order.experiment), order.experiment.spec
        seeds = "states " + ", ".join(map(str, sorted({r.state for r in results})))
        cpu = sum(sum(r.seconds.values()) for r in results)
        beside = tuple(Published(who=p.system, said=p.rate, given=p.given, source=p.source) for p in found.published)
        made = figure_now(spec.title, this_command(), numbers(found), seeds=seeds, seen=seen, cpu_s=cpu)
        write_figure(path, made.model_copy(update={"given": spec.given, "beside": beside}))


def _write(order: Order, results: tuple[EpisodeResult, ...]) -> str:
    """The files; gives the tables as text."""
    found = tables(results, order.experiment)
    write_whole(order.out / TABLES, as_json({"run": run_key(order), "tables": with_rates(found), "episodes": results}))
    write_whole(order.out / "tables.md", text := markdown(found, order.experiment))
    write_whole(order.out / "report.html", page(found, results, order.experiment, order.out))
    return text
