"""Hand movements that all demonstrations share: reach for the object, grasp it, move its hole along
points."""

from __future__ import annotations

import numpy as np

from cramlite.model import Floats, Pose
from cramlite.plugin import Performer

from ..simulation.model.hand_model import OPENING, PINCH
from .sight_of_person import Scene, half_extents

#: Room between the fingers beside the object before they close [m].
MARGIN = 0.012
#: Pad force for one metre of closing beyond contact [N/m]: half the finger actuator's gain (hand.py).
SQUEEZE = 10000.0


def reach(person: Performer, scene: Scene, grasp: Pose) -> None:
    """Reach from the hand's pose, by a detour, to in front of the object; hesitate; approach."""
    person.grip(max(extent(scene, grasp) + 2 * MARGIN, person.between(0.08, OPENING)), 0.2)
    away = grasp.position + grasp.rotate((0, 0, -person.between(0.07, 0.12)))
    before = Pose(tuple(away), grasp.quaternion)
    middle = np.add(person.aim.position, away) / 2 + person.rng.normal(0, 0.03, 3)
    person.move([Pose(tuple(middle)), before], person.between(0.2, 0.4), curved=True)
    if person.rng.random() < 0.5:
        person.wait(person.between(0.15, 0.6))
    person.move([grasp], person.between(0.08, 0.18))


def extent(scene: Scene, grasp: Pose) -> float:
    """Compute the object's extent along the closing axis of a grasp [m]."""
    axis = np.abs(scene.product.pose.inverse().rotate(grasp.rotate((0, 1, 0))))
    half = half_extents(scene.product)
    return float(min(2 * half[int(np.argmax(axis))], OPENING))


def close(person: Performer, width: float) -> None:
    """Close the fingers with a force between half and nearly all of their strength."""
    force = person.between(0.5, 0.9) * PINCH
    person.grip(max(width - 2 * force / SQUEEZE, 0.0), person.between(0.4, 0.8))
    person.wait(person.between(0.15, 0.4))


def lead(person: Performer, scene: Scene, route: list[Floats], speed: float) -> None:
    """Move the hand without turning it, so that the hole in the payload goes along points (3,) of the world [m]."""
    hole = np.array((person.pose(scene.product.name) * scene.hole.pose).position)
    offset = np.array(person.tool().position) - hole
    person.move([Pose(tuple(p + offset), person.aim.quaternion) for p in route], speed)


def tip_points(scene: Scene) -> list[Floats]:
    """Return the end of a peg's bent tip, or of a peg without one, as a list of one point in the world [m]."""
    tip = scene.hanger.feature("vrps:Tip")
    if tip is not None:
        return [scene.hanger.pose.apply(tip.pose.position)]
    return [scene.hanger.pose.apply(scene.peg.pose.apply((0, 0, scene.peg.size["length"])))]
