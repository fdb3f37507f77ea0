"""Fingers before a front that is to be pushed: the arm can follow it until it is shut, from over its upper edge where from nowhere else."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from msgspec.structs import replace

from cramlite import Engine
from cramlite.model import Belief, Held, Location, Pose, Robot, RobotMount, World, initial_belief
from cramlite.plugin import Context, Grounding, Refused
from cramlite_plugins.kinematics.inverse import inverse
from cramlite_plugins.locations.jointed.handles import LEFT, ajar, along_joint, lever
from cramlite_plugins.locations.kinds import ground
from cramlite_plugins.locations.pinching.antipodal import FINGER
from cramlite_plugins.locations.pushing.along_joint import NEARER
from cramlite_plugins.locations.pushing.straight import BEHIND
from cramlite_plugins.motion_planning.cartesian import COARSE, JointPath, plan_straight_line
from cramlite_plugins.motion_planning.reach import tcp
from cramlite_plugins.objects.furniture import cabinet, door, drawer
from cramlite_plugins.robots.fr3 import FR3
from cramlite_plugins.robots.ur5e import UR5E
from cramlite_plugins.shapes.ray_casting import body, intervals

IN_FRONT = Pose.from_rotvec((0.75, 0.1, 0.35), (0, 0, math.pi))


def _fronts(robot: Robot, at: Pose, opened: float) -> tuple[list[Grounding], list[Refused], Belief]:
    things = (cabinet("cabinet", at), door("door", at, "cabinet", swing=2.0, opened=opened))
    belief = initial_belief(World(things, (RobotMount("arm", robot.type),)), "arm", robot.home, 0.0)
    context = Context(robot, belief.world.robots[0], {"door": "door"}, Engine().knowledge.taxonomy)
    found = list(ground(Location("front", "front", "door"), belief, context))
    return [a for a in found if isinstance(a, Grounding)], [a for a in found if isinstance(a, Refused)], belief


@pytest.mark.parametrize(("held", "least", "most"), [(False, 0.002, 0.004), (True, 0.0005, 0.001)])
def test_a_hand_that_only_pushes_a_door_may_be_farther_off_its_arc_and_so_stops_less_often(held: bool, least: float, most: float) -> None:
    at = Pose.from_rotvec((0.75, 0.1, 0.35), (0, 0, math.pi))
    things = (cabinet("cabinet", at), door("door", at, "cabinet", swing=2.0, opened=1.3))
    belief = initial_belief(World(things, (RobotMount("arm", UR5E.type),)), "arm", UR5E.home, 0.0)
    context = Context(UR5E, belief.world.robots[0], {"door": "door"}, Engine().knowledge.taxonomy)
    joint, now, hand = belief.thing("door").joint, belief.pose("door"), tcp(belief, context)
    assert joint is not None
    belief = belief.grasped(Held("door", hand.inverse() * now, 0.02)) if held else belief
    ways = [a.value for a in ground(Location("way", "closed", "door"), belief, context) if isinstance(a, Grounding)]
    points = [p.position for p in (hand, *ways[0].path)]
    away = [lever(joint, now.inverse() * Pose(tuple((np.add(a, b) / 2).tolist()))) for a, b in itertools.pairwise(points)]
    assert least < lever(joint, now.inverse() * hand) - min(away) <= most


@pytest.mark.heavy
@pytest.mark.parametrize("every", [36, pytest.param(12, marks=pytest.mark.heavy)])
def test_the_arm_follows_each_front_that_is_offered_until_it_is_all_but_shut(every: int) -> None:
    found, refused, belief = _fronts(UR5E, Pose.from_rotvec((0.75, 0.1, 0.35), (0, 0, math.pi)), 1.3)
    thing = belief.world.thing("door")
    for place in (a.value for a in found[::every]):
        share = ajar(thing.joint, belief.pose("door").inverse() * place.pose)  # type: ignore[arg-type]
        path = along_joint(thing, belief, place.pose, share)
        joints = inverse(UR5E, place.pose, seed=UR5E.home)
        lines = [plan_straight_line(None, UR5E, q, path, step_m=COARSE[0], step_rad=COARSE[1]) for q in joints]  # as it is looked at
        assert any(isinstance(line, JointPath) for line in lines), place
    assert any(r.reason.startswith("straight motion stops after") for r in refused)


@pytest.mark.heavy
def test_over_the_upper_edge_of_a_wide_open_door_the_hand_points_down() -> None:
    """Beside a robot that is led by its tool: no hand that points at the front comes along."""
    led = replace(FR3, conditioning=0.08, posture=(0.0, -0.161, 0.0, -2.445, 0.0, 2.227, 0.785))
    found, _, belief = _fronts(led, Pose.from_rotvec((0.65, -0.25, 0.15), (0, 0, math.pi / 2)), 1.85)
    over = [a for a in found if a.value.pose.rotate((0.0, 0.0, 1.0))[2] < -0.99]
    far = [a for a in over if "+80 % of its width" in a.key]  # where the hinge gives way
    first = belief.pose("door").inverse() * over[0].value.pose
    assert far and 0.15 - abs(first.position[1]) > 0.039, "fingers slid 30 mm along a door, over its edge, and caught on that"


@pytest.mark.heavy
def test_where_the_arm_is_folded_too_far_before_a_front_it_comes_from_nearer_last_of_all() -> None:
    """A door that is open towards the robot: its elbow has room 20 mm before it, and not 50 mm."""
    led = replace(FR3, conditioning=0.08, posture=(0.0, -0.161, 0.0, -2.445, 0.0, 2.227, 0.785))
    found, _, _ = _fronts(led, Pose.from_rotvec((0.50, -0.15, 0.15), (0, 0, math.pi / 2)), 1.85)
    off = [round(math.dist(a.value.pose.position, a.value.before.position), 6) for a in found]
    assert {BEHIND, NEARER} == set(off) and off == sorted(off, reverse=True)


@pytest.mark.heavy
def test_fingers_come_at_a_door_along_the_arc_that_it_turns_on() -> None:
    """And not into its front: at a bar before it the two are 14 deg apart, and fingers that friction holds press along the door."""
    found, _, belief = _fronts(UR5E, Pose.from_rotvec((0.75, 0.1, 0.35), (0, 0, math.pi)), 1.3)
    thing, pose = belief.world.thing("door"), belief.pose("door")
    assert thing.joint is not None
    place = found[0].value
    nearly = thing.joint.moved(pose, -0.01) * pose.inverse() * place.pose
    arc, way = (np.subtract(to, at) for at, to in ((place.pose.position, nearly.position), (place.before.position, place.pose.position)))
    assert way @ arc / np.linalg.norm(way) / np.linalg.norm(arc) > math.cos(math.radians(0.5))
    into = pose.rotate((-1.0, 0.0, 0.0))
    assert place.approach @ into < math.cos(math.radians(5.0)), "else it tells nothing"


@pytest.mark.heavy
def test_no_finger_begins_inside_a_bar_beside_the_spot_that_it_points_at() -> None:
    found, _, belief = _fronts(UR5E, Pose.from_rotvec((0.75, 0.1, 0.35), (0, 0, math.pi)), 1.3)
    shape = body(belief.world.thing("door").geoms)
    depth, (wide, long) = UR5E.gripper.depth, UR5E.gripper.pad
    fingers = np.array(list(itertools.product((-wide / 2, wide / 2), (-FINGER, FINGER), np.linspace(-depth, long / 2, 12))))
    for place in (a.value for a in found):
        points = belief.pose("door").inverse().apply(place.pose.apply(fingers))
        low, high = intervals(shape, points, np.tile((1.0, 0.0, 0.0), (len(points), 1)))
        assert not ((low < -0.001) & (high > 0.001)).any(), place


@pytest.mark.heavy
def test_a_door_is_pushed_near_its_hinge_last() -> None:
    found, _, belief = _fronts(UR5E, Pose.from_rotvec((0.75, 0.1, 0.35), (0, 0, math.pi)), 1.3)
    thing, handle = belief.world.thing("door"), belief.feature("door", "cram:Handle")
    assert thing.joint is not None and handle is not None
    near = [lever(thing.joint, belief.pose("door").inverse() * a.value.pose) < lever(thing.joint, handle.pose) / 2 for a in found]
    assert any(near) and near == sorted(near)


@pytest.mark.heavy
def test_fingers_that_may_slip_off_the_end_of_a_bar_come_after_those_that_meet_it_whole() -> None:
    found, _, _ = _fronts(UR5E, Pose.from_rotvec((0.75, 0.1, 0.35), (0, 0, math.pi)), 1.3)
    keys = [a.key for a in found]
    steep = ("tilted -70 deg", "tilted -90 deg")  # along the fingers, which then have all of the bar
    ends = [k for k, n in enumerate(keys) if "+0 % of its width, +60 % of its height" in n and not any(tilt in n for tilt in steep)]
    whole = [k for k, name in enumerate(keys) if "+0 % of its width, +75 % of its height" in name or "-80 % of its width, +60 %" in name]
    assert ends and whole and min(ends) > max(k for k in whole if "turned 90 deg" in keys[k])


def test_as_little_is_left_to_be_felt_of_a_door_as_of_a_drawer() -> None:
    it = door("door", Pose(), swing=2.0).joint
    assert it is not None
    hand = it.pose * Pose((0.0, -0.25, 0.0))
    assert ajar(it, hand) * 2.0 * 0.25 == pytest.approx(LEFT)
    slide = drawer("drawer", Pose(), travel=0.2).joint
    assert slide is not None and ajar(slide, hand) == 0.08


def test_of_two_hands_half_a_turn_apart_the_one_is_first_that_the_hand_has_less_far_to_turn_to() -> None:
    """A drawer's front is pushed by either; the wrist need not turn by half a turn before."""
    belief = initial_belief(World((cabinet("cabinet", IN_FRONT), drawer("drawer", IN_FRONT, "cabinet", opened=0.15)),
                                  (RobotMount("arm", UR5E.type),)), "arm", UR5E.home, 0.0)  # fmt: skip
    context = Context(UR5E, belief.world.robots[0], {"drawer": "drawer"}, Engine().knowledge.taxonomy)
    first = []
    for turn in (0.0, math.pi):
        q = (*UR5E.home[:5], UR5E.home[5] + turn)
        found = ground(Location("front", "front", "drawer"), replace(belief, joints=q), context)
        first.append(next(a for a in found if isinstance(a, Grounding)))
    one, other = (a.value.pose for a in first)
    assert one.position == pytest.approx(other.position, abs=1e-9)
    assert np.linalg.norm((one.inverse() * other).rotvec) == pytest.approx(math.pi, abs=1e-6)
