"""Contact signals of a rollout: which entities touch, and with what force."""

from __future__ import annotations

from collections import defaultdict

import numpy as np

from cramlite.model import EntityName, Event, Floats, Rollout, Value, thing_of

#: A contact starts above the first and ends below the second normal force [N]; 0.1 kg weighs 1 N.
CONTACT = (0.05, 1e-6)
GRAVITY = 9.81


class Pair(Value):
    """Contact force and lift of one pair of entities, per sample, (N,) each [N]."""

    force: Floats
    lift: Floats


def touching_pairs(rollout: Rollout, known: set[str]) -> dict[tuple[str, str], Pair]:
    """Return the contact signals of every touching pair, in both directions: lift is what the first exerts on the second."""
    n = len(rollout.times)
    pairs: dict[tuple[str, str], Pair] = defaultdict(lambda: Pair(np.zeros(n), np.zeros(n)))
    for k, touches in enumerate(rollout.touches):
        for touch in touches:
            a, b = (_finest(entity_of(v, rollout), known) for v in (touch.a, touch.b))
            for first, second, lift in ((a, b, touch.lift), (b, a, -touch.lift)):
                pairs[first, second].force[k] += touch.force
                pairs[first, second].lift[k] += lift
    return dict(pairs)


def _finest(touched: str, known: set[str]) -> str:
    """The part, if it is one of the entities, else the thing."""
    return touched if touched in known else thing_of(touched)


def entity_of(touched: str, rollout: Rollout) -> str:
    """Return the name in episodes of a body: rollouts call the effector "effector", episodes by its name."""
    name = EntityName.parse(touched)
    return str(EntityName(rollout.effector, name.part)) if name.thing == "effector" else touched


def state(type_: str, span: tuple[float, float], roles: dict[str, str]) -> Event:
    """Return a state event over a time interval [s]."""
    return Event("", type_, "state", *span, roles)
