"""Loose contents in recordings: many similar things that stay in a vessel, or lie on a moved thing, become one entity.

Grains are recorded one by one, and nobody handles a grain. ``contents(cup)`` stands for those that were in the cup at first;
``ContainmentState`` says in which vessels they are, and the extra ``count:contents(cup):bowl`` how many, at each instant of
the extra ``times``.
"""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from itertools import pairwise

import numpy as np
from msgspec.structs import replace
from numpy.typing import NDArray

from cramlite.model import Entity, Episode, Event, Floats, Repair, Value

from .co_motion import STEP, TRAVEL, Grid, carried_spans, travel
from .signals import hysteresis, runs

#: So many things alike are contents; two cups on a table are two cups.
MANY = 3
#: What is this near to a vessel's origin is within it [m], where the vessel's size is not known: tableware is 0.2 m wide.
WITHIN = 0.12
#: Grains that a recorder lets fall into a vessel at the start are in it by then [s].
SETTLED = 3.0
#: A place is counted when it was kept this long [s]: a grain that falls past a bowl is not in it.
LASTING = 0.3
#: A thing up to this size sticks to a hand [m]: beans and pasta are 0.02 m long, what people pick singly is mostly larger.
GRAIN = 0.02
#: Share of its grains that a vessel must have to hold the contents, and to keep holding them (as ``detect.HELD``).
HELD = (0.1, 0.05)


class Loose(Value):
    """Contents of one vessel.

    Args:
        name: of the entity, e.g. "contents(cup)".
        members: the things alike.
        where: vessel -> how many are in it, at each time of the grid.
    """

    name: str
    members: tuple[str, ...]
    where: dict[str, Floats]


def contents_named(vessel: str) -> str:
    """Return the entity name of the contents that are in a vessel at the start."""
    return f"contents({vessel})"


def alike(name: str) -> str:
    """Return the common part of the names of similar things: "particle12" and "Particle_C_3" without the number."""
    return re.sub(r"[\W_]*\d+$", "", name)


def find_contents(episode: Episode, grid: Grid, things: Sequence[str], hands: Sequence[str]) -> tuple[Loose, ...]:
    """Find loose contents: at least ``MANY`` similar things that start in one vessel, and that no hand moves alone.

    A small thing that a hand moves alone is contents, too, where a hand carries a vessel with ``MANY`` others of its kind:
    it sticks to the hand.

    Args:
        things: frames that are neither hands nor parts.
        hands: who may take one of them out.
    """
    many = _many_alike(episode, grid, things)
    vessels = [n for n in things if n not in many]
    if not many or not vessels:
        return ()
    inside = {n: _vessel_of(episode, grid, n, vessels) for n in sorted(many)}
    first = {n: vessels[v] for n, at in inside.items() if (v := _first_vessel(at)) >= 0}
    out = {n for n in inside if any(_taken_out(grid, n, inside[n], vessels, hand) for hand in hands)}
    found = {k: m for k, m in _grouped(first, out).items() if len(m) >= MANY}
    for name in sorted(n for n in out if _small(episode, n)):
        carried = [v for v, kind in found if kind == alike(name) and any(carried_spans(grid, v, h) for h in hands)]
        if carried:
            found.setdefault((first.get(name, carried[0]), alike(name)), []).append(name)
    joined: dict[str, list[str]] = defaultdict(list)
    for (vessel, _), members in found.items():
        joined[vessel] += members
    return tuple(_loose(vessel, members, inside, vessels) for vessel, members in joined.items())


def _many_alike(episode: Episode, grid: Grid, things: Sequence[str]) -> set[str]:
    """Names of the things of which there are at least ``MANY`` with the same common part of the name.

    A kind is left out if one of it is a vessel that holds ``MANY`` things of a more numerous kind.
    """
    groups: dict[str, list[str]] = defaultdict(list)
    for name in things:
        groups[alike(name)].append(name)
    kinds = sorted((m for m in groups.values() if len(m) >= MANY), key=len)
    return {n for k, m in enumerate(kinds) if not any(_hold(episode, grid, m, o) for o in kinds[k + 1 :]) for n in m}


def _hold(episode: Episode, grid: Grid, vessels: list[str], others: list[str]) -> bool:
    """Whether one of several similar vessels holds at least ``MANY`` of some things at the start, which are more
    numerous than the vessels."""
    if len(others) <= len(vessels):
        return False
    at = [_first_vessel(_vessel_of(episode, grid, n, vessels)) for n in others]
    return any(at.count(k) >= MANY for k in range(len(vessels)))


def _first_vessel(at: NDArray[np.intp]) -> int:
    """Index of the first vessel that a thing is in while things settle after the start; -1 if it is in none."""
    return next((int(v) for v in at[: round(SETTLED / STEP)] if v >= 0), -1)


def _grouped(first: Mapping[str, str], out: set[str]) -> dict[tuple[str, str], list[str]]:
    """Things that no hand takes out of their vessel, grouped by the vessel that they start in and the common
    part of their names."""
    found: dict[tuple[str, str], list[str]] = defaultdict(list)
    for name, vessel in first.items():
        if name not in out:
            found[vessel, alike(name)].append(name)
    return dict(found)


def _small(episode: Episode, name: str) -> bool:
    """Whether a thing is small enough to stick to a hand; True if its size is unknown."""
    entity = episode.known(name)
    return entity is None or entity.size is None or max(entity.size) <= GRAIN


