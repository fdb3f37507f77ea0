"""What is in the way of a pushed thing is to blame, with the hand that pushes it, and nothing that the arm did before."""

from __future__ import annotations

import pytest
from msgspec.structs import replace

from cramlite import Engine, find_scenario, read_scenario
from cramlite.model import Location, Place, Pose, RobotMount, World, initial_belief
from cramlite.plugin import Context, Grounding, Refused
from cramlite_plugins.locations.kinds import ground
from cramlite_plugins.locations.pushing import around
from cramlite_plugins.objects.products_and_fixtures import block, table
from cramlite_plugins.robots.ur5e import UR5E

BEGIN = "1.Pushing/inside"
WHERE = {"region": "left_region", "inside": True}
MOUNT = RobotMount("arm", "ur5e")


def _asked(location: Location, scenario: str, begin: Place | None = None) -> list[Grounding | Refused]:
    engine = Engine()
    world = engine.setting(read_scenario(find_scenario(scenario))).world
    belief = initial_belief(world, world.robots[0].name, UR5E.home, 0.0)
    bindings = {"plate": "plate"} | ({BEGIN: begin} if begin else {})
    return list(ground(location, belief, Context(UR5E, world.robots[0], bindings, engine.knowledge.taxonomy)))


@pytest.mark.heavy
@pytest.mark.parametrize("around", [False, True])
def test_where_a_fence_is_no_hand_is_asked_for_and_no_task_before_is_to_blame(around: bool) -> None:
    (no,) = _asked(Location(BEGIN, "behind", "plate", {**WHERE, "around": around}), "tasks/pushing_around_fails")
    assert isinstance(no, Refused) and no.blocking == () and not no.because


def test_a_hand_that_cannot_go_on_is_to_blame_for_that() -> None:
    hands = _asked(Location(BEGIN, "behind", "plate", {**WHERE, "around": True}), "tasks/pushing_around")
    hand = next(a for a in hands if isinstance(a, Grounding))
    (no,) = _asked(Location("1.Pushing/far", "pushed_to", "plate", {**WHERE, "begin": BEGIN}), "tasks/pushing_around", hand.value)
    assert hand.anew and isinstance(no, Refused) and no.because == (BEGIN,)  # straight on, from where the arm is at home


def test_what_a_thing_would_meet_is_asked_anew_once_that_is_elsewhere() -> None:
    board, floor = block("board", Pose((0.45, 0.0, 0.003)), (0.12, 0.12, 0.016)), table("floor", Pose((0.3, 0.0, -0.005)), (1.6, 1.6, 0.02))
    context = Context(UR5E, MOUNT, {}, Engine().knowledge.taxonomy)
    world = World((floor, board, block("other", Pose((0.45, 0.2, 0.035)), (0.05, 0.05, 0.06))), (MOUNT,))
    belief = initial_belief(world, "arm", UR5E.home, 0.0)
    for y, meets in ((0.2, True), (0.4, False), (0.2, True)):
        other = replace(belief.poses["other"], pose=Pose((0.45, y, 0.035)))
        met = around.met_alone(replace(belief, poses={**belief.poses, "other": other}), context, "board")
        assert [bool(met((0.45, 0.2))) for _ in range(2)] == [meets, meets]
