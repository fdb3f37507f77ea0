"""Event detection: from a rollout to the states of an episode.

The one detection for human demonstrations and robot runs: it sees contacts and poses only, never
who moved or why.

- ContactState(a, b): a and b touch. "thing/part" where the contact is with a known part; the
  effector counts as a whole. A hole that touched the peg in it goes on touching it until the peg is out; an effector that
  the wrist feels pressing has not let go where contacts chatter (``felt.py``).
- SupportState(supporter, supportee): the supporter pushes the supportee up with a fair share of its
  weight. Being grasped is not being supported: the effector never supports.
- GraspState(gripper, object): both pads press the object, it stays where it is in the hand, and
  friction was seen to hold it, or the pads press so hard that it would carry the object's weight: who lets go of a
  thing again that hangs or stands still had grasped it. Squeezing without friction is no grasp.
- ContainmentState(container, content): a tenth at least of the grains that a thing was filled with are in the cavity.

Simulated contacts flicker. So each signal has hysteresis (it starts above one threshold and ends
below a lower one), gaps shorter than ``GAP`` are closed, and what is then shorter than ``SHORT`` is
dropped; RobCoG's logs show contacts of 0.02 to 0.3 s for one touch.

A state that still holds when the recording ends, ends one sample after it.
"""

from __future__ import annotations

from collections import defaultdict

import numpy as np
from msgspec.structs import replace

from cramlite.episode import Episode, Event, Track
from cramlite.geometry import Floats
from cramlite.rollout import Rollout
from cramlite.value import Value

from ..experts.contents import where
from .entities import (
    camera_entities,
    contents_entities,
    contents_of,
    effector_entities,
    effectors,
    platform_entities,
    thing_entities,
)
from .felt import pressed_on
from .signals import (
    GAP,
    SHORT,
    Flags,
    closed,
    hold,
    intervals,
    lasting,
    rotate_back,
    runs,
    smooth,
    span_of,
    spans,
    speed,
    step,
)
from .threaded import held_on, threaded

#: Boundaries nearer to each other than this are one [s]: a closing hand's pads touch and grip within it.
SNAP = 0.05
#: A contact starts above the first and ends below the second normal force [N]; 0.1 kg weighs 1 N.
CONTACT = (0.05, 1e-6)
#: Share of the supportee's weight that the supporter must carry to start and to keep a support.
SUPPORT = (0.3, 0.1)
#: What has moved by less than this stands where it stood [m]: trackers see no less, and pads that close lift by 0.1 mm
#: (measured on blocks of 0.2 kg).
STILL = 0.0005
#: What was carried for this long stood there [s]; a held product that bumps on a peg leans on it for 0.1 s.
STOOD = 0.5
#: Each pad's normal force to start and to keep a grip [N]; below 0.3 N friction 0.9 holds no 50 g.
GRIP = (0.6, 0.2)
#: What is between pads keeps them apart by more than this [m]; closed fingers that push a thing touch it with both pads.
THIN = 0.001
#: The object slips when it moves faster than this in the hand [m/s], plus this share of the hand's speed.
SLIP = (0.03, 0.3)
#: Friction was seen to hold: pads carry this share of the weight for GAP, or the hand drags the object this far [m].
CARRY, DRAG = 0.5, 0.02
#: Friction at both pads would carry so many times the weight: a grip that holds in any attitude (measured: grips by
#: person and robot press 4 to 30 times as hard).
FIRM = 2.0
#: Share of the grains that a vessel must have to start and to keep holding the contents: one that flew past is not it.
HELD = (0.1, 0.05)
GRAVITY = 9.81


class _Pair(Value):
    """Force and lift of one pair of entities, per sample."""

    force: Floats
    lift: Floats


