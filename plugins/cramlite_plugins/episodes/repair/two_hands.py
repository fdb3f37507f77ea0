"""Conversion of two-handed demonstrations to one hand: the one that acts.

A robot with one arm has nobody to hand over to. What a person passes from hand to hand is held all along, so both are one
effector for it: first the hand that gives, and from when it lets go the one that took. What either does beside that
remains what another hand does, and so does everything a person's other hand does on its own. A plugin of its own: a robot
with two arms can block it without losing the repair of recorders' defects.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterable, Iterator, Sequence
from itertools import pairwise

import numpy as np
from msgspec.structs import replace

from cramlite.model import EntityName, Episode, Event, Floats, Repair, Track, Value, thing_of
from cramlite.plugin import EpisodeRepair, hookimpl

from .dropouts import signature

#: Who takes over holds on for longer than the other one, by this at least [s]; else both only put it down together.
HELD_ON = 0.1


class Handover(Value):
    """Passing of a thing between two hands of a person, which both hold it for a while.

    Args:
        thing: that is handed over.
        given, taken: the grasps of the hand that gives and of the one that takes.
    """

    thing: str
    given: Event
    taken: Event

    @property
    def time(self) -> float:
        """Time at which the hand that gives lets go [s]."""
        return self.given.end


@hookimpl
def episode_repairs() -> Iterable[EpisodeRepair]:
    """Declare the repair of demonstrations with two hands."""
    return [EpisodeRepair("two hands", 30, one_handed)]


def one_handed(episode: Episode) -> Episode:
    """Merge hands that pass a thing to each other: together they become the episode's one effector.

    Returns:
        The very episode, if nothing is handed over; else a new one. The repair that it lists holds the states as they
        were recorded; tracks of hands are exchanged, and arrays that were recorded of one hand are left out.
    """
    chain = _chain(list(handovers(episode)))
    if not chain or episode.effector is None:
        return episode
    acting = _Acting(episode.effector, chain)
    states = [e for e in episode.events if e.kind == "state"]
    changed = {id(e): list(acting.pieces(e)) for e in states}
    joined = _joined([p for e in states for p in changed[id(e)] if not acting.is_passing(p)])
    others = [e for e in episode.events if e.kind != "state"]
    removed, added = (tuple(e for e in a if e not in b) for a, b in ((states, joined), (joined, states)))
    names = " and ".join(f"'{h}'" for h in sorted(acting.hands))
    why = ", ".join(f"'{h.thing}' at {h.time:.2f} s" for h in chain) + " passes from one to the other"
    repair = Repair(f"read {names} as one hand", (chain[0].taken.start, chain[-1].time), why, removed, added)
    tracks = episode.tracks | dict(_tracks(episode, acting))
    return replace(
        episode, events=tuple(sorted((*others, *joined), key=lambda e: (e.start, e.end, e.id))), tracks=tracks,
        repairs=(*episode.repairs, repair), extras=_extras(episode, tracks, acting),
    )  # fmt: skip


def handovers(episode: Episode) -> Iterator[Handover]:
    """Yield the handovers: each thing that one hand grasps before another hand, which then holds the thing alone."""
    grasps = [e for e in episode.of("state", ["cram:GraspState"]) if {"gripper", "object"} <= e.roles.keys()]
    for given in grasps:
        for taken in grasps:
            same = given.roles["object"] == taken.roles["object"] and given.roles["gripper"] != taken.roles["gripper"]
            if same and given.start < taken.start < given.end < taken.end - HELD_ON:
                yield Handover(given.roles["object"], given, taken)


def _chain(found: Sequence[Handover]) -> list[Handover]:
    """Return the handovers that pass one thing from hand to hand: the hand that gives the thing is the one that took it in the handover
    before."""
    chain: list[Handover] = []
    for one in sorted(found, key=lambda h: h.time):
        if not chain or one.given.roles["gripper"] == chain[-1].taken.roles["gripper"]:
            chain.append(one)
    return chain


class _Acting:
    """Hand that acts at each time of an episode in which hands pass a thing on.

    Args:
        name: of the effector of the episode.
        chain: handovers of one thing, in time order.
    """

    def __init__(self, name: str, chain: Sequence[Handover]) -> None:
        self.name, self.chain = name, chain
        self.times = [h.time for h in chain]
        self.order = [chain[0].given.roles["gripper"], *(h.taken.roles["gripper"] for h in chain)]
        self.hands = {name, *self.order}

    def at(self, time: float) -> str:
        return self.order[bisect_right(self.times, time)]

    def called(self, entity: str, time: float) -> str:
        """Return an entity's name after the hand that acts at ``time`` and the episode's effector have swapped their names."""
        name, mine = EntityName.parse(entity), self.at(time)
        return str(replace(name, thing={mine: self.name, self.name: mine}.get(name.thing, name.thing)))

    def pieces(self, event: Event) -> Iterator[Event]:
        """Yield the pieces of a state, cut where another hand begins to act; in each, the acting hand has
        the effector's name."""
        cuts = [event.start, *(t for t in self.times if event.start < t < event.end), event.end]
        for start, end in pairwise(cuts):
            roles = {r: self.called(filler, start) for r, filler in event.roles.items()}
            yield replace(event, start=start, end=end, roles=roles)

    def is_passing(self, event: Event) -> bool:
        """Whether a state, during a handover, involves the thing handed over and another hand than the
        episode's effector, but not the effector."""
        who = {thing_of(f) for f in event.roles.values()}
        hands = who & self.hands
        return bool(hands) and self.name not in hands and any(
            h.thing in who and h.given.start < event.end and event.start < h.taken.end for h in self.chain
        )  # fmt: skip


