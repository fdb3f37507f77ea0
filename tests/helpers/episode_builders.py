"""Rollouts and episodes made for tests: signals that a person can check by hand, no mocks."""

from __future__ import annotations

import numpy as np

from cramlite.model import Entity, Episode, Event, Feature, Geom, Pose, Repair, Rollout, Thing, Touch, Track, World

RATE = 100.0


def shop() -> World:
    """Make a world with a hanger with a peg, a product with a hole, and a basket."""
    hanger = Thing(
        "hanger",
        "cram:Hanger",
        Pose((0.7, 0.0, 0.4)),
        (
            Geom("box", (0.01, 0.1, 0.1)),
            Geom("capsule", (0.003, 0.069), Pose((0.08, 0, 0), (0.7071, 0, 0.7071, 0)), "peg"),
        ),
        (Feature("peg", "vrps:Peg", Pose((0.01, 0, 0)), {"radius": 0.003, "length": 0.138}),),
    )
    product = Thing(
        "product",
        "cram:Product",
        Pose((0.6, 0.0, 0.4)),
        (Geom("box", (0.02, 0.0125, 0.075)),),
        (Feature("hole", "vrps:Hole", Pose((0, 0, 0.08)), {"radius": 0.005}),),
        mass=0.2,
    )
    basket = Thing("basket", "cram:Basket", Pose((0.4, 0.4, 0.0)), (Geom("box", (0.1, 0.1, 0.005)),))
    return World((hanger, product, basket))


def rollout(seconds: float = 4.0, *, slip: float = 0.0, carried: float = 1.0) -> Rollout:
    """Return a rollout in which the product hangs on the peg until 1.5 s, is between the pads from 1 s to 3 s, and then stands in the
    basket.

    Args:
        slip: share of the hand's motion that the product does not follow.
        carried: share of the product's weight that the pads carry after 1.5 s.
    """
    n = int(seconds * RATE)
    times = np.arange(n) / RATE
    hand = np.tile([0.6, 0.0, 0.4, 1, 0, 0, 0], (n, 1)).astype(float)
    lifting = np.clip(times - 1.5, 0, 1.5)
    hand[:, 2] += 0.1 * lifting
    product = hand.copy()
    product[:, 2] -= slip * 0.1 * lifting
    hand[times > 3, 2] += 0.2 * (times[times > 3] - 3)
    tips = {f"effector/{s}": hand + np.array([0, y, 0, 0, 0, 0, 0]) for s, y in (("left", 0.02), ("right", -0.02))}
    still = {t.name: np.tile([*t.pose.position, *t.pose.quaternion], (n, 1)) for t in shop().things if t.mass is None}
    return Rollout(
        shop(),
        "hand",
        times,
        {"product": product, **still, "effector": hand, **tips},
        tuple(_touches(t, carried) for t in times),
        np.zeros((n, 0)),
        np.zeros((n, 6)),
        np.full(n, 0.04),
        np.zeros(n),
    )


def _touches(time: float, carried: float) -> tuple[Touch, ...]:
    found = []
    if time < 1.5:
        found.append(Touch("hanger/peg", "product/hole", 2.0, 1.96 - (carried * 0.5 if time > 1 else 0)))
    if 1.0 <= time < 3.0:
        lift = carried * (0.98 if time >= 1.5 else 0.25)
        found += [Touch("product", "effector/left", 10.0, -lift), Touch("effector/right", "product", 10.0, lift)]
    if time >= 3.0:
        found.append(Touch("product", "basket", 1.96, -1.96))
    return tuple(found)


def episode(poses: int = 50) -> Episode:
    """Return an episode with one element of every type that an episode can have, with numbers that are no short decimal fractions."""
    rng = np.random.default_rng(4)
    times = np.cumsum(rng.random(poses)) - 0.3
    quaternions = rng.normal(size=(poses, 4))
    track = Track(
        times, np.hstack([rng.normal(size=(poses, 3)), quaternions / np.linalg.norm(quaternions, axis=1)[:, None]])
    )
    geom = Geom("cylinder", (0.1 / 3, 0.2), Pose((1 / 3, 0, 0), (1, 2, 3, 4)), "lid", 0.3, (0.1, 0.2, 0.3, 1.0))
    entities = (
        Entity(
            'jar <&> "1"',
            ("cram:Product", "soma:Jar", "http://example.org/x#Jar"),
            None,
            Pose((1 / 3, 2, 3), (1, 1, 0, 0)),
            (0.1, 0.2, 1 / 3),
            (geom,),
            {"mass": 0.1 + 0.2},
        ),
        Entity('jar <&> "1"/lid', ("soma:Lid",), 'jar <&> "1"', Pose((0, 0, 1 / 7))),
        Entity("hand", ("soma:Hand",)),
        Entity("shelf", (), None, Pose()),
    )
    events = (
        Event("contact_1", "soma:ContactState", "state", -0.1, 1 / 3, {"a": "hand", "b": 'jar <&> "1"/lid'}),
        Event("support_1", "soma:SupportState", "state", 0.1, 2.5, {"supporter": "shelf", "supportee": 'jar <&> "1"'}),
        Event("grasp_1", "cram:GraspState", "state", 0.1, 1e-5 + 2, {"gripper": "hand", "object": 'jar <&> "1"'}, True),
        Event(
            "reach é",
            "soma:Reaching",
            "action",
            0.2,
            0.7,
            {"performer": "hand", "object": 'jar <&> "1"', "to": "shelf"},
        ),
        Event("any", "soma:PhysicalAction", "action", 0.7, 1.7),
        Event("scene", "soma:Scene", "situation", 0.9, 1.0),
    )
    repair = Repair("closed a gap", (0.1, 0.2), "flicker", events[:1], (events[1],))
    extras = {"times": times, "wrench": rng.normal(size=(poses, 6)), "joints": rng.normal(size=(poses, 6))}
    return Episode(
        "a test: 1/2",
        entities,
        events,
        {'jar <&> "1"': track, "hand": track, "shelf": track},
        "hand",
        (repair,),
        extras,
    )
