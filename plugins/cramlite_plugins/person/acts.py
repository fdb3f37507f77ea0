"""Actions of a person with one hand: each looks where the things are, and first grasps the things that it
moves."""

from __future__ import annotations

import numpy as np

from cramlite.model import Floats, Pose, Thing, World
from cramlite.plugin import Performer, UserError

from ..shapes.bounds import lowest, support
from ..simulation.model.hand_model import OPENING
from .at_ease import facing
from .grips import choose_grip
from .hand_moves import close
from .hanging import face, thread
from .sight_of_person import Scene
from .taking_off import pull_off
from .ways import free_spot, go, hand_for, narrow, top_of, upright

UP = np.array([0.0, 0.0, 1.0])
#: How far a vessel tilts to be empty [rad], and how far its lip is above the other one's opening meanwhile [m].
TILT, LIP = (2.0, 2.3), (0.03, 0.06)
#: A thing that is put down is pressed onto what it is put on by so much [m]; a hand's servo gives 6 N for one millimetre.
PRESS = 0.002
#: From the tool frame's origin to the fingertips' end [m]: the fingers' capsules (hand_model.py).
FINGER = 0.015
#: From the tool frame's origin to the back of a closed finger [m], and the room beside a thing that is about to be pushed [m].
KNUCKLE, BESIDE = 0.03, 0.03
#: How far drawers and doors are opened, as a share of their range.
OPEN = 0.8
#: Fingers open by so much to let go [m].
FREE = (0.02, 0.035)


def grasp(person: Performer, world: World, thing: Thing) -> None:
    """Reach for a thing and close the fingers around it."""
    grip = choose_grip(person, thing, facing(world))
    if grip is None:
        raise UserError(
            f"the simulated hand finds no grasp of '{thing.name}': it is wider than {1000 * OPENING:.0f} mm wherever the hand has room, or "
            "something stands in the way; give it a narrower part, or move what is beside it"
        )
    if person.holds(thing.name):
        return
    person.grip(grip.opening, 0.3)
    before = grip.tool * Pose((0, 0, -person.between(0.07, 0.1)))
    go(person, world, before, person.between(0.25, 0.4))
    if person.rng.random() < 0.5:
        person.wait(person.between(0.15, 0.5))
    person.move([grip.tool], person.between(0.08, 0.18))
    close(person, grip.width)


def pick_up(person: Performer, world: World, thing: Thing) -> None:
    """Lift a thing."""
    grasp(person, world, thing)
    _by(person, (0.0, 0.0, person.between(0.08, 0.14)), person.between(0.12, 0.25))
    if person.rng.random() < 0.4:
        person.wait(person.between(0.1, 0.4))


def _lifted(person: Performer, world: World, thing: Thing) -> None:
    """Lift a thing, unless it is in the hand and nothing is right below it."""
    free = person.holds(thing.name) and not any(
        t.name != thing.name and stands_on(person, thing, t) for t in world.things
    )
    if not free:
        pick_up(person, world, thing)


def stands_on(person: Performer, thing: Thing, other: Thing) -> bool:
    """Check whether the underside of a thing is at the surface of another one, within 20 mm."""
    pose = person.pose(thing.name)
    frame, half = top_of(other, person.pose(other.name), narrow(thing))
    x, y, z = frame.inverse().apply((*pose.position[:2], pose.position[2] + lowest(thing, pose)))
    return bool(abs(x) < half[0] + 0.02 and abs(y) < half[1] + 0.02 and abs(z) < 0.02)


def _by(person: Performer, way: Floats | tuple[float, float, float], speed: float) -> None:
    """Move the hand by a vector (3,) in the world [m]."""
    person.move([Pose(tuple(np.add(person.aim.position, way)), person.aim.quaternion)], speed)


def carry(person: Performer, world: World, thing: Thing, to: Thing | None) -> None:
    """Carry a thing upright over another thing, or a random distance aside if no other thing is named."""
    _lifted(person, world, thing)
    now = upright(person.pose(thing.name))
    if to is None:
        off = (*person.rng.uniform(-0.15, 0.15, 2), person.between(0.0, 0.1))
        goal = Pose(tuple(np.add(now.position, off)), now.quaternion)
    else:
        spot = free_spot(person, world, thing, to)
        rim = support(to, person.pose(to.name), UP)
        height = max(rim, spot[2]) + person.between(0.04, 0.09) - lowest(thing, now)
        goal = Pose((spot[0], spot[1], height), now.quaternion)
    go(person, world, hand_for(person, thing.name, goal), person.between(0.2, 0.35), held=thing.name)