def detect(rollout: Rollout, name: str) -> Episode:
    """The episode of a rollout: its entities, states and tracks.

    Args:
        rollout: samples of a demonstration or a program's run.
        name: the episode's name.

    Returns:
        Timeline of states only; actions are what lies between their boundaries, and are segmented later.
    """
    things = (e for t in rollout.world.things for e in thing_entities(t, rollout))
    robot = (*effector_entities(rollout), *platform_entities(rollout), *camera_entities(rollout))
    entities = (*things, *contents_entities(rollout), *robot)
    known = {e.name for e in entities}
    pairs = _pairs(rollout, known)
    carried = _carried(rollout, pairs)
    states = (
        *_contacts(rollout, pairs, carried), *_supports(rollout, carried), *_grasps(rollout, pairs), *_contents(rollout)
    )  # fmt: skip
    extras = {
        "times": rollout.times,
        "opening": rollout.opening,
        "joints": rollout.joints,
        "wrench": rollout.wrench,
        "lines": rollout.lines,
        **{f"joint:{name}": values for name, values in rollout.values.items()},
    }
    return Episode(
        name=name,
        entities=entities,
        events=_numbered(_snapped(states, rollout.times)),
        tracks={_entity(k, rollout): t for k, v in rollout.poses.items() if (t := _since(rollout, k, v)) is not None},
        effector=rollout.effector,
        extras={k: np.asarray(v, dtype=float) for k, v in extras.items() if np.size(v)},
    )


def _entity(touched: str, rollout: Rollout) -> str:
    """Rollouts call the effector "effector", episodes by its name."""
    return rollout.effector + touched[8:] if touched.split("/")[0] == "effector" else touched


def _since(rollout: Rollout, name: str, poses: Floats) -> Track | None:
    """The track of a frame from when a camera first saw it on, where its pose was not known at the start; None where no
    camera did."""
    known = rollout.times >= rollout.seen.get(name, -np.inf)
    return _track(rollout.times[known], poses[known]) if known.any() else None


def _track(times: Floats, poses: Floats) -> Track:
    """Poses on change; the first and the last sample are always kept, so that the span stays."""
    changed = np.any(np.abs(np.diff(poses, axis=0)) > 1e-9, axis=1)
    keep = np.concatenate([[True], changed])
    keep[-1] = True
    return Track(np.asarray(times, dtype=float)[keep], np.asarray(poses, dtype=float)[keep])


def _pairs(rollout: Rollout, known: set[str]) -> dict[tuple[str, str], _Pair]:
    """Signals of every touching pair, in both directions: lift is what the first exerts on the second."""
    n = len(rollout.times)
    pairs: dict[tuple[str, str], _Pair] = defaultdict(lambda: _Pair(np.zeros(n), np.zeros(n)))
    for k, touches in enumerate(rollout.touches):
        for touch in touches:
            a, b = (_finest(_entity(v, rollout), known) for v in (touch.a, touch.b))
            for first, second, lift in ((a, b, touch.lift), (b, a, -touch.lift)):
                pairs[first, second].force[k] += touch.force
                pairs[first, second].lift[k] += lift
    return dict(pairs)


def _finest(touched: str, known: set[str]) -> str:
    """The part, if it is one of the entities, else the thing."""
    return touched if touched in known else touched.split("/")[0]


def _whole(entity: str) -> str:
    return entity.split("/")[0]


def _contacts(rollout: Rollout, pairs: dict[tuple[str, str], _Pair], carried: dict[tuple[str, str], Flags]) -> list[Event]:
    """One state for each unordered pair; the effector's parts are merged. What still stands on a thing touches it."""
    forces: dict[tuple[str, str], Floats] = {}
    hands = effectors(rollout)
    for (a, b), pair in pairs.items():
        first, second = sorted(_whole(v) if _whole(v) in hands else v for v in (a, b))
        if a <= b and first != second:
            forces[first, second] = forces.get((first, second), 0.0) + pair.force
    through = {tuple(sorted((hole, peg))): flags for hole, peg, flags in threaded(rollout)}
    standing = {tuple(sorted(pair)): flags for pair, flags in carried.items()}
    never = np.zeros(len(rollout.times), dtype=bool)
    touching = {
        pair: held_on(hold(force, *CONTACT), through.get(pair, never)) | standing.get(pair, never)
        for pair, force in forces.items()
    }
    return [
        _state("soma:ContactState", span, {"a": a, "b": b})
        for (a, b), flags in pressed_on(touching, rollout).items()
        for span in spans(flags, rollout.times)
    ]


