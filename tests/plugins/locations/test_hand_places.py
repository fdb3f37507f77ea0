"""Places of the hand at no thing: what refuses a lift goes back to where the arm was led before."""

from __future__ import annotations

from cramlite import Engine
from cramlite.model import Location, Place, Pose, RobotMount, World, initial_belief
from cramlite.plugin import Context, Grounding, Refused
from cramlite_plugins.locations.places import resolve_location
from cramlite_plugins.robots.ur5e import UR5E

MOUNT = RobotMount("arm", "ur5e")


def test_a_lift_that_is_out_of_reach_blames_the_places_that_led_there() -> None:
    belief = initial_belief(World((), (MOUNT,)), "arm", UR5E.home, 0.085)
    bindings = {"tea": "tea", "grasp(tea)": Place(Pose(), Pose(), thing="tea")}
    context = Context(UR5E, MOUNT, bindings, Engine().knowledge.taxonomy, seed=0)
    answers = {h: list(resolve_location(Location("up", "lift", None, {"height_m": h}), belief, context) or ()) for h in (0.02, 2.0)}
    assert all(isinstance(a, Grounding) for a in answers[0.02])
    assert answers[2.0] and all(isinstance(a, Refused) and a.because == ("grasp(tea)",) for a in answers[2.0])
