"""Names of things and their parts, and of designators: each is read and written in one module, and nowhere else."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator

import pytest
from conftest import ROOT
from hypothesis import given
from hypothesis import strategies as st

from cramlite.model import EntityName, Object, enclosing_names, is_part_of, part_name, task_of, thing_of

PLAIN = st.text(st.characters(blacklist_characters="/", blacklist_categories=["Cs"]), min_size=1)
HOMES = {"cramlite/model/entity_name.py", "cramlite/model/designator_name.py"}
MODEL = "names of a MuJoCo model: what a robot, a hand or a thing brings has its name as prefix"
OTHERS = {
    "cramlite/testing/robot_skeleton.py": "addresses of files",
    "cramlite/experiment/store.py": "names of files",
    "plugins/cramlite_plugins/episodes/formats/fields.py": "IRIs",
    "plugins/cramlite_plugins/episodes/formats/neem.py": "tf frames",
    "plugins/cramlite_plugins/episodes/formats/mongodump.py": "tf frames",
    "plugins/cramlite_plugins/simulation/model/build.py": MODEL,
    "plugins/cramlite_plugins/simulation/model/compile.py": MODEL,
    "plugins/cramlite_plugins/simulation/model/grains.py": MODEL,
    "plugins/cramlite_plugins/simulation/model/hand_model.py": MODEL,
    "plugins/cramlite_plugins/simulation/model/index.py": MODEL,
    "plugins/cramlite_plugins/imports/robots/hand_drive.py": MODEL,
    "plugins/cramlite_plugins/imports/robots/hand_file.py": MODEL,
    "plugins/cramlite_plugins/imports/robots/hand_spec.py": MODEL,
    "plugins/cramlite_plugins/imports/scenes/source.py": "addresses of files",
}
READERS = {"split", "rsplit", "partition", "rpartition", "startswith", "endswith", "removeprefix", "removesuffix", "lstrip"}
WRITTEN = re.compile(r"\{\}/(\{\}|\w+|$)(/.*)?")


def _text(node: ast.AST) -> str:
    """A string, what is filled in as {}; "" for what is no string."""
    if isinstance(node, ast.JoinedStr):
        return "".join(_text(v) or "{}" for v in node.values)
    return node.value if isinstance(node, ast.Constant) and isinstance(node.value, str) else ""


def by_hand(source: str) -> Iterator[tuple[int, str]]:
    """Where a program takes text apart at "/" or puts two names together with it."""
    for node in ast.walk(ast.parse(source)):
        reads = isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and node.func.attr in READERS
        if (
            (reads and any(re.search(r"^/|/$", _text(a)) for a in node.args))  # type: ignore[attr-defined]
            or (isinstance(node, ast.Compare) and _text(node.left) == "/")
            or (isinstance(node, ast.JoinedStr) and WRITTEN.fullmatch(_text(node)))
        ):
            yield node.lineno, ast.unparse(node)  # type: ignore[attr-defined]


def _files() -> dict[str, str]:
    found = [f for folder in ("cramlite", "plugins") for f in (ROOT / folder).rglob("*.py")]
    return {f.relative_to(ROOT).as_posix(): f.read_text() for f in found}


@pytest.mark.heavy
def test_nobody_else_reads_or_writes_the_notation() -> None:
    found = {f: [*by_hand(text)] for f, text in _files().items() if f not in HOMES}
    assert {f: hits for f, hits in found.items() if hits and f not in OTHERS} == {}
    assert [f for f in OTHERS if not found[f]] == []  # an exception that nothing needs any more


@pytest.mark.parametrize(
    "line",
    [
        'name.split("/")[0]',
        'thing, _, part = name.partition("/")',
        'name.rpartition("/")',
        '"/" in name',
        '"/" not in name',
        'name.startswith(f"{thing}/")',
        'name.startswith("effector/")',
        'name.endswith("/left")',
        'f"{thing.name}/{feature.name}"',
        'f"{name}/base"',
    ],
)
def test_what_is_done_by_hand_is_seen(line: str) -> None:
    assert [*by_hand(line)]


@pytest.mark.parametrize("line", ['f"{a} of {b} m/s"', 'f"{folder}/{name}.json"', '"/".join(x)', "a / b", 'name.split(":")'])
def test_what_is_something_else_is_not(line: str) -> None:
    assert not [*by_hand(line)]


@given(PLAIN, st.text(st.characters(blacklist_categories=["Cs"])))
def test_what_is_written_is_read(thing: str, part: str) -> None:
    name = EntityName(thing, part)
    assert EntityName.parse(str(name)) == name
    assert thing_of(str(name)) == thing


def test_a_thing_is_no_part() -> None:
    assert str(EntityName("hook")) == "hook"
    assert str(EntityName("hook", "peg")) == "hook/peg"
    assert EntityName.parse("hook") == EntityName("hook", "") != EntityName.parse("hook/peg")


def test_the_thing_that_an_object_is_asked_for_by() -> None:
    assert Object("peg_1", entity="hook/peg").thing == Object("hook_1", entity="hook").thing == "hook"
    assert Object("hook_1").thing == ""


@given(st.lists(PLAIN, min_size=1, max_size=4))
def test_designators_inside_each_other(parts: list[str]) -> None:
    name = ""
    for part in parts:
        name = part_name(name, part)
    assert task_of(name) == parts[0]
    assert len([*enclosing_names(name)]) == len(parts)
    assert all(is_part_of(name, whole) for whole in [*enclosing_names(name)][1:])
    assert not is_part_of(name, name)


def test_a_task_is_not_inside_one_that_its_name_begins_with() -> None:
    assert is_part_of("1.Grasping/approach", "1.Grasping")
    assert not is_part_of("1.GraspingAgain/approach", "1.Grasping")
