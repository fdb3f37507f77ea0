"""Attempts to thread a hole onto a peg reach as far as the peg's place is uncertain; what they could not reach is refused."""

from __future__ import annotations

import math

import pytest
from msgspec.structs import replace

from cramlite.model import Action, Belief, Estimate, Held, Object, Pose, World, initial_belief
from cramlite.plugin import Unresolvable
from cramlite_plugins.objects.products_and_fixtures import hanger
from cramlite_plugins.tasks.insert_hole_onto_peg import EDGES, InsertHoleOntoPeg

ROLES = {"Locatum": Object("object_1", entity="tea"), "Relatum": Object("object_2", entity="hook/peg")}
THREAD = Action("3.InsertHoleOntoPeg", "artm:InsertHoleOntoPeg", ROLES)
HOLDS = replace(initial_belief(World((hanger("hook", Pose()),)), "arm", (0.0,), 0.08), held=Held("tea", Pose(), 0.05))


def uncertain(sigma: float) -> Belief:
    """Belief in which a hand holds a payload, and the hanger's position has a standard deviation [m]."""
    return replace(HOLDS, poses={**HOLDS.poses, "hook": Estimate(Pose(), sigma)})


def offsets(action: Action, sigma: float) -> list[tuple[float, float]]:
    """Offsets across the peg and up of the attempts [m]."""
    return [(0.008 * x, 0.008 * z) for x, z in InsertHoleOntoPeg()._places(action, uncertain(sigma))]


@pytest.mark.parametrize(("sigma", "attempts"), [(0.0, 5), (0.004, 5), (0.008, 13), (0.012, 25)])
def test_attempts_surround_the_place_as_far_as_it_is_uncertain(sigma: float, attempts: int) -> None:
    found = offsets(THREAD, sigma)
    assert len(found) == len(set(found)) == attempts and found[0] == (0.0, 0.0)
    assert [math.hypot(*f) for f in found[1:5]] == pytest.approx([0.008] * 4)
    angles = [math.radians(a) for a in range(0, 360, 15)]
    edge = [(EDGES * sigma * math.cos(a), EDGES * sigma * math.sin(a)) for a in angles]
    assert max(min(math.dist(p, f) for f in found) for p in edge) <= 0.010


def test_a_peg_that_may_be_anywhere_is_not_felt_for() -> None:
    with pytest.raises(Unresolvable, match=r"uncertain by 14 mm .*26 mm around; look at it from nearer, or calibrate"):
        list(InsertHoleOntoPeg().decompose(THREAD, uncertain(0.014)))


def test_stated_attempts_are_made() -> None:
    assert len(offsets(replace(THREAD, parameters={"attempts": 1}), 0.014)) == 1
