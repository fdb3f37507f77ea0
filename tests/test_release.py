"""A release: files of the same bytes whoever builds them, workflows that say what the project says, versions that agree."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tarfile
import time
import tomllib
import zipfile
from pathlib import Path
from typing import Any

import pytest
from conftest import ROOT
from packaging.specifiers import SpecifierSet

from cramlite import __version__
from cramlite.plugin import load_yaml

PROJECT: dict[str, Any] = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
WORKFLOWS = sorted((ROOT / ".github" / "workflows").glob("*.yml"))
EPOCH = "1767225600"  # 2026-01-01
NEVER = shutil.ignore_patterns(".git", ".venv", "__pycache__", "build", "dist", "runs", ".*_cache")


def build(source: Path, out: Path) -> dict[str, bytes]:
    """The wheel and the sdist of a tree, without a network."""
    command = [sys.executable, "-m", "build", "--no-isolation", "--outdir", str(out), str(source)]
    ran = subprocess.run(command, capture_output=True, text=True, env={**os.environ, "SOURCE_DATE_EPOCH": EPOCH}, check=False)
    assert ran.returncode == 0, ran.stdout + ran.stderr
    return {p.suffix: p.read_bytes() for p in sorted(out.iterdir())}


@pytest.mark.heavy
def test_two_builds_are_of_the_same_bytes(tmp_path: Path) -> None:
    trees = [tmp_path / "one", tmp_path / "elsewhere" / "two"]
    for tree in trees:
        shutil.copytree(ROOT, tree, ignore=NEVER)
    (trees[1] / "cramlite" / "version.py").touch()
    os.utime(trees[1] / "README.md", (0, time.time()))
    first, second = (build(tree, tmp_path / f"dist{n}") for n, tree in enumerate(trees))
    assert set(first) == {".whl", ".gz"} and first == second
    (trees[1] / "README.md").write_text("another", encoding="utf-8")
    assert build(trees[1], tmp_path / "dist2") != first
    _holds_what_it_should(tmp_path / "dist0")


def _holds_what_it_should(dist: Path) -> None:
    """Whether the wheel has code and data, and the sdist what its tests need."""
    wheel = set(zipfile.ZipFile(next(dist.glob("*.whl"))).namelist())
    assert {"cramlite/py.typed", "cramlite_plugins/__init__.py", "cramlite/data/scenarios/fetch_from_hanger.yaml"} <= wheel
    assert not any(n.startswith(("tests/", "docs/")) for n in wheel)
    with tarfile.open(next(dist.glob("*.tar.gz"))) as sdist:
        names = {n.split("/", 1)[1] for n in sdist.getnames()}
    assert {"pyproject.toml", "LICENSE", "README.md", "tests/test_release.py", "scenarios/fetch_from_hanger.yaml"} <= names


def test_versions_agree() -> None:
    citation = load_yaml(ROOT / "CITATION.cff")
    newest = re.search(r"^## (\S+)", (ROOT / "CHANGELOG.md").read_text(encoding="utf-8"), re.MULTILINE)
    assert newest is not None
    assert {PROJECT["version"], __version__, citation["version"], newest[1]} == {__version__}


# Workflows


def jobs(path: Path) -> dict[str, Any]:
    found: dict[str, Any] = load_yaml(path)["jobs"]
    return found


def commands(path: Path) -> list[str]:
    """What the steps of a workflow run."""
    return [step["run"] for job in jobs(path).values() for step in job["steps"] if "run" in step]


def readme_command(name: str) -> str:
    found = re.search(rf"<!-- command: {name} -->\n```bash\n(.*?)\n```", (ROOT / "README.md").read_text(encoding="utf-8"))
    assert found is not None
    return found[1]


def test_workflows_run_what_the_project_says() -> None:
    assert [p.name for p in WORKFLOWS] == ["release.yml", "tests.yml"]
    said = commands(ROOT / ".github" / "workflows" / "tests.yml")
    assert {".ci/run", readme_command("test"), readme_command("run")} <= set(said)
    assert os.access(ROOT / ".ci" / "run", os.X_OK)


def test_workflows_try_the_versions_of_python_that_are_promised() -> None:
    promised = [f"3.{n}" for n in range(8, 30) if SpecifierSet(PROJECT["requires-python"]).contains(f"3.{n}.1")]
    tried = set(re.findall(r'"(3\.\d+)"', (ROOT / ".github" / "workflows" / "tests.yml").read_text(encoding="utf-8")))
    assert sorted(tried, key=lambda v: int(v[2:])) == promised == ["3.11", "3.12", "3.13"]


@pytest.mark.parametrize("path", WORKFLOWS, ids=lambda p: p.name)
def test_workflows_may_do_little_and_use_what_cannot_change(path: Path) -> None:
    assert load_yaml(path)["permissions"] == {}
    for name, job in jobs(path).items():
        assert job["timeout-minutes"] <= 90
        assert set(job["permissions"].items()) <= {("contents", "read"), ("id-token", "write")}
        assert "id-token" not in job["permissions"] or (name == "publish" and job["environment"] == "pypi")
        used = [step["uses"] for step in job["steps"] if "uses" in step]
        assert used and all(re.fullmatch(r"[\w./-]+@[0-9a-f]{40}", u) for u in used)
