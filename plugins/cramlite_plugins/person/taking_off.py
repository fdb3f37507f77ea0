"""A demonstrated taking-off: a person takes an object off a peg and puts it into a container."""

from __future__ import annotations

import numpy as np

from cramlite.model import Pose
from cramlite.plugin import Performer

from ..simulation.model.hand_model import OPENING, TCP
from .hand_moves import close, extent, lead, reach, tip_points
from .sight_of_person import Scene, half_extents

#: The palm and wrist stay this far below the peg, and above a container's rim, measured from the tool's axis [m].
PALM = 0.05


def take_off_hanger(person: Performer, scene: Scene, grasp: Pose) -> None:
    """Take the object off the peg and put it into the container."""
    reach(person, scene, grasp)
    close(person, extent(scene, grasp))
    pull_off(person, scene)
    carry(person, scene)
    let_go(person, scene)


def pull_off(person: Performer, scene: Scene) -> None:
    """Lift the object until the peg is centred in its hole, then move the hole along the peg and over the peg's tip."""
    peg = scene.hanger.pose * scene.peg.pose
    hole = person.pose(scene.product.name) * scene.hole.pose
    x, y, depth = peg.inverse().apply(hole.position)
    centred = np.array(hole.position) - peg.rotate((x, y, 0))
    end = peg.apply((0, 0, max(scene.peg.size["length"], depth)))
    route = [centred, end, *tip_points(scene), tip_points(scene)[-1] + scene.along * person.between(0.05, 0.09)]
    lead(person, scene, route[:1], 0.03)
    lead(person, scene, route[1:], person.between(0.07, 0.16))


def carry(person: Performer, scene: Scene) -> None:
    """Carry the object in an arc to a spot above the container, and tilt the hand on the way."""
    opening = scene.container.pose * scene.cavity.pose
    inner = np.array([scene.cavity.size[k] for k in ("width", "depth")])
    spot = opening.apply((*(person.rng.uniform(-0.12, 0.12, 2) * inner), 0.0))
    held = np.array(person.tool().position)
    body = np.array(person.pose(scene.product.name).position)
    low = body[2] - half_extents(scene.product)[2]
    above = np.array(
        [*(spot[:2] + held[:2] - body[:2]), max(opening.position[2] + held[2] - low, opening.position[2] + PALM)]
    )
    above[2] += person.between(0.03, 0.08)
    middle = (held + above) / 2 + np.array([*person.rng.normal(0, 0.03, 2), abs(person.rng.normal(0.05, 0.03))])
    turned = Pose((0, 0, 0), person.aim.quaternion) * Pose.from_rotvec(
        (0, 0, 0), person.rng.normal(0, 0.12, 3).tolist()
    )
    person.move([Pose(tuple(middle)), Pose(tuple(above), turned.quaternion)], person.between(0.2, 0.4), curved=True)
    if person.rng.random() < 0.4:
        person.wait(person.between(0.1, 0.5))


def _below(tool: Pose) -> float:
    """Return how far the palm and wrist of the tilted hand reach below the tool's origin [m]."""
    return PALM + max(0.0, -float(tool.rotate((0, 0, -(TCP + 0.08)))[2]))


def let_go(person: Performer, scene: Scene) -> None:
    """Lower the payload to a random height up to 40 mm above the lowest at which the palm clears the rim;
    open, withdraw, wait."""
    rim = (scene.container.pose * scene.cavity.pose).position[2]
    x, y, z = person.aim.position
    lowest = rim + _below(person.aim) + person.between(0.0, 0.04)
    if z > lowest:
        person.move([Pose((x, y, lowest), person.aim.quaternion)], person.between(0.08, 0.2))
    person.wait(person.between(0.05, 0.3))
    person.grip(OPENING, person.between(0.25, 0.5))
    back = person.aim.position + person.aim.rotate((0, 0, -(TCP - 0.02)))
    person.move([Pose((*back[:2], z + person.between(0.05, 0.1)), person.aim.quaternion)], person.between(0.15, 0.3))
    person.wait(1.0)
