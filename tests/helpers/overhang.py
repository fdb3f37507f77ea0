"""Shelf with room under a board, a thing in the hand before it, and what a query for a place there is asked with."""

from __future__ import annotations

from cramlite import Engine
from cramlite.model import Belief, Feature, Geom, GripFacts, Held, Place, Pose, RobotMount, Thing, World, initial_belief
from cramlite.plugin import Context
from cramlite_plugins.kinematics.inverse import inverse
from cramlite_plugins.objects.products_and_fixtures import table
from cramlite_plugins.robots.ur5e import UR5E

MOUNT = RobotMount("arm", "ur5e")
FRONT = 0.25  # of the room under the shelf, along y [m]


def overhang(room: float = 0.08, roof: float = 0.16, floor: float = 0.0) -> Thing:
    """Return a board on three sides so high over the table, so wide to each side [m].

    Below it there is room 0.3 m wide and 0.17 m deep, on a floor so high [m].
    """
    board = Geom("box", (roof, 0.09, 0.003), Pose((0.0, 0.0, room + 0.003)))
    sides = (Geom("box", (0.005, 0.09, room / 2), Pose((s * 0.155, 0.0, room / 2))) for s in (-1, 1))
    back = Geom("box", (0.16, 0.002, room / 2), Pose((0.0, 0.088, room / 2)))
    base = [Geom("box", (0.15, 0.09, floor / 2), Pose((0.0, 0.0, floor / 2)))] if floor else []
    below = Feature("below", "cram:Cavity", Pose((0.0, 0.0, 0.9 * room)), {"width": 0.3, "depth": 0.17, "height": 0.9 * room})
    return Thing("shelf", "cram:Shelf", Pose((0.5, FRONT + 0.085, 0.0)), (board, *sides, back, *base), (below,))


def holding(geom: Geom, at: Pose, height: float, top: float, *things: Thing) -> tuple[Belief, Context]:
    """Return the belief with a thing of one shape, ``at`` a pose, in a hand from above, among things on a table.

    Args:
        height: of the hand [m].
        top: of the table [m].
    """
    it = Thing("it", "cram:Product", at, (geom,), (), 0.05, 0.95)
    hand = Pose.from_axes((*at.position[:2], height), (0.0, 0.0, -1.0), (1.0, 0.0, 0.0))
    floor = table("table", Pose((0.3, 0.0, top)), (1.2, 1.2, 0.02))
    start = initial_belief(World((floor, *things, it), (MOUNT,)), "arm", UR5E.home, 0.04)
    belief = start.grasped(Held("it", hand.inverse() * it.pose, 0.024)).moved(inverse(UR5E, hand, seed=UR5E.home)[0])
    bindings = {"shelf": "shelf", "it": "it", "grasp(it)": Place(hand, hand, thing="it", grip=GripFacts(0.024))}
    return belief, Context(UR5E, MOUNT, bindings, Engine().knowledge.taxonomy)
