"""Fingers behind a door that stands ajar: over its upper edge, where the arm can push it on; not behind one that is shut."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from msgspec.structs import replace

from cramlite import Engine
from cramlite.model import Action, Belief, Held, Location, Object, Pose, RobotMount, Thing, World, initial_belief
from cramlite.plugin import Context, Grounding, Refused, Unresolvable
from cramlite_plugins.kinematics.inverse import inverse
from cramlite_plugins.locations.jointed.handles import BEGUN, CLOSER, OPENED, PUSHED_ON, along_joint, lever
from cramlite_plugins.locations.kinds import ground
from cramlite_plugins.locations.pinching.antipodal import FINGER
from cramlite_plugins.locations.pushing.along_joint import INSIDE
from cramlite_plugins.motion_planning.cartesian import COARSE, JointPath, plan_straight_line
from cramlite_plugins.motion_planning.reach import tcp
from cramlite_plugins.objects.furniture import cabinet, door, drawer
from cramlite_plugins.robots.ur5e import UR5E
from cramlite_plugins.shapes.ray_casting import body, intervals
from cramlite_plugins.tasks.closing import Closing
from cramlite_plugins.tasks.opening import Opening

AT, SWING, LEAST = Pose.from_rotvec((0.6, 0.15, 0.25), (0, 0, -math.pi / 2)), 2.0, 0.8
"""As in scenario opening_turned_away: the door opens away from the robot."""
ACTION = Action("1.Closing", "soma:Closing", {"Patient": Object("door", entity="door")})


def _asked(opened: float, thing: Thing | None = None) -> tuple[Belief, Context]:
    things = (cabinet("cabinet", AT), thing or door("door", AT, "cabinet", swing=SWING, opened=opened))
    belief = initial_belief(World(things, (RobotMount("arm", "ur5e"),)), "arm", UR5E.home, 0.0)
    return belief, Context(UR5E, belief.world.robots[0], {"door": things[1].name}, Engine().knowledge.taxonomy)


def _behind(opened: float) -> tuple[list[Grounding], list[Refused], Belief]:
    belief, context = _asked(opened)
    found = list(ground(Location("it", "inner_side", "door", {"least": LEAST}), belief, context))
    return [a for a in found if isinstance(a, Grounding)], [a for a in found if isinstance(a, Refused)], belief


@pytest.mark.heavy
@pytest.mark.parametrize("every", [32, pytest.param(8, marks=pytest.mark.heavy)])
def test_the_arm_follows_each_hand_behind_a_door_until_that_is_open(every: int) -> None:
    found, refused, belief = _behind(0.6)
    thing = belief.world.thing("door")
    assert found and refused
    for place in (a.value for a in found[::every]):
        path = along_joint(thing, belief, place.pose, LEAST)
        lines = [
            plan_straight_line(None, UR5E, q, path, step_m=COARSE[0], step_rad=COARSE[1])
            for q in inverse(UR5E, place.pose, seed=UR5E.home)
        ]
        assert any(isinstance(line, JointPath) for line in lines), place


@pytest.mark.heavy
def test_a_hand_comes_from_behind_along_the_arc_and_is_in_nothing_of_the_door() -> None:
    found, _, belief = _behind(0.6)
    thing, pose = belief.world.thing("door"), belief.pose("door")
    assert thing.joint is not None
    wide, long = UR5E.gripper.pad
    fingers = np.array(list(itertools.product((-wide / 2, wide / 2), (-FINGER, FINGER), np.linspace(-UR5E.gripper.depth, long / 2, 12))))
    for place in (a.value for a in found):
        points = pose.inverse().apply(place.pose.apply(fingers))
        low, high = intervals(body(thing.geoms), points, np.tile((1.0, 0.0, 0.0), (len(points), 1)))
        assert not ((low < -0.001) & (high > 0.001)).any() and points[:, 0].max() < 0.003, place
        on = thing.joint.moved(pose, 0.01) * pose.inverse() * place.pose
        arc, way = (np.subtract(to, at) for at, to in ((place.pose.position, on.position), (place.before.position, place.pose.position)))
        assert way @ arc > 0.999 * np.linalg.norm(way) * np.linalg.norm(arc) and np.linalg.norm(way) < INSIDE + 1e-6


@pytest.mark.heavy
def test_near_the_hinge_it_is_pushed_last() -> None:
    found, _, belief = _behind(1.2)
    thing, handle = belief.world.thing("door"), belief.feature("door", "cram:Handle")
    assert thing.joint is not None and handle is not None
    near = [lever(thing.joint, belief.pose("door").inverse() * a.value.pose) < lever(thing.joint, handle.pose) / 2 for a in found]
    assert any(near) and near == sorted(near)


@pytest.mark.heavy
def test_behind_a_door_that_is_shut_there_is_no_hand() -> None:
    found, refused, _ = _behind(0.0)
    assert not found and any("'cabinet'" in r.reason for r in refused)


def test_a_drawer_has_no_side_to_be_pushed_open_from() -> None:
    belief, context = _asked(0.0, drawer("door", AT, "cabinet"))
    with pytest.raises(Unresolvable, match="'door' is no door with a handle"):
        list(ground(Location("it", "inner_side", "door", {"least": LEAST}), belief, context))


def _relations(belief: Belief) -> list[str]:
    ways = Opening().decompose(Action("1.Opening", "soma:Opening", {"Patient": Object("door", entity="door")}), belief)
    return [s.relation for way in ways for s in way.steps if isinstance(s, Location)]


def test_doors_alone_are_pushed_on() -> None:
    assert "inner_side" in _relations(_asked(0.0)[0])
    assert "inner_side" not in _relations(_asked(0.0, drawer("door", AT, "cabinet"))[0])


@pytest.mark.parametrize(
    ("held", "parameters", "shares"),
    [
        (True, {}, OPENED), (False, {}, PUSHED_ON), (False, {"share": 0.5}, (0.5,)), (True, {"ajar": 0.8}, BEGUN),
        (True, {"ajar": 0.25}, (0.2, 0.175, 0.15)), (True, {"ajar": 0.1}, (0.05,)),
    ],
)  # fmt: skip
def test_how_far_a_door_is_drawn_and_pushed(held: bool, parameters: dict[str, float], shares: tuple[float, ...]) -> None:
    belief, context = _asked(0.0)
    if held:
        belief = replace(belief, held=Held("door", tcp(belief, context).inverse() * belief.pose("door"), 0.0))
    found = ground(Location("it", "opened", "door", parameters), belief, context)
    ends = [a.value.carried.joint / SWING for a in found or () if isinstance(a, Grounding)]
    assert ends == pytest.approx(list(shares))


@pytest.mark.parametrize(("opened", "shares"), [(1.0, CLOSER), (0.6, CLOSER[:2]), (0.3, (0.15,))])
def test_how_far_a_door_is_led_before_it_is_pushed_shut(opened: float, shares: tuple[float, ...]) -> None:
    belief, context = _asked(SWING * opened)
    belief = replace(belief, held=Held("door", tcp(belief, context).inverse() * belief.pose("door"), 0.0))
    found = ground(Location("it", "closed", "door", {"ajar": 1.0}), belief, context)
    ends = [opened + a.value.carried.joint / SWING for a in found or () if isinstance(a, Grounding)]
    assert ends == pytest.approx(list(shares))


def test_doors_alone_are_led_before_they_are_pushed_shut() -> None:
    """A door turns farther than the wrist does: the hand lets go of its handle on the way, and goes before its front."""
    ways = [w for thing in (None, drawer("door", AT, "cabinet")) for w in Closing().decompose(ACTION, _asked(0.5, thing)[0])]
    led = [[s.relation for s in way.steps if isinstance(s, Location)] for way in ways if way.cost == 2.0]
    assert led == [["handle", "closed", "retreat", "front", "closed", "stop", "retreat"]]
    names = [s.name for s in next(w for w in ways if w.cost == 2.0).steps]
    assert len(set(names)) == len(names)


def test_a_drawer_that_is_pressed_on_is_drawn_as_far_as_by_its_handle() -> None:
    belief, context = _asked(0.0, drawer("door", AT, "cabinet"))
    found = ground(Location("it", "opened", "door", {"share": 0.0}), belief, context)
    assert len(list(found or ())) == len(OPENED)