def put_down(person: Performer, world: World, thing: Thing, onto: Thing) -> None:
    """Lower a held thing onto another thing, and press down a little."""
    _lifted(person, world, thing)
    pose = upright(person.pose(thing.name))
    spot = free_spot(person, world, thing, onto)
    above = Pose((spot[0], spot[1], spot[2] - lowest(thing, pose) + person.between(0.03, 0.06)), pose.quaternion)
    go(person, world, hand_for(person, thing.name, above), person.between(0.2, 0.35), held=thing.name)
    pose = person.pose(thing.name)
    gap = pose.position[2] + lowest(thing, pose) - spot[2]
    _by(person, (0.0, 0.0, -gap - PRESS), person.between(0.05, 0.1))
    person.wait(person.between(0.1, 0.3))


def release(person: Performer, world: World, thing: Thing) -> None:
    """Open the fingers around the payload."""
    grasp(person, world, thing)
    person.wait(person.between(0.1, 0.3))
    person.grip(min(person.opening + person.between(*FREE) + 0.01, OPENING), person.between(0.3, 0.5))
    person.wait(0.2)


def withdraw(person: Performer, world: World) -> None:
    """Withdraw the hand straight back, against its pointing direction."""
    back = person.aim * Pose((0, 0, -person.between(0.12, 0.18)))
    person.move([back], person.between(0.15, 0.3))
    person.wait(person.between(0.2, 0.5))


def place(person: Performer, world: World, thing: Thing, onto: Thing) -> None:
    """Put a thing down, let go, withdraw."""
    put_down(person, world, thing, onto)
    release(person, world, thing)
    withdraw(person, world)


def drop_into(person: Performer, world: World, thing: Thing, into: Thing) -> None:
    """Hold a thing over the opening of a container, let go, withdraw."""
    opening = person.pose(into.name) * _cavity(into)
    _lifted(person, world, thing)
    now = person.pose(thing.name)
    x, y = opening.position[:2] + person.rng.uniform(-0.02, 0.02, 2)
    goal = Pose((x, y, opening.position[2] - lowest(thing, now) + person.between(0.0, 0.03)), now.quaternion)
    go(person, world, hand_for(person, thing.name, goal), person.between(0.2, 0.35), held=thing.name)
    person.wait(person.between(0.05, 0.3))
    person.grip(OPENING, person.between(0.25, 0.5))
    withdraw(person, world)
    person.wait(0.5)


def _cavity(thing: Thing) -> Pose:
    cavity = thing.feature("cram:Cavity")
    if cavity is None:
        raise UserError(f"'{thing.name}' ({thing.type}) has no opening (cram:Cavity), so nothing goes into it or out of it")
    return cavity.pose


def pour(person: Performer, world: World, vessel: Thing, into: Thing) -> None:
    """Hold the lip of a vessel over the opening of another one, tilt it about the lip until it is empty, and turn it back."""
    _lifted(person, world, vessel)
    now = upright(person.pose(vessel.name))
    axis, out = _tilting(person)
    opening = vessel.feature("cram:Cavity")
    radius = opening.size.get("width", 0.0) / 2 if opening is not None else 0.0
    lip = np.add(_cavity(vessel).position, now.inverse().rotate(radius * out))
    target = np.add((person.pose(into.name) * _cavity(into)).position, (0, 0, person.between(*LIP)))
    angle = person.between(*TILT)
    turned = [_clear(vessel, _about(now, lip, target, axis, share * angle), target[2]) for share in np.linspace(0.0, 1.0, 9)]
    go(person, world, hand_for(person, vessel.name, turned[0]), person.between(0.2, 0.35), held=vessel.name)
    person.wait(person.between(0.1, 0.4))
    path = [hand_for(person, vessel.name, pose) for pose in turned]
    person.follow(path, person.between(1.5, 2.5))
    person.wait(person.between(0.8, 1.4))
    person.follow(path[::-1], person.between(1.2, 2.0))
    _by(person, (0, 0, person.between(0.04, 0.08)), 0.2)


