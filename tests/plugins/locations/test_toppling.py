"""What is too high for the room under a roof: with its foot in there it is let go of leaning out, tips over, and is pushed in."""

from __future__ import annotations

import math

import numpy as np
import pytest
from helpers.overhang import FRONT, holding, overhang
from msgspec.structs import replace

from cramlite.model import (
    Action,
    Belief,
    Estimate,
    Geom,
    Location,
    Motion,
    Object,
    Place,
    Pose,
    Thing,
)
from cramlite.plugin import Context, Grounding, Unresolvable
from cramlite_plugins.kinematics.inverse import inverse
from cramlite_plugins.locations.kinds import ground
from cramlite_plugins.locations.placing.query import queries
from cramlite_plugins.locations.placing.tilting import BACK, LEANS
from cramlite_plugins.locations.placing.ways_out import WAYS
from cramlite_plugins.locations.pushing.back_in import CAME_OUT, FURTHER
from cramlite_plugins.objects.products_and_fixtures import block
from cramlite_plugins.robots.ur5e import UR5E
from cramlite_plugins.shapes.bounds import corners, support
from cramlite_plugins.shapes.roofs import has_own_roof
from cramlite_plugins.shapes.tipping_over import tipped_over
from cramlite_plugins.tasks.ungrasping import Ungrasping

TIPPED = Location("toppled(shelf)", "toppled", "shelf", {"region": "below"})
PUSHED = Location("pushed_in(it)", "pushed_in", "it", {"begin": "toppled(shelf)"})


def _asked(shelf: Thing, *things: Thing) -> tuple[Belief, Context]:
    """A book of 120 mm in the hand, by its upper end."""
    upright = Geom("box", (0.048, 0.012, 0.06), Pose((0.0, 0.0, 0.06)))  # its origin is at its foot
    return holding(upright, Pose((0.45, 0.0, 0.24)), 0.345, -0.01, shelf, *things)


def _first(shelf: Thing) -> tuple[Belief, Context, Place]:
    belief, context = _asked(shelf)
    found = next(a for a in ground(TIPPED, belief, context) if isinstance(a, Grounding))
    return belief, context, found.value


def _refused(location: Location, belief: Belief, context: Context) -> Unresolvable:
    with pytest.raises(Unresolvable) as no:
        list(ground(location, belief, context))
    return no.value


def test_its_foot_is_under_the_roof_and_it_leans_out_and_lies_in_the_region_when_it_has_tipped_over() -> None:
    belief, _, place = _first(overhang())
    assert belief.held is not None
    thing = belief.world.thing("it")
    before, there, back = (p * belief.held.tcp_to_thing for p in (place.before, place.pose, place.path[-1]))
    assert round(math.degrees(math.acos(float(there.rotate((0.0, 0.0, 1.0))[2])))) in LEANS
    assert there.rotate((0.0, 0.0, 1.0))[1] < -0.4  # out, towards the robot
    assert before.position[2] == pytest.approx(there.position[2])  # level
    assert support(thing, before, (0.0, 1.0, 0.0)) < FRONT  # all of it is before the roof
    over = tipped_over(thing, there)
    assert over is not None and support(thing, over[0], (0.0, 1.0, 0.0)) > FRONT + 0.01
    assert np.ptp(corners(thing, over[0]), axis=0)[2] == pytest.approx(0.024)  # on its broad side
    assert np.subtract(back.position, there.position) == pytest.approx(
        -BACK * place.pose.rotate((0.0, 0.0, 1.0)), abs=1e-6
    )


def test_fingers_bring_it_back_to_where_it_should_lie_from_behind() -> None:
    belief, context, place = _first(overhang())
    assert belief.held is not None
    over = tipped_over(belief.world.thing("it"), place.pose * belief.held.tcp_to_thing)
    assert over is not None
    x, y, _ = over[0].position
    lies = Pose((x, y, 0.012), over[0].quaternion)
    there = belief.released(Estimate(lies, 0.0, "tipped over"), 0.08).moved(
        inverse(UR5E, place.path[-1], seed=belief.joints)[0]
    )
    context = replace(context, bindings={**context.bindings, "toppled(shelf)": place})
    found = next(a for a in ground(PUSHED, there, context) if isinstance(a, Grounding)).value
    way = np.subtract(found.path[-1].position, found.pose.position)
    assert way[1] > CAME_OUT and abs(way[0]) < 1e-6 and abs(way[2]) < 1e-6
    end = found.path[-1].position[1] + UR5E.gripper.pad[0] / 2  # of the fingers' front
    assert end == pytest.approx(-support(belief.world.thing("it"), lies, (0.0, -1.0, 0.0)) + FURTHER, abs=1e-6)


def test_where_it_lies_there_is_no_room_for_it_and_no_grasp_is_to_blame() -> None:
    no = _refused(TIPPED, *_asked(overhang(room=0.022)))
    assert no.reason.startswith("toppling: not lying there: 'it' is") and no.because == ("shelf",)


def test_what_stands_before_it_is_in_the_way() -> None:
    no = _refused(TIPPED, *_asked(overhang(), block("wall", Pose((0.5, 0.18, 0.1)), (0.4, 0.05, 0.2), 1.0)))
    assert no.reason == "toppling: not lying there: 'it' is 22.0 mm inside 'wall'" and no.blocking == (("wall",),)


def test_without_a_roof_things_go_in_from_above() -> None:
    shelf = overhang()
    asked = queries(TIPPED, *_asked(replace(shelf, geoms=shelf.geoms[1:])))
    assert [way.name for way in WAYS["in"] if way.rank(asked) is not None] == ["from above"]


@pytest.mark.parametrize(("roof", "covered"), [(0.16, True), (0.02, False)])
def test_a_handle_over_the_middle_is_no_roof(roof: float, covered: bool) -> None:
    shelf = overhang(roof=roof)
    assert has_own_roof(shelf, shelf.pose, "below") == covered
    assert not has_own_roof(shelf, shelf.pose, "above")


@pytest.mark.parametrize(("roof", "topples"), [(0.16, True), (0.02, False)])
def test_the_task_tips_it_over_under_a_roof_alone(roof: float, topples: bool) -> None:
    belief, _ = _asked(overhang(roof=roof))
    roles = {"Locatum": Object("it", entity="it"), "Relatum": Object("shelf", entity="shelf")}
    drop = Action("1", "artm:Ungrasping", roles, parameters={"where": {"region": "below"}})
    steps = [d.steps for d in Ungrasping().decompose(drop, belief)]
    assert [s[0].relation for s in steps if isinstance(s[0], Location)] == ["in", "toppled", "before"][
        : 1 + 2 * topples
    ]
    assert any(isinstance(s, Motion) and s.name.endswith("push") for s in steps[-1]) == topples
