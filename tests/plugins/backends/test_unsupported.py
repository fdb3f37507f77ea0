"""Every kind of step in every backend: written, or refused in one paragraph that says which backend can."""

from __future__ import annotations

from typing import get_args

import pytest
from msgspec.structs import replace
from test_ur_rtde import AWAY, DOWN, OPEN, SLIDE
from test_urscript import STEPS, program

from cramlite.model import (
    AnyStep,
    Drive,
    Fallback,
    ForceExtract,
    ForceInsert,
    Monitor,
    Parallel,
    Repeat,
    Robot,
    SpiralSearch,
)
from cramlite.plugin import UserError
from cramlite_plugins.backends import typed_json
from cramlite_plugins.backends.rapid import emit as rapid
from cramlite_plugins.backends.ur_rtde import emit as ur_rtde
from cramlite_plugins.backends.urscript import emit as urscript
from cramlite_plugins.robots import irb1200
from cramlite_plugins.robots.ur5e import UR5E

DRIVE = Drive(((1.0, 0.0, 0.0),), 0.3, 0.5, 0.5, 1.0, origin="1.Navigating/drive")
KINDS: tuple[AnyStep, ...] = (
    *STEPS, SLIDE, DRIVE,
    SpiralSearch(DOWN, 3.0, 0.001, 0.001, 0.02, 0.002, 25.0, 20.0, origin="search"),
    ForceInsert(DOWN, 8.0, 0.07, 0.02, 25.0, 11.0, origin="push"),
    ForceExtract(DOWN, 8.0, (0.0, 0.0), 0.07, 0.02, 25.0, 11.0, origin="pull"),
    Fallback(((AWAY,), (AWAY,)), origin="tries"), Parallel(((AWAY,), (OPEN,)), origin="both"),
    Repeat((AWAY,), 2, origin="again"), Monitor((AWAY,), force=20.0, origin="watch"),
)  # fmt: skip
LACKING = {
    "urscript": {"Drive"}, "ur_rtde": {"Drive"}, "typed_json": set[str](),
    "rapid": {"Drive", "ForceMove", "CompliantSlide", "SpiralSearch", "ForceInsert", "ForceExtract", "Parallel", "Monitor"},
    "rapid_fc": {"Drive", "ForceMove", "CompliantSlide", "Parallel", "Monitor"},
}  # fmt: skip


def emitted(backend: str, step: AnyStep) -> str:
    robot: Robot = irb1200.IRB1200 if backend.startswith("rapid") else UR5E
    typed = replace(program(step), sections=(), robot_type=robot.type, start=robot.home)
    if backend.startswith("rapid"):
        return rapid.emit(typed, robot, forces=backend == "rapid_fc").text
    modules = {"urscript": urscript.emit, "ur_rtde": ur_rtde.emit, "typed_json": typed_json.TypedJson().emit}
    return modules[backend](typed, robot).text


def test_every_kind_of_step_is_tried() -> None:
    known = {k.__name__ for kind in get_args(AnyStep) for k in (get_args(kind) or (kind,))}
    assert {type(s).__name__ for s in KINDS} >= known


@pytest.mark.parametrize("backend", LACKING)
@pytest.mark.parametrize("step", KINDS, ids=lambda s: type(s).__name__)
def test_a_step_is_written_or_refused_with_the_backend_that_can(backend: str, step: AnyStep) -> None:
    name = type(step).__name__
    if name not in LACKING[backend]:
        assert emitted(backend, step)
        return
    with pytest.raises(UserError) as refused:
        emitted(backend, step)
    said = str(refused.value)
    assert (step.origin or name) in said and "\n" not in said
    assert "rapid_fc" in said if backend == "rapid" and "rapid_fc" in said else "typed_json" in said


def test_a_drive_inside_a_control_step_is_found_before_anything_is_written() -> None:
    for backend in LACKING:
        if backend != "typed_json":
            with pytest.raises(UserError, match=r"1\.Navigating/drive': it drives a platform"):
                emitted(backend, Repeat((DRIVE,), 2, origin="again"))