def _tilting(person: Performer) -> tuple[Floats, Floats]:
    """Axis to tilt a vessel about, and direction from its middle to the lip: both level (3,), chosen so
    that the hand is beside the stream."""
    level = np.array(person.tool().rotate((0, 0, 1))) * (1, 1, 0)
    if np.linalg.norm(level) < 0.5:  # a hand from above turns with the vessel, to the side of a finger
        level = np.array(person.tool().rotate((1, 0, 0))) * (1, 1, 0)
    axis = level / np.linalg.norm(level)
    axes = [axis, -axis]
    far = [Pose((0, 0, 5.0)) * Pose.from_rotvec((0, 0, 0), tuple(TILT[1] * a)) * Pose((0, 0, 0), person.aim.quaternion) for a in axes]
    chosen = next((a for a, f in zip(axes, far, strict=True) if person.fits(f, person.opening)), axis)
    return chosen, np.cross(chosen, UP)


def _clear(vessel: Thing, pose: Pose, height: float) -> Pose:
    """A pose of a vessel, raised as far as needed so that no part of the vessel is below a height [m]."""
    low = pose.position[2] + lowest(vessel, pose)
    return Pose((*pose.position[:2], pose.position[2] + max(height - low, 0.0)), pose.quaternion)


def _about(pose: Pose, point: Floats, target: Floats, axis: Floats, angle: float) -> Pose:
    """Pose that is turned about an axis by an angle, and moved so that a point in its frame comes to a target."""
    turned = Pose.from_rotvec((0, 0, 0), tuple(angle * axis)) * Pose((0, 0, 0), pose.quaternion)
    return Pose(tuple(np.subtract(target, turned.rotate(point))), turned.quaternion)


def shake(person: Performer, world: World, thing: Thing, swings: float = 8) -> None:
    """Swing a held thing up and down."""
    _lifted(person, world, thing)
    height, speed = person.between(0.03, 0.045), person.between(0.25, 0.35)
    for k in range(round(swings)):
        _by(person, (0, 0, height if k % 2 == 0 else -height), speed)


def hold(person: Performer, world: World, thing: Thing, duration_s: float = 1.0) -> None:
    """Hold a thing still."""
    grasp(person, world, thing)
    person.wait(duration_s)


def push(person: Performer, world: World, thing: Thing, distance_m: float = 0.06) -> None:
    """Push a thing along its support, with closed fingers that point down."""
    ahead = facing(world)
    aside = np.cross(ahead, UP)
    ways = [ahead, aside, -aside, -ahead]
    way, start = next(
        ((w, s) for w in ways for s in _pushing_poses(person, thing, w) if person.fits(s, 0.0)),
        (ahead, _pushing_poses(person, thing, ahead)[0]),
    )
    person.grip(0.0, 0.3)
    go(person, world, start, person.between(0.25, 0.4))
    _by(person, BESIDE * way, 0.08)
    speed, before = person.between(0.06, 0.1), np.array(person.pose(thing.name).position)
    _by(person, 0.5 * distance_m * way, speed)
    done = float(np.subtract(person.pose(thing.name).position, before) @ way)  # the hand began a little before the thing
    _by(person, max(distance_m - done, 0.0) * way, speed)
    _by(person, -(BESIDE + 0.02) * way, 0.15)


def _pushing_poses(person: Performer, thing: Thing, way: Floats) -> list[Pose]:
    """Two poses, half a turn apart, of a hand that points down and is about to push a thing in a direction
    with closed fingers."""
    pose = person.pose(thing.name)
    bottom, top = pose.position[2] + lowest(thing, pose), support(thing, pose, UP)
    back = support(thing, Pose((0, 0, 0), pose.quaternion), -way) + BESIDE + KNUCKLE
    place = (*np.subtract(pose.position, back * way)[:2], max(bottom + 0.3 * (top - bottom), bottom + 0.025))
    return [Pose.from_axes(place, -UP, s * np.cross(way, -UP)) for s in (1, -1)]


def slide(person: Performer, world: World, thing: Thing, distance_m: float = 0.08) -> None:
    """Slide a payload along its support, pressing lightly."""
    grasp(person, world, thing)
    way = facing(world) * person.rng.choice([-1.0, 1.0]) * distance_m
    _by(person, (0, 0, -PRESS), 0.02)
    _by(person, way, person.between(0.06, 0.1))


def touch(person: Performer, world: World, surface: Thing) -> None:
    """Bring the closed fingers onto a surface."""
    frame, half = top_of(surface, person.pose(surface.name))
    spot = frame.apply((*(person.rng.uniform(-0.3, 0.3, 2) * half), 0.0))
    down = Pose.from_axes(tuple(np.add(spot, (0, 0, 0.08))), -UP, -facing(world))
    person.grip(0.0, 0.3)
    go(person, world, down, person.between(0.25, 0.4))
    _by(person, (0, 0, -0.08 + FINGER - PRESS), 0.06)
    person.wait(person.between(0.2, 0.4))


