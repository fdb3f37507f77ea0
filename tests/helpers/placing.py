"""Queries for places: a small world with a shelf, a block in the hand, and what is answered to "on" and "in"."""

from __future__ import annotations

import itertools
from functools import cache
from typing import Any

import shapely
from msgspec.structs import replace

from cramlite import Engine
from cramlite.model import Belief, Held, Location, Place, Pose, RobotMount, Thing, World, initial_belief
from cramlite.ontology.taxonomy import Taxonomy
from cramlite.plugin import Context, Grounding, Refused, Unresolvable
from cramlite_plugins.locations.kinds import ground
from cramlite_plugins.locations.parameters import Where
from cramlite_plugins.locations.placing.query import Placement, Query, queries
from cramlite_plugins.locations.placing.ways_out import prepared
from cramlite_plugins.locations.reached import Arm
from cramlite_plugins.objects.products_and_fixtures import block, table
from cramlite_plugins.robots.ur5e import UR5E
from cramlite_plugins.shapes.surfaces import Surface, surfaces

MOUNT = RobotMount("arm", "ur5e")
HELD = Held("it", Pose((0.0, 0.0, 0.03)), 0.04)
Answer = Grounding | Refused
TIN = block("tin", Pose((0.45, -0.45, 0.19)), (0.05, 0.05, 0.08))


def believed(*things: Thing) -> Belief:
    """Return the belief with a block of 40 mm by 40 mm by 100 mm in the hand, a shelf, and the given things."""
    it = block("it", Pose((0.4, 0.3, 0.5)), (0.04, 0.04, 0.10))
    world = World((table("shelf", Pose((0.45, -0.35, 0.15)), (0.3, 0.3, 0.02)), *things, it), (MOUNT,))
    return initial_belief(world, "arm", UR5E.home, 0.085).grasped(HELD)


@cache
def taxonomy() -> Taxonomy:
    """The classes of the shipped ontologies, read once."""
    return Engine().knowledge.taxonomy


def context_of(belief: Belief) -> Context:
    """Return the context of a query, in which the roles "shelf" and "box" are filled by the things of these names."""
    return Context(UR5E, MOUNT, {"shelf": "shelf", "box": "box"}, taxonomy())


def query_on(belief: Belief, on: str = "shelf", where: dict[str, Any] | None = None) -> Query:
    """Return a query for places on the first surface of a thing or, if it has a cavity, in its opening."""
    cavity = belief.world.thing(on).feature("cram:Cavity")
    if cavity is None:
        target = surfaces(belief.world.thing(on), belief.pose(on))[0]
    else:
        half = cavity.size["width"] / 2, cavity.size["depth"] / 2
        target = Surface(belief.pose(on) * cavity.pose, shapely.box(-half[0], -half[1], *half))
    return Query(belief.world.thing("it"), on, target, Arm(belief, context_of(belief)), Where(**(where or {})))


def spot_at(at: tuple[float, float, float]) -> Placement:
    """Return a placement of the upright block at a position in the base frame, with the hand above it pointing down."""
    down = Pose.from_axes((0, 0, 0), (0, 0, -1), (0, 1, 0))
    tcp = Pose((at[0], at[1], at[2] + 0.03), down.quaternion)
    return Placement("here", Pose(at), tcp, Pose((at[0], at[1], at[2] + 0.09), down.quaternion), 0.02)


def on(thing: str, **where: Any) -> Location:
    return Location(f"on({thing})", "on", thing, where)


def into(thing: str, **where: Any) -> Location:
    return Location(f"in({thing})", "in", thing, where)


def answers(location: Location, belief: Belief, samples: int = 4000) -> tuple[list[Answer], Unresolvable | None]:
    """Return all answers to a location designator with a number of samples, and the error with which they end."""
    found = list[Answer]()
    try:
        for answer in ground(location, belief, replace(context_of(belief), samples=samples)):
            found.append(answer)
    except Unresolvable as ended:
        return found, ended
    return found, None


def first(count: int, location: Location, belief: Belief) -> list[Grounding]:
    """Return the first groundings of a location designator."""
    found = ground(location, belief, context_of(belief))
    return list(itertools.islice((a for a in found if isinstance(a, Grounding)), count))


def placed(answer: Grounding) -> Pose:
    """Return the pose of the block at a grounded place, in the base frame."""
    assert isinstance(answer.value, Place)
    return answer.value.pose * HELD.tcp_to_thing


def turns(found: list[Grounding]) -> list[tuple[str, int]]:
    """Return position and turn [deg] of placements, read from their keys."""
    names = [("middle, " if not g.key.startswith("(") else "") + g.key for g in found]
    return [(n.split(", turned ")[0].split(" mm")[0], int(n.split("turned ")[1].split(" deg")[0])) for n in names]


def targets(location: Location, belief: Belief) -> list[Query]:
    """Return the prepared queries of a location designator."""
    return prepared(queries(location, belief, context_of(belief)))


def depth_of(box: Thing) -> float:
    """Return the depth of a basket's cavity [m]."""
    cavity = box.feature("cram:Cavity")
    assert cavity is not None
    return cavity.size["height"]
