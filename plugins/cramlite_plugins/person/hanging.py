"""A demonstrated hanging: a person takes an object that stands somewhere and threads its hole onto a peg.

The person looks before each part of the way and corrects; what the hole then meets, contacts and friction decide.
"""

from __future__ import annotations

import numpy as np

from cramlite.model import Floats, Pose
from cramlite.plugin import Performer

from ..simulation.model.hand_model import OPENING, TCP
from .hand_moves import close, extent, lead, reach, tip_points
from .sight_of_person import Scene

#: Where the hole is brought before it is threaded: this far past the end of the tip [m].
BEFORE, NEAR = (0.05, 0.09), 0.015
#: How far from the peg's root the object ends up, as a share of the peg's length: the middle, where nothing falls off.
DEPTH = (0.45, 0.65)
#: How much wider than the object the fingers open to let go [m]: it swings a little, and fingers are not opened for nothing.
FREE = (0.012, 0.018)


def hang_onto_hanger(person: Performer, scene: Scene, grasp: Pose) -> None:
    """Take the object, bring its hole in front of the peg, thread it, let it down, let go, withdraw."""
    reach(person, scene, grasp)
    close(person, extent(scene, grasp))
    lift(person)
    face(person, scene)
    thread(person, scene)
    leave(person, scene, grasp)


def lift(person: Performer) -> None:
    """Lift the payload."""
    up = np.add(person.aim.position, (0.0, 0.0, person.between(0.06, 0.12)))
    person.move([Pose(tuple(up), person.aim.quaternion)], person.between(0.12, 0.25))
    if person.rng.random() < 0.4:
        person.wait(person.between(0.1, 0.4))


def hole(person: Performer, scene: Scene) -> Floats:
    """Return the position (3,) in the world [m] of the hole of the object that the person hangs up."""
    return np.array((person.pose(scene.product.name) * scene.hole.pose).position)


def face(person: Performer, scene: Scene) -> None:
    """Turn the object upright, its front along the peg, and bring the hole in front of the peg's tip, by an arc."""
    end = tip_points(scene)[-1] + scene.along * person.between(*BEFORE)
    goal = _hand_for(person, scene, end)
    middle = (np.array(person.aim.position) + goal.position) / 2
    middle += scene.along * person.between(0.03, 0.08) + person.rng.normal(0, 0.02, 3)
    person.move([Pose(tuple(middle)), goal], person.between(0.2, 0.35), curved=True)
    person.wait(person.between(0.2, 0.5))
    person.move([_hand_for(person, scene, tip_points(scene)[-1] + scene.along * NEAR)], 0.05)


def _hand_for(person: Performer, scene: Scene, hole: Floats) -> Pose:
    """Target pose of the hand that brings the hole to a point, the object's front along the peg and its top
    upwards.

    What the hand lags behind its aim (a load pulls it down) is corrected.
    """
    front = scene.along
    side = np.cross((0.0, 0.0, 1.0), front)
    wanted = Pose.from_axes(tuple(hole), front, side) * scene.hole.pose.inverse()
    goal = wanted * person.pose(scene.product.name).inverse() * person.tool()
    lag = np.subtract(person.aim.position, person.tool().position)
    return Pose(tuple(np.add(goal.position, lag)), goal.quaternion)


def thread(person: Performer, scene: Scene) -> None:
    """Thread the payload's hole over the peg's tip and bend and along the peg, and lower the payload until the peg
    carries it."""
    peg = scene.hanger.pose * scene.peg.pose
    length = scene.peg.size["length"]
    lead(person, scene, [tip_points(scene)[-1]], 0.04)
    lead(person, scene, [peg.apply((0, 0, length))], 0.04)
    lead(person, scene, [peg.apply((0, 0, length * person.between(*DEPTH)))], person.between(0.06, 0.12))
    play = scene.hole.size["diameter"] / 2 - scene.peg.size["radius"]
    depth = float(peg.inverse().apply(hole(person, scene))[2])
    lead(person, scene, [peg.apply((0, 0, depth)) - (0, 0, play + 0.001)], 0.02)


def leave(person: Performer, scene: Scene, grasp: Pose) -> None:
    """Open the fingers as far as needed, withdraw the hand against its pointing direction, and wait until
    nothing moves."""
    person.wait(person.between(0.1, 0.3))
    person.grip(min(extent(scene, grasp) + person.between(*FREE), OPENING), person.between(0.3, 0.6))
    person.wait(0.2)
    back = person.aim.position + person.aim.rotate((0, 0, -(TCP + person.between(0.0, 0.08))))
    person.move([Pose(tuple(back), person.aim.quaternion)], person.between(0.15, 0.3))
    person.wait(1.5)
