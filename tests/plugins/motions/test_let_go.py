"""How sure it is where a thing is that the hand has let go of."""

from __future__ import annotations

import pytest
from scenes import TABLE, down, world

from cramlite.model import Held, Motion, Pose, initial_belief
from cramlite.plugin import Context
from cramlite_plugins.kinematics.kinematics import inverse
from cramlite_plugins.motions.gripping import LET_GO, resolve_motion
from cramlite_plugins.robots.ur5e import UR5E
from cramlite_plugins.simulation.objects.furniture import cabinet, drawer
from cramlite_plugins.simulation.objects.products_and_fixtures import block

AT = Pose((0.75, 0.1, 0.35), (0.0, 0.0, 0.0, 1.0))
SHIFTED = 0.002


@pytest.mark.parametrize(("thing", "sigma"), [("drawer", SHIFTED), ("it", (LET_GO**2 + SHIFTED**2) ** 0.5)])
def test_what_is_on_rails_stays_where_it_is_let_go_of(thing: str, sigma: float) -> None:
    """Anything else is turned and pulled along a little by fingers that open."""
    it = block("it", Pose((0.5, -0.2, 0.1)), (0.04, 0.04, 0.06))
    room = world(TABLE, cabinet("cabinet", AT), drawer("drawer", AT, parent="cabinet"), it)
    there = inverse(UR5E, down(0.5, 0.2, 0.3), seed=UR5E.home)[0]
    belief = initial_belief(room, "arm1", there, 0.0).grasped(Held(thing, Pose((0.0, 0.0, 0.05)), 0.02, SHIFTED))
    context = Context(UR5E, room.robots[0], {}, None)  # type: ignore[arg-type]
    answers = resolve_motion(Motion("1.Opening/release", "gripper", None, {"to": "open"}), belief, context)
    after = next(iter(answers or ())).belief
    assert after is not None and after.poses[thing].sigma == pytest.approx(sigma)


@pytest.mark.parametrize(("opening", "moves"), [(0.085, False), (0.070, False), (0.055, True)])
def test_an_open_hand_is_not_opened_again(opening: float, moves: bool) -> None:
    """Open is what ``gripper_open`` calls so, more than 0.75 of the widest: a task that opens fingers would find its work done."""
    room = world(TABLE)
    context = Context(UR5E, room.robots[0], {}, None)  # type: ignore[arg-type]
    belief = initial_belief(room, "arm1", UR5E.home, opening)
    answer = next(iter(resolve_motion(Motion("1.Opening/release", "gripper", None, {"to": "open"}), belief, context) or ()))
    assert bool(answer.value) == moves
