"""Repair of tracking dropouts: a thing is lost by the tracker, and found at the same place in the hand or the world.

A thing that is let go falls g t^2 / 2: 44 mm in 0.1 s, 0.44 m in 0.3 s. So a thing that is found again at its very
place in the hand was never let go; what was lost is the recording. The paper (Alt et al., KR 2023) lost one of 60
demonstrations to such a glitch. Two cases are told from real releases:

- *carried*: hand and thing have the same relative pose before and after, and the hand moved in between;
- *unsupported*: nothing at all touched, held or supported the thing in between, and it is where it was.

While a thing is gone, its states are continued, those with a partner that it left meanwhile until it moved away from it;
states that begin and end meanwhile are a phantom's, and its poses are those of the hand (or of rest). Each repair keeps what was recorded.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise

import numpy as np
from msgspec.structs import replace

from cramlite.model import Episode, Event, Floats, Pose, Repair, Track, Value

from ..tracks import compose

#: Longest absence [s]. In more time a hand can put a thing down, and take it up as before.
VANISH = 1.0
#: Shortest one looked at [s]; what is shorter than a frame of a 100 Hz recorder needs no reason.
MOMENT = 0.01
#: Poses are compared this long before and after the absence [s]: at its edges the tracker is unsure.
MARGIN = 0.05
#: Back at the same place: within this [m] and [rad]. Hands are compliant: 1.5 cm in a real recording.
NEAR, TURNED = 0.025, 0.35
#: A thing that moved less than this [m] from what it touched touches it still.
STAYED = 0.005
#: A hand that moved this far [m] would have left a thing behind that it no longer held.
MOVED = 0.02


class Dropout(Value):
    """Tracking dropout of a thing.

    Args:
        thing: its name.
        start, end: [s].
        hand: what carried it; None if it was at rest.
        place: its pose, in the hand, or in the world.
    """

    thing: str
    start: float
    end: float
    hand: str | None
    place: Pose


def bridge_dropouts(episode: Episode, longest: float = VANISH) -> Episode:
    """Bridge the tracking dropouts of an episode.

    Args:
        episode: with states and tracks.
        longest: absences up to this long are repaired [s].

    Returns:
        A new episode; each change is in ``repairs`` and can be undone.
    """
    for absence in sorted(_absences(episode, longest), key=lambda a: (a.start, a.end, a.thing)):
        episode = _without(absence, episode)
    return episode


def _absences(episode: Episode, longest: float) -> Iterator[Dropout]:
    for thing in [n for n in episode.tracks if n != episode.effector and episode.whole(n) == n]:
        mine = [e for e in episode.of("state") if thing in _wholes(e, episode)]
        for start, end, hand in _losses(mine, thing, episode, longest):
            found = _absence(episode, thing, hand, start, end)
            if found is not None:
                yield found


def _wholes(event: Event, episode: Episode) -> set[str]:
    """Things that take part in an event; a part counts as the thing that it belongs to."""
    return {episode.whole(filler) for filler in event.roles.values()}


def _losses(
    mine: list[Event], thing: str, episode: Episode, longest: float
) -> Iterator[tuple[float, float, str | None]]:
    """Yield start, end and hand of each pause, up to ``longest`` [s], between grasps of a thing by one hand, or between
    contacts of the thing with that hand.

    With hand None, all states of the thing pause.
    """
    seen = set()
    hands = {h for e in mine for h in _hands(e, episode)} - {thing}
    groups: list[tuple[str | None, list[Event]]] = [
        (hand, [e for e in mine if e.type == type_ and hand in _wholes(e, episode)])
        for hand in sorted(hands)
        for type_ in ("cram:GraspState", "soma:ContactState")
    ]
    for hand, group in [*groups, (None, mine)]:
        for start, end in _pauses(group):
            if MOMENT < end - start <= longest and (start, end, hand) not in seen:
                seen.add((start, end, hand))
                yield start, end, hand


def _hands(event: Event, episode: Episode) -> set[str]:
    gripper = {event.roles["gripper"]} if "gripper" in event.roles else set()
    return gripper | ({episode.effector} & _wholes(event, episode) if episode.effector else set())


def _pauses(group: list[Event]) -> Iterator[tuple[float, float]]:
    """Pauses: intervals between a list of states in which none of the states holds."""
    end = float("inf")
    for event in sorted(group, key=lambda e: e.start):
        if event.start > end:
            yield end, event.start
        end = event.end if end == float("inf") else max(end, event.end)


def _absence(episode: Episode, thing: str, hand: str | None, start: float, end: float) -> Dropout | None:
    """Return the tracking dropout in an interval, if the thing's pose in the hand or in the world is the same
    before and after it.

    The result is None if the thing may really have been let go.
    """
    before, after = start - MARGIN, end + MARGIN
    if hand is not None:
        at = [(episode.pose_at(hand, t), episode.pose_at(thing, t)) for t in (before, after)]
        if any(h is None or b is None for h, b in at):
            return None
        places = [h.inverse() * b for h, b in at]  # type: ignore[union-attr, operator]
        moved = _travel(episode.tracks.get(hand), before, after)
        return Dropout(thing, start, end, hand, places[0]) if moved > MOVED and _same(*places) else None
    rest = [episode.pose_at(thing, t) for t in (before, after)]
    if rest[0] is None or rest[1] is None or not _same(rest[0], rest[1]):
        return None
    return Dropout(thing, start, end, None, rest[0])


def _same(a: Pose, b: Pose) -> bool:
    metres, radians = a.distance(b)
    return metres < NEAR and radians < TURNED


def _travel(track: Track | None, start: float, end: float) -> float:
    """Largest distance of a track from its first position [m]."""
    if track is None:
        return 0.0
    rows = track.poses[(track.times >= start) & (track.times <= end), :3]
    return float(np.max(np.linalg.norm(rows - rows[0], axis=1))) if len(rows) else 0.0


def _without(absence: Dropout, episode: Episode) -> Episode:
    """Repair a dropout: continue the thing's states, drop spurious states that began and ended meanwhile, and
    correct the thing's poses."""
    mine = [e for e in episode.of("state") if absence.thing in _wholes(e, episode)]
    start, end = absence.start - MARGIN, absence.end + MARGIN
    cut_short = _cut_short(absence, mine)
    phantom = [e for e in mine if start < e.start and e.end < end and e.id not in cut_short]
    joined = [(a, b) for a, b in _pairs([e for e in mine if e not in phantom]) if start <= a.end < b.start <= end]
    if not joined:
        return episode
    track = _carried(absence, episode)
    mended = replace(episode, tracks=episode.tracks | ({absence.thing: track} if track else {}))
    cut = [e for e in mine if abs(e.end - absence.start) < MOMENT and not any(e in p for p in (phantom, *joined))]
    lasting = [(e, until) for e in cut if (until := _stays(absence, e, mended)) > e.end]
    removed = (*phantom, *(e for pair in joined for e in pair), *(e for e, _ in lasting))
    added = (
        *(replace(a, end=max(a.end, b.end), inferred=a.inferred or b.inferred) for a, b in joined),
        *(replace(e, end=until, inferred=True) for e, until in lasting),
    )
    repair = _repair(absence, removed, added, len(phantom), episode.tracks[absence.thing] if track else None)
    events = [e for e in episode.events if e not in removed] + list(added)
    events.sort(key=lambda e: (e.start, e.end, e.id))
    return replace(mended, events=tuple(events), repairs=(*episode.repairs, repair))


