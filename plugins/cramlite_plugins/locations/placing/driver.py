"""Search for placements: tries the candidates of each way into the target, best first, and explains if none
passes the checks."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator, Sequence
from functools import partial

import numpy as np
from msgspec.structs import replace

from cramlite.model import Belief, CarriedAlong, Location, Place, Pose, Stage
from cramlite.plugin import SIDES, Answer, Context, Grounding, Refused, Unresolvable

from ...motion_planning.reach import bound, led_by, taken_at
from ..laying_down import hung, laid_down
from .access import check_open
from .checks.hand import lowered, opened
from .checks.order import REACHED, SHAPES, first_objection
from .demands import DEMANDS, OUT_OF_THE_WAY, TIGHT, is_tight
from .query import AS_LET_GO, Found, Placement, Query, is_roofed, queries
from .ways_out import HUNG, LAID, WAYS, WayOut

SAME = 1e-6  # stand-offs that are one [m]
IN_ORDER = 0.1  # cost of each placement that comes before, on a way that has an end
OUTLINE, ARM = 5, 20
"""Samples of a query's budget that one check of shapes costs, and one check of the arm: a sampling planner
checks as many states in the same time."""
ALONE = {kind: {**shapes, **OUT_OF_THE_WAY} for kind, shapes in SHAPES.items()}
"""Checks of the payload alone, whatever holds it, by kind of stable pose."""
CHECKS = {kind: {**alone, **REACHED, **DEMANDS} for kind, alone in ALONE.items()}


def onto(location: Location, belief: Belief, context: Context) -> Iterator[Answer]:
    """Generate placements on a thing; a payload that hangs from the fingers is laid down, or released as it
    hangs.

    Onto a thing that can move, such as another plate, it is first tried as it hangs: laid down it slides out
    of the fingers there.
    """
    held = belief.held
    if held is None or held.swing is None:
        yield from placements(location, belief, context)
        return
    stuck, found = list[Unresolvable](), False
    laid = laid_down(location, belief, context, partial(placements, ways=LAID))
    hanging = (hung(answer, held) for answer in placements(location, belief, context, HUNG))
    lies_first = belief.thing(bound(context, location.of)).furniture
    for answers in (laid, hanging) if lies_first else (hanging, laid):
        try:
            for answer in answers:
                found = found or isinstance(answer, Grounding)
                yield answer
        except Unresolvable as no:
            stuck.append(no)
    if stuck and not found:
        raise _merged(stuck, location)
    yield from (Refused("as it hangs", no.reason, because=no.because, blocking=no.blocking) for no in stuck)


def placements(
    location: Location, belief: Belief, context: Context, ways: Sequence[WayOut] = ()
) -> Iterator[Answer]:
    """Generate placements on or in a thing, by all ways to bring the payload there, or only by some: from
    above, through a side, tilted.

    Raises:
        Unresolvable: there is none by any way, or the samples of the query are used up.
    """
    asked, stuck = queries(location, belief, context), list[tuple[str, Unresolvable]]()
    try:
        check_open(asked)
    except Unresolvable as shut:
        raise _merged([shut], location) from None
    tasks = led_by(location, context) if is_roofed(asked[0]) else ()  # have another way in there: toppling
    ranked = [(rank, way) for way in ways or WAYS[location.relation] if (rank := way.rank(asked)) is not None]
    for rank, way in sorted(ranked, key=lambda one: one[0]):
        try:
            yield from _by(way, max(rank, 0), asked)
        except Unresolvable as no:
            stuck.append((way.name, no))
    if ranked and len(stuck) == len(ranked):
        raise _merged([no for _, no in stuck], location, tasks)
    yield from (Refused(n, no.reason, because=(*no.because, *tasks), blocking=no.blocking) for n, no in stuck)


def _merged(stuck: list[Unresolvable], location: Location, tasks: tuple[str, ...] = ()) -> Unresolvable:
    """Merge the refusals of all ways of a payload to its target: all reasons, and all choices that a reason
    depends on."""
    because = dict.fromkeys(name for no in stuck for name in (location.of or "", *no.because, *tasks))
    blocking = dict.fromkeys(name for no in stuck for name in no.blocking or ())
    remedy = next((no.remedy for no in stuck if no.remedy is not None), None)
    reason = "; ".join(dict.fromkeys(no.reason for no in stuck))
    return Unresolvable(reason, tuple(because), blocking=tuple(blocking), remedy=remedy)


def _by(way: WayOut, cost: float, asked: list[Query]) -> Iterator[Answer]:
    """Placements by one way to bring the payload to its target; those that leave little room for closing a
    thing later come last.

    What shapes refuse is told when the first candidate gets past them. If none does, no other grasp would
    help: it depends on the two things alone, and on where tasks have put what stands there.
    """
    work, kept, tight, refused = asked[0].context.samples, list[Refused](), list[Grounding](), list[Refused]()
    passed, found, there = False, 0, dict[str, None]()
    for query, answer, by_shapes in itertools.chain.from_iterable(map(_of_group, way.groups(asked))):
        there |= dict.fromkeys(query.standing_there()) if query else {}
        alone = by_shapes and not (isinstance(answer, Refused) and answer.check in OUT_OF_THE_WAY)
        work -= OUTLINE if alone else ARM
        if isinstance(answer, Refused):
            refused.append(answer)
        if by_shapes and not passed:
            kept += refused[-1:]
        else:
            yield from kept
            passed, kept = True, []
            if isinstance(answer, Grounding):
                answer = replace(answer, cost=answer.cost + cost + (0.0 if way.endless else IN_ORDER * found))
                found += 1
            if isinstance(answer, Grounding) and answer.cost >= TIGHT:
                tight.append(answer)
            else:
                yield answer
        if way.endless and work <= 0:
            break
    yield from tight
    if not passed and way.endless:
        raise _no_room(refused, asked[0], there)
    if way.endless and work <= 0:
        looked = f"{found + len(refused)} placements were looked at"
        said = f"{looked}, as many as the {asked[0].context.samples} samples of a query allow"
        if not found:
            nearest = _nearest(refused)
            said = f"{said}; none fits: {nearest.value}: {nearest.reason}"
        raise Unresolvable(said, blocking=tuple(there))
    if not found and not way.endless:
        raise _blocked(way, refused, asked[0])


def _of_group(group: Iterator[Found] | Refused) -> Iterator[tuple[Query | None, Answer, bool]]:
    """Check placements that differ in height or approach until one passes; yield each result with its placing
    problem.

    The last value says whether shapes alone, without the arm, refuse the placement.

    From a stand-off that is blocked no other height is tried, but from aside.
    """
    if isinstance(group, Refused):
        yield None, group, True
        return
    blocked: Pose | None = None
    for query, one in group:
        again = blocked is not None and blocked.distance(one.before)[0] < SAME
        if again or (one.aside and blocked is None):
            continue
        no = first_objection(one, query, {**REACHED, **DEMANDS} if one.aside else CHECKS[one.kind])
        if no is None:
            cost = one.cost + TIGHT * is_tight(one, query)
            said = f"'{query.entity}', {one.name}"
            yield query, Grounding(place_at(one, query), said, cost, key=one.name, anew=True), False
            return
        if one.aside:
            continue
        by_shapes = no.check in ALONE[one.kind]
        yield query, no, by_shapes and one.kind != "at rest"
        if by_shapes:
            return  # no height changes what is seen from above
        blocked = one.before if no.where is Stage.BEFORE else None


def place_at(placement: Placement, query: Query) -> Place:
    """Convert a placement to the ``Place`` that the arm is led to, with approach and release.

    A payload that is led aside onto a surface is lowered the rest of the way in the end.
    """
    via, pose, height = placement.through, placement.pose, placement.height
    if placement.led and not query.depth:
        via, pose, height = (*via, pose), lowered(placement, query), 0.0
    opening = opened(placement, query) if placement.opens and len(query.openings) > 1 else query.openings[0]
    let_go = pose * query.held.tcp_to_thing
    settles = let_go.inverse() * placement.lies if placement.lies else AS_LET_GO
    wide = opening if placement.opens and not isinstance(opening, Refused) else None
    release = query.release(height, wide, settles, placement.pushed is None)
    way = np.subtract(placement.begins.position, placement.before.position)
    x, y, z = (way / np.linalg.norm(way)).tolist() if placement.led else (0.0, 0.0, -1.0)
    return Place(
        pose, placement.before, approach=(x, y, z), path=(placement.back,) if placement.back else (),
        thing=query.thing.name, release=release, reorients=placement.reorients, via=via,
        carried=CarriedAlong(to_m=placement.pushed.position[:2]) if placement.pushed else None,
    )  # fmt: skip


def _no_room(refused: list[Refused], query: Query, there: Iterable[str]) -> Unresolvable:
    """Refusal if every placement fails a check of shapes, without the arm: first failure of each check, and
    what it depends on."""
    named = {thing for name in (*SIDES, "near") if (thing := getattr(query.where, name))}
    named |= {*there, *(name for no in refused for name in no.blocking or () if isinstance(name, str))}
    bindings = query.context.bindings.items()
    places = [(n, v) for n, v in bindings if isinstance(v, Place)]
    put = (n for n, v in places if v.thing in named and v.release is not None)
    about = (n for n, v in bindings if v in (query.thing.name, *named))
    first = {r.passed: f"{r.value}: {r.reason}" for r in reversed(refused)}
    said = "; ".join(first[passed] for passed in sorted(first, reverse=True))
    turned = any(r.check == "falls" for r in refused)  # another grip turns the hand another way
    grips = (n for n, v in places if turned and v.thing == query.thing.name)
    lacks = min((r.remedy for r in refused if r.remedy is not None), key=lambda r: r.missing, default=None)
    reason = f"none of {len(refused)} placements fits; {said}"
    return Unresolvable(reason, (*put, *about, *grips), blocking=tuple(sorted(named)), remedy=lacks)


def _blocked(way: WayOut, refused: list[Refused], query: Query) -> Unresolvable:
    """Refusal if no candidate for one way of the payload to its target passes all checks: the nearest
    miss. It names the grasp as a cause unless the payload's own shape is to blame."""
    nearest = _nearest(refused)
    own = any(nearest.check in alone for alone in ALONE.values()) or not nearest.check
    by_hand = way.by_hand and nearest.check not in OUT_OF_THE_WAY
    grasps = taken_at(query.belief, query.context) if by_hand or not own else ()
    blocking = tuple(dict.fromkeys(name for no in refused for name in no.blocking or ()))
    return Unresolvable(f"{way.name}: {nearest.reason}", grasps, blocking=blocking, remedy=nearest.remedy)


def _nearest(refused: Sequence[Refused]) -> Refused:
    """Return the refusal that passed most checks; of several, the last."""
    return max(reversed(refused), key=lambda no: no.passed)
