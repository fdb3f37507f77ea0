"""Places leave room for what a later task closes: a door comes to its stop, and a drawer with what lies in it."""

from __future__ import annotations

import re
from functools import cache

import numpy as np
import pytest

from cramlite import Engine
from cramlite.model import (
    Action,
    Belief,
    Estimate,
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
)
from cramlite.plugin import Context, Grounding, Refused, Unresolvable
from cramlite_plugins.kinematics.inverse import inverse
from cramlite_plugins.locations.jointed import room_to_close
from cramlite_plugins.locations.jointed.handles import LEFT
from cramlite_plugins.locations.jointed.room_to_close import first_met
from cramlite_plugins.locations.kinds import ground
from cramlite_plugins.locations.later import CLOSING, moves
from cramlite_plugins.locations.placing import floors, sideways
from cramlite_plugins.locations.placing.demands import TIGHT
from cramlite_plugins.objects.furniture import cabinet, door, drawer
from cramlite_plugins.objects.products_and_fixtures import block
from cramlite_plugins.robots.ur5e import UR5E

MOUNT = RobotMount("arm", "ur5e")
AT = Pose.from_rotvec((0.70, -0.1, 0.30), (0, 0, np.pi))  # its front looks to the robot
INSIDE = Location("on(cabinet)", "on", "cabinet", {"region": "inside"})


@pytest.fixture(autouse=True)
def _straight_in(monkeypatch: pytest.MonkeyPatch) -> None:
    """Positions straight in alone, 20 mm apart: the others meet the door alike."""
    monkeypatch.setattr(floors, "STEP", 0.02)
    monkeypatch.setattr(sideways, "ASIDE", (0.0,))
    monkeypatch.setattr(sideways, "TURNS", (0.0,))


def _about(task: str, name: str, **roles: str) -> Action:
    return Action(name, task, {role: Object(thing, entity=thing) for role, thing in roles.items()})


PLACING = _about("soma:Placing", "3.Placing", Locatum="it", Relatum="cabinet")
RELEASED = _about("soma:Releasing", "3.Placing/Releasing", Locatum="it", Relatum="cabinet")
RETRACTED = _about("soma:Retracting", "3.Placing/Retracting", Relatum="it")
CLOSED = _about("soma:Closing", "4.Closing", Patient="door")
OPENED = _about("soma:Opening", "4.Opening", Patient="door")


