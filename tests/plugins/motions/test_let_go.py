"""How sure it is where a thing is that the hand has let go of."""

from __future__ import annotations

import pytest
from helpers.scenes import TABLE, down, world

from cramlite.model import GripFacts, Held, Location, Motion, Place, Pose, Release, initial_belief
from cramlite.plugin import Context
from cramlite_plugins.kinematics.inverse import inverse
from cramlite_plugins.motion_planning.reach import held_pose
from cramlite_plugins.motions.gripping import DROPPED, LET_GO, resolve_motion
from cramlite_plugins.objects.furniture import cabinet, drawer
from cramlite_plugins.objects.products_and_fixtures import basket, block
from cramlite_plugins.robots.ur5e import UR5E

AT = Pose((0.75, 0.1, 0.35), (0.0, 0.0, 0.0, 1.0))
SHIFTED = 0.002
CONTENT = 0.1  # height of what lies on the floor of the basket [m]


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


@pytest.mark.parametrize(("relation", "deeper"), [("in", True), ("on", False)])
def test_a_payload_may_fall_past_what_lies_in_a_container(relation: str, deeper: bool) -> None:
    """Contents give way, so its fall ends on the floor at the latest; what is put onto a thing stays there."""
    bin_ = basket("bin", Pose((0.5, 0.2, 0.0)))
    content = block("content", Pose((0.5, 0.2, 0.01 + CONTENT / 2)), (0.06, 0.06, CONTENT))
    room = world(TABLE, bin_, content, block("it", Pose((0.5, -0.2, 0.1)), (0.04, 0.04, 0.06)))
    there = inverse(UR5E, down(0.5, 0.2, 0.3), seed=UR5E.home)[0]
    belief = initial_belief(room, "arm1", there, 0.0).grasped(Held("it", Pose((0.0, 0.0, 0.05)), 0.02))
    belief = belief.related(("on", "it", "content")) if relation == "on" else belief
    release = Release(0.1, into="bin", sigma_m=DROPPED) if deeper else Release(0.02, sigma_m=LET_GO)
    context = Context(UR5E, room.robots[0], {"place": Place(Pose(), Pose(), release=release)}, None)  # type: ignore[arg-type]
    motion = Motion("1.Ungrasping/open", "gripper", Location("place", "any", "target"), {"to": "open"})
    after = next(iter(resolve_motion(motion, belief, context) or ())).belief
    assert after is not None
    rest, let_go_at = after.poses["it"], belief.base() * held_pose(belief, context)
    believed = let_go_at.position[2] - rest.pose.position[2]
    assert rest.sigma == pytest.approx(release.sigma_m)
    assert rest.fall == pytest.approx(believed + (CONTENT if deeper else 0.0), abs=1e-6)


def test_a_payload_comes_to_rest_as_its_place_says() -> None:
    """No relation is known by name: the place says how it settles, and into what it falls."""
    room = world(TABLE, block("it", Pose((0.5, -0.2, 0.1)), (0.04, 0.04, 0.06)))
    belief = initial_belief(room, "arm1", UR5E.home, 0.0).grasped(Held("it", Pose((0.0, 0.0, 0.05)), 0.02))
    settles = Pose.from_rotvec((0.0, 0.0, 0.0), (0.3, 0.0, 0.0))
    context = Context(UR5E, room.robots[0], {"place": Place(Pose(), Pose(), release=Release(0.0, settles=settles))}, None)  # type: ignore[arg-type]
    motion = Motion("1.Ungrasping/open", "gripper", Location("place", "any"), {"to": "open"})
    after = next(iter(resolve_motion(motion, belief, context) or ())).belief
    assert after is not None
    assert after.poses["it"].pose.distance(belief.base() * held_pose(belief, context) * settles) == pytest.approx((0.0, 0.0), abs=1e-9)


def test_a_plugin_that_says_the_width_of_a_grip_among_the_values_says_a_grip() -> None:
    assert Place(Pose(), Pose(), values={"width_m": 0.04}).grip == GripFacts(0.04)
    assert Place(Pose(), Pose(), values={"depth_m": 0.04}).grip is None
