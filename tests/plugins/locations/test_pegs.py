"""What a peg that nothing can be led onto is blamed on."""

from __future__ import annotations

import pytest
from msgspec.structs import replace

from cramlite import Engine
from cramlite.model import GripFacts, Held, Location, Place, Pose, RobotMount, World, initial_belief
from cramlite.plugin import Context, Unresolvable
from cramlite_plugins.locations.kinds import ground
from cramlite_plugins.objects.products_and_fixtures import hanger, product
from cramlite_plugins.robots.ur5e import UR5E

MOUNT = RobotMount("arm", "ur5e")
GRASPED = Place(Pose(), Pose(), thing="coffee", grip=GripFacts(0.05))
LIFTED = Place(Pose((0.0, 0.0, 0.1)), Pose((0.0, 0.0, 0.1)))


@pytest.mark.parametrize("grasped", [True, False])
def test_a_peg_out_of_reach_is_blamed_on_the_grasp_and_on_no_lift(grasped: bool) -> None:
    """Another height of the lift is no help: each was tried, with each grasp, until the budget of the search was spent."""
    world = World((hanger("hook", Pose((3.0, 0.0, 0.5))), product("coffee", Pose((0.5, 0.0, 0.2)))), (MOUNT,))
    belief = replace(initial_belief(world, "arm", UR5E.home, 0.05), held=Held("coffee", Pose(), 0.05))
    bindings = {"peg": "hook/peg", **({"grasp": GRASPED} if grasped else {}), "up": LIFTED}
    context = Context(UR5E, MOUNT, bindings, Engine().knowledge.taxonomy)
    with pytest.raises(Unresolvable, match="the hole cannot be led onto the peg") as ended:
        list(ground(Location("onto", "insert", "peg"), belief, context))
    assert ended.value.because == (("grasp", "peg") if grasped else ("up", "peg"))
