"""The way of a drawer: what it meets there is said before any hand is tried."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from msgspec.structs import replace

from cramlite import Engine
from cramlite.model import (
    Action,
    Belief,
    CarriedAlong,
    GripFacts,
    Held,
    JudgingLimits,
    Location,
    Motion,
    Object,
    Place,
    Pose,
    Release,
    RobotMount,
    Thing,
    World,
    initial_belief,
)
from cramlite.plugin import Context, Grounding, Refused, Unresolvable
from cramlite_plugins.locations.jointed.joint_obstacles import driven_along
from cramlite_plugins.locations.kinds import ground
from cramlite_plugins.motion_planning import reach
from cramlite_plugins.objects.furniture import cabinet, door, drawer
from cramlite_plugins.objects.products_and_fixtures import block, table
from cramlite_plugins.robots.ur5e import UR5E
from cramlite_plugins.shapes.carried_along import driven, driven_before
from cramlite_plugins.tasks.closing import Closing
from cramlite_plugins.tasks.opening import Opening

MOUNT, AT = RobotMount("arm", "ur5e"), Pose((0.75, 0.1, 0.1), (0.0, 0.0, 0.0, 1.0))


def asked(*things: Thing) -> tuple[Belief, Context]:
    """A drawer of 200 mm whose front is at 0.73 m when it is closed and opens towards the robot."""
    kitchen = (table("floor", Pose((0.2, 0.0, -0.015)), (1.6, 1.6, 0.02)), cabinet("cabinet", AT), drawer("drawer", AT, parent="cabinet"))
    belief = initial_belief(World((*kitchen, *things), (MOUNT,)), "arm", UR5E.home, 0.085)
    return belief, Context(UR5E, MOUNT, {"drawer": "drawer"}, Engine().knowledge.taxonomy)


def place(relation: str, least: float | None) -> Location:
    return Location("it", relation, "drawer", {} if least is None else {"least": least})


def standing(metres: float) -> Thing:
    """A block that the front of the drawer meets when it is open so far, aside of the handle."""
    return block("it", Pose((0.73 - 0.02 - metres, 0.2, 0.03)), (0.04, 0.04, 0.06))


@pytest.mark.parametrize("relation", ["handle", "atop"])
def test_what_stands_in_the_way_of_a_drawer_is_named_before_any_hand_is_tried(relation: str) -> None:
    with pytest.raises(Unresolvable, match=r"after 1[0-9][0-9] mm of its own motion 'drawer' is .* mm inside 'it'") as ended:
        list(ground(place(relation, 0.8), *asked(standing(0.13))))
    assert ended.value.blocking == (("it",),) and ended.value.because == ("drawer",)


@pytest.mark.heavy
@pytest.mark.parametrize(("metres", "least"), [(0.19, 0.8), (0.13, None), (0.13, 0.5)])
def test_what_it_does_not_come_to_is_not_in_its_way(metres: float, least: float | None) -> None:
    """The hand comes to the handle as it does where nothing stands there."""
    free = [g.value for g in ground(place("handle", least), *asked())]
    beside = [g.value for g in ground(place("handle", least), *asked(standing(metres)))]
    assert beside[:10] == free[:10]  # fingers that come from its side may meet it: these follow later


@pytest.mark.parametrize("parameters", [{}, {"share": 0.8}])
def test_opening_says_how_far_it_must_get(parameters: dict[str, float]) -> None:
    """However it is opened: held by its handle, or pressed on from above."""
    belief, context = asked(standing(0.13))
    action = Action("1.Opening", "soma:Opening", {"Patient": Object("drawer", entity="drawer")}, parameters=parameters)
    steps = [s for way in Opening().decompose(action, belief) for s in way.steps]
    begun = [s for s in steps if isinstance(s, Location) and s.relation in ("handle", "atop")]
    assert {b.relation for b in begun} == {"handle", "atop"}
    for location in begun:
        with pytest.raises(Unresolvable, match=r"of its own motion 'drawer' is .* inside 'it'"):
            list(ground(location, belief, context))


def test_what_stands_in_the_way_of_a_door_that_is_closed_is_named_before_any_hand_is_tried() -> None:
    """However it is closed; what stands behind it is none of that."""
    belief, context = asked()
    wide = door("drawer", AT, "cabinet", swing=2.0, opened=1.3)
    assert wide.joint is not None
    for turn, stands in ((-0.4, True), (0.4, False)):
        x, y, _ = (wide.joint.moved(wide.pose, turn) * wide.features[0].pose).position
        it = block("it", Pose((x, y, 0.06)), (0.04, 0.04, 0.12))
        things = tuple(wide if t.name == "drawer" else t for t in (*belief.world.things, it))
        there = initial_belief(replace(belief.world, things=things), "arm", UR5E.home, 0.085)
        action = Action("1.Closing", "soma:Closing", {"Patient": Object("drawer", entity="drawer")})
        begun = [w.steps[0] for w in Closing().decompose(action, there) if isinstance(w.steps[0], Location)]
        assert {b.relation for b in begun} == {"front", "handle"}
        for location in begun:
            if not stands:
                assert next(iter(ground(location, there, context)), None) is not None
                continue
            with pytest.raises(Unresolvable, match=r"deg of its own motion 'drawer' is .* inside 'it'") as ended:
                list(ground(location, there, context))
            assert ended.value.blocking == (("it",),)


def test_what_it_is_asked_for_need_not_be_more() -> None:
    belief, context = asked(standing(0.13))
    action = Action("1.Opening", "soma:Opening", {"Patient": Object("drawer", entity="drawer")}, parameters={"share": 0.5})
    assert list(ground(Opening().begins_at(action), belief, context))


def test_what_touches_it_where_it_is_is_left_to_planned_paths() -> None:
    """They know what it may touch: a block that leans on the front is no reason to try no hand."""
    belief, context = asked(standing(-0.005))
    assert list(ground(place("handle", 0.8), belief, context))


@pytest.mark.parametrize("task", [Opening(), Closing()])
def test_what_is_held_by_its_handle_is_led_at_the_robots_pace(task: Opening | Closing) -> None:
    belief, _ = asked()
    action = Action("1", task.task, {"Patient": Object("drawer", entity="drawer")})
    held = [w for w in task.decompose(action, belief) if isinstance(w.steps[0], Location) and w.steps[0].relation == "handle"]
    led = [s for way in held for s in way.steps if isinstance(s, Motion) and s.kind == "force_path"]
    assert led and all(s.parameters["paced"] == 1.0 for s in led)


def test_the_hand_that_presses_comes_down_fast_and_touches_slowly() -> None:
    belief, _ = asked()
    action = Action("1.Opening", "soma:Opening", {"Patient": Object("drawer", entity="drawer")})
    *_, pressing = Opening().decompose(action, belief)
    (down,) = (s for s in pressing.steps if isinstance(s, Motion) and s.kind == "until_contact")
    assert down.parameters["free_m_s"] >= 0.1 and down.parameters["speed_m_s"] <= 0.01


def test_all_that_stands_in_its_way_is_named_at_once() -> None:
    """To put aside what it comes to first would be no help."""
    behind = block("behind", Pose((0.73 - 0.02 - 0.15, 0.0, 0.03)), (0.04, 0.04, 0.06))
    with pytest.raises(Unresolvable, match=r"after 1[0-9][0-9] mm .* inside 'it'") as ended:
        list(ground(place("handle", 0.9), *asked(standing(0.13), behind)))
    assert ended.value.blocking == (("behind", "it"),)
    screwed = table("screwed", behind.pose, (0.04, 0.04, 0.06))
    with pytest.raises(Unresolvable) as ended:
        list(ground(place("handle", 0.9), *asked(standing(0.13), screwed)))
    assert ended.value.blocking == ()


def test_another_place_of_what_was_put_in_its_way_may_do() -> None:
    belief, context = asked(standing(0.13))
    put, held = (Place(Pose(), Pose(), thing="it", **facts) for facts in ({"release": Release(0.01)}, {"grip": GripFacts(0.04)}))
    context = replace(context, bindings={**context.bindings, "spot": put, "grasp": held})
    with pytest.raises(Unresolvable) as ended:
        list(ground(place("handle", 0.8), belief, context))
    assert ended.value.because == ("drawer", "spot")


def test_what_lies_in_it_comes_along() -> None:
    """Its back would else run against it."""
    inside = block("it", Pose((0.88, 0.1, 0.1 - 0.082 + 0.016 + 0.03)), (0.04, 0.04, 0.06))
    assert list(ground(place("handle", 0.8), *asked(inside)))


def unminded(*things: Thing) -> tuple[Belief, Context]:
    """The same where nobody minds what becomes of other things."""
    belief, context = asked(*things)
    return belief, replace(context, limits=JudgingLimits(may_push=True))


def only_advised(*things: Thing) -> tuple[Belief, Context]:
    """The same where a validator of them only advises, and nobody permits to push them."""
    belief, context = asked(*things)
    return belief, replace(context, limits=JudgingLimits(advisory=("bystanders",)))


DRIVING = Location("it", "handle", "drawer", {"least": 0.8, "drives": True})


def test_it_drives_along_what_it_meets_where_nobody_minds() -> None:
    assert list(ground(DRIVING, *unminded(standing(0.13))))
    for things, location in ((asked, DRIVING), (only_advised, DRIVING), (unminded, place("handle", 0.8))):
        with pytest.raises(Unresolvable, match="of its own motion 'drawer' is"):
            list(ground(location, *things(standing(0.13))))


def test_that_another_way_of_opening_may_drive_it_is_said_where_nobody_minds() -> None:
    """The task is to blame then, and not the drawer alone, so that its other ways are tried."""
    led = (Motion("1.Opening/transfer", "transfer", place("handle", 0.8)),)
    for things, because in ((unminded, ("drawer", "1.Opening")), (asked, ("drawer",))):
        belief, context = things(standing(0.13))
        with pytest.raises(Unresolvable) as ended:
            list(ground(place("handle", 0.8), belief, replace(context, agenda=led)))
        assert ended.value.because == because


def test_what_is_driven_goes_the_rest_of_the_way() -> None:
    belief, context = asked(standing(0.13), block("aside", Pose((0.4, -0.5, 0.03)), (0.04, 0.04, 0.06)))
    found = driven_along(belief.thing("drawer"), 0.0, 0.19, belief, context)
    assert not isinstance(found, Refused) and found == {"it": pytest.approx(0.06, abs=0.011)}
    assert driven_along(belief.thing("drawer"), 0.0, 0.1, belief, context) == {}


@pytest.mark.parametrize("make", [block, table], ids=["loose", "fixed"])
def test_nothing_is_driven_into_something_else(make: Callable[[str, Pose, tuple[float, float, float]], Thing]) -> None:
    """Behind a block that goes 60 mm along there is another, or a wall, after 30."""
    behind = make("behind", Pose((0.73 - 0.06 - 0.13 - 0.03, 0.2, 0.03)), (0.04, 0.04, 0.06))
    belief, context = unminded(standing(0.13), behind)
    found = driven_along(belief.thing("drawer"), 0.0, 0.19, belief, context)
    assert isinstance(found, Refused) and found.reason.startswith("'it', pushed along, would be") and "'behind'" in found.reason
    assert found.blocking == ((("behind",),) if make is block else ())


def test_what_is_in_a_container_is_not_driven_out_of_it() -> None:
    belief, context = unminded(standing(0.13))
    found = driven_along(belief.thing("drawer"), 0.0, 0.19, belief.related(("in", "it", "box")), context)
    assert isinstance(found, Refused) and found.blocking == (("it",),)
    assert found.reason.endswith("'it' is in 'box', and not pushed out of it")
    assert not isinstance(driven_along(belief.thing("drawer"), 0.0, 0.19, belief, context), Refused)


def test_what_would_tip_over_is_not_driven_and_no_other_way_of_opening_is_asked_for() -> None:
    """The drawer's lowest point is 8 mm over the floor: at a friction of 0.6 a foot of 4 mm ahead is too little, one of 20 mm is not."""
    thin = block("it", Pose((0.73 - 0.004 - 0.13, 0.2, 0.05)), (0.008, 0.04, 0.1))
    belief, context = unminded(thin)
    found = driven_along(belief.thing("drawer"), 0.0, 0.19, belief, context)
    assert isinstance(found, Refused) and found.reason.endswith("pushed along, 'it' would tip over") and found.blocking == (("it",),)
    led = (Motion("1.Opening/transfer", "transfer", place("handle", 0.8)),)
    with pytest.raises(Unresolvable) as ended:
        list(ground(place("handle", 0.8), belief, replace(context, agenda=led)))
    assert ended.value.because == ("drawer",) and ended.value.blocking == (("it",),)


