"""Variations of demonstrations: habits of people, such as pauses and detours, that are no part of the task.

A person of these scripts has a pace, a tremor and habits, all from the seed: they come from anywhere in front, look twice,
take hold again, pause, take detours, put the thing down in between, let it drop the last bit, and now and then the
tracker loses sight of it.

No frequencies are published; these give about one habit of each kind in three demonstrations, and every demonstration
some (measured over the development seeds).
"""

from __future__ import annotations

import numpy as np
from msgspec.structs import replace

from cramlite.model import Feature, Floats, Pose, Rollout, Thing, Touch, Value, thing_of
from cramlite.plugin import Performer

from ..simulation.model.hand_model import OPENING
from .hand_moves import close, extent
from .sight_of_person import Scene, featured, half_extents

#: How often [share of demonstrations], and how much.
SECOND_LOOK, REGRASP, PUT_DOWN, GLITCH, PAUSE = 0.25, 0.25, 0.25, 0.2, 0.35
PACE, SHAKE = (0.7, 1.5), (0.5, 2.0)
#: The same for what only the distracted do.
DISTRACTED = 0.6
#: What their other hand does, each as often.
OTHER_HAND = ("", "busy", "hand_over")
#: A thing is let go this far above what it is put on [m]: from touching it to a small drop.
DROP = (0.0, 0.006)
#: The tracker loses sight for this long [s]; 0.02 to 0.9 s were seen in recordings (docs/figures/episodes.yaml).
BLIND = (0.04, 0.5)


class Habits(Value):
    """Variations of one demonstration; the other hand is idle, "busy", or takes over ("hand_over")."""

    second_look: bool
    regrasp: bool
    put_down: bool
    pause: float
    wrong_way: bool = False
    interrupted: bool = False
    other_hand: str = ""


def habits(rng: np.random.Generator, *, distracted: bool = False) -> Habits:
    """Draw the variations of a demonstration, once, before it begins.

    Args:
        distracted: somebody who is at two things at once: they begin with the wrong one, and are interrupted.
    """
    look, again, down = rng.random(3) < (SECOND_LOOK, REGRASP, PUT_DOWN)
    own = Habits(bool(look), bool(again), bool(down), PAUSE)
    if not distracted:
        return own
    wrong, stopped = rng.random(2) < DISTRACTED
    other = str(rng.choice(OTHER_HAND))
    return replace(own, wrong_way=bool(wrong), interrupted=bool(stopped), other_hand=other)


def draw_pace_and_tremor(person: Performer) -> None:
    """Draw the person's pace and tremor."""
    person.pace = person.between(*PACE)
    person.shake(person.between(*SHAKE))


def pause(person: Performer, own: Habits) -> None:
    """Wait for a moment, if that was drawn as a habit of the person."""
    if person.rng.random() < own.pause:
        person.wait(person.between(0.25, 0.8))


def look_twice(person: Performer, grasp: Pose) -> None:
    """Move the hand to the grasp and back off again."""
    near = Pose(tuple(grasp.position + grasp.rotate((0, 0, -person.between(0.09, 0.14)))), grasp.quaternion)
    before = person.aim
    person.move([near], person.between(0.2, 0.35))
    back = np.add(near.position, 0.4 * np.subtract(before.position, near.position))
    person.move([Pose(tuple(back), near.quaternion)], person.between(0.15, 0.3))
    person.wait(person.between(0.2, 0.5))


def go_wrong(person: Performer, scene: Scene, grasp: Pose) -> None:
    """Let the person's hand reach for a wrong thing, stop in front of it, and move back in front of the
    right thing."""
    others = [t for t in scene.world.things if t.movable and t is not scene.product]
    if not others:
        return
    other = others[int(person.rng.integers(len(others)))]
    off = np.array(grasp.rotate((0, 0, 1))) * person.between(0.12, 0.18)
    place = np.add(other.pose.position, (0.0, 0.0, person.between(0.02, 0.08))) - off
    person.move([Pose(tuple(place), grasp.quaternion)], person.between(0.2, 0.35))
    person.wait(person.between(0.4, 1.0))
    back = np.array(grasp.position) - np.array(grasp.rotate((0, 0, 1))) * person.between(0.2, 0.3)
    person.move([Pose(tuple(back), grasp.quaternion)], person.between(0.2, 0.35))


def be_interrupted(person: Performer) -> None:
    """Stop with the payload, move a few centimetres aside, wait, and move back."""
    here = person.aim
    away = Pose(tuple(np.add(here.position, person.rng.uniform(-0.06, 0.06, 3))), here.quaternion)
    person.move([away], person.between(0.1, 0.2))
    person.wait(person.between(0.8, 2.0))
    person.move([here], person.between(0.1, 0.25))


def take_again(person: Performer, scene: Scene, grasp: Pose) -> None:
    """Let go of the payload, and regrasp it a little elsewhere."""
    person.wait(person.between(0.2, 0.5))
    width = extent(scene, grasp)
    person.grip(min(width + 0.02, OPENING), person.between(0.25, 0.4))
    person.wait(person.between(0.2, 0.4))
    moved = Pose(tuple(person.rng.uniform(-0.004, 0.004, 3)), (1, 0, 0, 0))
    person.move([grasp * moved], 0.05)
    close(person, width)


def detour(person: Performer) -> None:
    """Move the payload to a random point some centimetres away, as a detour."""
    side = np.array([person.between(-0.08, 0.0), person.between(-0.08, 0.08), person.between(-0.02, 0.08)])
    goal = Pose(tuple(np.add(person.aim.position, side)), person.aim.quaternion)
    person.move([goal], person.between(0.15, 0.3))


