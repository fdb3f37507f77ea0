"""A source of error of twins is one entry: its field, with its declaration, is all that a new one takes."""

from __future__ import annotations

import hashlib
from typing import Annotated

import pytest
from msgspec.structs import replace
from pydantic import ValidationError, create_model

from cramlite import Engine, find_scenario, read_scenario
from cramlite.base.json_text import as_json
from cramlite.model import ErrorModel, Pose, SensorErrors, Thing, World
from cramlite.model.twins.error_model import sources, without_errors
from cramlite.model.twins.error_sources import ErrorSource, Size
from cramlite.model.twins.twin_drawing import MM, Drawing
from cramlite.scenario.error_spec import ErrorSpec, keys_of
from cramlite.scenario.twin import Twin, draw_twin

SETTING = Engine().setting(read_scenario(find_scenario("grasp_one_thing")))
DRAWN = {1: "28a84439c4db8aad", 7: "10f3a89b6eba8ca7"}
"""Seed -> hash of what is drawn for it with the default errors: the same seed gives the same twin in every version."""


def sunk(thing: Thing, size: float, draw: Drawing) -> Thing:
    """A thing deeper in what is soft under it."""
    down = draw.number("sinking", f"{thing.name}: sinks", size, "mm", MM)
    return replace(thing, pose=Pose((0.0, 0.0, down)) * thing.pose)


class Soft(ErrorModel):
    """Errors with a further source."""

    sinking: Annotated[float, ErrorSource("sinking", size=Size("length", 0.01), thing=sunk)] = 0.004


SoftSpec = create_model("SoftSpec", __base__=ErrorSpec, **keys_of(Soft))


def twin(errors: ErrorModel, seed: int = 1) -> Twin:
    return draw_twin(SETTING.world, SETTING.relations, SETTING.robot, errors, seed)


def heights(world: World) -> list[float]:
    return [t.pose.position[2] for t in world.things]


def test_a_new_source_is_written_left_out_drawn_and_applied_by_its_one_entry() -> None:
    assert list(sources(Soft)) == [*sources(ErrorModel), "sinking"] and without_errors(Soft).sinking == 0
    written = SoftSpec(sinking="3 mm").errors(without_errors(Soft), SensorErrors(0.0, 0.0, 0.0))
    assert isinstance(written, Soft) and written.sinking == 0.003
    alone = twin(Soft().only("sinking"))
    assert {d.source for d in alone.draws} == {"sinking"} and len(alone.draws) == len(SETTING.world.things)
    moved = [abs(b - a) for a, b in zip(heights(SETTING.world), heights(alone.world), strict=True)]
    assert moved == pytest.approx([abs(d.value) / MM for d in alone.draws], abs=1e-8) and 0 < max(moved) <= 0.004


def test_a_new_source_changes_nothing_of_what_the_others_draw() -> None:
    assert [d for d in twin(Soft()).draws if d.source != "sinking"] == list(twin(ErrorModel()).draws)


def test_a_size_of_a_new_source_beyond_its_most_is_refused() -> None:
    with pytest.raises(ValidationError, match=r"less than or equal to 0\.01"):
        SoftSpec(sinking="20 mm")
    with pytest.raises(ValidationError, match="sinking"):
        ErrorSpec(sinking="3 mm")


@pytest.mark.parametrize(
    ("key", "most", "beyond"),
    [
        ("position", "50 cm", "51 cm"),
        ("angle", "3.2 rad", "3.3 rad"),
        ("kinematics", "50 cm", "51 cm"),
        ("calibration", "3.2 rad", "3.3 rad"),
        ("lean", "0.2 rad", "0.21 rad"),
        ("latency", ("8 ms", "1 s"), ("8 ms", "1.01 s")),
    ],
)
def test_the_largest_error_of_a_file_is_taken_and_none_beyond_it(key: str, most: object, beyond: object) -> None:
    assert getattr(ErrorSpec(**{key: most}), key)
    with pytest.raises(ValidationError, match=key):
        ErrorSpec(**{key: beyond})


@pytest.mark.parametrize("seed", DRAWN)
def test_a_seed_draws_the_twin_that_it_always_drew(seed: int) -> None:
    draws = sorted(twin(ErrorModel(), seed).draws, key=as_json)
    assert hashlib.sha256(as_json(draws).encode()).hexdigest()[:16] == DRAWN[seed]
