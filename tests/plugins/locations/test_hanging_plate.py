"""A plate that hangs from the fingers is let go of where it comes to rest as simulated: in an opening, under a roof, on another plate."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import islice

import pytest
from msgspec.structs import replace

from cramlite import Engine
from cramlite.model import (
    Belief,
    Feature,
    Geom,
    GripFacts,
    Held,
    Location,
    Place,
    Pose,
    RobotMount,
    Thing,
    World,
    initial_belief,
    thing_of,
)
from cramlite.plugin import Context, Grounding, Refused, Unresolvable
from cramlite_plugins.locations.kinds import ground
from cramlite_plugins.locations.pinching.rim_pinches import rim_pinches
from cramlite_plugins.locations.placing.edge_first import edge_first
from cramlite_plugins.locations.placing.query import queries
from cramlite_plugins.objects.furniture import cabinet
from cramlite_plugins.objects.products_and_fixtures import block, table
from cramlite_plugins.robots.fr3 import FR3

MOUNT, AT = RobotMount("arm", "fr3"), Pose((0.5, 0.0, 0.01))
GRASP = "grasp(plate)"
DEEP = 0.06  # of the box; its region reaches a little below its floor, as the origin of the plate does that lies there [m]


def _plate() -> Thing:
    """A plate of 150 mm with a rim that rises outwards."""
    slope = Pose.from_rotvec((0.0, 0.0, 0.0), (0.0, -math.radians(20.0), 0.0))
    around = (Pose.from_rotvec((0.0, 0.0, 0.0), (0.0, 0.0, k * math.tau / 8)) for k in range(8))
    rim = tuple(Geom("box", (0.02, 0.027, 0.0025), turn * Pose((0.0535, 0.0, 0.0092)) * slope, friction=0.9) for turn in around)
    middle = Geom("cylinder", (0.036, 0.0025), Pose((0.0, 0.0, 0.0055)))
    return Thing("plate", "soma:Plate", Pose((0.4, 0.3, 0.0)), (middle, *rim), mass=0.02)


def _box(wide: float, long: float) -> Thing:
    """An open box, so wide and long inside [m]."""
    floor = Geom("box", (wide / 2 + 0.005, long / 2 + 0.005, 0.005), Pose((0.0, 0.0, -0.005)), friction=0.9)
    ends = (Geom("box", (0.0025, long / 2 + 0.005, DEEP / 2), Pose((x, 0.0, DEEP / 2))) for x in (-wide / 2 - 0.0025, wide / 2 + 0.0025))
    sides = (Geom("box", (wide / 2, 0.0025, DEEP / 2), Pose((0.0, y, DEEP / 2))) for y in (-long / 2 - 0.0025, long / 2 + 0.0025))
    cavity = Feature("inside", "cram:Cavity", Pose((0.0, 0.0, DEEP)), {"width": wide, "depth": long, "height": DEEP + 0.006})
    return Thing("box", "soma:DesignedContainer", AT, (floor, *ends, *sides), features=(cavity,))


def _answers(box: Thing, count: int) -> list[Grounding | Refused]:
    """The first answers for a plate that hangs from its rim."""
    return list(islice(_asked(Location("in(box)", "in", "box", {"region": "inside"}), "box/inside", box), count))


def _asked(location: Location, entity: str, *things: Thing) -> Iterator[Grounding | Refused]:
    found = ground(location, *_hanging(entity, *things))
    assert found is not None
    return iter(found)


def _hanging(entity: str, *things: Thing) -> tuple[Belief, Context]:
    """A plate that hangs from its rim, and what is known when a place for it is asked for."""
    plate = _plate()
    pinch = rim_pinches(plate, plate.pose, FR3.gripper, 0.9)[0]
    held = Held("plate", pinch.swing.end, pinch.width, swing=pinch.swing)
    world = World((table("floor", Pose((0.2, 0.0, -0.01)), (1.6, 1.6, 0.02)), *things, plate), (MOUNT,))
    belief = initial_belief(world, "arm", FR3.home, 0.08).grasped(held)
    bindings = {thing_of(entity): entity, GRASP: Place(Pose(), Pose(), thing="plate", grip=GripFacts(pinch.width))}
    return belief, Context(FR3, MOUNT, bindings, Engine().knowledge.taxonomy)


def _put(location: Location, entity: str, *things: Thing) -> tuple[Place, Pose, Pose]:
    """The first place found, with the plate's pose where it is released and where it comes to rest."""
    place = next(a.value for a in _asked(location, entity, *things) if isinstance(a, Grounding))
    plate = _plate()
    released = place.pose * rim_pinches(plate, plate.pose, FR3.gripper, 0.9)[0].swing.end
    return place, released, released * place.release.settles


def _cabinet(height: float) -> Thing:
    """A cabinet 0.3 m deep and wide inside, 0.2 m high, whose open front looks to the robot."""
    return cabinet("cabinet", Pose.from_rotvec((0.6, 0.0, height), (0.0, 0.0, math.pi)))


