"""The error model: its declared defaults, one source at a time, and all of them scaled."""

from __future__ import annotations

import math

import pytest
from msgspec.structs import asdict, fields, replace

from cramlite.model import ErrorModel, PoseError, SensorErrors
from cramlite.model.twins.error_model import NO_ERRORS, SOURCES


def test_the_defaults_are_those_that_are_declared() -> None:
    model = ErrorModel()
    assert (model.pose.position, math.degrees(model.pose.angle)) == (0.002, pytest.approx(1.0))
    assert (model.friction, model.mass, model.gripper_force, model.latency) == (0.5, 0.2, 0.1, (0.008, 0.024))
    assert (model.size, model.centre, math.degrees(model.lean)) == (0.01, 0.05, pytest.approx(1.0))
    assert (model.kinematics, math.degrees(model.calibration), math.degrees(model.backlash)) == pytest.approx((0.0003, 0.02, 1 / 60))
    assert (model.hand_eye.position, math.degrees(model.hand_eye.angle)) == (0.003, pytest.approx(0.5))
    assert (dict(model.things), model.sensor, model.scale) == ({}, None, 1.0) and PoseError() == PoseError(0.0, 0.0)


def test_without_errors_every_number_is_nothing() -> None:
    assert NO_ERRORS.pose == NO_ERRORS.hand_eye == PoseError() and NO_ERRORS.sensor == SensorErrors(0.0, 0.0, 0.0)
    numbers = [v for n, v in asdict(NO_ERRORS).items() if isinstance(v, float) and n != "scale"]
    assert not any(numbers) and len(numbers) >= 6 and NO_ERRORS.latency == (0.0, 0.0) and NO_ERRORS.scale == 1.0


def test_every_number_belongs_to_one_source() -> None:
    owned = [name for names in SOURCES.values() for name in names]
    assert sorted(owned) == sorted({f.name for f in fields(ErrorModel)} - {"scale"})


@pytest.mark.parametrize("source", SOURCES)
def test_one_source_alone_keeps_its_own_numbers_and_the_scale(source: str) -> None:
    model = replace(ErrorModel(), scale=2.0, sensor=SensorErrors(), things={"cup": PoseError(0.1)})
    alone = model.only(source)
    for field in fields(ErrorModel):
        kept = field.name in (*SOURCES[source], "scale")
        assert getattr(alone, field.name) == getattr(model if kept else NO_ERRORS, field.name), field.name


def test_a_source_that_there_is_not() -> None:
    with pytest.raises(KeyError):
        ErrorModel().only("weather")


def test_scaling_twice_multiplies_and_changes_nothing_else() -> None:
    assert ErrorModel().scaled(3.0).scaled(2.0) == replace(ErrorModel(), scale=6.0)


def test_a_thing_has_its_own_error_or_that_of_all() -> None:
    model = replace(ErrorModel(), things={"cup": PoseError(0.1, 0.2)})
    assert model.of("cup") == PoseError(0.1, 0.2) and model.of("jug") == model.pose
