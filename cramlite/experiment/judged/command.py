"""``cramlite experiment`` where somebody else judges: play what is left, print the tables, write the files."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from ...base.errors import UserError, nearest
from ...base.json_text import as_json
from ...base.run_directory import write_whole
from ...plugin.selection import INSTALLED, PluginChoice
from ..run import check_workers, speak
from .run import Order, run_judged, run_key
from .spec import read_judged


def judged_command(
    path: Path, suites: Sequence[str], tasks: str, states: str, *, out: Path | None = None, workers: int = 2, twins: int = 0,
    environment: Path | None = None, attempt_refused: bool = False, pictures: bool = True, json_output: bool = False,
    plugins: PluginChoice = INSTALLED,
) -> int:  # fmt: skip
    """Play episodes of a judged experiment, and write their tables.

    Args:
        suites: none for the tables of what the directory holds.
        tasks, states: as ``JudgedExperiment.episodes`` has them.

    Returns:
        0, whatever the judge says of the episodes.

    Raises:
        UserError: the experiment, its judge or its directory cannot be used.
    """
    experiment = read_judged(path)
    if not suites and out is None:
        raise UserError(f"Which suite is to be played is not said; add --suite NAME: {nearest('', experiment.spec.suites)}.")
    episodes = tuple(e for suite in suites for e in experiment.episodes(suite, tasks, states))
    own = PluginChoice(tuple(p.resolve() for p in plugins.files), plugins.blocked, plugins.preferred)
    place = out or Path("runs") / experiment.spec.experiment
    order = Order(experiment, episodes, place, check_workers(workers), environment, twins, attempt_refused, pictures, own)
    results = run_judged(order, speak)
    write_whole(place / "tables.json", data := as_json({"run": run_key(order), "episodes": results}))
    if json_output:
        print(data)
    return 0