def stroke(person: Performer, world: World, surface: Thing, distance_m: float = 0.08) -> None:
    """Slide the closed fingers along a surface."""
    if not person.touches(surface.name):
        touch(person, world, surface)
    _by(person, facing(world) * distance_m, person.between(0.05, 0.1))


def move_joint(person: Performer, world: World, thing: Thing, share: float) -> None:
    """Take a drawer or a door by its handle, move it to a share of its range, let go, withdraw."""
    joint = thing.joint
    if joint is None:
        raise UserError(f"'{thing.name}' ({thing.type}) is neither a drawer nor a door: it has no joint to open or close")
    grasp(person, world, thing)
    now = person.pose(thing.name)
    by = joint.value_at(share) - joint.value - joint.between(thing.pose, now)
    path = [hand_for(person, thing.name, joint.moved(now, s * by)) for s in np.linspace(0.0, 1.0, 17)[1:]]
    person.follow(path, person.between(1.5, 2.5))
    person.wait(person.between(0.1, 0.3))
    person.grip(min(person.opening + 0.04, OPENING), person.between(0.3, 0.5))
    withdraw(person, world)


def reach_for(person: Performer, world: World, thing: Thing) -> None:
    """Bring the open hand in front of a thing."""
    grip = choose_grip(person, thing, facing(world))
    if grip is None:
        raise UserError(f"the simulated hand has no room in front of '{thing.name}'; move the obstacle beside it")
    person.grip(grip.opening, 0.3)
    go(person, world, grip.tool * Pose((0, 0, -0.06)), person.between(0.25, 0.4))


def roam(person: Performer, world: World) -> None:
    """Move the hand up and aside."""
    _by(person, (*person.rng.uniform(-0.15, 0.15, 2), person.between(0.05, 0.15)), person.between(0.2, 0.3))


def _threading(person: Performer, world: World, thing: Thing, hanger: Thing) -> Scene:
    """Scene for threading a hole on or off a peg: an object with a hole, and a hanger with a peg."""
    hole, peg = thing.feature("vrps:Hole"), hanger.feature("vrps:Peg")
    if hole is None or peg is None:
        lacks = f"'{thing.name}' has no hole (vrps:Hole)" if hole is None else f"'{hanger.name}' has no peg (vrps:Peg)"
        raise UserError(f"the simulated hand cannot thread a hole on or off a peg: {lacks}")
    return Scene(world, thing, hole, hanger, peg, hanger, peg)


def extract(person: Performer, world: World, thing: Thing, hanger: Thing) -> None:
    """Pull a hanging thing off its peg."""
    scene = _threading(person, world, thing, hanger)
    grasp(person, world, thing)
    pull_off(person, scene)


def insert(person: Performer, world: World, thing: Thing, hanger: Thing) -> None:
    """Thread the hole of a thing onto a peg, with the thing lifted first."""
    scene = _threading(person, world, thing, hanger)
    _lifted(person, world, thing)
    face(person, scene)
    thread(person, scene)
    person.wait(person.between(0.3, 0.5))


def stay(person: Performer, _world: World) -> None:
    """Keep the hand still for about a second."""
    person.wait(person.between(0.8, 1.5))


def open_fingers(person: Performer, _world: World) -> None:
    """Open the empty hand."""
    person.grip(OPENING, person.between(0.3, 0.5))


def close_fingers(person: Performer, _world: World) -> None:
    """Close the empty hand."""
    person.grip(0.0, person.between(0.3, 0.5))


def is_inside(person: Performer, thing: Thing, into: Thing) -> bool:
    """Check whether the middle of a thing is below the opening of a container, and between its walls."""
    frame, half = top_of(into, person.pose(into.name))
    x, y, _ = frame.inverse().apply(person.pose(thing.name).position)
    opening = (person.pose(into.name) * _cavity(into)).position[2]
    return bool(abs(x) < half[0] and abs(y) < half[1] and person.pose(thing.name).position[2] < opening + 0.05)


def opened(person: Performer, thing: Thing) -> float:
    """Return the opening of a drawer or a door, as a share of its range."""
    joint = thing.joint
    return 0.0 if joint is None else joint.share(joint.value + joint.between(thing.pose, person.pose(thing.name)))
