"""Event detection from poses alone, for recordings without contacts.

Without contacts, a grasp can only be concluded: a thing that moves, and keeps its place in a moving hand, is held by it.
Of several that move with one hand, one is held and the others lie on it or in it. From the held thing's path follow when it
left what it stood on and when it stood again, swings and tilts; from shapes, where they are known, what a thing at rest
stands on. Every event is marked ``inferred``. The actions are what lies between the boundaries of the states; only what no
state shows, shaking and tilting, is an action here.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Sequence
from itertools import pairwise

import numpy as np
from msgspec.structs import replace

from cramlite.model import Entity, Episode, Event, Floats, Repair, Track

from .co_motion import STEP, Grid, carried_spans, grid_of, travel
from .gestures import shaking, tilting
from .inferred_grasps import InferredGrasp, grasps_of_hand, grasps_of_unseen_hand, overlap
from .loose_things import Loose, carried_along, find_contents, with_contents
from .plausible import too_fast, without_pauses
from .standing import resting

#: Stands again where it stood: seen from above within the first, in height within the second [m].
SAME_PLACE = (0.4, 0.03)
#: Who holds a thing this much longer than another hand takes it over, else it steadies it [s].
HANDED_OVER = 0.5

#: The hand that acts where none that was recorded moves farther than this [m].
NOBODY, IDLE = "unseen_hand", 0.1
#: Longest recording looked at [s]: a grid of STEP over six hours takes 0.2 GB. One wrong stamp can make a recording
#: of 50 years out of one of a minute.
LONGEST = 6 * 3600.0


def infer(episode: Episode) -> Episode:
    """Infer the events of an episode from its tracks; an episode with states, or without a hand that moves
    things, is unchanged.

    Adds ContactState and GraspState of hands with what moves along with them; SupportState, ContactState and
    ContainmentState of things at rest; contents in place of many things alike; and the actions cram:Shaking and
    soma:Pouring (tilting). A thing at rest stands on something: where no shape says on what, on an entity ``support(thing)``.
    """
    if episode.of("state") or not episode.tracks:
        return episode
    episode = without_pauses(episode)
    first, last = episode.span
    if last - first > LONGEST:
        why = f"the recording lasts {last - first:.0f} s, more than {LONGEST:.0f} s; is a time stamp wrong?"
        return replace(episode, repairs=(*episode.repairs, Repair("no events were inferred", (first, last), why)))
    grid = _grid(episode)
    if doubt := too_fast(hands_of(episode), grid):
        return replace(episode, repairs=(*episode.repairs, Repair("no events were inferred", (first, last), doubt)))
    return _inferred(episode if hands_of(episode) else _with_carrier(episode, grid), grid)


def with_grasps(episode: Episode) -> Episode:
    """Add inferred grasps to an episode whose recorded states contain no grasp; unchanged if no thing moves
    along with a hand."""
    first, last = episode.span
    states = episode.of("state")
    if not states or any(e.type == "cram:GraspState" for e in states) or not episode.tracks or last - first > LONGEST:
        return episode
    grid = _grid(episode)
    hands = [h for h in hands_of(episode) if h in episode.tracks]
    moving = [n for n, t in episode.tracks.items() if n not in hands and episode.whole(n) == n and len(t.times) > 1]
    grips = [g for hand in hands for g in grasps_of_hand(episode, grid, hand, moving)[0]]
    grasps = [e for e in _of_grips(grips, grid) if e.type == "cram:GraspState"]
    if not grasps:
        return episode
    added = tuple(replace(e, id=f"inferred_{k}", end=min(e.end, last)) for k, e in enumerate(grasps, 1))
    repair = Repair(f"inferred {len(added)} grasps", (first, last), "none was recorded, and things move along with a hand", (), added)
    events = tuple(sorted([*episode.events, *added], key=lambda e: (e.start, e.end, e.type)))
    return replace(episode, events=events, effector=_acting(episode, grips, grid), repairs=(*episode.repairs, repair))


def _with_carrier(episode: Episode, grid: Grid) -> Episode:
    """Declare a frame to be the hand of an episode that names none: the frame that carries other things and travels
    farthest alone."""
    free = [n for n, t in episode.tracks.items() if episode.whole(n) == n and len(t.times) > 1]
    alone = {n: w for n in free if (w := _alone(grid, n, [o for o in free if o != n])) > IDLE}
    if not alone:
        return episode
    hand = max(sorted(alone), key=lambda n: alone[n])
    why = "nothing is named like a hand, and it moves about alone and takes other things along"
    entities = tuple(replace(e, types=("soma:Hand",)) if e.name == hand else e for e in episode.entities)
    repair = Repair(f"read '{hand}' as a hand", episode.span, why)
    return replace(episode, entities=entities, effector=hand, repairs=(*episode.repairs, repair))


def _alone(grid: Grid, name: str, others: Sequence[str]) -> float:
    """Path length [m] that a frame travels alone before it first carries another thing, or after it last did
    so, whichever is shorter; 0 if it carries none."""
    taken = [span for o in others for span in carried_spans(grid, o, name)]
    if not taken:
        return 0.0
    steps = np.linalg.norm(np.diff(grid.poses[name][:, :3], axis=0), axis=1)
    return float(min(steps[: min(s for s, _ in taken)].sum(), steps[max(e for _, e in taken) :].sum()))


def hands_of(episode: Episode) -> tuple[str, ...]:
    """Return the effector and all other entities of class soma:Hand that are not parts of an entity."""
    others = (e.name for e in episode.entities if "soma:Hand" in e.types and e.part_of is None)
    return tuple(dict.fromkeys([*([episode.effector] if episode.effector else []), *others]))


def _grid(episode: Episode) -> Grid:
    """Return all tracks on one time grid; things whose pose was recorded only once have constant poses."""
    grid = grid_of(episode.tracks)
    still = {e.name: e.pose for e in episode.entities if e.part_of is None and e.name not in grid.poses and e.pose is not None}
    poses = {n: np.tile([*p.position, *p.quaternion], (len(grid.times), 1)) for n, p in still.items()}
    return Grid(grid.times, {**grid.poses, **poses})


def _inferred(episode: Episode, grid: Grid) -> Episode:
    hands = [h for h in hands_of(episode) if h in episode.tracks]
    things = [n for n in grid.poses if n not in hands and episode.whole(n) == n]
    loose = find_contents(episode, grid, things, hands)
    grains = {m for one in loose for m in one.members}
    moving = [n for n in things if n not in grains and n in episode.tracks and len(episode.tracks[n].times) > 1]
    grips, riders = _all_grips(episode, grid, hands, moving)
    episode = _with_nobody(episode, grips)
    handled = {g.thing for g in grips}
    vessels = [n for n in things if n not in grains.union(*riders.values())]
    bound = handled | {n for n in moving if _on_joint(episode, n)}
    laid = [carried_along(episode, grid, c, r, vessels) for c, names in riders.items() if (r := names - bound)]
    last = episode.span[1]
    episode = with_contents(episode, grid, _merged([*loose, *laid]))
    acting = _acting(episode, grips, grid)
    steadied = [g for g in grips if g.hand != acting and any(_steadies(g, m) for m in grips if m.hand == acting)]
    doing = [g for g in grips if g not in steadied]
    episode = replace(episode, repairs=(*episode.repairs, *(_left_out(g, grid) for g in steadied)))
    episode, doing = _one_after_the_other(episode, doing, acting, grid)
    events = [*_of_grips(doing, grid), *_labels(doing, grid)]
    supports, grounds = _standing(episode, doing, grid)
    events = sorted([*episode.events, *events, *supports], key=lambda e: (e.start, e.end, e.type))
    numbered = tuple(replace(e, id=f"inferred_{k}", end=min(e.end, last)) for k, e in enumerate(events, 1))
    return replace(episode, entities=(*episode.entities, *grounds), events=numbered, effector=acting)


def _all_grips(
    episode: Episode, grid: Grid, hands: Sequence[str], moving: Sequence[str]
) -> tuple[list[InferredGrasp], dict[str, set[str]]]:
    """Grasps of all hands, those of recorded hands first; and the things that ride on each payload (payload
    -> names)."""
    grips: list[InferredGrasp] = []
    riders: dict[str, set[str]] = defaultdict(set)
    for hand in [*hands, None]:
        if hand is not None:
            held, along = grasps_of_hand(episode, grid, hand, moving)
        else:
            free = [n for n in moving if n not in {g.thing for g in grips} | set().union(*riders.values())]
            held, along = grasps_of_unseen_hand(episode, grid, _unseen_hand(episode, grid, hands), free)
        grips += held
        for carrier, names in along.items():
            riders[carrier] |= names
    return grips, riders


def _on_joint(episode: Episode, name: str) -> bool:
    """Whether a thing slides or turns on a joint, so that, when it moves along with another thing, it is mounted on
    that thing and not its contents."""
    entity = episode.known(name)
    return entity is not None and "joint_upper" in entity.properties


def _merged(found: Sequence[Loose]) -> list[Loose]:
    """Merge entries about the same loose contents into one, and add up their numbers of pieces in each vessel."""
    by_name: dict[str, Loose] = {}
    for one in found:
        other = by_name.get(one.name)
        if other is None:
            by_name[one.name] = one
            continue
        where = {v: one.where.get(v, 0.0) + other.where.get(v, 0.0) for v in {**one.where, **other.where}}
        by_name[one.name] = Loose(one.name, (*other.members, *one.members), where)  # type: ignore[arg-type]
    return list(by_name.values())


def _steadies(grip: InferredGrasp, acting: InferredGrasp) -> bool:
    """Whether the second hand only steadies the payload that the acting hand holds, and does not take it over."""
    both = overlap(grip.span, acting.span)
    return grip.thing == acting.thing and both > 0 and (grip.span[1] - grip.span[0]) - both < HANDED_OVER / STEP


def _left_out(grip: InferredGrasp, grid: Grid) -> Repair:
    events = tuple(_of_grips([grip], grid))
    when = (grid.time(grip.span[0]), grid.time(grip.span[1]))
    why = "it only steadies what the other hand holds; a robot with one arm does without"
    return Repair(f"left out that '{grip.hand}' holds '{grip.thing}'", when, why, removed=events)


def _one_after_the_other(
    episode: Episode, grips: list[InferredGrasp], acting: str | None, grid: Grid
) -> tuple[Episode, list[InferredGrasp]]:
    """Episode in which hands that take turns are read as one hand, and its grasps: the acting hand's track
    consists of the tracks of whichever hand is active."""
    mine = [g for g in grips if g.hand == acting]
    turns = [g for g in grips if g.hand == acting or not any(overlap(g.near, m.near) > 0 for m in mine)]
    turns.sort(key=lambda g: g.span)
    if len({g.hand for g in turns}) < 2 or any(overlap(a.near, b.near) > 0 for a, b in pairwise(turns)):
        return episode, grips
    middles = [grid.time((a.near[1] + b.near[0]) // 2) for a, b in pairwise(turns)]
    bounds = list(pairwise([-np.inf, *middles, np.inf]))
    tracks = [(episode.tracks[g.hand], a, b) for g, (a, b) in zip(turns, bounds, strict=True) if g.hand in episode.tracks]
    within = [(t, (t.times >= a) & (t.times < b)) for t, a, b in tracks]
    joined = Track(np.concatenate([t.times[w] for t, w in within]), np.concatenate([t.poses[w] for t, w in within]))
    names = " and ".join(f"'{h}'" for h in sorted({g.hand for g in turns}))
    why = "they hold things one after the other, never at once, and a robot with one arm can do so, too"
    repair = Repair(f"read {names} as one hand", (grid.time(turns[0].span[0]), grid.time(turns[-1].span[1])), why)
    episode = replace(episode, tracks={**episode.tracks, str(acting): joined}, repairs=(*episode.repairs, repair))
    return episode, [replace(g, hand=str(acting)) if g in turns else g for g in grips]


def _unseen_hand(episode: Episode, grid: Grid, tracked: Sequence[str]) -> str | None:
    """Return the hand that must have moved the things though its poses were not recorded; None if a recorded
    hand may have.

    Of several hands without poses a right one is taken; if there is none, and all recorded hands are idle, it
    is ``NOBODY``.
    """
    lost = sorted((h for h in hands_of(episode) if h not in tracked), key=_right_first)
    idle = all(travel(grid.poses[h]) < IDLE for h in tracked)
    return lost[0] if lost else NOBODY if idle else None


def _with_nobody(episode: Episode, held: Sequence[InferredGrasp]) -> Episode:
    if not any(g.hand == NOBODY for g in held):
        return episode
    why = "things rise and stay up, and no hand that was recorded moves"
    repairs = (*episode.repairs, Repair(f"added the hand '{NOBODY}'", episode.span, why))
    return replace(episode, entities=(*episode.entities, Entity(NOBODY, ("soma:Hand",))), repairs=repairs)


def _acting(episode: Episode, grips: Sequence[InferredGrasp], grid: Grid) -> str | None:
    """Hand that carries things farthest (to 0.1 m), a right one if several do; without any grasps the effector."""
    ways: dict[str, float] = defaultdict(float)
    for g in grips:
        ways[g.hand] += float(np.sum(np.linalg.norm(np.diff(grid.poses[g.thing][slice(*g.span), :3], axis=0), axis=1)))
    return min(sorted(ways), key=lambda h: (-round(ways[h], 1), _right_first(h))) if ways else episode.effector


def _right_first(hand: str) -> bool:
    return "right" not in hand.lower()


def _of_grips(grips: Sequence[InferredGrasp], grid: Grid) -> Iterator[Event]:
    for g in grips:
        near, span = ((grid.time(s), grid.time(e)) for s, e in (g.near, g.span))
        yield Event("", "soma:ContactState", "state", *near, {"a": g.hand, "b": g.thing}, True)
        yield Event("", "cram:GraspState", "state", *span, {"gripper": g.hand, "object": g.thing}, True)


def _labels(grips: Sequence[InferredGrasp], grid: Grid) -> Iterator[Event]:
    """Shaking and pouring as actions, found in the motion of held things; a tilt that overlaps shaking is no
    pouring."""
    for g in grips:
        if g.lift is None:
            continue
        roles = {"performer": g.hand, "object": g.thing}
        start, end = g.lift, g.down if g.down is not None else g.span[1]
        swung = shaking(grid.poses[g.thing], start, end)
        tilted = [t for t in tilting(grid.poses[g.thing], g.span[0], start, end) if not any(s < t[1] and t[0] < e for s, e in swung)]
        for type_, found in (("cram:Shaking", swung), ("soma:Pouring", tilted)):
            yield from (Event("", type_, "action", grid.time(s), grid.time(e), roles, True) for s, e in found)


def _standing(episode: Episode, grips: Sequence[InferredGrasp], grid: Grid) -> tuple[list[Event], list[Entity]]:
    """Return support states of lifted things before and after each lift; where no known thing is below, a new
    entity stands for the support."""
    free = [(g.thing, grid.time(g.lift), grid.time(g.down if g.down is not None else g.span[1])) for g in grips if g.lift is not None]
    known = resting(episode, free)
    carried = {e.roles["supportee"] for e in known if e.type == "soma:SupportState"}
    events, grounds = list(known), list[Entity]()
    for thing in dict.fromkeys(n for n, _, _ in free if n not in carried):
        found, made = _on_something(episode, thing, sorted((s, e) for n, s, e in free if n == thing), grid)
        events += found
        grounds += made
    return events, grounds


def _on_something(
    episode: Episode, thing: str, free: list[tuple[float, float]], grid: Grid
) -> tuple[list[Event], list[Entity]]:
    """Support and contact states of a thing at rest between the spans in which it is lifted, and one support
    entity for each resting position."""
    first, last = episode.span
    rests = [(s, e) for s, e in zip([first, *(e for _, e in free)], [*(s for s, _ in free), last], strict=True) if e - s > STEP]
    places: list[tuple[str, Floats]] = []
    events = []
    for start, end in rests:
        within = (grid.times >= start) & (grid.times <= end)
        at = np.median(grid.poses[thing][within, :3], axis=0)
        name = next((n for n, p in places if _same_place(at, p)), None)
        if name is None:
            name = f"support({thing})" + (f"_{len(places) + 1}" if places else "")
            places.append((name, at))
        events += [
            Event("", "soma:SupportState", "state", start, end, {"supporter": name, "supportee": thing}, True),
            Event("", "soma:ContactState", "state", start, end, {"a": thing, "b": name}, True),
        ]
    return events, [Entity(name, ("cram:Support",)) for name, _ in places]


def _same_place(one: Floats, other: Floats) -> bool:
    return bool(np.linalg.norm(one[:2] - other[:2]) < SAME_PLACE[0] and abs(one[2] - other[2]) < SAME_PLACE[1])