def _cut_short(absence: Dropout, mine: list[Event]) -> set[str]:
    """Ids of the states that are halves of one state which a dropout cut in two; they are kept, however short."""
    pairs = ((a, b) for a, b in _pairs(mine) if a.start < absence.start and b.end > absence.end)
    return {e.id for a, b in pairs if abs(a.end - absence.start) < MOMENT for e in (a, b)}


def _stays(absence: Dropout, event: Event, mended: Episode) -> float:
    """Return the time [s] until which a state really lasted, if the recording ends it because its thing was
    lost by tracking.

    It is read from the thing's corrected poses.
    """
    partner = next((w for w in _wholes(event, mended) if w != absence.thing), absence.thing)
    times = [t for t in mended.tracks[absence.thing].times.tolist() if absence.start <= t < absence.end]
    until = event.end
    first = _between(mended, partner, absence.thing, absence.start - MARGIN)
    for time in times:
        now = _between(mended, partner, absence.thing, time)
        if first is None or now is None or first.distance(now)[0] > STAYED:
            return until
        until = time
    return until


def _between(episode: Episode, partner: str, thing: str, time: float) -> Pose | None:
    a, b = episode.pose_at(partner, time), episode.pose_at(thing, time)
    return None if a is None or b is None else a.inverse() * b


