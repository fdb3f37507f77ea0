"""Grasp detection in a rollout: both pads press the object, it stays where it is in the hand, and friction holds it.

Only contacts and motion are seen, as touch and cameras could see them: what the object weighs and how it rubs is not known here.
"""

from __future__ import annotations

import numpy as np

from cramlite.model import EntityName, Event, Floats, Rollout, thing_of

from .entities import effectors
from .signals import (
    GAP,
    Flags,
    close_gaps,
    drop_short,
    hysteresis,
    intervals,
    moving_average,
    rotate_into_frame,
    span_of,
    spans,
    speed,
)
from .touches import CONTACT, Pair, state

#: Each pad's normal force to start and to keep a grip [N]; below 0.3 N friction 0.9 holds no 50 g.
GRIP = (0.6, 0.2)
#: What is between pads keeps them apart by more than this [m]; closed fingers that push a thing touch it with both pads.
THIN = 0.001
#: The object slips when it moves faster than this in the hand [m/s], plus this share of the hand's speed.
SLIP = (0.03, 0.3)
#: Friction was seen to hold: for GAP the pads push the object up with this share of what all that touches it does (at rest that
#: is its weight), or the hand drags it this far [m].
CARRY, DRAG = 0.5, 0.02
#: Each pad's normal force of a grip that is meant to hold, although nothing was seen to move [N]: a person's pinch has 40 N, the
#: weakest gripper presses with 10 N at least.
FIRM = 5.0


def grasps(rollout: Rollout, pairs: dict[tuple[str, str], Pair]) -> list[Event]:
    """Detect the grasps of every hand of a rollout, as states."""
    return [e for hand in effectors(rollout) for e in _grasps_of(hand, rollout, pairs)]


def _grasps_of(hand: str, rollout: Rollout, pairs: dict[tuple[str, str], Pair]) -> list[Event]:
    found = []
    frame = "effector" if hand == rollout.effector else hand
    for thing in rollout.world.things:
        pads = [_pressing(pairs, str(EntityName(hand, side)), thing.name) for side in ("left", "right")]
        if thing.mass is None or any(p is None for p in pads):
            continue
        weaker = np.minimum(pads[0].force, pads[1].force)  # type: ignore[union-attr]
        pressed = np.logical_and(*(hysteresis(p.force, *GRIP) for p in pads))  # type: ignore[union-attr]
        held = close_gaps(pressed & (rollout.opening > THIN), rollout.times)
        lift = pads[0].lift + pads[1].lift  # type: ignore[union-attr]
        others = _others_lift(pairs, hand, thing.name, rollout)
        inside = _in_hand(rollout, thing.name, frame)
        still = held & ~drop_short(held & _slipping(inside, rollout, frame), rollout.times)
        for start, end in intervals(still, rollout.times):
            within = slice(start, end)
            slipped = end < len(held) and bool(held[end])  # the pads still press, and hold it no longer
            shift, times = np.linalg.norm(inside[within] - inside[start], axis=1), rollout.times[within]
            firm = not slipped and shift.max() < DRAG and bool(spans(weaker[within] > FIRM, times))
            if firm or _carries(lift[within], others[within], times) or _dragged(rollout, thing.name, frame, within, shift):
                roles = {"gripper": hand, "object": thing.name}
                found.append(state("cram:GraspState", span_of(start, end, rollout.times), roles))
    return found


def _pressing(pairs: dict[tuple[str, str], Pair], pad: str, thing: str) -> Pair | None:
    """Force of a pad on a thing and all its parts."""
    mine = [p for (a, b), p in pairs.items() if a == pad and thing_of(b) == thing]
    return Pair(sum(p.force for p in mine), sum(p.lift for p in mine)) if mine else None  # type: ignore[arg-type]


def _in_hand(rollout: Rollout, thing: str, frame: str) -> Floats:
    """Position of a thing in the frame of the hand at each sample, (N, 3) [m]."""
    hand, body = rollout.poses[frame], rollout.poses[thing]
    return rotate_into_frame(hand[:, 3:], body[:, :3] - hand[:, :3])


def _slipping(inside: Floats, rollout: Rollout, frame: str) -> Flags:
    """Samples in which the thing moves in the hand faster than a limit that rises with the hand's own
    speed."""
    limit = SLIP[0] + SLIP[1] * speed(rollout.poses[frame][:, :3], rollout.times)
    return np.asarray(speed(inside, rollout.times) > limit)


def _others_lift(pairs: dict[tuple[str, str], Pair], hand: str, thing: str, rollout: Rollout) -> Floats:
    """Upward force on a thing from all but the hand, (N,) [N]."""
    lifts = [p.lift for (a, b), p in pairs.items() if thing_of(b) == thing and thing_of(a) not in (thing, hand)]
    return np.asarray(sum(lifts, np.zeros(len(rollout.times))))


def _carries(lift: Floats, others: Floats, times: Floats) -> bool:
    """Whether the pads exert, at some time, at least the share CARRY of the upward force on a thing, averaged over GAP seconds."""
    mine, whole = (moving_average(v, times, GAP) for v in (lift, lift + others))
    return bool(np.any((whole > CONTACT[0]) & (mine > CARRY * whole)))


def _dragged(rollout: Rollout, thing: str, frame: str, span: slice, shift: Floats) -> bool:
    """Whether the thing travelled at right angles to the closing axis by more than ``DRAG`` further than it
    slid in the hand (``shift``)."""
    closing = np.subtract(*(rollout.poses[str(EntityName(frame, side))][span, :3] for side in ("left", "right")))
    closing = closing.mean(axis=0) / max(float(np.linalg.norm(closing.mean(axis=0))), 1e-9)
    travel = rollout.poses[thing][span, :3] - rollout.poses[thing][span.start, :3]
    across = travel - np.outer(travel @ closing, closing)
    return bool(np.max(np.linalg.norm(across, axis=1) - shift) > DRAG)
