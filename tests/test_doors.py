"""Whoever builds upon the core comes through its four doors: plugins, the documentation's snippets, what ``cramlite new`` writes."""

from __future__ import annotations

import ast
import importlib
import json
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from conftest import ROOT
from released.doors import DOORS, List, broken, doors, last_released, promised

import cramlite
from cramlite.testing.skeleton import KINDS, fill, write_skeleton

PLUGINS = sorted((ROOT / "plugins" / "cramlite_plugins").rglob("*.py"))
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
SKELETONS = sorted((ROOT / "cramlite" / "testing" / "skeletons").rglob("*.txt"))
BUILT_UPON = {
    "cramlite_plugins.adapters.behaviour": "a behaviour for py_trees: what it is there for",
    "cramlite_plugins.adapters.planning": "a bridge to unified-planning: what it is there for",
    "cramlite_plugins.benchmarks.benchmark_process": "a robot process that is a benchmark's simulator, too: what it is there for",
    "cramlite_plugins.episodes.repair.flicker": "undoes what this plugin did",
    "cramlite_plugins.motion_planning.reach": "a path of a relation of one's own",
    "cramlite_plugins.robots.ur5e": "a robot that differs from a shipped one in one number",
    "cramlite_plugins.imports.robots.agreement": "checks a robot against the file that it was read from",
    "cramlite_plugins.imports.robots.robot_file": "a robot from the MJCF or URDF of an arm: what it is there for",
    "cramlite_plugins.simulator.simulator": "a simulator that differs from the shipped one in one method",
}
"""Modules of shipped plugins that snippets and skeletons use, and why: another plugin's, and no door."""
OF_FILE = "robot_file"
"""Templates of a robot from a file, beside those of the kinds."""
HEAVY = ("mujoco", "msgspec", "numpy", "pluggy", "pydantic", "rdflib", "scipy")


