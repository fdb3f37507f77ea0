"""Contact signals of a rollout: pairs of entities in contact, with the force."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Mapping
from itertools import pairwise

import numpy as np

from cramlite.model import EntityName, Event, Floats, Rollout, Touch, Value, thing_of
from cramlite.plugin import checkpoint

from .signals import Flags, close_gaps, runs

#: A contact starts above the first and ends below the second normal force [N]; 0.1 kg weighs 1 N.
CONTACT = (0.05, 1e-6)
#: Gaps shorter than this may be chatter [s]: a slide of a program, too, counts a contact as lost after 0.5 s (``lost_s``).
CHATTER = 0.5
#: All through the gap the hand applies more than this [N], measured at the wrist. Finger tips that slide on a plate, pressed
#: on with 12 N, have single contacts of 0 and 50 N in turn, sampled at 50 Hz, and 12 to 15 N at the wrist all the time.
PRESSED = 5.0

Pairs = Mapping[tuple[str, str], Flags]


class Pair(Value):
    """Contact force of one pair of entities, and upward force of the first on the second, per sample, (N,)
    each [N]."""

    force: Floats
    lift: Floats


def touching_pairs(rollout: Rollout, known: set[str]) -> dict[tuple[str, str], Pair]:
    """Return the contact signals of every touching pair, in both directions: lift is the upward force of
    the first on the second."""
    n = len(rollout.times)
    pairs: dict[tuple[str, str], Pair] = defaultdict(lambda: Pair(np.zeros(n), np.zeros(n)))
    single: dict[tuple[str, str], list[tuple[int, float, float]]] = defaultdict(list)
    names: dict[str, str] = {}
    for rows, touches in _stretches(rollout):
        checkpoint()
        for touch in touches:
            a, b = (names.get(v) or names.setdefault(v, _finest(entity_of(v, rollout), known)) for v in (touch.a, touch.b))
            for first, second, lift in ((a, b, touch.lift), (b, a, -touch.lift)):
                pair = pairs[first, second]
                if rows.stop - rows.start == 1:
                    single[first, second].append((rows.start, touch.force, lift))
                else:
                    pair.force[rows] += touch.force
                    pair.lift[rows] += lift
    for both, found in single.items():
        samples, forces, lifts = zip(*found, strict=True)
        np.add.at(pairs[both].force, list(samples), forces)
        np.add.at(pairs[both].lift, list(samples), lifts)
    return dict(pairs)


def _stretches(rollout: Rollout) -> Iterator[tuple[slice, tuple[Touch, ...]]]:
    """Yield ranges of samples with their contacts; contacts of things at rest come once for all samples of the rest."""
    asleep = rollout.asleep or ((),) * len(rollout.touches)
    begins = [k for k in range(len(asleep)) if k == 0 or asleep[k] is not asleep[k - 1]]
    spans = dict(zip(begins, [*begins[1:], len(asleep)], strict=True))
    for k, awake in enumerate(rollout.awake_touches):
        if k in spans:
            yield slice(k, spans[k]), asleep[k]
        yield slice(k, k + 1), awake


def _finest(touched: str, known: set[str]) -> str:
    """Name of the touched part if the part is a known entity, else of the thing."""
    return touched if touched in known else thing_of(touched)


def entity_of(touched: str, rollout: Rollout) -> str:
    """Return the name that a touched body has in an episode; a rollout's "effector" has there the name of the
    hand or gripper."""
    name = EntityName.parse(touched)
    return str(EntityName(rollout.effector, name.part)) if name.thing == "effector" else touched


def state(type_: str, span: tuple[float, float], roles: dict[str, str]) -> Event:
    """Return a state event over a time interval [s]."""
    return Event("", type_, "state", *span, roles)


def pressed_on(contacts: Pairs, rollout: Rollout) -> dict[tuple[str, str], Flags]:
    """Close the gaps in the effector's contact with a thing during which the wrist still measured a force and
    the effector touched nothing else.

    Args:
        contacts: pair of entities -> whether they touch, per sample.
        rollout: its ``wrench`` is what the effector applies, without the gripper's own weight.
    """
    force = np.linalg.norm(rollout.wrench[:, :3], axis=1)
    mine = {pair: on for pair, on in contacts.items() if rollout.effector in pair}
    found = dict(contacts)
    for pair, on in mine.items():
        filled = close_gaps(on, rollout.times)
        others = [o for other, o in mine.items() if other != pair]
        for (_, end), (start, _) in pairwise(runs(on)):
            alone = not any(o[end - 1 : start + 1].any() for o in others)
            short = rollout.times[start] - rollout.times[end - 1] < CHATTER
            filled[end:start] |= bool(short and alone and (force[end:start] > PRESSED).all())
        found[pair] = filled
    return found
