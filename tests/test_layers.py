"""Who may import whom: the contracts of pyproject.toml hold, and each, broken on purpose, says so."""

from __future__ import annotations

import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
from conftest import ROOT

LINT = "import sys; from importlinter.cli import lint_imports; sys.exit(lint_imports(config_filename=sys.argv[1], no_cache=True))"
CONFIG = ROOT / "pyproject.toml"
CONTRACTS = {c["name"]: c for c in tomllib.loads(CONFIG.read_text(encoding="utf-8"))["tool"]["importlinter"]["contracts"]}
WAYS = {
    "plain": "{}\n",
    "in_a_function": "def later() -> None:\n    {}\n",
    "for_type_checkers": "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    {}\n",
}
"""How a module may import another: each counts."""
BREAKS = [
    ("Layers of the core", "cramlite/model", "from ..planning import trace"),
    ("Layers of the core", "cramlite/model", "from ..ontology import taxonomy"),  # beside it, not below
    ("Layers of the plugins", "cramlite_plugins/kinematics", "from ..motions import moving"),
    ("Layers of the plugins", "cramlite_plugins/tasks", "from ..predicates import relations"),
    ("Layers of the plugins", "cramlite_plugins/simulation", "from ..ur_controller import clock"),
    ("Layers of the plugins", "cramlite_plugins/person", "from ..ur_controller import clock"),
    ("The core knows no plugin", "cramlite/engine", "import cramlite_plugins.tasks.grasping"),
    ("Plugins import public modules only", "cramlite_plugins/tasks", "from cramlite.planning import trace"),
    ("Plugins import public modules only", "cramlite_plugins/tasks", "from cramlite.model.geometry import Pose"),
    ("Plugins import public modules only", "cramlite_plugins/tasks", "from cramlite.plugin import registry"),
    ("Task modules import no task module", "cramlite_plugins/tasks", "from .grasping import Grasping"),
    ("No circle of modules", "cramlite/planning", "from . import needs_{way}"),
    ("No circle of modules", "cramlite_plugins/shapes", "from . import needs_{way}"),
    ("Only the contract and the registry touch pluggy", "cramlite/engine", "import pluggy"),
    ("Only the contract and the registry touch pluggy", "cramlite_plugins/tasks", "import pluggy"),
]
"""The contract, the package of the module that breaks it, and the import that does."""
FIRST = {start: (package, line) for start, package, line in reversed(BREAKS)}
"""The first break of each contract; the usual run leaves out further ones."""
HOUSE = {
    "cramlite/model/geometry.py": "from ..base import value\nPose = value\n",
    "cramlite/base/value.py": "",
    "cramlite/ontology/taxonomy.py": "",
    "cramlite/planning/trace.py": "from ..base import value\n",
    "cramlite/plugin/registry.py": "import pluggy\n",
    "cramlite/testing/task_checks.py": "from ..model import geometry\nfrom ..planning import trace\n",
    "cramlite_plugins/motions/moving.py": "from cramlite import model, plugin, testing\nfrom ..shapes import hull\n",
    "cramlite_plugins/kinematics/forward.py": "import cramlite.model\n",
    "cramlite_plugins/shapes/hull.py": "",
    "cramlite_plugins/predicates/relations.py": "from cramlite.plugin import hookimpl\n",
    "cramlite_plugins/ur_controller/clock.py": "",
    "cramlite_plugins/tasks/grasping.py": "from ..task_kit import bases\nGrasping = bases\n",
    "cramlite_plugins/task_kit/bases.py": "",
}
"""A house of the same rooms with little in them, in which every contract holds."""


def _lint(folder: Path) -> subprocess.CompletedProcess[str]:
    """The contracts of pyproject.toml, over the packages in a folder."""
    command = [sys.executable, "-c", LINT, str(CONFIG)]
    return subprocess.run(command, capture_output=True, text=True, check=False, cwd=folder)


def _broken(said: str) -> list[str]:
    """The contracts that a run says are broken; a long name is said over two lines."""
    listed = re.sub(r"\s+", " ", said.partition("Broken contracts")[0])
    return [name for name in CONTRACTS if re.search(rf"{re.escape(name)} ?BROKEN", listed)]


@pytest.fixture
def house(tmp_path: Path) -> Path:
    """The small house, with every package that a contract names."""
    layers = {c["containers"][0]: c["layers"] for c in CONTRACTS.values() if c["type"] == "layers"}
    for container, rooms in layers.items():
        for room in re.findall(r"\w+", " ".join(rooms)):
            (tmp_path / container / room).mkdir(parents=True)
            (tmp_path / container / room / "__init__.py").touch()
        (tmp_path / container / "__init__.py").touch()
    for name, text in HOUSE.items():
        (tmp_path / name).write_text(text)
    return tmp_path


def test_contracts_hold() -> None:
    ran = _lint(ROOT)
    assert ran.returncode == 0, ran.stdout + ran.stderr
    assert f"{len(CONTRACTS)} kept, 0 broken" in ran.stdout


def test_contracts_hold_in_the_small_house(house: Path) -> None:
    ran = _lint(house)
    assert ran.returncode == 0, ran.stdout + ran.stderr
    assert f"{len(CONTRACTS)} kept, 0 broken" in ran.stdout
    seen = re.search(r"Analyzed (\d+) files", ran.stdout)
    assert seen and int(seen[1]) < 60  # this house, not the large one


@pytest.mark.heavy
@pytest.mark.parametrize(
    ("contract", "package", "line"),
    [pytest.param(*b, id=f"{b[1]}: {b[2]}", marks=() if FIRST[b[0]] == b[1:] else pytest.mark.heavy) for b in BREAKS],
)
def test_a_contract_that_is_broken_says_so(house: Path, contract: str, package: str, line: str) -> None:
    for way, text in WAYS.items():
        (house / package / f"breaks_{way}.py").write_text(text.format(line.format(way=way)))
        (house / package / f"needs_{way}.py").write_text(f"from . import breaks_{way}\n" if "needs" in line else "")
    ran = _lint(house)
    assert ran.returncode == 1, ran.stdout + ran.stderr
    (broken,) = _broken(ran.stdout)
    assert broken.startswith(contract)
    for way in WAYS:
        assert f"breaks_{way}" in ran.stdout, ran.stdout


def test_every_contract_is_broken_once() -> None:
    tried = {name for name in CONTRACTS for start, *_ in BREAKS if name.startswith(start)}
    assert tried == set(CONTRACTS)