def test_it_is_let_go_of_where_it_comes_to_lie_in_its_region() -> None:
    found = next(a for a in _answers(_box(0.24, 0.19), 40) if isinstance(a, Grounding))
    place = found.value
    plate = _plate()
    hangs = rim_pinches(plate, plate.pose, FR3.gripper, 0.9)[0].swing.end
    released = place.pose * hangs
    lies = AT.inverse() * released * place.release.settles
    assert -0.006 <= lies.position[2] <= DEEP and abs(lies.position[0]) < 0.12 and abs(lies.position[1]) < 0.095
    assert released.distance(released * place.release.settles)[1] > math.radians(20.0)  # it falls over


def test_in_a_narrow_box_it_would_stay_above_its_region() -> None:
    found = [a for a in _answers(_box(0.06, 0.145), 40) if isinstance(a, Refused)]
    assert any("its origin comes to rest above or below its region" in a.reason for a in found), [a.reason for a in found]


def _lean(pose: Pose) -> float:
    """Angle of a plate from lying level [deg]."""
    return math.degrees(math.acos(min(1.0, float(pose.rotate((0.0, 0.0, 1.0))[2]))))


INSIDE = Location("on(cabinet)", "on", "cabinet", {"region": "inside"})


def test_high_above_a_table_it_goes_in_level_between_fingers_that_are_one_above_the_other() -> None:
    place, released, rests = _put(INSIDE, "cabinet", _cabinet(0.15))
    assert _lean(released) == pytest.approx(0.0, abs=1.0) and _lean(rests) == pytest.approx(0.0, abs=1.0)
    assert place.pose.rotate((0.0, 1.0, 0.0))[2] ** 2 > 0.8  # the closing direction is nearly upright
    assert place.before.position[2] == pytest.approx(place.via[0].position[2])  # level
    assert place.before.position[0] < 0.45 and rests.position[0] > 0.61
    assert place.path == () and place.swing is not None and place.swing.start == place.swing.end  # it does not turn in the hand


def test_over_a_table_the_hand_points_farther_down_and_the_far_edge_goes_in_first() -> None:
    place, released, rests = _put(INSIDE, "cabinet", _cabinet(0.1))
    assert 10.0 < _lean(released) < 32.0 and _lean(rests) == pytest.approx(0.0, abs=1.0)
    assert released.rotate((0.0, 0.0, 1.0))[0] > 0.1  # its far edge is the lower one
    assert place.pose.rotate((0.0, 0.0, 1.0))[2] < -0.4 and rests.position[0] > 0.61


def test_in_a_room_that_is_too_low_for_the_hand_it_has_no_place() -> None:
    low = cabinet("cabinet", Pose.from_rotvec((0.6, 0.0, 0.035), (0.0, 0.0, math.pi)), (0.3, 0.3, 0.07))
    with pytest.raises(Unresolvable, match="through its sides: "):
        list(_asked(INSIDE, "cabinet", low))


def test_onto_another_plate_its_far_edge_comes_first_and_it_falls_flat_into_that() -> None:
    other = replace(_plate(), name="other", pose=Pose((0.5, 0.0, 0.0)))
    place, released, rests = _put(Location("on(other)", "on", "other"), "other", other)
    assert 5.0 < _lean(released) < 32.0 and _lean(rests) < 3.0
    assert math.dist(rests.position[:2], other.pose.position[:2]) < 0.015
    assert len(place.via) == 1 and place.via[0].position[2] - place.pose.position[2] == pytest.approx(0.013)  # straight down


def test_a_post_on_which_it_would_not_come_to_rest_is_refused_edge_first() -> None:
    post = block("other", Pose((0.5, 0.0, 0.02)), (0.02, 0.02, 0.04))
    found = list(islice(_asked(Location("on(other)", "on", "other"), "other", post), 12))
    first = [a for a in found if isinstance(a, Refused) and str(a.value).startswith("far edge first")]
    assert len(first) == 12 and any("rest beside 'other'" in a.reason or "rest nowhere near" in a.reason for a in first)


def test_where_something_stands_in_its_place_no_other_grasp_is_asked_for() -> None:
    board, bowl = block("board", AT, (0.2, 0.2, 0.02)), block("bowl", Pose((0.5, 0.0, 0.045)), (0.1, 0.1, 0.05))
    with pytest.raises(Unresolvable, match="edge first: no room to lie") as no:
        list(_asked(Location("on(board)", "on", "board"), "board", board, bowl))
    assert no.value.blocking and set(no.value.blocking) >= {"bowl"} and GRASP not in no.value.because
    with pytest.raises(Unresolvable) as alone:
        list(edge_first(queries(Location("on(board)", "on", "board"), *_hanging("board", board, bowl))))
    assert alone.value.blocking == ("bowl",)
