"""A small experiment: the shipped one with three demonstrations, and what it found without what a clock said."""

from __future__ import annotations

import json
from pathlib import Path

import yaml

from cramlite.experiment.demonstrations.trials import Demonstrations
from cramlite.experiment.experiment_file import find_experiment
from cramlite.experiment.order import Order
from cramlite.plugin.selection import PluginChoice

FOLDER = find_experiment("fetch_from_hanger").parent


def quick_experiment(folder: Path, count: int = 1) -> Path:
    """Write the shipped experiment with ``count`` demonstrations of each of three objects and a budget of two questions."""
    folder.mkdir()
    scenario = (FOLDER / "scenario.yaml").read_text().replace("take_off_hanger_varied", "take_off_hanger")
    (folder / "scenario.yaml").write_text(scenario)
    text = (FOLDER / "experiment.yaml").read_text()
    text = text.replace("budget: {proofs: 4, expansions: 400}", "budget: {proofs: 1, expansions: 2}\nmost_candidates: 1")
    lines = [line for line in text.splitlines() if not line.lstrip().startswith(("main:", "hard:"))]
    at = next(k for k, line in enumerate(lines) if line.startswith("sets:"))
    lines.insert(at + 1, f"  main: {{first: 1000, count: {count}, about: quick}}")
    (folder / "experiment.yaml").write_text("\n".join(lines))
    return folder


def solved_experiment(folder: Path) -> Path:
    """Write an experiment with one demonstration whose first candidate gives a program, proven in two twins and executed in one."""
    path = quick_experiment(folder) / "experiment.yaml"
    data = yaml.safe_load(path.read_text())
    data |= {"budget": {"proofs": 1, "expansions": 400}, "scales": [1], "objects": {"O1": data["objects"]["O1"]}}
    data["proof"]["twins"], data["sets"]["main"]["first"] = 2, 1002
    del data["published"]
    path.write_text(yaml.safe_dump(data))
    return folder


def order(experiment: Path, out: Path, workers: int = 1, *plugins: Path, executor: str = "local") -> Order:
    return Order(Demonstrations(experiment / "experiment.yaml", plugins=PluginChoice(plugins), pictures=False), out, workers, executor)


def told(out: Path) -> dict[str, object]:
    """Return all results of an experiment without the measured times."""
    found = {}
    for path in sorted((out / "results").rglob("*.json")):
        data = json.loads(path.read_text())
        data.pop("seconds", None)
        for one in data.get("results", []):
            one.pop("seconds")
        found[path.relative_to(out).as_posix()] = data
    return found