def _carried(rollout: Rollout, pairs: dict[tuple[str, str], _Pair]) -> dict[tuple[str, str], Flags]:
    """When which thing carries which: supporters at the finest entity, supportees as wholes.

    A support begins and ends with a share of the weight, while they touch; and it goes on for as long as the thing stays
    where it stood, within ``STILL``: closing fingers that take the weight off a table have not lifted anything.
    """
    wholes: dict[tuple[str, str], list[_Pair]] = defaultdict(list)
    for (a, b), pair in pairs.items():
        if not {_whole(a), _whole(b)} & {*effectors(rollout)}:
            wholes[a, _whole(b)].append(pair)
    found = {}
    for (a, b), parts in wholes.items():
        weight = GRAVITY * (rollout.world.thing(b).mass or 0.0)
        if weight > 0:
            lift = smooth(np.sum([p.lift for p in parts], axis=0), rollout.times, GAP / 3)
            touching = closed(hold(np.sum([p.force for p in parts], axis=0), *CONTACT), rollout.times)
            on = touching & hold(lift, SUPPORT[0] * weight, SUPPORT[1] * weight)
            found[a, b] = _until_moved(on, rollout.poses[b][:, :3] - rollout.poses[_whole(a)][:, :3], rollout.times)
    return found


def _until_moved(on: Flags, offset: Floats, times: Floats) -> Flags:
    """Flags that, after STOOD, last until the offset (N, 3) has changed by STILL since they ended."""
    kept = on.copy()
    for start, end in runs(on):
        if times[end - 1] - times[start] < STOOD:
            continue
        away = np.linalg.norm(offset[end:] - offset[end - 1], axis=1) > STILL
        kept[end : end + (int(np.argmax(away)) if away.any() else len(away))] = True
    return kept


def _supports(rollout: Rollout, carried: dict[tuple[str, str], Flags]) -> list[Event]:
    return [
        _state("soma:SupportState", span, {"supporter": a, "supportee": b})
        for (a, b), flags in carried.items()
        for span in spans(flags, rollout.times)
    ]


def _grasps(rollout: Rollout, pairs: dict[tuple[str, str], _Pair]) -> list[Event]:
    return [e for hand in effectors(rollout) for e in _grasps_of(hand, rollout, pairs)]


def _grasps_of(hand: str, rollout: Rollout, pairs: dict[tuple[str, str], _Pair]) -> list[Event]:
    found = []
    frame = "effector" if hand == rollout.effector else hand
    for thing in rollout.world.things:
        pads = [_pressing(pairs, f"{hand}/{side}", thing.name) for side in ("left", "right")]
        if thing.mass is None or any(p is None for p in pads):
            continue
        lift = pads[0].lift + pads[1].lift  # type: ignore[union-attr]
        pressed = np.logical_and(*(hold(p.force, *GRIP) for p in pads))  # type: ignore[union-attr]
        held = closed(pressed & (rollout.opening > THIN), rollout.times)
        for start, end in intervals(
            held & ~lasting(held & _slipping(rollout, thing.name, frame), rollout.times), rollout.times
        ):
            weight, within = GRAVITY * thing.mass, slice(start, end)
            grip = rollout.world.physics.pad_friction * (pads[0].force + pads[1].force)  # type: ignore[union-attr]
            slipped = end < len(held) and bool(held[end])  # the pads still press, and hold it no longer
            firm = not slipped and _lasts(grip[within] / weight > FIRM, rollout.times[within])
            if firm or _friction_seen(rollout, thing.name, frame, within, lift / weight):
                roles = {"gripper": hand, "object": thing.name}
                found.append(_state("cram:GraspState", span_of(start, end, rollout.times), roles))
    return found


