"""Ways of grasping: with the hand straight back first only where it may stand among things."""

from __future__ import annotations

import pytest
from helpers.scenes import BLOCK, TABLE, world
from msgspec.structs import replace

from cramlite.model import Action, Object, initial_belief
from cramlite_plugins.robots.ur5e import UR5E
from cramlite_plugins.tasks.grasping import Grasping

ACTION = Action("1.Grasping", "soma:Grasping", {"Patient": Object("block", entity="block")})


@pytest.mark.parametrize(("opening", "moved", "ways"), [(0.002, False, 2), (0.002, True, 1), (None, False, 1)])
def test_an_arm_that_was_stopped_may_go_straight_back_first(opening: float | None, moved: bool, ways: int) -> None:
    """It is the last way, for the others take less time; where the arm stands as a scenario says, nothing is around its fingers."""
    room = world(TABLE, BLOCK)
    room = replace(room, robots=(replace(room.robots[0], joints=UR5E.home, opening=opening),))
    belief = initial_belief(room, "arm1", UR5E.home, 0.0)
    found = list(Grasping().decompose(ACTION, belief.moved((0.1, *UR5E.home[1:])) if moved else belief))
    assert len(found) == ways and [w.steps[0].name for w in found][1:] == ["1.Grasping/away"] * (ways - 1)
    assert [w.cost for w in found] == sorted(w.cost for w in found)