def _joined(events: Sequence[Event]) -> list[Event]:
    """Events in which adjoining or overlapping states of the same class and roles are joined into one."""
    found: list[Event] = []
    for event in sorted(events, key=lambda e: (e.start, e.end, e.id)):
        at = next((k for k, e in enumerate(found) if signature(e) == signature(event) and event.start <= e.end), None)
        if at is None:
            found.append(event)
        else:
            found[at] = replace(found[at], end=max(found[at].end, event.end))
    return _renamed(found)


def _renamed(events: Sequence[Event]) -> list[Event]:
    """Events with unique ids: repeated ids get a number."""
    ids: set[str] = set()
    found = []
    for event in events:
        name, k = event.id, 2
        while name in ids:
            name, k = f"{event.id}_{k}", k + 1
        ids.add(name)
        found.append(replace(event, id=name))
    return found


def _tracks(episode: Episode, acting: _Acting) -> Iterator[tuple[str, Track]]:
    """Tracks of hands and finger tips under their names in the converted episode, joined from the hands that
    act in turn."""
    frames = [n for n in episode.tracks if thing_of(n) in acting.hands]
    begin, end = episode.span
    bounds = [begin, *acting.times, float(np.nextafter(end, np.inf))]
    for name in frames:
        pieces = []
        for start, until in pairwise(bounds):
            source = episode.tracks.get(acting.called(name, start))
            if source is not None and len(source.times):
                pieces.append(_cut(source, start, until))
        if pieces:
            yield name, Track(np.concatenate([p.times for p in pieces]), np.concatenate([p.poses for p in pieces]))


def _cut(track: Track, start: float, until: float) -> Track:
    """Track within [start, until), beginning with its pose at ``start``."""
    within = (track.times > start) & (track.times < until)
    here = track.at(start)
    first = np.array([*here.position, *here.quaternion])
    return Track(np.concatenate([[start], track.times[within]]), np.vstack([first, track.poses[within]]))


def _extras(episode: Episode, tracks: dict[str, Track], acting: _Acting) -> dict[str, Floats]:
    """Extras of the converted episode: the recorded ones without the wrench; the opening is the distance of
    the acting hand's finger tips [m].

    The opening stays constant during a handover, since fingers that take over the thing neither open nor
    close the gripper.
    """
    extras = {k: v for k, v in episode.extras.items() if k not in ("opening", "wrench")}
    times = extras.get("times")
    tips = [tracks[n] for n in tracks if thing_of(n) == acting.name != n][:2]
    if times is None or len(tips) < 2:
        return extras
    left, right = (t.poses[np.maximum(np.searchsorted(t.times, times, side="right") - 1, 0), :3] for t in tips)
    opening: Floats = np.linalg.norm(left - right, axis=1)
    for one in acting.chain:
        held = (times >= one.time) & (times < one.taken.end)
        opening[held] = opening[max(int(np.searchsorted(times, one.time)) - 1, 0)]
    return extras | {"opening": opening}
