"""The engine knows no task: the core names no predicate that a plugin declares and no class of an ontology."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path

import pytest
from conftest import ROOT

from cramlite import Engine

CORE = ROOT / "cramlite"
KNOWN = Engine().knowledge
PREDICATES = frozenset(p.name for p in KNOWN.predicates)
TAXONOMY = KNOWN.taxonomy

UPPER = "foundation.py"
"""The one place for classes of the upper ontology in whose terms the model itself is written."""

ALLOWED: Mapping[tuple[str, str], str] = {
    ("rollout.py", "touches"): "an array of the file, named like the rollout's field",
    ("rollout.py", "effector"): "an array of the file, named like the rollout's field",
    ("run_peaks.py", "effector"): "the frame of the tool in a rollout",
    ("miss.py", "effector"): "the frame of the tool in a rollout",
    ("expectation.py", "effector"): "the frame of the tool in a rollout",
    ("program_run.py", "effector"): "the frame of the tool in a rollout",
    ("snapshots.py", "effector"): "the frame of the tool in a rollout",
    ("program_run.py", "touches("): "the name of an assertion, in a message",
    ("program_run.py", "moves("): "the name of an assertion, in a message",
    ("viewer.py", "effector"): "a node of the viewer's scene",
    ("setting_from_scenario.py", "thing"): "a key of the scenario, where an error points to it",
    ("worlds.py", "thing"): "a key of the scenario, where an error points to it",
    ("task_checks.py", "cram:Cavity"): "the kit for plugin authors has a hollow cube, so that tasks about contents run",
    ("task_checks.py", "soma:Grasping"): "an example in a message",
    ("check.py", "thing"): "a noun that is counted",
    ("goal.py", "thing"): "a noun that is counted",
    ("import_scene.py", "thing"): "a noun that is counted",
    ("perceive.py", "cram:TeaBox"): "an example in the help",
    ("condition_parser.py", "vrps:Peg"): "an example in a message",
    ("sparql.py", "soma:PhysicalTask"): "an example in a message",
    ("rules.py", "soma:Patient"): "an example in a message",
    ("rules.py", "soma:Grasping"): "an example in a message",
    ("rules.py", "grasps("): "an example in two messages",
    ("places.py", "near"): "a word of goals: where in a place a spot is",
    ("schema.py", "dul:Task"): "a description in the schema of rule files",
    ("schema.py", "grasps("): "an example in the schema of rule files",
}
"""(file, what it names) -> why it may."""


def named(path: Path) -> Iterator[tuple[int, str]]:
    """Line and word for each predicate or class that stands in a text of a module; documentation is none."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    remarks = {id(s.value) for n in ast.walk(tree) for s in _statements(n) if isinstance(s, ast.Expr)}
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in remarks:
            yield from ((node.lineno, word) for word in _words(node.value))


def _statements(node: ast.AST) -> list[ast.stmt]:
    body = getattr(node, "body", None)
    return body if isinstance(body, list) else []


def _words(text: str) -> Iterator[str]:
    if text in PREDICATES:
        yield text
    yield from (f"{p}(" for p in re.findall(r"\b([a-z_]+)\(", text) if p in PREDICATES)
    yield from (c for c in re.findall(r"\b[a-z]+:\w+", text) if c in TAXONOMY.classes)
    yield from (i for i in re.findall(r"https?://[^\s\"'<>]+", text) if TAXONOMY.curie(i) in TAXONOMY.classes)


def found(files: Iterable[Path]) -> list[str]:
    return [f"{f.name}:{line}: {w}" for f in files for line, w in named(f) if f.name != UPPER and (f.name, w) not in ALLOWED]


def test_the_core_names_no_predicate_and_no_class() -> None:
    assert not found(sorted(p for p in CORE.rglob("*.py") if "skeletons" not in p.parts))


def test_what_may_be_named_is_named() -> None:
    there = {(f.name, word) for f in CORE.rglob("*.py") for _, word in named(f)}
    assert set(ALLOWED) <= there, f"no longer named, so no longer allowed: {sorted(set(ALLOWED) - there)}"


def test_the_upper_classes_are_few_and_the_ontologies_have_them() -> None:
    classes = [word for _, word in named(CORE / "ontology" / UPPER)]
    assert set(classes) <= TAXONOMY.classes and {c.split(":")[0] for c in classes} == {"dul", "soma"}
    assert len(classes) == 6


@pytest.mark.parametrize(
    "line",
    [
        'fact = ("grasps", thing)', 'if kind == "vrps:Peg": pass', 'text = "touches(A, B)"',
        'peg = "http://www.artiminds.com/kb/vr_program_synthesis.owl#Peg"', 'says = f"{x} is no cram:Cavity"',
    ],
)  # fmt: skip
def test_a_name_that_is_put_in_is_found(line: str, tmp_path: Path) -> None:
    file = tmp_path / "operators.py"
    file.write_text(f'"""grasps(Gripper, Patient) and vrps:Peg may be explained."""\n{line}\n')
    assert len(found([file])) == 1
    file.write_text(file.read_text().replace(line, 'fact = ("grips it", "xyz:Peg")'))
    assert found([file]) == []
