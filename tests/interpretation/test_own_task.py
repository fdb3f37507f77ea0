"""A task of a user's own that says more than the shipped one comes first, and a reading can be picked."""

from __future__ import annotations

from pathlib import Path

import pytest

from cramlite import Engine, Interpretation, Trace, data_folder, find_scenario, read_scenario
from cramlite.interpretation.interpretation import interpret
from cramlite.interpretation.rules import load_rules
from cramlite.plugin import UserError

ENGINE = Engine()
DEMONSTRATION = ENGINE.read_episode(data_folder("scenarios") / "fetch_from_hanger" / "demonstration")
CLASS = """
@prefix owl: <http://www.w3.org/2002/07/owl#> .
@prefix rdfs: <http://www.w3.org/2000/01/rdf-schema#> .
@prefix soma: <http://www.ease-crc.org/ont/SOMA.owl#> .
@prefix cram: <http://cramlite.org/ont/cram.owl#> .
cram:Selling a owl:Class ; rdfs:subClassOf soma:ModifyingPhysicalObject ,
    [ a owl:Restriction ; owl:onProperty cram:definesRole ; owl:someValuesFrom soma:LocatumRole ] ,
    [ a owl:Restriction ; owl:onProperty cram:definesRole ; owl:someValuesFrom soma:RelatumRole ] .
"""
RULE = """
task: cram:Selling
roles: {Locatum: soma:LocatumRole, Relatum: soma:RelatumRole}
source: a shop of our own
pre:
  - grasps(_, Locatum)
post:
  - not grasps(_, Locatum)
  - in_or_above(Locatum, Relatum)
explain: "{Locatum} is sold"
"""


def found(folder: Path, more: str = "") -> Interpretation:
    (folder / "own.ttl").write_text(CLASS)
    (folder / "selling.yaml").write_text(RULE.replace("explain:", f"{more}explain:"))
    taxonomy = Engine(ontologies=[folder / "own.ttl"]).knowledge.taxonomy
    rules = load_rules([data_folder("task_rules"), folder], ENGINE.knowledge.predicates, taxonomy)
    return interpret(DEMONSTRATION, rules, taxonomy)


def names(one: Interpretation) -> list[list[str]]:
    return [[m.task.split(":")[-1] for m in sequence.matches] for sequence in one.sequences()]


def test_one_that_says_what_class_a_thing_is_of_comes_before_a_generic_one(tmp_path: Path) -> None:
    assert names(found(tmp_path, "  - isa(Locatum, cram:BoxedProduct)\n"))[0][-1] == "Selling"


def test_one_that_says_less_does_not(tmp_path: Path) -> None:
    first, *others = names(found(tmp_path))
    assert first[-1] == "Ungrasping" and any("Selling" in tasks for tasks in others)


def first_plan(reading: int | str) -> str:
    scenario = read_scenario(find_scenario("fetch_from_hanger")).read_as(reading)
    return str(next(ENGINE.plans(scenario, ENGINE.setting(scenario), Trace()))[0])


def test_a_reading_is_picked_by_its_number_or_by_a_task() -> None:
    first, second = first_plan(1), first_plan("2")
    assert first == "Grasping -> ExtractHoleFromPeg -> Ungrasping" and second != first
    assert "Holding" in first_plan("Holding") or "Retracting" in second
    for wrong in ("0", 999, "Pouring"):
        with pytest.raises(UserError, match=f"There is no reading '{wrong}'"):
            first_plan(wrong)