def _contents(rollout: Rollout) -> list[Event]:
    """One state for each vessel that has a fair share of what is loose in a run."""
    return [
        _state("soma:ContainmentState", span, {"container": vessel, "content": contents_of(thing)})
        for thing, grains in rollout.grains.items()
        for vessel, count in where(rollout, thing).items()
        for span in spans(hold(count / grains.shape[1], *HELD), rollout.times)
    ]


def _pressing(pairs: dict[tuple[str, str], _Pair], pad: str, thing: str) -> _Pair | None:
    """What a pad exerts on a thing and all its parts."""
    mine = [p for (a, b), p in pairs.items() if a == pad and _whole(b) == thing]
    return _Pair(sum(p.force for p in mine), sum(p.lift for p in mine)) if mine else None  # type: ignore[arg-type]


def _slipping(rollout: Rollout, thing: str, frame: str) -> Flags:
    """Samples in which the thing moves relative to the hand, allowing for a share of the hand's own speed."""
    hand, body = rollout.poses[frame], rollout.poses[thing]
    inside = rotate_back(hand[:, 3:], body[:, :3] - hand[:, :3])
    limit = SLIP[0] + SLIP[1] * speed(hand[:, :3], rollout.times)
    return np.asarray(speed(inside, rollout.times) > limit)


def _friction_seen(rollout: Rollout, thing: str, frame: str, span: slice, carried: Floats) -> bool:
    """Did friction transmit a force: weight carried by the pads, or a drag across the closing axis?"""
    dt = step(rollout.times)
    steady = smooth(carried[span], rollout.times[span], GAP)
    if len(steady) * dt >= SHORT and float(np.max(steady)) > CARRY:
        return True
    closing = rollout.poses[f"{frame}/left"][span, :3] - rollout.poses[f"{frame}/right"][span, :3]
    closing = closing.mean(axis=0) / max(float(np.linalg.norm(closing.mean(axis=0))), 1e-9)
    travel = rollout.poses[thing][span, :3] - rollout.poses[thing][span.start, :3]
    across = travel - np.outer(travel @ closing, closing)
    return bool(np.max(np.linalg.norm(across, axis=1)) > DRAG)


def _lasts(flags: Flags, times: Floats) -> bool:
    """Whether flags hold for SHORT at a stretch."""
    return any(end - start >= SHORT for start, end in spans(flags, times))


def _state(type_: str, span: tuple[float, float], roles: dict[str, str]) -> Event:
    return Event("", type_, "state", *span, roles)


def _snapped(states: tuple[Event, ...], times: Floats) -> list[Event]:
    """Boundaries within SNAP after another one, or after the recording's start, are moved to it: they are one instant
    of the demonstration, and would else cut actions of a few samples out of the timeline."""
    instants: dict[float, float] = {}
    first, last = float(times[0]), float(times[-1])
    for time in sorted({t for s in states for t in (s.start, s.end)}):
        first = time if time - first > SNAP and time <= last else first
        instants[time] = time if time > last else first
    moved = (replace(s, start=instants[s.start], end=instants[s.end]) for s in states)
    return [s for s in moved if s.start < s.end]


def _numbered(states: list[Event]) -> tuple[Event, ...]:
    """Sorted by start, with ids that name class and number: "grasp_1"."""
    counts: dict[str, int] = defaultdict(int)
    found = []
    for s in sorted(states, key=lambda e: (e.start, e.end, e.type, sorted(e.roles.items()))):
        word = s.type.split(":")[1].removesuffix("State").lower()
        counts[word] += 1
        found.append(Event(f"{word}_{counts[word]}", s.type, s.kind, s.start, s.end, s.roles))
    return tuple(found)
