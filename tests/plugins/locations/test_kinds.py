"""Kinds of locations: each has a function, its parameters are explained, and those of placements are the keys of scenarios."""

from __future__ import annotations

import importlib

import pytest
from msgspec.structs import fields

from cramlite.plugin import LocationKind
from cramlite.scenario.task_specs import WhereSpec
from cramlite_plugins.locations.kinds import KINDS, Lazy
from cramlite_plugins.locations.parameters import Where


@pytest.mark.parametrize("kind", KINDS.values(), ids=list(KINDS))
def test_each_kind_has_a_function_and_explains_its_parameters(kind: LocationKind) -> None:
    assert isinstance(kind.ground, Lazy)
    module = importlib.import_module(f"cramlite_plugins.locations.{kind.ground.module}")
    assert callable(getattr(module, kind.ground.function))
    assert set(kind.explained) == {f.name for f in fields(kind.parameters)} and all(kind.explained.values())
    assert kind.summary.endswith(".")


def test_placements_take_what_scenarios_write_under_where() -> None:
    assert {f.name for f in fields(Where)} == set(WhereSpec.model_fields)
    for given in ({"near": "tin"}, {"visible_from": (0.1, 0, 1.2)}, {"attitude": "upside down", "region": "left"}):
        asked = WhereSpec.model_validate(given).model_dump(exclude_none=True)
        assert KINDS["on"].misfit(asked) == ""
    assert "'attitude' of the relation 'on': invalid enum value" in KINDS["on"].misfit({"attitude": "sideways"})
