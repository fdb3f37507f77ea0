"""Key of an experiment's results: what they depend on, the same on every machine that would give the same results."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from ..base.resources import find_scenario
from ..base.run_directory import content_key
from ..plugin.selection import PluginChoice
from ..scenario.scenario import read_scenario
from ..version import VERSION
from .bench import bench
from .store import code_key


def results_key(path: Path, set_name: str, *, short: bool, without: str | None, plugins: PluginChoice) -> dict[str, Any]:
    """Return what the results of an experiment depend on: files, seeds, code.

    Args:
        path: of the experiment's file.
        set_name, short, without: which demonstrations, and the ablation.

    Raises:
        UserError: a file that cannot be used.
    """
    place = bench(path, set_name, without, plugins)
    experiment = place.experiment
    chosen = experiment.choose(set_name)
    scenario = read_scenario(find_scenario(str(experiment.beside(chosen.scenario or experiment.spec.scenario))))
    ablation = experiment.ablation(without)
    files = [experiment.path, scenario.path]
    files += [experiment.beside(f) for f in (ablation.plugin, ablation.rules) if f]
    folders = [
        Path(__file__).resolve().parents[1],
        *(Path(i.file).resolve().parent for i in place.engine.registry.infos),
    ]
    return {
        "cramlite": VERSION, "experiment": experiment.spec.experiment, "set": set_name, "short": short,
        "without": without, "scenario": content_key(*files), "code": code_key(folders),
    }  # fmt: skip
