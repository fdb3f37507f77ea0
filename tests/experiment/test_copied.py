"""An experiment's folder can be copied elsewhere: what it shares with its neighbours is found where the shipped ones are."""

from __future__ import annotations

import sys
from pathlib import Path
from shutil import copytree

import pytest
from conftest import ROOT

from cramlite import UserError
from cramlite.experiment.benchmark.protocol import module_of
from cramlite.experiment.benchmark.spec import read_benchmark
from cramlite.experiment.demonstrations.spec import read_experiment

EXPERIMENTS = ROOT / "experiments"


def copied(name: str, folder: Path) -> Path:
    """A copy of an experiment's folder, alone."""
    return Path(copytree(EXPERIMENTS / name, folder / "somewhere" / "mine"))


@pytest.mark.parametrize(("name", "benchmark"), [("libero", "Libero"), ("robosuite", "Robosuite")])
def test_a_copied_benchmark_answers(name: str, benchmark: str, tmp_path: Path) -> None:
    python = tmp_path / "bin" / "python"
    python.parent.mkdir()
    python.write_text(f'#!/bin/sh\nexec {sys.executable} "$@"\n')
    python.chmod(0o755)
    connection = module_of(copied(name, tmp_path) / "connection.py")
    with getattr(connection, benchmark)(tmp_path) as process, pytest.raises(UserError, match="'scene' needs an episode"):
        process.scene()


@pytest.mark.parametrize("name", ["libero", "robosuite"])
def test_plugins_of_a_copied_experiment_are_found(name: str, tmp_path: Path) -> None:
    experiment = read_benchmark(copied(name, tmp_path) / "experiment.yaml")
    assert all(experiment.beside(plugin).is_file() for plugin in experiment.spec.plugins)


def test_ablations_of_a_copied_experiment_are_found(tmp_path: Path) -> None:
    experiment = read_experiment(copied("fetch_from_hanger", tmp_path) / "experiment.yaml")
    named = [file for a in experiment.spec.ablations.values() for file in (a.plugin, a.rules) if file]
    assert named and all(experiment.beside(file).exists() for file in named)


def test_its_own_neighbour_comes_first_and_its_own_files_are_its_own(tmp_path: Path) -> None:
    experiment = read_benchmark(copied("robosuite", tmp_path) / "experiment.yaml")
    own = tmp_path / "somewhere" / "libero" / "panda.py"
    own.parent.mkdir()
    own.touch()
    assert experiment.beside("../libero/panda.py").resolve() == own.resolve()
    assert experiment.beside("ur5e.py").resolve() == (tmp_path / "somewhere" / "mine" / "ur5e.py").resolve()
    renamed = read_benchmark((tmp_path / "somewhere" / "mine").rename(tmp_path / "robosuite") / "experiment.yaml")
    (tmp_path / "robosuite" / "ur5e.py").unlink()
    assert not renamed.beside("ur5e.py").exists(), "what the copy has lost is not taken from elsewhere"