def beside_the_doors(source: str) -> Iterator[str]:
    """What a Python source imports of the core that no door offers, at any depth; one line for each."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            wrong = [a.name for a in node.names if _of_core(a.name) and a.name not in DOORS]
        elif isinstance(node, ast.ImportFrom) and not node.level and _of_core(node.module or ""):
            module = node.module or ""
            offered = _offered(module)
            wrong = [f"{module}.{a.name}" for a in node.names if a.name not in offered]
        else:
            continue
        yield from (f"line {node.lineno}: {name}" for name in wrong)


def _of_core(module: str) -> bool:
    return module.partition(".")[0] == "cramlite"


def _offered(module: str) -> set[str]:
    """The names that a door offers, and the doors behind it."""
    if module not in DOORS:
        return set()
    behind = {d.removeprefix(f"{module}.") for d in DOORS if d.startswith(f"{module}.")}
    return {*importlib.import_module(module).__all__, *behind}


def of_plugins(source: str) -> set[str]:
    """Modules of the shipped plugins that a source imports from."""
    froms = {n.module or "" for n in ast.walk(ast.parse(source)) if isinstance(n, ast.ImportFrom) and not n.level}
    plain = {a.name for n in ast.walk(ast.parse(source)) if isinstance(n, ast.Import) for a in n.names}
    return {m for m in froms | plain if m.partition(".")[0] == "cramlite_plugins"}


def snippets(page: Path) -> Iterator[tuple[int, str]]:
    """The Python blocks of a page, with the lines that they begin in; those that are shown only, too."""
    text = page.read_text(encoding="utf-8")
    for block in re.finditer(r"^```python\n(.*?)^```$", text, re.MULTILINE | re.DOTALL):
        yield text[: block.start(1)].count("\n") + 1, block[1]


def named_beside_the_doors(text: str) -> list[str]:
    """The dotted names of the core in backticks that no door offers: "cramlite.model.Pose" is one that a door does."""
    found = re.findall(r"`(cramlite(?:\.\w+)+)", text)
    return [n for n in found if n not in DOORS and not any(n == f"{d}.{o}" for d in DOORS for o in _offered(d))]


def skeleton_sources(kind: str, folder: Path) -> Iterator[tuple[Path, str]]:
    """What ``cramlite new`` writes for a kind of plugin."""
    words = {"model": "arm.xml", "stated": ""}
    of_file = kind == OF_FILE
    name = f"made_{kind}"
    written = (fill(kind, "robot", name, folder, words) if of_file else write_skeleton(kind, name, folder))[1:]
    yield from ((path, path.read_text(encoding="utf-8")) for path in written if path.suffix == ".py")


# What is shipped


def test_shipped_plugins_use_the_doors() -> None:
    found = {str(p.relative_to(ROOT)): list(beside_the_doors(p.read_text(encoding="utf-8"))) for p in PLUGINS}
    assert len(found) > 100
    assert {path: wrong for path, wrong in found.items() if wrong} == {}


WITH_SNIPPETS = [p for p in PAGES if any(snippets(p))]


@pytest.mark.parametrize("page", WITH_SNIPPETS, ids=lambda p: p.relative_to(ROOT).as_posix())
def test_snippets_use_the_doors(page: Path) -> None:
    for line, source in snippets(page):
        assert list(beside_the_doors(source)) == [], f"{page}:{line}"
        assert of_plugins(source) <= BUILT_UPON.keys(), f"{page}:{line}"


@pytest.mark.parametrize("kind", [*KINDS, OF_FILE])
def test_skeletons_use_the_doors(kind: str, tmp_path: Path) -> None:
    sources = list(skeleton_sources(kind, tmp_path / kind))
    assert len(sources) == 2  # the module and its test
    for path, source in sources:
        assert "cramlite" in source
        assert list(beside_the_doors(source)) == [], path
        assert of_plugins(source) <= BUILT_UPON.keys(), path


def test_every_module_that_is_built_upon_is_there_and_used(tmp_path: Path) -> None:
    sources = [s for page in WITH_SNIPPETS for _, s in snippets(page)]
    sources += [s for kind in (*KINDS, OF_FILE) for _, s in skeleton_sources(kind, tmp_path / kind)]
    assert set().union(*map(of_plugins, sources)) == BUILT_UPON.keys()


@pytest.mark.parametrize(
    ("source", "found"),
    [
        ("from cramlite.model import Pose\nfrom cramlite import model, Engine\nimport cramlite.testing", []),
        ("from . import model\nimport cramlite_plugins.robots.ur5e\nimport cramlitest", []),
        ("import cramlite.base.errors as e", ["line 1: cramlite.base.errors"]),
        ("from cramlite.model.geometry import Pose", ["line 1: cramlite.model.geometry.Pose"]),
        ("from cramlite.testing.task_checks import sample_action", ["line 1: cramlite.testing.task_checks.sample_action"]),
        ("from cramlite import planning", ["line 1: cramlite.planning"]),
        ("from cramlite import Pose", ["line 1: cramlite.Pose"]),  # a value: cramlite.model has it
        ("from cramlite.plugin import *", ["line 1: cramlite.plugin.*"]),
        ("def f():\n    from cramlite.plugin.registry import Registry", ["line 2: cramlite.plugin.registry.Registry"]),
        ("if TYPE_CHECKING:\n    import os, cramlite.cli.main", ["line 2: cramlite.cli.main"]),
    ],
)  # fmt: skip
def test_what_goes_beside_the_doors_is_seen(source: str, found: list[str]) -> None:
    assert list(beside_the_doors(source)) == found


def test_a_module_of_a_plugin_that_is_no_door_is_seen() -> None:
    assert of_plugins("import os\ndef f():\n    from cramlite_plugins.shapes.hull import hull") == {"cramlite_plugins.shapes.hull"}
    assert not of_plugins("from cramlite.model import Pose")


@pytest.mark.parametrize("page", [*PAGES, *SKELETONS], ids=lambda p: p.relative_to(ROOT).as_posix())
def test_names_that_readers_are_pointed_at_are_behind_a_door(page: Path) -> None:
    assert named_beside_the_doors(page.read_text(encoding="utf-8")) == []


def test_names_that_plugins_point_at_are_behind_a_door() -> None:
    found = {str(p.relative_to(ROOT)): named_beside_the_doors(p.read_text(encoding="utf-8")) for p in PLUGINS}
    assert {path: names for path, names in found.items() if names} == {}


def test_a_name_behind_no_door_is_seen() -> None:
    text = "see `cramlite.Pose`, ``cramlite.planning.trace.Entry``, `cramlite.model.Pose(...)`, `cramlite.testing`, `cramlite resolve`"
    assert named_beside_the_doors(text) == ["cramlite.Pose", "cramlite.planning.trace.Entry"]


# What a version promises


def test_nothing_is_lost_that_the_last_release_had() -> None:
    last = last_released()
    before = json.loads(last.read_text(encoding="utf-8"))
    assert tuple(before) == DOORS and all(before.values())
    assert list(broken(before, doors())) == [], f"{last.name}: docs/reference/promises.md says how a name is deprecated"


BEFORE: List = {"cramlite": {"f": {"positional": ["a", "b"], "by_keyword": ["c"], "required": ["a"]}, "K": {"members": ["m"]}, "LIMIT": {}}}


@pytest.mark.parametrize(
    ("name", "now", "said"),
    [
        ("f", {"positional": ["a", "b", "more"], "by_keyword": ["c", "d"], "required": ["a"]}, []),
        ("f", {"positional": ["a"], "by_keyword": ["b", "c"], "required": ["a"]}, ["positional parameters stand in another order"]),
        ("f", {"positional": ["b", "a"], "by_keyword": ["c"], "required": ["a"]}, ["positional parameters stand in another order"]),
        ("f", {"positional": ["a", "new", "b"], "by_keyword": ["c"], "required": ["a"]}, ["positional parameters stand in another order"]),
        ("f", {"positional": ["a", "b"], "required": ["a"]}, ["parameter 'c' is gone"]),
        ("f", {"positional": ["a", "b"], "by_keyword": ["c"], "required": ["a", "b"]}, ["parameter 'b' must be given"]),
        ("K", {"members": ["more"]}, ["'m' is gone"]),
        ("K", {"members": ["m", "more"]}, []),
    ],
)  # fmt: skip
def test_what_a_builder_would_miss_is_seen(name: str, now: dict[str, list[str]], said: list[str]) -> None:
    assert list(broken(BEFORE, {"cramlite": {**BEFORE["cramlite"], name: now}})) == [f"cramlite.{name}: {s}" for s in said]


def test_a_name_that_is_gone_is_seen_and_a_deprecated_one_is_not_gone(monkeypatch: pytest.MonkeyPatch) -> None:
    assert list(broken(BEFORE, {"cramlite": {"f": BEFORE["cramlite"]["f"], "LIMIT": {}, "more": {}}})) == ["cramlite.K is gone"]
    monkeypatch.setattr(cramlite._NAMES, "deprecated", {"Plannings": ("Plan", "0.2")})
    before = {"cramlite": {"Plannings": promised(cramlite.Plan)}}
    assert list(broken(before, doors())) == []


# What a door costs


def loaded_by(statement: str) -> set[str]:
    """The heavy libraries that a fresh process has loaded after a statement."""
    code = f"{statement}\nimport sys\nprint(*(m for m in {HEAVY!r} if m in sys.modules))"
    ran = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return set(ran.stdout.split())


@pytest.mark.parametrize("door", DOORS[:3])
def test_a_door_opens_lightly(door: str) -> None:
    assert loaded_by(f"import {door}") == set()


def test_what_is_heavy_is_seen() -> None:
    assert "msgspec" in loaded_by("from cramlite.model import Pose")