def _taken_out(grid: Grid, name: str, at: NDArray[np.intp], vessels: list[str], hand: str) -> bool:
    """Whether a hand moves a thing while it does not move the vessel that the thing is in, or was in before."""
    spans = carried_spans(grid, name, hand) if travel(grid.poses[name]) > TRAVEL else []
    for start, end in spans:
        inside = at[: start + 1][at[: start + 1] >= 0]
        vessel = vessels[int(inside[-1])] if len(inside) else None
        along = carried_spans(grid, vessel, hand) if vessel is not None else []
        if not any(s < end and start < e for s, e in along):
            return True
    return False


def carried_along(episode: Episode, grid: Grid, carrier: str, members: Iterable[str], things: Iterable[str]) -> Loose:
    """Return the things on a moved carrier as its loose contents; a thing is content while it is no farther from the carrier than at first.

    Args:
        things: frames that may be vessels, too.
    """
    names = tuple(sorted(members))
    vessels = [carrier, *(n for n in things if n not in (carrier, *names))]
    inside = {}
    for name in names:
        gap = grid.distance(name, carrier)
        inside[name] = np.where(gap < gap[0] + TRAVEL, 0, _vessel_of(episode, grid, name, vessels))
    return _loose(carrier, list(names), inside, vessels)


def _vessel_of(episode: Episode, grid: Grid, name: str, vessels: list[str]) -> NDArray[np.intp]:
    """Index, in ``vessels``, of the vessel that a thing is in at each time; -1 where it is in none."""
    gaps = np.array([grid.distance(name, v) - _radius(episode, v) for v in vessels])
    nearest = np.where(gaps.min(axis=0) < 0, gaps.argmin(axis=0), -1)
    lasting = nearest.copy()
    for start, end in _pieces(nearest):
        if (end - start) * STEP < LASTING and start > 0:
            lasting[start:end] = lasting[start - 1]
    return np.asarray(lasting)


def _radius(episode: Episode, vessel: str) -> float:
    """Distance from a vessel's origin within which things are in it [m]: half its diagonal, if its size is
    known."""
    entity = episode.known(vessel)
    return WITHIN if entity is None or entity.size is None else float(np.linalg.norm(entity.size)) / 2


def _pieces(values: NDArray[np.intp]) -> list[tuple[int, int]]:
    cuts = [0, *(np.flatnonzero(np.diff(values)) + 1).tolist(), len(values)]
    return list(pairwise(cuts))


def _loose(vessel: str, members: list[str], inside: Mapping[str, NDArray[np.intp]], vessels: list[str]) -> Loose:
    rows = np.array([inside[m] for m in members])
    where = {v: np.sum(rows == k, axis=0).astype(float) for k, v in enumerate(vessels) if (rows == k).any()}
    return Loose(contents_named(vessel), tuple(members), where)


def with_contents(episode: Episode, grid: Grid, found: Iterable[Loose]) -> Episode:
    """Return the episode in which one entity for each vessel's contents, with its states and its numbers of
    pieces, replaces the single pieces."""
    listed = tuple(found)
    gone = {m for one in listed for m in one.members}
    if not listed:
        return episode
    entities = tuple(e for e in episode.entities if e.name not in gone)
    made = tuple(_entity(one, episode) for one in listed)
    span = (float(grid.times[0]), float(grid.times[-1]))
    counts = {f"count:{one.name}:{v}": n for one in listed for v, n in one.where.items()}
    return replace(
        episode,
        entities=(*entities, *made),
        events=(*episode.events, *(e for one in listed for e in _states(one, grid))),
        tracks={n: t for n, t in episode.tracks.items() if n not in gone},
        repairs=(*episode.repairs, *(_repair(one, span) for one in listed)),
        extras={**_on_grid(episode, grid), **counts, "times": grid.times},
    )


def _on_grid(episode: Episode, grid: Grid) -> dict[str, Floats]:
    """Resample the extra arrays of an episode, such as wrenches, on the time grid: the last row at or before
    each time."""
    times = episode.extras.get("times")
    if times is None or not len(times):
        return dict(episode.extras)
    at = np.clip(np.searchsorted(times, grid.times, side="right") - 1, 0, None)
    return {k: v[at] if len(v) == len(times) else v for k, v in episode.extras.items()}


def _entity(one: Loose, episode: Episode) -> Entity:
    types = {t for m in one.members if (e := episode.known(m)) is not None for t in e.types}
    return Entity(one.name, (*sorted(types), "dul:Substance"), properties={"count": float(len(one.members))})


def _states(one: Loose, grid: Grid) -> list[Event]:
    return [
        Event("", "soma:ContainmentState", "state", grid.time(s), grid.time(e), {"container": v, "content": one.name}, True)
        for v, count in one.where.items()
        for s, e in runs(hysteresis(count / len(one.members), *HELD))
    ]


def _repair(one: Loose, span: tuple[float, float]) -> Repair:
    shown = ", ".join(one.members[:3]) + (", ..." if len(one.members) > 3 else "")
    ends = ", ".join(f"{count[0]:g} then {count[-1]:g} in {v}" for v, count in one.where.items())
    beside = len(one.members) - sum(count[-1] for count in one.where.values())
    why = f"these things stay within a vessel: {ends}; at the end {beside:g} are beside all vessels"
    return Repair(f"read {len(one.members)} things ({shown}) as '{one.name}'", span, why)

