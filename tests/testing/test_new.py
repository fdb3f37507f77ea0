"""``cramlite new``: each kind of package builds, installs beside the others without a network, and passes its own tests."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
from conftest import Run

from cramlite import Engine, Trace, read_scenario
from cramlite.plugin import UserError
from cramlite.testing.skeleton import KINDS, camel, write_skeleton

NAMES = {kind: f"made_{kind}" for kind in KINDS}


def _run(*command: object, cwd: Path) -> str:
    environment = {**os.environ, "PIP_NO_INDEX": "1", "PIP_DISABLE_PIP_VERSION_CHECK": "1", "OMP_NUM_THREADS": "1"}
    done = subprocess.run(
        list(map(str, command)), cwd=cwd, env=environment, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, f"{command}\n{done.stdout[-3000:]}\n{done.stderr[-3000:]}"
    return done.stdout


@dataclass(frozen=True)
class Installed:
    """Where the packages are, what ``cramlite plugins`` says of them, and what their tests said."""

    folder: Path
    plugins: dict[str, dict[str, Any]]
    tests: str


@pytest.fixture(scope="module")
def installed(tmp_path_factory: pytest.TempPathFactory) -> Installed:
    """The packages of this environment, and one new plugin of each kind, built and installed from what was written."""
    folder = tmp_path_factory.mktemp("new")
    packages = [write_skeleton(kind, name, folder / kind)[0] for kind, name in NAMES.items()]
    _run(sys.executable, "-m", "venv", "--without-pip", folder / "venv", cwd=folder)
    (site,) = (folder / "venv" / "lib").glob("python*/site-packages")
    (site / "borrowed.pth").write_text("\n".join(p for p in sys.path if p))
    pip = (
        sys.executable,
        "-m",
        "pip",
        "--python",
        folder / "venv",
        "install",
        "-q",
        "--no-deps",
        "--no-build-isolation",
    )
    _run(*pip, *packages, cwd=folder)
    python = folder / "venv" / "bin" / "python"
    listed = json.loads(_run(python, "-m", "cramlite", "plugins", "--json", cwd=folder))
    plain = ("-p", "no:cacheprovider", "-p", "no:xdist", "--import-mode=importlib", "-v", "--rootdir", folder)
    said = _run(python, "-m", "pytest", *plain, *(f"{p}/tests" for p in packages), cwd=folder)
    return Installed(folder, {p["name"]: p for p in listed}, said)


@pytest.mark.heavy
@pytest.mark.parametrize("kind", KINDS)
def test_a_new_package_is_installed_listed_and_tested(kind: str, installed: Installed) -> None:
    plugin = installed.plugins[NAMES[kind]]
    assert plugin["distribution"] == f"cramlite-made-{kind}"
    assert plugin["version"] == "0.1.0"
    assert plugin["hooks"] == ["task_types" if kind == "task" else f"{kind}s"]
    assert plugin["fault"] == ""
    assert len(re.findall(rf"^{kind}/tests/test_made_{kind}.py::\S+ PASSED", installed.tests, re.MULTILINE)) >= 2
    assert not list((installed.folder / "venv").rglob(f"test_made_{kind}.py"))  # tests are not installed


def test_what_is_written_is_clean(tmp_path: Path) -> None:
    written = [write_skeleton(kind, name, tmp_path / kind) for kind, name in NAMES.items()]
    assert not [f for _, *files in written for f in files if "$" in f.read_text()]
    ruff = [
        sys.executable,
        "-m",
        "ruff",
        "check",
        "--isolated",
        "--config",
        "line-length=120",
        "--select=E,F,I,UP,B",
        ".",
    ]
    for folder, *_ in written:
        _run(*ruff, cwd=folder)


@pytest.mark.parametrize(
    ("name", "says"),
    [
        ("NoSpill", "'no_spill' would do"),
        ("no-spill", "'no_spill' would do"),
        ("2nd", "'nd' would do"),
        ("_", "a letter first"),
        ("../evil", "'evil' would do"),
        ("", "small letters"),
        ("a" * 41, "40 characters"),
        ("class", "a word of Python"),
        ("match", "a word of Python"),
        ("grasping", "There is a plugin 'grasping' already, in 'cramlite'"),
        ("öl", "small letters"),
    ],
)
def test_bad_names_are_explained(name: str, says: str, tmp_path: Path) -> None:
    with pytest.raises(UserError, match=says):
        write_skeleton("task", name, tmp_path / "made")
    assert not (tmp_path / "made").exists()


@pytest.mark.parametrize(
    ("kind", "name", "says"),
    [
        ("task", "shaking", "There is a plugin 'shaking' already"),
        ("task", "lift", "'Lift' is taken: it names the task 'soma:PickingUp' of the plugin 'picking_up'"),
        ("task", "handle", "there is a class 'cram:Handle' already"),
        ("task", "cup", "there is a class 'soma:Cup' already"),
        ("task", "location", "its class would be 'Location', a name that the module needs"),
        ("task", "plugins", "its package would be 'cramlite_plugins'"),
        ("backend", "text", ""),
        ("backend", "code", "its class would be 'Code'"),
        ("expert", "segment", "that one is the engine's"),
        ("expert", "antipodal", ""),
        ("predicate", "supports", "declares the predicate 'supports', and names are unique"),
        ("robot", "ur5e", "the plugin 'arms' declares the robot 'ur5e'"),
        ("validator", "collision", "the plugin 'physics' declares the validator 'collision'"),
        ("validator", "finding", "its class would be 'Finding'"),
    ],
)
def test_names_of_what_there_is_are_refused_at_once(kind: str, name: str, says: str, tmp_path: Path) -> None:
    if says:
        with pytest.raises(UserError, match=says):
            write_skeleton(kind, name, tmp_path / "made")
    else:
        write_skeleton(kind, name, tmp_path / "made")
    assert (tmp_path / "made").exists() == (not says)


def task_words() -> list[str]:
    """Names that tasks could have: classes of the ontologies, shipped tasks and their other names, rules, and free ones."""
    knowledge = Engine().knowledge
    tasks = [n for t in knowledge.tasks.values() for n in (t.task, *t.aliases)]
    words = [c.split(":")[-1] for c in (*tasks, *sorted(knowledge.taxonomy.classes)[::40], *(r.task for r in knowledge.rules))]
    words += ["Mixing", "Tapping", "Action", "Motion", "Role", "TaskType", "Path", "Block", "Floor", "Try", "Gripper", "Patient"]
    return sorted({re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", w).lower() for w in words})


@pytest.mark.heavy
def test_a_task_of_every_name_that_is_accepted_works(tmp_path: Path) -> None:
    made: list[Path] = []
    refused = 0
    for word in task_words():
        try:
            _, *files = write_skeleton("task", word, tmp_path / f"cramlite-{word}")
        except UserError:
            refused += 1
            continue
        module = next(f for f in files if f.name == "__init__.py")
        made.append(module)
    assert refused > 60 and len(made) >= 2
    for module in made:
        engine = Engine(files=[module])
        word = module.parent.name.removeprefix("cramlite_")
        scenario = read_scenario(module.parent.parent / "tests" / f"try_{word}.yaml")
        assert f"cram:{camel(word)}" in {r.task for r in engine.knowledge.rules}
        setting = engine.setting(scenario)
        plan, _ = next(iter(engine.plans(scenario, setting, Trace())))
        assert plan.actions[1].task == f"cram:{camel(word)}"


@pytest.mark.heavy
def test_a_task_with_a_name_of_soma_is_proven(tmp_path: Path) -> None:
    _, *files = write_skeleton("task", "mixing", tmp_path / "cramlite-mixing")
    module = next(f for f in files if f.name == "__init__.py")
    scenario = next(f for f in files if f.name == "try_mixing.yaml")
    solution = next(Engine(files=[module]).resolve(read_scenario(scenario)))
    assert solution.verdict.passed
    judged = [f.reason for f in solution.verdict.findings if f.validator == "task_rules"]
    assert any("2.Mixing" in reason for reason in judged)


def test_nothing_is_overwritten(tmp_path: Path, run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    first = run("new", "task", "no_spill")
    assert first.code == 0
    assert "cramlite-no-spill" in first.out
    module = tmp_path / "cramlite-no-spill" / "cramlite_no_spill" / "__init__.py"
    module.write_text("mine")
    again = run("new", "task", "no_spill")
    assert again.code == 2
    assert "not an empty folder" in again.err
    assert module.read_text() == "mine"
    assert run("new", "task", "no_spill", "--out", module).code == 2
