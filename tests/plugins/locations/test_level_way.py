"""Level ways in under a roof are as high above the floor as the errors of the proof's twins ask for, and the room allows."""

from __future__ import annotations

import pytest
from helpers.placing import believed, context_of, query_on
from msgspec.structs import replace

from cramlite.model import ErrorModel, Pose
from cramlite_plugins.locations.placing.floors import HIGH
from cramlite_plugins.locations.placing.sideways import sideways
from cramlite_plugins.locations.reached import Arm
from cramlite_plugins.objects.furniture import WALL, cabinet

TALL = 2 * HIGH + 0.10
"""Height of the room that the block needs, standing [m]."""


def heights(inner: float, errors: ErrorModel | None) -> set[float]:
    """Heights above the floor of a cabinet with so high a room at which the block is carried in [m]."""
    belief = believed(cabinet("box", Pose.from_rotvec((0.6, -0.1, 0.3), (0.0, 0.0, 3.1416)), (0.3, 0.3, inner)))
    query = query_on(belief, "box", {"region": "inside"})
    asked = replace(query, arm=Arm(belief, replace(context_of(belief), errors=errors)))
    return {round(placement.height, 4) for group in sideways([asked]) if not hasattr(group, "reason") for _, placement in group}


def test_without_errors_a_thing_is_carried_in_low() -> None:
    assert heights(0.20, None) == {HIGH}


def test_errors_of_twins_ask_for_more_height_up_to_the_middle_of_the_room() -> None:
    assert HIGH + 0.004 < min(heights(0.20, ErrorModel())) < HIGH + 0.02
    assert min(heights(0.20, ErrorModel().scaled(10.0))) == pytest.approx(HIGH + (0.20 - 2 * WALL - TALL) / 2)
