"""A plate that hangs from the fingers is let go of in an opening where it comes to rest in its region, as simulated."""

from __future__ import annotations

import math
from itertools import islice

from cramlite import Engine
from cramlite.model import Feature, Geom, Held, Location, Pose, RobotMount, Thing, World, initial_belief
from cramlite.plugin import Context, Grounding, Refused
from cramlite_plugins.locations.kinds import ground
from cramlite_plugins.locations.rim_pinches import rim_pinches
from cramlite_plugins.objects.products_and_fixtures import table
from cramlite_plugins.robots.fr3 import FR3

MOUNT, AT = RobotMount("arm", "fr3"), Pose((0.5, 0.0, 0.01))
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
    plate = _plate()
    pinch = rim_pinches(plate, plate.pose, FR3.gripper, 0.9)[0]
    held = Held("plate", pinch.swing.end, pinch.width, swing=pinch.swing)
    world = World((table("floor", Pose((0.2, 0.0, -0.01)), (1.6, 1.6, 0.02)), box, plate), (MOUNT,))
    belief = initial_belief(world, "arm", FR3.home, 0.08).grasped(held)
    context = Context(FR3, MOUNT, {"box": "box/inside"}, Engine().knowledge.taxonomy)
    found = ground(Location("in(box)", "in", "box", {"region": "inside"}), belief, context)
    assert found is not None
    return list(islice(found, count))


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
