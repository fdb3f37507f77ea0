"""Truth values are no numbers, in any file that people write, although pydantic reads them as 1 and 0."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from conftest import TASKS, Run
from pydantic import Field, ValidationError

import cramlite.experiment.benchmark.spec
import cramlite.experiment.demonstrations.spec
import cramlite.scenario.scenario
import cramlite_plugins.episodes.tables.mapping
from cramlite.base.quantities import Length
from cramlite.base.spec import Spec, read_value
from cramlite.model import Pose
from cramlite.plugin import UserError
from cramlite_plugins.objects.products_and_fixtures import make

FILES = (
    cramlite.scenario.scenario.ScenarioSpec,
    cramlite.experiment.demonstrations.spec.ExperimentSpec,
    cramlite.experiment.benchmark.spec.BenchmarkSpec,
    cramlite_plugins.episodes.tables.mapping.Mapping,
)


def specs(of: type[Spec] = Spec) -> Iterator[type[Spec]]:
    for one in of.__subclasses__():
        if one.__module__.startswith("cramlite"):
            yield one
        yield from specs(one)


def asks_a_number(schema: dict[str, Any]) -> bool:
    kinds = [schema.get("type"), *(s.get("type") for s in schema.get("anyOf", ()))]
    return bool({"number", "integer"} & set(kinds)) and "boolean" not in kinds


NUMBERS = [(s, k) for s in specs() for k, v in s.model_json_schema().get("properties", {}).items() if asks_a_number(v)]


@pytest.mark.parametrize(("spec", "key"), NUMBERS, ids=[f"{s.__module__}.{s.__name__}.{k}" for s, k in NUMBERS])
def test_true_is_no_number_in_any_file(spec: type[Spec], key: str) -> None:
    with pytest.raises(ValidationError) as found:
        spec.model_validate({key: True})
    assert (key,) in [e["loc"] for e in found.value.errors()]


def test_every_file_is_read_by_specs() -> None:
    assert len(NUMBERS) > 50, "else the tests above ask nothing"
    assert all(issubclass(f, Spec) for f in FILES)


class _Own(Spec):
    pair: tuple[float, float] = (0.0, 0.0)
    by_name: dict[str, int] = Field({})
    rows: tuple[tuple[float, ...], ...] = ()
    sure: bool = False
    things: dict[str, Any] = Field({})


@pytest.mark.parametrize(
    ("data", "says"),
    [
        ({"pair": [1, True]}, "this is true"),
        ({"by_name": {"proofs": False}}, "'proofs' is false"),
        ({"rows": [[1], [2, True]]}, "this is true"),
        ({"pair": [1, math.inf]}, "this is inf, which is not finite"),
        ({"things": {"damping": math.nan}}, "'damping' is nan, which is not finite"),
    ],
)
def test_nor_within_a_list_or_a_mapping(data: dict[str, Any], says: str) -> None:
    with pytest.raises(ValidationError, match=f"{says}; it should be a number"):
        _Own.model_validate(data)


def test_truth_values_stay_where_they_are_asked_for() -> None:
    found = _Own.model_validate({"sure": True, "things": {"fixed": True, "many": [True]}, "pair": [1, 0]})
    assert (found.sure, found.things, found.pair) == (True, {"fixed": True, "many": [True]}, (1.0, 0.0))


def test_a_budget_is_no_truth_value(run: Run, tmp_path: Path) -> None:
    path = tmp_path / "scenario.yaml"
    path.write_text(TASKS.read_text() + "budget: {proofs: true}\n")
    ran = run("check", path)
    assert ran.code == 2
    assert "'budget': 'proofs' is true; it should be a number" in ran.err


@pytest.mark.parametrize("hint", [float, Length, tuple[float, ...], float | None])
def test_values_are_read_as_fields_are(hint: Any) -> None:
    with pytest.raises(ValueError, match=r"[tT]rue"):
        read_value(hint, [True] if hint == tuple[float, ...] else True)


def test_a_models_number_is_no_truth_value() -> None:
    assert make("table", "floor", Pose(), {"size": [1, 1, 0.1], "friction": 1}).name == "floor"
    with pytest.raises(UserError, match="parameter 'friction' is True: this is true; it should be a number"):
        make("table", "floor", Pose(), {"size": [1, 1, 0.1], "friction": True})
    with pytest.raises(UserError, match="parameter 'damping' is nan: this is nan, which is not finite"):
        make("door", "door", Pose(), {"parent": "cabinet", "damping": math.nan})
