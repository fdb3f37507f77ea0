"""The table of mutants: each module of the validators is in it, and what it names is there."""

from __future__ import annotations

import pytest
import yaml
from benchmarks.mutants import ROOT, stale

TABLE = yaml.safe_load((ROOT / "tests" / "benchmarks" / "mutants.yaml").read_text())
VALIDATORS = "plugins/cramlite_plugins/validators"


def test_every_module_of_the_validators_has_mutants() -> None:
    there = {f"{VALIDATORS}/{path.name}" for path in (ROOT / VALIDATORS).glob("*.py")} - {f"{VALIDATORS}/__init__.py"}
    assert there and there - TABLE["modules"].keys() == set()


@pytest.mark.parametrize("module", TABLE["modules"])
def test_a_module_of_the_table_is_there_with_its_tests_and_what_is_changed_by_hand(module: str) -> None:
    entry, text = TABLE["modules"][module], (ROOT / module).read_text()
    assert entry["tests"] and [t for t in entry["tests"] if not (ROOT / t).is_file()] == []
    assert [old for old in entry.get("by_hand", {}) if old not in text] == []


@pytest.mark.parametrize("module", TABLE["equivalent"])
def test_an_equivalent_is_of_a_line_that_is_there_and_has_a_reason(module: str) -> None:
    assert module in TABLE["modules"] and stale(module, TABLE["equivalent"][module]) == []
    assert all(TABLE["equivalent"][module].values())
