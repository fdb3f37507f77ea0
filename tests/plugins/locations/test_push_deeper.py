"""What was let go of under a roof, where a door that is closed later would meet it, is pushed farther in by closed fingers."""

from __future__ import annotations

import numpy as np
import pytest
from msgspec.structs import replace

from cramlite import Engine
from cramlite.model import Action, Belief, Location, Motion, Object, Place, Pose, RobotMount, World, initial_belief
from cramlite.plugin import Context, Grounding, Refused, Unresolvable
from cramlite_plugins.kinematics.inverse import inverse
from cramlite_plugins.locations.jointed.room_to_close import first_met
from cramlite_plugins.locations.kinds import ground
from cramlite_plugins.motions.gripping import LET_GO
from cramlite_plugins.objects.furniture import WALL, cabinet, door
from cramlite_plugins.objects.products_and_fixtures import block
from cramlite_plugins.robots.ur5e import UR5E
from cramlite_plugins.shapes.carried_along import pushed_along
from cramlite_plugins.tasks.retracting import Retracting

MOUNT = RobotMount("arm", "ur5e")
AT = Pose.from_rotvec((0.70, -0.1, 0.30), (0, 0, np.pi))  # its front looks to the robot
LONG = 0.11  # of a block, along the way in [m]
FLOOR = 0.30 - 0.10 + WALL  # of the cabinet [m]
OFF, DEEPER = Location("off", "off", "it"), Location("deeper", "deeper", "it")


def _about(task: str, name: str, **roles: str) -> Action:
    return Action(name, task, {role: Object(thing, entity=thing) for role, thing in roles.items()})


RETRACTING = _about("soma:Retracting", "3.Placing/Retracting", Relatum="it")
CLOSING = _about("soma:Closing", "4.Closing", Patient="door")


def _asked(out: float, *agenda: Action, deep: float = 0.25, down: float = 0.0) -> tuple[Belief, Context]:
    """Open fingers about the near end of a block in a narrow cabinet, so far from its front; the door is open."""
    near = 0.70 + out
    it = block("it", Pose((near + LONG / 2, -0.1, FLOOR + 0.065)), (LONG, 0.04, 0.13))
    size = (deep, 0.16, 0.20)
    things = (cabinet("cabinet", AT, size), door("door", AT, "cabinet", width=0.16, swing=1.9, opened=1.8), it)
    hand = Pose.from_axes((near + 0.03, -0.1, FLOOR + 0.07), (np.cos(down), 0.0, -np.sin(down)), (0.0, 0.0, 1.0))
    belief = initial_belief(World(things, (MOUNT,)), "arm", UR5E.home, 0.06).moved(inverse(UR5E, hand, seed=UR5E.home)[0])
    bindings = {"cabinet": "cabinet", "it": "it", "door": "door"}
    return belief, Context(UR5E, MOUNT, bindings, Engine().knowledge.taxonomy, agenda)


def _first(location: Location, belief: Belief, context: Context) -> Grounding | Refused:
    return next(iter(ground(location, belief, context)))


def test_fingers_come_off_it_and_push_it_so_far_in_that_the_door_can_be_closed() -> None:
    belief, context = _asked(0.0, RETRACTING, CLOSING)
    off = _first(OFF, belief, context)
    assert isinstance(off, Grounding) and off.value.pose.position[0] < 0.70 - UR5E.gripper.pad[1] / 2  # before its near end
    there = replace(belief, opening=0.0).moved(inverse(UR5E, off.value.pose, seed=belief.joints)[0])
    assert first_met("it", belief, context, LET_GO) is not None
    deeper = _first(DEEPER, there, context)
    assert isinstance(deeper, Grounding), deeper
    place: Place = deeper.value
    assert 0.003 < place.carried.pushed_m < 0.03 and abs(place.pose.position[2] - off.value.pose.position[2]) < 1e-6
    gone = pushed_along(there, place)
    assert first_met("it", gone, context, LET_GO) is None
    assert gone.pose("it").position[0] == pytest.approx(belief.pose("it").position[0] + place.carried.pushed_m)
    tips = place.pose.position[0] + UR5E.gripper.pad[1] / 2
    assert tips == pytest.approx(0.70 + place.carried.pushed_m, abs=0.003)  # they are at it in the end


@pytest.mark.parametrize(
    ("out", "agenda", "says"),
    [
        (0.03, (RETRACTING, CLOSING), "'it' is not in the way of a drawer or door that a later task closes"),
        (0.0, (RETRACTING,), "'it' is not in the way of a drawer or door that a later task closes"),
        (-0.09, (RETRACTING, CLOSING), "'it' cannot be pushed in so far that it is out of the way"),
    ],
)
def test_nothing_is_pushed_that_is_in_no_way_or_out_of_reach(out: float, agenda: tuple[Action, ...], says: str) -> None:
    with pytest.raises(Unresolvable, match=says):
        _first(OFF, *_asked(out, *agenda))


def test_a_hand_that_points_down_pushes_nothing_in() -> None:
    with pytest.raises(Unresolvable, match="the hand points down"):
        _first(OFF, *_asked(0.0, RETRACTING, CLOSING, down=1.2))


def test_it_is_not_pushed_into_a_wall() -> None:
    belief, context = _asked(0.0, RETRACTING, CLOSING, deep=LONG + WALL + 0.004)
    off = _first(OFF, belief, context)
    assert isinstance(off, Grounding)
    no = _first(DEEPER, replace(belief, opening=0.0).moved(inverse(UR5E, off.value.pose, seed=belief.joints)[0]), context)
    assert isinstance(no, Refused) and "'it' is" in no.reason and "'cabinet'" in no.reason


def test_a_hand_that_withdraws_pushes_what_is_under_a_roof_and_says_so() -> None:
    belief, context = _asked(0.0)
    assert [len(d.steps) for d in Retracting().decompose(RETRACTING, belief)] == [2]  # nobody put it onto anything
    pushing, plain = Retracting().decompose(RETRACTING, belief.related(("on", "it", "cabinet")))
    kinds = [s.kind for s in pushing.steps if isinstance(s, Motion)]
    assert kinds == ["linear", "gripper", "linear", "linear"] and pushing.cost == plain.cost and len(plain.steps) == 2
    place = Place(Pose(), Pose(), thing="it")
    assert Retracting().allowance(RETRACTING, {RETRACTING.inside("deeper"): place}).moves == {"it"}
    assert not Retracting().allowance(RETRACTING, context.bindings).moves
