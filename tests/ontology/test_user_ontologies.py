"""Users bring their own classes with a scenario."""

from __future__ import annotations

import re
from pathlib import Path
from subprocess import CompletedProcess

import pytest
from helpers.as_a_user import cramlite

TURTLE = """
@prefix owl: <http://www.w3.org/2002/07/owl#> .
@prefix rdfs: <http://www.w3.org/2000/01/rdf-schema#> .
@prefix cram: <http://cramlite.org/ont/cram.owl#> .
cram:Chocolate a owl:Class ; rdfs:subClassOf cram:BoxedProduct .
"""

SCENARIO = """
scenario: sweets
designator: {task: Grasping, Patient: sweet}
objects: {sweet: {types: [cram:BoxedProduct]}}
robot: {type: ur5e}
things:
  - {name: floor, model: table, at: {position: [0.2, 0, -5 mm]}, with: {size: [1.6 m, 1.6 m, 20 mm]}}
  - {name: bar, model: block, type: cram:Chocolate, at: {position: [0.5, 0.2, 51 mm]}, with: {size: [50 mm, 50 mm, 100 mm]}}
"""


def resolve(folder: Path, text: str) -> CompletedProcess[str]:
    (folder / "sweets.ttl").write_text(TURTLE)
    (folder / "sweets.yaml").write_text(text)
    return cramlite("resolve", folder / "sweets.yaml", "--out", folder / "run", "--no-report")


def test_a_scenario_brings_a_class(tmp_path: Path) -> None:
    done = resolve(tmp_path, SCENARIO + "ontologies: [sweets.ttl]\n")
    assert done.returncode == 0, done.stderr
    assert "bar: cram:Chocolate is a cram:BoxedProduct" in done.stdout


def test_without_it_the_class_is_unknown(tmp_path: Path) -> None:
    done = resolve(tmp_path, SCENARIO)
    assert done.returncode == 2, done.stderr
    assert "cram:Chocolate" in done.stderr


@pytest.mark.parametrize("empty", ["folder", "sweets.ttl", "sweets.owl"])
def test_nothing_is_not_called_sound(empty: str, tmp_path: Path) -> None:
    (tmp_path / "folder").mkdir()
    (tmp_path / empty).write_text("\n") if empty != "folder" else None
    done = cramlite("ontology", "check", tmp_path / empty)
    assert done.returncode == 2
    assert re.search(rf"{empty}: (there is no ontology in this folder|this file is empty)", done.stderr)