def put_down_and_take(person: Performer, scene: Scene, grasp: Pose) -> None:
    """Put the payload on the nearest surface, let go, move back, and grasp it again."""
    support, top = nearest_top(person, scene)
    put_down(person, scene, support, top, grasp)
    person.grip(min(extent(scene, grasp) + 0.02, OPENING), person.between(0.3, 0.5))
    person.wait(person.between(0.2, 0.4))
    hold = person.aim
    back = Pose(tuple(hold.position + hold.rotate((0, 0, -person.between(0.10, 0.15)))), hold.quaternion)
    person.move([back], person.between(0.15, 0.25))
    person.wait(person.between(0.2, 0.6))
    person.move([hold], person.between(0.08, 0.15))
    close(person, extent(scene, grasp))
    up = np.add(person.aim.position, (0.0, 0.0, person.between(0.06, 0.12)))
    person.move([Pose(tuple(up), person.aim.quaternion)], person.between(0.12, 0.25))


def nearest_top(person: Performer, scene: Scene) -> tuple[Thing, Feature]:
    """Find the fixed surface whose middle is nearest to the hand; containers and the product itself are left
    out."""
    tops = [
        (t, f)
        for t, f in featured(scene.world, "vrps:SurfaceFeature")
        if t is not scene.product and t.feature("cram:Cavity") is None and not t.movable
    ]
    here = np.array(person.aim.position)
    return min(tops, key=lambda c: float(np.linalg.norm(c[0].pose.apply(c[1].pose.position) - here)))


def put_down(person: Performer, scene: Scene, support: Thing, top: Feature, grasp: Pose) -> None:
    """Lower the payload upright to a small random gap above a surface; the payload drops over the gap when the hand lets go."""
    spot = _spot(person, scene, support, top)
    body = person.pose(scene.product.name)
    goal = Pose(tuple(np.add(spot, (0, 0, half_extents(scene.product)[2]))), body.quaternion)
    upright = _upright(goal)
    hold = upright * body.inverse() * person.tool()
    lag = np.subtract(person.aim.position, person.tool().position)
    above = np.add(np.add(hold.position, lag), (0, 0, person.between(0.06, 0.1)))
    middle = (np.array(person.aim.position) + above) / 2 + (0, 0, person.between(0.02, 0.06))
    person.move([Pose(tuple(middle)), Pose(tuple(above), hold.quaternion)], person.between(0.2, 0.35), curved=True)
    low = np.add(np.add(hold.position, lag), (0, 0, person.between(*DROP)))
    person.move([Pose(tuple(low), hold.quaternion)], person.between(0.05, 0.1))
    person.wait(person.between(0.1, 0.3))


def _upright(pose: Pose) -> Pose:
    """Pose at the same position with z up and its x direction kept in the plan view."""
    x = pose.rotate((1, 0, 0))
    return Pose.from_axes(pose.position, (0, 0, 1), (x[0], x[1], 0.0))


def _spot(person: Performer, scene: Scene, support: Thing, top: Feature) -> Floats:
    """Point on a surface: near the hand, away from the surface's edge and from all things on it."""
    frame = support.pose * top.pose
    x, y, _ = frame.inverse().apply(person.aim.position)
    room = [max(top.size[k] / 2 - 0.09, 0.0) for k in ("width", "depth")]
    wanted = np.clip((x, y), (-room[0], -room[1]), room)
    others = [t for t in scene.world.things if t not in (scene.product, support, scene.hanger)]
    for _ in range(60):
        spot = frame.apply((*wanted, 0.0))
        if all(_apart(spot, other) for other in others) and _apart(spot, scene.hanger, 0.2):
            return np.asarray(spot)
        wanted = np.clip(wanted + person.rng.normal(0, 0.06, 2), (-room[0], -room[1]), room)
    return np.asarray(frame.apply((0, 0, 0)))


def _apart(spot: Floats, other: Thing, room: float = 0.12) -> bool:
    reach = np.abs(half_extents(other)[:2])
    if reach.max() > 0.5:  # the ground
        return True
    off = np.abs(other.pose.inverse().apply(spot)[:2]) - reach
    return bool(off.max() > room)


def with_tracking_loss(rollout: Rollout, thing: str, rng: np.random.Generator) -> Rollout:
    """Corrupt a rollout as by a tracker that lost the thing in the hand: poses at the origin, no contacts."""
    held = np.array([_gripped(touches, thing) for touches in rollout.touches])
    seconds = rng.uniform(*BLIND)
    moments = np.flatnonzero(held)
    if len(moments) < 20:
        return rollout
    first = int(rng.integers(len(moments) // 4, 3 * len(moments) // 4))
    start = rollout.times[moments[first]]
    gone = (rollout.times >= start) & (rollout.times < start + seconds) & held
    poses = {**rollout.poses, thing: np.where(gone[:, None], [0, 0, 0, 1, 0, 0, 0.0], rollout.poses[thing])}
    touches = tuple(
        tuple(t for t in now if not lost or thing not in (thing_of(t.a), thing_of(t.b)))
        for now, lost in zip(rollout.touches, gone, strict=True)
    )
    return replace(rollout, poses=poses, touches=touches)


def _gripped(touches: tuple[Touch, ...], thing: str) -> bool:
    sides = {t.a for t in touches if thing_of(t.b) == thing}
    return {"effector/left", "effector/right"} <= sides
