"""Event detection: from the contacts and poses of a rollout to the states of an episode.

The one detection for human demonstrations and robot runs: it sees contacts and poses only, never
who moved or why.

- ContactState(a, b): a and b touch. "thing/part" where the contact is with a known part; the
  effector counts as a whole. A hole that touched the peg in it goes on touching it until the peg is out; an effector that
  the wrist feels pressing has not let go where contacts chatter (``pressed_on``). What is
  threaded onto a peg that stands touches it, too: it rests around it.
- SupportState(supporter, supportee): the supporter pushes the supportee up with a fair share of its
  weight. Being grasped is not being supported: the effector never supports.
- GraspState(gripper, object): both pads press the object, it stays where it is in the hand, and friction was seen to
  hold it (nothing else touches it, or the hand takes it along), or the pads press firmly until they let go: who lets go of a
  thing again that hangs or stands still had grasped it. What slips while the pads press was not held. One pad holds nothing.
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

from cramlite.model import Episode, Event, Floats, Rollout, Track, thing_of

from ...shapes.contents import where
from .entities import (
    camera_entities,
    contents_entities,
    contents_of,
    effector_entities,
    effectors,
    platform_entities,
    thing_entities,
)
from .grasped import grasps
from .signals import Flags, hysteresis, spans
from .supported import carried, supports
from .threaded import around_standing, held_on, threaded
from .touches import CONTACT, Pair, entity_of, pressed_on, state, touching_pairs

#: Boundaries nearer to each other than this are one [s]: a closing hand's pads touch and grip within it.
SNAP = 0.05
#: Share of the grains that a vessel must have to start and to keep holding the contents: one that flew past is not it.
HELD = (0.1, 0.05)


def detect(rollout: Rollout, name: str) -> Episode:
    """Detect the states of a rollout, and return its episode: entities, states and tracks.

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
    pairs = touching_pairs(rollout, known)
    standing = carried(rollout, pairs)
    states = (
        *_contacts(rollout, pairs, standing), *supports(rollout, standing), *grasps(rollout, pairs), *_contents(rollout)
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
        tracks={entity_of(k, rollout): t for k, v in rollout.poses.items() if (t := _since(rollout, k, v)) is not None},
        effector=rollout.effector,
        extras={k: np.asarray(v, dtype=float) for k, v in extras.items() if np.size(v)},
    )


def _since(rollout: Rollout, name: str, poses: Floats) -> Track | None:
    """Return the track of a frame from the time at which its pose is known: from the start, or since a camera first sees it; None if no
    camera sees it."""
    known = rollout.times >= rollout.seen.get(name, -np.inf)
    return _track(rollout.times[known], poses[known]) if known.any() else None


def _track(times: Floats, poses: Floats) -> Track:
    """Track with a pose for each sample at which the pose changes, and for the first and the last sample."""
    changed = np.any(np.abs(np.diff(poses, axis=0)) > 1e-9, axis=1)
    keep = np.concatenate([[True], changed])
    keep[-1] = True
    return Track(np.asarray(times, dtype=float)[keep], np.asarray(poses, dtype=float)[keep])


def _contacts(rollout: Rollout, pairs: dict[tuple[str, str], Pair], carries: dict[tuple[str, str], Flags]) -> list[Event]:
    """Contact states, one for each unordered pair of bodies; contacts of the effector's parts are merged. A
    body that stands on another one counts as in contact with it."""
    forces: dict[tuple[str, str], Floats] = {}
    hands = effectors(rollout)
    for (a, b), pair in pairs.items():
        first, second = sorted(thing_of(v) if thing_of(v) in hands else v for v in (a, b))
        if a <= b and first != second:
            forces[first, second] = forces.get((first, second), 0.0) + pair.force
    on_pegs = list(threaded(rollout))
    through = {tuple(sorted((hole, peg))): flags for hole, peg, flags in on_pegs}
    standing = {tuple(sorted(pair)): flags for pair, flags in carries.items()}
    never = np.zeros(len(rollout.times), dtype=bool)
    touching = {
        pair: held_on(hysteresis(force, *CONTACT), through.get(pair, never)) | standing.get(pair, never)
        for pair, force in forces.items()
    }
    for hole, peg, flags in on_pegs:
        if around_standing(rollout.world.thing(thing_of(peg))):
            first, second = sorted((thing_of(hole), peg))
            touching[first, second] = touching.get((first, second), never) | flags
    return [
        state("soma:ContactState", span, {"a": a, "b": b})
        for (a, b), flags in pressed_on(touching, rollout).items()
        for span in spans(flags, rollout.times)
    ]


def _contents(rollout: Rollout) -> list[Event]:
    """Containment states, one for each vessel that holds a large enough share of the loose contents of a run
    (HELD)."""
    return [
        state("soma:ContainmentState", span, {"container": vessel, "content": contents_of(thing)})
        for thing, grains in rollout.grains.items()
        for vessel, count in where(rollout, thing).items()
        for span in spans(hysteresis(count / grains.shape[1], *HELD), rollout.times)
    ]


def _snapped(states: tuple[Event, ...], times: Floats) -> list[Event]:
    """Move starts and ends of states to the earliest start or end of any state, or to the recording's start, within
    SNAP before them.

    Both are one instant; the gap would otherwise become an action of a few samples.
    """
    instants: dict[float, float] = {}
    first, last = float(times[0]), float(times[-1])
    for time in sorted({t for s in states for t in (s.start, s.end)}):
        first = time if time - first > SNAP and time <= last else first
        instants[time] = time if time > last else first
    moved = (replace(s, start=instants[s.start], end=instants[s.end]) for s in states)
    return [s for s in moved if s.start < s.end]


def _numbered(states: list[Event]) -> tuple[Event, ...]:
    """States sorted by start, with ids that name class and number: "grasp_1"."""
    counts: dict[str, int] = defaultdict(int)
    found = []
    for s in sorted(states, key=lambda e: (e.start, e.end, e.type, sorted(e.roles.items()))):
        word = s.type.split(":")[1].removesuffix("State").lower()
        counts[word] += 1
        found.append(Event(f"{word}_{counts[word]}", s.type, s.kind, s.start, s.end, s.roles))
    return tuple(found)