@pytest.mark.parametrize("gripped", [True, False], ids=["gripped", "pressed on"])
def test_the_way_says_what_is_driven_and_that_is_believed_there(gripped: bool) -> None:
    belief, context = unminded(standing(0.13))
    if gripped:
        hand = reach.tcp(belief, context).inverse() * belief.pose("drawer")
        belief = belief.grasped(Held("drawer", hand, 0.02))
    way = Location("way", "opened", "drawer", {"share": 0.95, "drives": True})
    (answer,) = ground(way, belief, context)
    assert isinstance(answer, Grounding) and driven(answer.value) == {"it": pytest.approx(0.06, abs=0.011)}
    after = driven_before(belief, answer.value, np.array([-1.0, 0.0, 0.0]))
    moved = np.subtract(after.poses["it"].pose.position, belief.poses["it"].pose.position)
    assert moved == pytest.approx((-driven(answer.value)["it"], 0.0, 0.0)) and after.poses["it"].sigma > 0.05
    (plain,) = ground(replace(way, parameters={"share": 0.95}), belief, context)
    assert isinstance(plain, Grounding) and not driven(plain.value)
    screwed = unminded(table("it", standing(0.13).pose, (0.04, 0.04, 0.06)))
    (no,) = ground(way, *screwed)
    assert isinstance(no, Refused)


def test_the_drawer_may_touch_what_it_drives_and_no_door_drives_anything() -> None:
    belief, _ = asked(standing(0.13))
    action = Action("1.Opening", "soma:Opening", {"Patient": Object("drawer", entity="drawer")})
    carried = CarriedAlong(joint=0.19, driven_m={"it": 0.06})
    bindings = {"opened(drawer)": Place(Pose(), Pose(), thing="drawer", carried=carried)}
    assert frozenset({"drawer", "it"}) in Opening().allowance(action, bindings).touches
    assert frozenset({"drawer", "it"}) not in Opening().allowance(action, {}).touches
    assert [w.reason for w in Opening().decompose(action, belief) if "pushed along" in w.reason]
    world = replace(belief.world, things=(*belief.world.things, door("door", AT, parent="cabinet")))
    of_door = replace(action, roles={"Patient": Object("door", entity="door")})
    assert not [w for w in Opening().decompose(of_door, replace(belief, world=world)) if "pushed along" in w.reason]
