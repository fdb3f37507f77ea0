"""A task that moves a drawer by its handle, when the hand has that handle already, as after a stop on its way."""

from __future__ import annotations

import pytest

from cramlite import Engine, find_scenario, read_scenario
from cramlite.engine.proof.proof import load_on_the_flange
from cramlite.model import Action, Held, Motion, Object, Pose
from cramlite.plugin import Unresolvable

ENGINE = Engine()


@pytest.mark.parametrize("task", ["soma:Opening", "soma:Closing"])
def test_it_lets_go_and_begins_again(task: str) -> None:
    setting = ENGINE.setting(ENGINE.read(read_scenario(find_scenario("kitchen/into_drawer"))), twins=0)
    action = Action("1.Task", task, {"Patient": Object("object_1", entity="drawer")})
    belief = setting.belief().grasped(Held("drawer", Pose(), 0.0))
    ways = list(ENGINE.knowledge.tasks[task].decompose(action, belief))
    motions = [step for step in ways[0].steps if isinstance(step, Motion)]
    assert len(ways) == 1 and [m.kind for m in motions[:3]] == ["gripper", "linear", "gripper"]
    assert len({m.name for m in motions}) == len(motions)
    with pytest.raises(Unresolvable, match="already holds 'tin'"):
        list(ENGINE.knowledge.tasks[task].decompose(action, setting.belief().grasped(Held("tin", Pose(), 0.0))))


def test_rails_carry_a_drawer_that_is_in_the_hand() -> None:
    setting = ENGINE.setting(ENGINE.read(read_scenario(find_scenario("kitchen/into_drawer"))), twins=0)
    gripper = setting.robot.gripper
    in_hand = {name: load_on_the_flange(setting.belief().grasped(Held(name, Pose(), 0.0)), gripper)[0] for name in ("drawer", "tin")}
    assert in_hand["drawer"] == gripper.mass < in_hand["tin"]