def _repair(
    absence: Dropout, removed: tuple[Event, ...], added: tuple[Event, ...], phantoms: int, track: Track | None
) -> Repair:
    carrier = f"its place in '{absence.hand}'" if absence.hand else "the place where it was, and nothing held it"
    what = f"'{absence.thing}' vanished for {absence.end - absence.start:.3f} s: {_names(added)} continued"
    what += f", {phantoms} spurious states meanwhile dropped" if phantoms else ""
    why = f"the vanished thing was seen again within {NEAR * 1000:.0f} mm of {carrier}"
    when = (absence.start, absence.end)
    poses = (absence.thing, _recorded(track, *when)) if track else ()
    return Repair(what, when, why, removed, added, *poses)


def _names(events: tuple[Event, ...]) -> str:
    return ", ".join(f"{e.type} of {' and '.join(e.roles.values())}" for e in events)


def _pairs(events: list[Event]) -> Iterator[tuple[Event, Event]]:
    """Consecutive states that differ in nothing but their times."""
    groups: dict[object, list[Event]] = {}
    for event in sorted(events, key=lambda e: e.start):
        groups.setdefault(signature(event), []).append(event)
    for group in groups.values():
        yield from pairwise(group)


def signature(event: Event) -> tuple[object, ...]:
    """Return class and roles of a state; the two sides of a contact are interchangeable."""
    symmetric = event.type == "soma:ContactState"
    return event.type, tuple(sorted(event.roles.values()) if symmetric else sorted(event.roles.items()))


def _recorded(track: Track, start: float, end: float) -> tuple[tuple[float, ...], ...]:
    within = (track.times >= start) & (track.times < end)
    return tuple(map(tuple, np.column_stack([track.times, track.poses])[within].tolist()))


def _carried(absence: Dropout, episode: Episode) -> Track | None:
    """Return a thing's track with expected poses for the time of a dropout; None if the recorded ones agree
    with them."""
    track = episode.tracks[absence.thing]
    within = (track.times >= absence.start) & (track.times < absence.end)
    if absence.hand is None:
        times = track.times[within]
        expected = np.tile([*absence.place.position, *absence.place.quaternion], (len(times), 1))
    else:
        hand = episode.tracks[absence.hand]
        moves = (hand.times >= absence.start) & (hand.times < absence.end)
        times = hand.times[moves]
        place = np.array([[*absence.place.position, *absence.place.quaternion]])
        expected = compose(hand.poses[moves], np.repeat(place, len(times), axis=0))
    if _agree(track, times, expected):
        return None
    return spliced(track, (absence.start, absence.end), np.column_stack([times, expected]))


def _agree(track: Track, times: Floats, expected: Floats) -> bool:
    held = track.poses[np.clip(np.searchsorted(track.times, times, side="right") - 1, 0, None)]
    return bool(np.all(np.linalg.norm(held[:, :3] - expected[:, :3], axis=1) < NEAR))


def spliced(track: Track, when: tuple[float, float], rows: Floats) -> Track:
    """Return a track whose rows (time, pose) within an interval, end exclusive, are replaced by others."""
    first, last = (int(np.searchsorted(track.times, t)) for t in when)
    rows = rows.reshape(-1, 8)
    times = np.concatenate([track.times[:first], rows[:, 0], track.times[last:]])
    return Track(times, np.concatenate([track.poses[:first], rows[:, 1:], track.poses[last:]]))
