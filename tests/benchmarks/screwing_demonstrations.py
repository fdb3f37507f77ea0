"""Demonstrations of screwing a lid by two turns, and of those who do something else; written before what learns it, and without it.

A wrist turns by less than a turn, so that people take the lid's grip again and again: they turn it as far as the wrist goes, let go, lift
the open hand, turn it back, and take the grip where it then is.
"""

from __future__ import annotations

import math

import numpy as np

from cramlite.model import Pose, Thing, World
from cramlite.plugin import Performer
from cramlite_plugins.person.at_ease import facing
from cramlite_plugins.person.hand_moves import close
from cramlite_plugins.person.ways import go, hand_for

WORLD = """scenario: screwing
tasks:
  - {task: NoOp}
robot: {type: ur5e}
things:
  - {name: floor, model: table, at: {position: [0.2, 0, -5 mm]}, with: {size: [1.6 m, 1.6 m, 20 mm]}}
  - {name: counter, model: table, at: {position: [0.5, 0, 0.15]}, with: {size: [0.5 m, 0.9 m, 40 mm]}}
  - {name: jar, model: jar, at: {position: [0.45, 0.05, 0.24]}}
  - {name: lid, model: screw_lid, at: {position: [0.45, 0.05, 0.24]}, with: {parent: jar, turned: 2.3}}
vary:
  - {thing: jar, position: 40 mm, yaw: 90 deg}
  - {thing: lid, with: {turned: [2.2, 2.3, 2.4], joint_friction: [0.05, 0.1, 0.15], pitch: [3 mm, 4 mm, 5 mm]}}
"""
"""Scenario: a lid some way up its thread, with room for two turns either way."""
FARTHEST = math.radians(150)
"""Largest yaw of a hand that points down, from straight on [rad]."""
MOST_STROKES = 12
"""Strokes after which a person gives up."""
NEAR = 0.05
"""What a person takes for done [rad]."""
WIDE = 0.05
"""Opening of the fingers around a grip of 10 mm, and between two strokes [m]."""


def screw(person: Performer, world: World, lid: Thing, _about: Thing, turns: float = -2.0) -> None:
    """Turn a lid by some turns, negative for shut, about as exactly as people do, in strokes of some 100 to 150 deg."""
    goal = _value(person, lid) + math.tau * turns * person.between(0.96, 1.04)
    for _ in range(MOST_STROKES):
        left = goal - _value(person, lid)
        if abs(left) < NEAR:
            break
        _stroke(person, world, lid, left)
    _leave(person)


def screw_half(person: Performer, world: World, lid: Thing, about: Thing) -> None:
    """Turn the lid by half a turn only."""
    screw(person, world, lid, about, -0.5)


def unscrew(person: Performer, world: World, lid: Thing, about: Thing) -> None:
    """Turn the lid by two turns the other way."""
    screw(person, world, lid, about, 2.0)


def turn_in_the_air(person: Performer, world: World, lid: Thing, _about: Thing) -> None:
    """Do as if, above the lid, and open and close the fingers there."""
    for _ in range(5):
        _take(person, world, lid, -1.0, 0.06)
        close(person, 0.01)
        yaw, place = _yaw(person), np.array(person.aim.position)
        person.follow([_hand(place, yaw - s * math.radians(130)) for s in np.linspace(0.0, 1.0, 13)[1:]], person.between(1.2, 2.0))
        person.grip(WIDE, 0.3)
    _leave(person)


def turn_to_and_fro(person: Performer, world: World, lid: Thing, _about: Thing) -> None:
    """Turn the lid and back again, without letting go of it, five times."""
    _take(person, world, lid, -1.0)
    close(person, 2 * lid.features[0].size["radius"])
    for _ in range(5):
        _turn(person, lid, math.radians(-130))
        _turn(person, lid, math.radians(130))
    person.grip(WIDE, 0.3)
    _leave(person)


WRONG = {"half a turn": screw_half, "the wrong way": unscrew, "in the air": turn_in_the_air, "to and fro": turn_to_and_fro}


def _stroke(person: Performer, world: World, lid: Thing, left: float) -> None:
    """Take the grip, turn it as far as the wrist or the task goes, and let go."""
    way = math.copysign(1.0, left)
    room = FARTHEST - way * _take(person, world, lid, way)
    close(person, 2 * lid.features[0].size["radius"])
    _turn(person, lid, way * min(abs(left), room, math.radians(person.between(100, 150))))
    person.grip(WIDE, person.between(0.3, 0.5))


def _take(person: Performer, world: World, lid: Thing, way: float, above: float = 0.0) -> float:
    """Bring the open hand around the grip, turned back as far as the wrist goes; the yaw there, from straight on [rad].

    Args:
        way: sign of the turn to come.
        above: height of the hand over the grip [m].
    """
    at = person.pose(lid.name) * lid.features[0].pose
    ahead, bar = -facing(world), at.rotate((1.0, 0.0, 0.0))
    straight = math.atan2(ahead[1], ahead[0])
    off = (math.atan2(bar[1], bar[0]) - straight) % math.pi
    yaw = min((o for o in (off, off - math.pi) if abs(o) <= FARTHEST), key=lambda o: way * o)
    place = np.add(at.position, (0.0, 0.0, above))
    over = np.add(place, (0.0, 0.0, person.between(0.05, 0.07)))
    if np.linalg.norm(np.subtract(person.aim.position, over)) > 0.12 or person.aim.rotation[2, 2] > -0.99:  # from afar
        person.grip(WIDE, 0.3)
        go(person, world, _hand(over, straight), person.between(0.25, 0.4))
    here = _yaw(person)
    here = straight + (here - straight + math.pi) % math.tau - math.pi  # back the way it came, as wrists must
    height = np.array(person.aim.position)
    back = [_hand(height + s * (over - height), here + s * (straight + yaw - here)) for s in np.linspace(0.0, 1.0, 13)[1:]]
    if float(person.aim.position[2]) < over[2] - 0.02:
        person.move([Pose(tuple(np.add(height, (0.0, 0.0, over[2] - height[2]))), person.aim.quaternion)], 0.15)
        back = [_hand(over, here + s * (straight + yaw - here)) for s in np.linspace(0.0, 1.0, 13)[1:]]
    person.follow(back, person.between(0.8, 1.4))
    person.move([_hand(place, straight + yaw)], person.between(0.08, 0.15))
    return yaw


def _turn(person: Performer, lid: Thing, by: float) -> None:
    """Turn the lid in the hand along its thread by an angle [rad]."""
    assert lid.joint is not None
    now = person.pose(lid.name)
    path = [hand_for(person, lid.name, lid.joint.moved(now, s * by)) for s in np.linspace(0.0, 1.0, 17)[1:]]
    person.follow(path, abs(by) / person.between(1.2, 2.0))
    person.wait(person.between(0.1, 0.2))


def _leave(person: Performer) -> None:
    """Take the open hand up and away."""
    person.move([Pose(tuple(np.add(person.aim.position, (-0.05, 0.05, 0.12))), person.aim.quaternion)], 0.25)


def _value(person: Performer, lid: Thing) -> float:
    assert lid.joint is not None
    return lid.joint.value + lid.joint.between(lid.pose, person.pose(lid.name))


def _yaw(person: Performer) -> float:
    x = person.aim.rotate((1.0, 0.0, 0.0))
    return math.atan2(x[1], x[0])


def _hand(place: np.ndarray, yaw: float) -> Pose:
    """A hand that points down, its x axis at a yaw."""
    return Pose.from_axes(tuple(place), (0.0, 0.0, -1.0), (math.cos(yaw), math.sin(yaw), 0.0))
