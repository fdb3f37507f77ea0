"""Files of strangers through the command line: one paragraph that names the file, exit code 2, little memory, no other file
opened."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import pytest
from conftest import Ran, Run
from helpers.as_a_user import cramlite
from helpers.audited import audited
from helpers.hostile_files import IMPORTS, ONTOLOGIES, SCENES, VIEWS, YAML, around_scene

from cramlite_plugins.imports.scenes.guard import MOST_BYTES

MOST = 2**30
"""Bytes that a refusal may take beside those of Python and its libraries."""
ELSEWHERE = ("/etc/passwd", "/dev/zero", "secret.txt", "secret.stl", "pwned")

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="has neither pipes nor limits of a process")


def refused(run: Run, name: str, *words: object) -> Ran:
    """Run a command that must refuse, with a limit to its memory, and look at the files that it opens."""
    import resource

    taken = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize() if Path("/proc/self/statm").exists() else 0
    before = resource.getrlimit(resource.RLIMIT_AS)
    resource.setrlimit(resource.RLIMIT_AS, (taken + MOST, before[1]))
    try:
        with audited() as heard:
            ran = run(*words)
    finally:
        resource.setrlimit(resource.RLIMIT_AS, before)
    _nothing_else(heard)
    assert ran.code == 2, ran.err
    assert "Traceback" not in ran.out + ran.err
    message = ran.err[ran.err.index("cramlite: ") :]
    assert message.count("\n") == 1 and name in message and len(message) < 1000
    assert "SECRET" not in ran.out + ran.err
    return ran


def _nothing_else(heard: list[tuple[str, Any]]) -> None:
    opened = [str(what[0]) for event, what in heard if event == "open"]
    assert not [o for o in opened if o.endswith(ELSEWHERE)]
    assert not [event for event, _ in heard if event.startswith(("socket.", "urllib.", "subprocess.", "os.system", "pickle."))]


@pytest.fixture(autouse=True, scope="module")
def warm(tmp_path_factory: pytest.TempPathFactory) -> None:
    """What is imported at a first call, and asks the machine, is imported."""
    path = tmp_path_factory.mktemp("warm") / "scene.xml"
    path.write_text("<mujoco><worldbody><body name='tin'><freejoint/><geom size='.1'/></body></worldbody></mujoco>")
    assert cramlite("import", path).returncode == 0


@pytest.mark.parametrize("case", SCENES)
def test_scenes(case: str, run: Run, tmp_path: Path) -> None:
    text, said = SCENES[case]
    folder = tmp_path / "scene"
    folder.mkdir()
    around_scene(folder)
    path = folder / ("scene.urdf" if text.endswith("</robot>") else "scene.xml")
    path.write_text(text)
    before = sorted(tmp_path.rglob("*"))
    assert said in refused(run, path.name, "import", path, "--out", tmp_path / "out.yaml").err
    assert sorted(tmp_path.rglob("*")) == before


def test_a_folder_that_is_stated_may_be_read(run: Run, tmp_path: Path) -> None:
    (tmp_path / "scene").mkdir()
    tin = "<body name='tin' pos='.7 0 .1'><freejoint/><geom size='.1'/></body>"
    (tmp_path / "more.xml").write_text(f"<mujoco><worldbody>{tin}</worldbody></mujoco>")
    path = tmp_path / "scene" / "scene.xml"
    path.write_text('<mujoco><include file="../more.xml"/></mujoco>')
    said = refused(run, "scene.xml", "import", path).err
    assert "'packages: {assets: FOLDER}' beside 'file' in a scenario, or 'cramlite import' with --package assets=FOLDER" in said
    assert "tin" in run("import", path, "--package", f"assets={tmp_path}").out
    scenario = "scenario: own\ngoal: [tin held]\nrobot: {type: ur5e}\nworld: {file: scene.xml%s}\n"
    for stated, code in (("", 2), (f", packages: {{assets: {tmp_path}}}", 0)):
        (tmp_path / "scene" / "own.yaml").write_text(scenario % stated)
        assert run("check", tmp_path / "scene" / "own.yaml").code == code


@pytest.mark.parametrize("marker", ["package.xml", "__init__.py", ".git"])
def test_comments_with_hyphens_and_a_package_around_are_let_pass(run: Run, tmp_path: Path, marker: str) -> None:
    (tmp_path / marker).write_text("")
    (tmp_path / "more.xml").write_text("<mujoco><worldbody><body name='tin'><freejoint/><geom size='.1'/></body></worldbody></mujoco>")
    (tmp_path / "worlds").mkdir()
    path = tmp_path / "worlds" / "scene.xml"
    path.write_text('\n<?xml version="1.0"?><mujoco><!-- ---- a -- b --- --><include file="../more.xml"/></mujoco>')
    assert "tin" in run("import", path).out


def test_a_mesh_that_is_too_large_is_not_opened(run: Run, tmp_path: Path) -> None:
    (tmp_path / "scene.xml").write_text('<mujoco><asset><mesh name="m" file="m.obj"/></asset></mujoco>')
    with (tmp_path / "m.obj").open("wb") as file:
        file.truncate(MOST_BYTES + 1)
    assert "200.0 MB; files of this kind" in refused(run, "m.obj", "import", tmp_path / "scene.xml").err


@pytest.mark.parametrize("case", YAML)
def test_yaml(case: str, run: Run, tmp_path: Path) -> None:
    text, said = YAML[case]
    (tmp_path / "scenario.yaml").write_text(text)
    assert said in refused(run, "scenario.yaml", "check", tmp_path / "scenario.yaml").err


@pytest.mark.parametrize("case", ONTOLOGIES)
def test_ontologies(case: str, run: Run, tmp_path: Path) -> None:
    name, text, said = ONTOLOGIES[case]
    (tmp_path / name).write_text(text)
    assert said in refused(run, name, "ontology", "check", tmp_path / name).err


@pytest.mark.parametrize("case", IMPORTS)
def test_what_an_ontology_imports_is_not_opened(case: str, run: Run, tmp_path: Path) -> None:
    name, text = IMPORTS[case]
    (tmp_path / name).write_text(text)
    with audited() as heard:
        assert run("ontology", "check", tmp_path / name).code == 0
    _nothing_else(heard)


QUERIES = ("SELECT * FROM <file:///etc/passwd> WHERE {?a ?b ?c}", "SELECT * WHERE {SERVICE <http://127.0.0.1:9/x> {?a ?b ?c}}")


@pytest.mark.parametrize("query", QUERIES)
def test_a_query_opens_nothing(query: str, run: Run) -> None:
    assert "would read another file or address" in refused(run, "ontologies and episodes alone", "query", query).err


@pytest.mark.parametrize("case", VIEWS)
def test_views(case: str, run: Run, tmp_path: Path) -> None:
    write, said = VIEWS[case]
    path = write(tmp_path)
    assert said in refused(run, path.name if path.is_file() else "depth.png", "perceive", path).err
