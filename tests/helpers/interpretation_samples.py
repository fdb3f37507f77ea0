"""Small hand-made episodes with known meaning, for the tests of interpretation."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from cramlite.model import Entity, Episode, Event, Floats, Pose, Track

HAND = (
    Entity("hand", ("soma:Hand",), properties={"max_opening": 0.1}),
    Entity("hand/left", ("soma:Finger",), part_of="hand"),
    Entity("hand/right", ("soma:Finger",), part_of="hand"),
)


def state(kind: str, first: str, second: str, start: float, end: float) -> Event:
    """Make the event of a state: a contact, support, grasp or containment of two entities."""
    type_, a, b = {
        "contact": ("soma:ContactState", "a", "b"),
        "support": ("soma:SupportState", "supporter", "supportee"),
        "grasp": ("cram:GraspState", "gripper", "object"),
        "contain": ("soma:ContainmentState", "container", "content"),
    }[kind]
    return Event(f"{kind}_{first}_{second}_{start}", type_, "state", start, end, {a: first, b: second})


def action(type_: str, start: float, end: float, **roles: str) -> Event:
    """Make the event of a labelled action."""
    return Event(f"{type_}_{start}", type_, "action", start, end, roles)


def track(*points: tuple[float, float, float, float]) -> Track:
    """Make a track of straight lines through points (t, x, y, z), sampled at 50 Hz, with constant orientation."""
    keys = np.array(points)
    times = np.union1d(np.arange(keys[0, 0], keys[-1, 0], 0.02), keys[:, 0])
    poses = np.zeros((len(times), 7))
    poses[:, 3] = 1.0
    for axis in range(3):
        poses[:, axis] = np.interp(times, keys[:, 0], keys[:, axis + 1])
    return Track(times, poses)


def episode(
    entities: Iterable[Entity],
    events: Iterable[Event],
    tracks: dict[str, Track] | None = None,
    opening: Floats | None = None,
    **extras: Floats,
) -> Episode:
    """Make the episode of a hand; ``opening`` holds rows of time [s] and opening of the hand [m]."""
    found = dict(extras)
    if opening is not None:
        found["times"] = np.arange(opening[0, 0], opening[-1, 0], 0.02)
        found["opening"] = np.interp(found["times"], opening[:, 0], opening[:, 1])
    return Episode(
        "sample", (*HAND, *entities), tuple(sorted(events, key=lambda e: e.start)), tracks or {}, "hand", extras=found
    )


SHOP = (
    Entity("hanger", ("cram:Hanger",), pose=Pose((0.6, 0, 1.0)), size=(0.02, 0.02, 0.02)),
    Entity("hanger/peg", ("vrps:Peg",), part_of="hanger", pose=Pose()),
    Entity("product", ("cram:BoxedProduct",), size=(0.06, 0.02, 0.12)),
    Entity("product/hole", ("vrps:Hole",), part_of="product", pose=Pose((0, 0, 0.05))),
    Entity("basket", ("cram:Basket",), pose=Pose((0.4, 0.5, 0.5)), size=(0.3, 0.3, 0.2)),
)


def hanger_episode(friction: bool = True) -> Episode:
    """Make the episode of a product that is taken off a hanger and dropped into a basket; without friction the hand closes on the
    product but does not move it."""
    carry = ((3.0, 0.5, 0, 0.95), (4.0, 0.3, 0, 0.97), (6.0, 0.4, 0.5, 0.9))
    hand = track(
        (0, 0.1, 0, 1.2),
        (2.0, 0.4, 0, 0.95),
        (3.0, 0.42, 0, 0.95),
        (4.0, 0.22, 0, 0.97),
        (6.0, 0.32, 0.5, 0.9),
        (6.7, 0.2, 0.5, 0.9),
        (8.0, 0.1, 0.2, 1.2),
    )
    product = track(
        (0, 0.5, 0, 0.95),
        *(carry if friction else ((3.0, 0.5, 0, 0.95),)),
        *(((6.3, 0.4, 0.5, 0.5),) if friction else ()),
        (8.0, *((0.4, 0.5, 0.5) if friction else (0.5, 0, 0.95))),
    )
    events = [
        state("contact", "hanger/peg", "product", 0.0, 3.6 if friction else 8.0),
        state("support", "hanger/peg", "product", 0.0, 3.5 if friction else 8.0),
        state("contact", "hand", "product", 2.3, 6.15 if friction else 2.9),
    ]
    if friction:
        events += [
            state("grasp", "hand", "product", 2.8, 6.0),
            state("contact", "product", "basket", 6.3, 8.0),
            state("support", "basket", "product", 6.4, 8.0),
        ]
    opening = np.array([(0, 0.09), (2.2, 0.09), (2.7, 0.02), (5.9, 0.02), (6.3, 0.08), (8.0, 0.08)])
    return episode(SHOP, events, {"hand": hand, "product": product}, opening)
