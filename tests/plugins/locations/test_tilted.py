"""Placements in a covered opening: what does not get in upright comes in leaning, where a hand leads it, and stands up in there."""

from __future__ import annotations

import math

import numpy as np
import pytest
from msgspec.structs import replace

from cramlite import Engine
from cramlite.model import (
    Action,
    Belief,
    GripFacts,
    Held,
    Location,
    Object,
    Place,
    Pose,
    RobotMount,
    Thing,
    World,
    initial_belief,
    pair_friction,
)
from cramlite.plugin import Context, Grounding, Unresolvable
from cramlite_plugins.kinematics.inverse import inverse
from cramlite_plugins.locations.kinds import ground
from cramlite_plugins.locations.pinching.antipodal import Hands
from cramlite_plugins.locations.pinching.grips import Grip, ranked
from cramlite_plugins.locations.pinching.hand_room import Taken
from cramlite_plugins.locations.placing.for_later import leans
from cramlite_plugins.locations.placing.query import queries
from cramlite_plugins.locations.placing.tilting import LEFT, TILTS
from cramlite_plugins.locations.placing.ways_out import WAYS
from cramlite_plugins.objects.furniture import cabinet, drawer
from cramlite_plugins.objects.vessels import bowl
from cramlite_plugins.robots.fr3 import FR3

MOUNT = RobotMount("arm", "fr3")
LOW, HIGH = (Pose.from_rotvec((0.65, 0.0, z), (0.0, 0.0, np.pi)) for z in (0.14, 0.24))  # their fronts look to the robot
INTO = Location("in(drawer)", "in", "drawer", {})


def _cabinets(opened: float = 0.2) -> tuple[Thing, ...]:
    size, inner = (0.3, 0.3, 0.1), (0.25, 0.264, 0.07)
    lower = (cabinet("cabinet", LOW, size), drawer("drawer", LOW, "cabinet", inner, opened=opened))
    return (*lower, cabinet("upper", HIGH, size), drawer("upper_drawer", HIGH, "upper", inner))


def _grips(it: Thing, world: World, leans: bool) -> list[Grip]:
    """Those from above of a hand that leans, or does not, best first."""
    found = ranked(it, FR3.gripper, pair_friction(world.physics.pad_friction, it.least_friction))
    return [g for g in found if bool(g.lean) == leans and not g.ends and g.pose.rotate((0.0, 0.0, 1.0))[2] < -0.8]


def _asked(radius: float, leans: bool = True, opened: float = 0.2, grip: int = 0) -> tuple[Belief, Context]:
    """A bowl in the hand of an arm before two cabinets, one on the other."""
    it = bowl("it", Pose((0.4, -0.3, 0.4)), radius, 0.05, 0.003, 0.06)
    world = World((*_cabinets(opened), it), (MOUNT,))
    hand = it.pose * _grips(it, world, leans)[grip].pose
    start = initial_belief(world, "arm", FR3.home, 0.04)
    belief = start.grasped(Held("it", hand.inverse() * it.pose, 0.003)).moved(inverse(FR3, hand, seed=FR3.home)[0])
    bindings = {"drawer": "drawer", "it": "it", "grasp(it)": Place(hand, hand, thing="it", grip=GripFacts(0.003))}
    return belief, Context(FR3, MOUNT, bindings, Engine().knowledge.taxonomy)


def _lean(pose: Pose) -> float:
    return math.degrees(math.acos(float(pose.rotate((0.0, 0.0, 1.0))[2])))


def _refused(location: Location, belief: Belief, context: Context) -> Unresolvable:
    with pytest.raises(Unresolvable) as no:
        list(ground(location, belief, context))
    return no.value


def _first_place() -> tuple[Belief, Context, Place]:
    """By the first grip that does."""
    for grip in range(20):
        belief, context = _asked(0.0705, grip=grip)
        try:
            found = next(a for a in ground(INTO, belief, context) if isinstance(a, Grounding))
        except Unresolvable:
            continue
        return belief, context, found.value
    raise AssertionError("no grip does")


@pytest.mark.heavy
def test_a_bowl_comes_in_leaning_and_is_let_go_of_where_it_stands_up() -> None:
    belief, _, place = _first_place()
    assert belief.held is not None
    before, there, end = (pose * belief.held.tcp_to_thing for pose in (place.before, *place.via, place.pose))
    assert _lean(there) == pytest.approx(_lean(before), abs=1e-3) and round(_lean(there)) in TILTS
    assert _lean(end) == pytest.approx(LEFT, abs=1e-3)
    assert end.position[0] > there.position[0] > before.position[0]  # in under the handle, away from the robot
    assert place.reorients


def test_upright_it_is_refused_at_once_and_another_way_of_the_task_is_asked_for() -> None:
    no = _refused(INTO, *_asked(0.0705, leans=False))
    assert no.reason.startswith("'it' does not get into 'drawer' upright: 'cabinet' and 'upper' and 'upper_drawer' are over it")
    assert "upper_drawer" in (no.blocking or ())


def test_one_that_is_narrow_enough_is_not_refused_upright() -> None:
    found = ground(INTO, *_asked(0.045, leans=False))
    assert any(isinstance(a, Grounding) for a in found)


def test_a_hand_that_does_not_lean_is_to_blame() -> None:
    no = _refused(INTO, *_asked(0.0705, leans=False))
    assert no.reason.endswith("; tilted: hand and tilted payload fit nowhere between the target's overhang and its walls")
    assert no.because == ("drawer", "grasp(it)")


def test_between_a_front_and_a_handle_that_are_too_near_to_each_other_nothing_comes_in() -> None:
    assert "fit nowhere between" in _refused(INTO, *_asked(0.0705, opened=0.11)).reason


def test_under_nothing_things_go_in_from_above() -> None:
    belief, context = _asked(0.0705)
    alone = World(tuple(t for t in belief.world.things if not t.name.startswith("upper")), (MOUNT,))
    held = belief.held
    assert held is not None
    free = initial_belief(alone, "arm", FR3.home, 0.04).grasped(held).moved(belief.joints)
    poses = {n: e for n, e in free.poses.items() if n != "cabinet"}  # which is over the half of it that is not open
    names = [way.name for way in WAYS["in"] if way.rank(queries(INTO, replace(free, poses=poses), context)) is not None]
    assert names == ["from above"]


@pytest.mark.parametrize(("radius", "leaning"), [(0.0705, True), (0.045, False)])
def test_hands_that_lean_come_first_for_what_goes_in_tilted(radius: float, leaning: bool) -> None:
    belief, context = _asked(radius, leans=False)
    there = initial_belief(belief.world, "arm", FR3.home, 0.04)
    drop = Action("1", "artm:Ungrasping", {"Locatum": Object("it", entity="it"), "Relatum": Object("drawer", entity="drawer")})
    it, two = belief.thing("it"), np.array([True, False])
    taken = Taken(Hands.at([Pose(), Pose()]), np.full(2, 0.05), np.ones(2, bool), two)
    found = leans(it, there, replace(context, agenda=(drop,)), taken)
    assert (found is not None and found.tolist() == two.tolist()) == leaning
    assert leans(it, there, context, taken) is None  # nothing brings it there
