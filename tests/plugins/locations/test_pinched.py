"""In which order a thing that lies flat is taken: across its rim before hundreds of ways in which the hand would be in what carries it."""

from __future__ import annotations

import pytest
from msgspec.structs import replace

from cramlite import Engine, find_scenario, read_scenario
from cramlite.model import Location, Pose
from cramlite.plugin import Context, Grounding
from cramlite_plugins.locations.kinds import ground


def _names(lifted: float) -> list[str]:
    """How a plate that is so high over its table may be taken [m], in the order that is tried, to the tenth that is offered."""
    engine, scenario = Engine(), read_scenario(find_scenario("tasks/laying_down"))
    setting = engine.setting(scenario, twins=0)
    belief = setting.belief()
    x, y, z = belief.poses["plate"].pose.position
    there = Pose((x, y, z + lifted), belief.poses["plate"].pose.quaternion)
    belief = replace(belief, poses={**belief.poses, "plate": replace(belief.poses["plate"], pose=there)})
    context = Context(setting.robot, setting.world.robots[0], {"plate": "plate"}, engine.knowledge.taxonomy)
    found = list(ground(Location("grasp(plate)", "grasp", "plate"), belief, context))
    return [str(a.key) if isinstance(a, Grounding) else str(a.value) for a in found]


@pytest.mark.heavy
def test_where_it_lies_its_rim_comes_before_all_that_has_no_room() -> None:
    names = _names(0.0)
    rim = [k for k, name in enumerate(names) if name.startswith("across its rim")]
    assert rim == list(range(len(rim))) and len(names) > 3 * len(rim)  # what is left is tried last


@pytest.mark.heavy
def test_where_a_hand_has_room_beside_it_its_rim_comes_later() -> None:
    names = _names(0.3)
    assert not names[0].startswith("across its rim") and any(name.startswith("across its rim") for name in names)