def _asked(long: float, *agenda: Action, opened: float = 1.9) -> tuple[Belief, Context]:
    """A block that lies in the hand, along where that points, before a cabinet 300 mm deep whose door is open."""
    hand = Pose.from_axes((0.4, 0.3, 0.4), (1.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    it = block("it", Pose((0.4 + long / 2 - 0.03, 0.3, 0.4)), (long, 0.05, 0.05))
    things = (cabinet("cabinet", AT), door("door", AT, "cabinet", swing=2.0, opened=opened), it)
    start = initial_belief(World(things, (MOUNT,)), "arm", UR5E.home, 0.05)
    belief = start.grasped(Held("it", hand.inverse() * it.pose, 0.05)).moved(inverse(UR5E, hand, seed=UR5E.home)[0])
    bindings = {"cabinet": "cabinet", "it": "it", "door": "door", "grasp(it)": Place(hand, hand, thing="it", grip=GripFacts(0.05))}
    return belief, Context(UR5E, MOUNT, bindings, Engine().knowledge.taxonomy, agenda)


AGENDAS = {"placed": (PLACING,), "closed": (PLACING, CLOSED), "let go, closed": (PLACING, RELEASED, RETRACTED, CLOSED)}


@cache
def _answers(long: float, agenda: str) -> tuple[list[Grounding], list[Refused]]:
    found = [a for a in ground(INSIDE, *_asked(long, *AGENDAS[agenda])) if "through its side" in str(a)]
    return [a for a in found if isinstance(a, Grounding)], [a for a in found if isinstance(a, Refused)]


def _sticks_out(place: Grounding, long: float) -> float:
    """How far a block reaches out of the front of the cabinet [m]."""
    hand = place.value.pose
    held = _asked(long)[0].held
    assert held is not None
    back = (hand * held.tcp_to_thing).apply((-long / 2, 0.0, 0.0))
    return float(AT.position[0] - back[0])


def test_what_a_door_would_meet_is_refused_where_it_is_closed_later_and_it_says_how_far_that_would_be_open() -> None:
    found, refused = _answers(0.2, "closed")
    anywhere, _ = _answers(0.2, "placed")
    assert found and max(_sticks_out(a, 0.2) for a in found) < LEFT < 0.02 < max(_sticks_out(a, 0.2) for a in anywhere)
    said = [r for r in refused if r.reason.startswith("not out of the way: with 'door', which a later task closes, open by ")]
    assert said and {r.blocking for r in said} == {("door",)}
    assert all(re.search(r"open by \d+ deg still, .*'(it|door)' is [\d.]+ mm inside '(it|door)'$", r.reason) for r in said)
    assert all(r.collision is not None and {"it", "door"} <= set(r.collision.moved) for r in said)


def test_places_with_little_room_come_last() -> None:
    found, _ = _answers(0.2, "closed")
    tight = [a.cost >= TIGHT for a in found]
    assert tight == sorted(tight) and not tight[0]
    assert all(_sticks_out(a, 0.2) < -0.001 for a in found if a.cost < TIGHT)  # the plate is 2 mm before the front


def test_what_the_hand_can_push_farther_in_may_stand_in_the_way_at_first() -> None:
    """As far as there is room: not what is longer than the cabinet is deep."""
    pushed, _ = _answers(0.2, "let go, closed")
    plain, _ = _answers(0.2, "closed")
    assert max(_sticks_out(a, 0.2) for a in pushed) > LEFT > max(_sticks_out(a, 0.2) for a in plain)
    assert all(a.cost >= TIGHT for a in pushed if _sticks_out(a, 0.2) > 0)
    with pytest.raises(Unresolvable, match="not out of the way"):
        list(ground(INSIDE, *_asked(0.31, *AGENDAS["let go, closed"])))


def test_what_is_longer_than_its_cabinet_leaves_no_room_anywhere() -> None:
    with pytest.raises(Unresolvable, match=r"not out of the way: with 'door', which a later task closes, open by [0-9]+ deg still"):
        list(ground(INSIDE, *_asked(0.31, PLACING, CLOSED)))
    assert _answers(0.31, "placed")[0]


def test_where_the_arm_stands_says_nothing_of_what_a_door_meets() -> None:
    """What stays is moved about the door: beside the door's way that may lead through the arm's base."""
    belief, context = _asked(0.1, PLACING, CLOSED)
    leaf, at = belief.thing("door"), belief.poses["door"].pose
    handle = next(f.pose for f in leaf.features if f.type == "cram:Handle")
    assert leaf.joint is not None
    moved = leaf.joint.moved(at, -0.5)
    for there, meets in ((moved * at.inverse() * Pose((0.0, 0.0, 0.1)), False), (moved * handle, True)):
        after = belief.released(Estimate(there, 0.0, "let go there"), 0.05)
        assert (first_met("it", after, context, None) is not None) == meets


def test_shapes_are_compared_exactly_only_with_what_a_later_task_moves(monkeypatch: pytest.MonkeyPatch) -> None:
    """A scene for that costs more than all boxes."""
    belief, context = _asked(0.1, PLACING)
    before = belief.poses["door"].pose * next(f.pose for f in belief.thing("door").features if f.type == "cram:Handle")
    monkeypatch.setattr(room_to_close, "make_scene", lambda *_, **__: pytest.fail("a scene is made"))
    assert first_met("it", belief.released(Estimate(before, 0.0, "let go there"), 0.05), context, None) is None
    aside = belief.released(Estimate(Pose((-0.5, 0.0, 0.1)), 0.0, "let go there"), 0.05)
    assert first_met("it", aside, _asked(0.1, PLACING, CLOSED)[1], None) is None


@pytest.mark.parametrize(("within", "opens"), [(True, True), (True, False), (False, True)])
def test_what_is_in_a_container_is_not_before_a_door_that_a_later_task_opens(within: bool, opens: bool) -> None:
    """Beside a container it may be pushed along."""
    belief, context = _asked(0.1, PLACING, *((OPENED,) if opens else ()), opened=0.0)
    leaf = belief.thing("door")
    assert leaf.joint is not None
    before = leaf.joint.moved(belief.poses["door"].pose, 1.0) * next(f.pose for f in leaf.features if f.type == "cram:Handle")
    after = belief.released(Estimate(before, 0.0, "let go there"), 0.05)
    met = first_met("it", after.related(("in", "it", "tray")) if within else after, context, None)
    assert (met is not None) == (within and opens)
    assert met is None or (met.reason.startswith("with 'door', which a later task opens, open by ") and met.blocking == ("door",))


def test_what_a_later_task_takes_away_again_stands_in_no_way() -> None:
    _, context = _asked(0.2)
    taken = _about("soma:Grasping", "4.Grasping", Patient="it")

    def closed(*agenda: Action) -> bool:
        return moves("door", CLOSING, "it", Context(UR5E, MOUNT, context.bindings, context.taxonomy, agenda))

    assert closed(PLACING, RELEASED, CLOSED) and not closed(PLACING, taken, CLOSED)
    assert closed(PLACING, _about("soma:Retracting", "4.Retracting", Relatum="it"), CLOSED)
    assert not closed(PLACING, OPENED) and not closed()
    assert not moves("other", CLOSING, "it", Context(UR5E, MOUNT, context.bindings, context.taxonomy, (PLACING, CLOSED)))


@pytest.mark.heavy
@pytest.mark.parametrize(("high", "fits"), [(0.05, True), (0.16, False)])
def test_what_sticks_out_of_a_drawer_meets_the_board_over_it(high: float, fits: bool) -> None:
    at = Pose.from_rotvec((0.62, 0.0, 0.15), (0, 0, np.pi))
    things: tuple[Thing, ...] = (cabinet("cabinet", at), drawer("drawer", at, parent="cabinet", opened=0.18))
    hand = Pose.from_axes((0.4, 0.3, 0.5), (0.0, 0.0, -1.0), (1.0, 0.0, 0.0))
    it = block("it", Pose((0.4, 0.3, 0.5 + 0.03 - high / 2)), (0.04, 0.04, high))
    start = initial_belief(World((*things, it), (MOUNT,)), "arm", UR5E.home, 0.04)
    belief = start.grasped(Held("it", hand.inverse() * it.pose, 0.04)).moved(inverse(UR5E, hand, seed=UR5E.home)[0])
    grasp = Place(hand, hand, thing="it", grip=GripFacts(0.04))
    agenda = (_about("soma:Placing", "3.Placing", Locatum="it", Relatum="drawer"), _about("soma:Closing", "4.Closing", Patient="drawer"))
    bindings = {"drawer": "drawer", "it": "it", "grasp(it)": grasp}
    context = Context(UR5E, MOUNT, bindings, Engine().knowledge.taxonomy, agenda)
    found, said = _some(Location("in(drawer)", "in", "drawer"), belief, context)
    assert found == fits
    said = [reason for reason in said if "with 'drawer', which a later task closes, open by" in reason]
    assert fits or (said and all(re.search(r"open by \d+ mm still, .*'cabinet'", reason) for reason in said))


def _some(location: Location, belief: Belief, context: Context) -> tuple[bool, list[str]]:
    """Whether there is an answer, and the reasons of what was refused before it."""
    said = list[str]()
    try:
        for answer in ground(location, belief, context):
            if isinstance(answer, Grounding):
                return True, said
            assert isinstance(answer, Refused)
            said.append(answer.reason)
    except Unresolvable as ended:
        said.append(str(ended))
    return False, said
