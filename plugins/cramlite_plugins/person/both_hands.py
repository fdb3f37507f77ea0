"""Two-handed demonstrations: one hand holds the thing that the other takes over, or is busy meanwhile.

Both are hands of the same strength, and meet each other and everything else. The other hand works from above, as over a
table; it waits beside the one that acts.
"""

from __future__ import annotations

import numpy as np

from cramlite.model import Pose, Thing
from cramlite.plugin import Performer

from ..simulation.model.hand_model import OPENING, PINCH
from .hand_moves import MARGIN, SQUEEZE, extent
from .sight_of_person import Scene, half_extents

#: From the top of a thing down to the middle of the pads that hold it from above [m].
DEEP = 0.012
#: The other hand takes things that are no wider than this, and whose place on the map is farther than this from what the
#: person is after [m].
WIDEST, CLEAR = 0.075, 0.25


def from_above(pose: Pose, thing: Thing) -> Pose:
    """Compute a grasp pose from above, across the thing's shorter side, in the world."""
    half = half_extents(thing)
    top = np.add(pose.position, pose.rotate((0.0, 0.0, half[2] - DEEP)))
    axis = pose.rotate((1.0, 0.0, 0.0) if half[0] <= half[1] else (0.0, 1.0, 0.0))
    return Pose.from_axes(tuple(top), (0.0, 0.0, -1.0), np.cross(axis, (0.0, 0.0, -1.0)))


def width_from_above(thing: Thing) -> float:
    """Compute the width between the fingers of a grasp from above [m]."""
    return float(2 * min(half_extents(thing)[:2]))


def waiting(scene: Scene, rng: np.random.Generator) -> Pose:
    """Choose the pose at which the person's other hand waits: in front of the product, pointing down, beside the things that this hand may
    take."""
    side = np.cross(scene.facing, (0.0, 0.0, 1.0)) * rng.choice([-1.0, 1.0]) * rng.uniform(0.28, 0.4)
    others = [np.subtract(t.pose.position, scene.product.pose.position) for t in _for_other_hand(scene)]
    if others and float(np.sum(others @ side)) < 0:
        side = -side
    up = np.array((0.0, 0.0, rng.uniform(0.05, 0.2)))
    place = np.array(scene.product.pose.position) + scene.facing * rng.uniform(0.2, 0.35) + side + up
    return Pose(tuple(place), from_above(scene.product.pose, scene.product).quaternion)


def be_busy(person: Performer, scene: Scene) -> None:
    """Make the other hand pick another thing up and put it back, while the acting hand goes on."""
    others = _for_other_hand(scene)
    if person.other is None or not others:
        return
    thing = others[int(person.rng.integers(len(others)))]
    hold, width, home, hand = from_above(thing.pose, thing), width_from_above(thing), person.other.aim, person.other
    above, up = _raised(hold, person.between(0.12, 0.16)), _raised(hold, person.between(0.03, 0.07))
    speed = person.pace * person.between(0.2, 0.3)
    hand.wait(person.between(0.3, 2.0))
    hand.move([_raised(home, 0.05), above], speed, curved=True)
    hand.grip(width + 2 * MARGIN, 0.3)
    hand.move([hold], speed / 2)
    hand.grip(max(width - 2 * person.between(0.4, 0.7) * PINCH / SQUEEZE, 0.0), person.between(0.4, 0.7))
    hand.wait(0.3)
    hand.move([up], speed / 2)
    hand.wait(person.between(0.2, 1.0))
    hand.move([hold], speed / 3)
    hand.grip(width + 2 * MARGIN, person.between(0.3, 0.5))
    hand.wait(0.2)
    hand.move([above], speed / 2)
    hand.move([home], speed)


def _for_other_hand(scene: Scene) -> list[Thing]:
    """Things for the other hand to take, far enough from the acting hand to keep clear of it."""
    own = scene.product
    far = [t for t in scene.world.things if np.hypot(*np.subtract(t.pose.position, own.pose.position)[:2]) > CLEAR]
    return [t for t in far if t.movable and t is not own and width_from_above(t) <= WIDEST]


def _raised(pose: Pose, height: float) -> Pose:
    return Pose(tuple(np.add(pose.position, (0.0, 0.0, height))), pose.quaternion)


def hand_over(person: Performer, scene: Scene, hold: Pose, take: Pose) -> None:
    """Hand the payload over: the other hand grasps it, the acting hand lets go and withdraws, and from then on the other hand acts.

    Args:
        hold: where this hand closed, in the world, when the thing was where it is in the scene.
        take: where the other one will, likewise.
    """
    assert person.other is not None
    hand, width = person.other, extent(scene, take)
    person.wait(person.between(0.1, 0.4))
    goal = person.pose(scene.product.name) * scene.product.pose.inverse() * take
    before = Pose(tuple(goal.position + goal.rotate((0, 0, -person.between(0.10, 0.14)))), goal.quaternion)
    hand.move([before], person.pace * person.between(0.2, 0.35))
    hand.grip(min(width + 2 * MARGIN, OPENING), 0.3)
    hand.move([goal], person.pace * person.between(0.06, 0.12))
    hand.grip(max(width - 2 * person.between(0.5, 0.9) * PINCH / SQUEEZE, 0.0), person.between(0.4, 0.8))
    hand.wait(person.between(0.2, 0.5))
    person.wait_for_other()
    person.grip(min(extent(scene, hold) + 2 * MARGIN, OPENING), person.between(0.3, 0.5))
    person.wait(person.between(0.1, 0.3))
    back = np.add(person.aim.position, person.aim.rotate((0, 0, -person.between(0.15, 0.2))))
    person.move([Pose(tuple(back), person.aim.quaternion)], person.between(0.15, 0.3))
    person.change_hands()
    _get_out_of_the_way(person, scene)


def _get_out_of_the_way(person: Performer, scene: Scene) -> None:
    """Move the hand that has handed the payload over away from the hanger or container to which the payload goes next."""
    assert person.other is not None
    here = np.array(person.other.aim.position)
    off = here - scene.hanger.pose.position if scene.stands else here - scene.container.pose.position
    aside = np.array([off[0], off[1], 0.0]) / max(float(np.hypot(off[0], off[1])), 1e-6)
    place = Pose(tuple(here + person.between(0.15, 0.25) * aside), person.other.aim.quaternion)
    person.other.move([place], person.between(0.2, 0.4))
