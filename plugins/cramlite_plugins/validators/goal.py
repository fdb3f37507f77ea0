"""Validator of the goal: each literal is evaluated at the run's end, by the predicates that rules use on demonstrations."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING

import numpy as np
from msgspec.structs import replace

from cramlite.model import Episode, Floats, Rollout, Value, thing_of, vector3
from cramlite.plugin import EFFECTOR, Candidate, Cost, Finding, Validator, contents, hookimpl, wrong_side

from ..episodes.detection.entities import contents_of
from ..predicates.motion import joint_closed
from ..predicates.places import distance_seen_from_above, in_region, in_region_by
from ..predicates.relations import supports
from ..shapes.contents import SHARE, where
from .bystanders import stays
from .held_times import MOMENT, held_times, said_times
from .movers import moved_by
from .rest import at_the_end
from .stance import wrongly_rests
from .steps import LEAN
from .task_times import origins

if TYPE_CHECKING:
    from cramlite.plugin import Atom, Clause, GoalLiteral, Phase, Timeline

LASTS = 0.5
"""Time before the end of a run during which a literal must hold throughout [s]: a thing that falls past a place is over it for less."""
STILL = 0.02
"""Largest displacement of the things of a literal during the last ``LASTS`` seconds of a run [m]: a thing on a peg may swing by 40 mm/s
(``postconditions.SWING``), and one that rolls or falls is faster."""
SURE = (0.001, 0.001, 0.0005)
"""Least distance of an origin inside its region, along each of the region's axes [m]. Aside simulators differ by more than in height: a
thing sinks into its support by some 0.5 mm, a bowl in a drawer as deep in two of them, within 0.01 mm."""
APART = 0.004
"""Least margin inside an allowed distance of two things [m]: a bowl that slid down onto a plate came to rest 28 mm from its middle in one
simulator, and 31 mm in another."""
AT_STOP = 0.001
"""Largest distance of a knob that is off from its stop, as a share of its range: a knob with a range of 2.1 rad, pressed there, rested
within 0.1 mrad in two simulators. Two that had sprang back by 3.5 mrad glided on to 5 and 6.5 mrad in the other one, whose stove was
still on."""
CONTROL = "cram:Control"
PLACES = {"vrps:SurfaceFeature", "cram:Cavity"}
"""Features that things are in or over, and do not touch."""


class Goal(Value):
    """Validator of the goal: each literal, of the goal or of the state in which the demonstration ended,
    holds at the end of the run, and its thing is at rest.

    Places are measured where they then are: what was put into a drawer is looked for in the drawer where it was pushed to.
    """

    name: str = "goal"
    cost: Cost = "rollout"
    by_goal: bool = True

    def check(self, candidate: Candidate) -> Iterator[Finding]:
        from cramlite.plugin import Timeline

        assert candidate.episode is not None
        if not candidate.goal:
            return
        timeline, rollout = Timeline(candidate.episode, candidate.taxonomy), candidate.ran
        for literal in candidate.goal:
            wrong = _unmet(literal, timeline, rollout) or _doubtful(literal, timeline, rollout)
            wrong = wrong or _beside(literal, candidate) or _unsettled(literal, rollout) or _badly_rests(literal, candidate)
            wrong = wrong or _sprung_back(literal, candidate) or _tipped(literal, candidate)
            end = _measured(literal, rollout, candidate.episode)
            said = f"{_what(literal)} {f'is not reached: {wrong}' if wrong else f'holds for the last {LASTS:g} s'}"
            yield Finding(self.name, not wrong, f"{said}; {end}" if end else said, things=True, literal=literal.says)


def _what(literal: GoalLiteral) -> str:
    return f"'{literal.says}'" + (f", with which {literal.task} of the demonstration ended," if literal.task else "")


def _unmet(literal: GoalLiteral, timeline: Timeline, rollout: Rollout) -> str:
    """Describe the first condition that does not hold all through the last moments of the run; empty if
    all do."""
    binding: dict[str, str | float] = {v: _recorded(e, timeline.episode) for v, e in literal.binding.items()}
    last = float(rollout.times[-1])
    first = max(last - LASTS, timeline.cuts[0])
    moments = sorted({first, last, *(c for c in timeline.cuts if first < c < last), *np.arange(first, last, MOMENT).tolist()})
    for clause in literal.clauses:
        phases = [timeline.instant(t) for t in moments]
        gone = next((p.start for p in reversed(phases) if next(clause.condition.solve(p, binding), None) is None), None)
        if gone is not None:
            held = said_times(held_times(clause, [binding], timeline))
            when = "at the end" if gone == last else f"at {gone:.2f} s, {last - gone:.2f} s before the end,"
            return f"{when} '{clause.text}' does not hold" + (f" ({held})" if held else "")
        if few := _too_few(clause, literal, rollout):
            return few
    return ""


def _doubtful(literal: GoalLiteral, timeline: Timeline, rollout: Rollout) -> str:
    """Describe a thing so near to the border of its region, or to the end of an allowed distance, that another
    simulator may find it outside; "" if it is well inside."""
    binding: dict[str, str | float] = {v: _recorded(e, timeline.episode) for v, e in literal.binding.items()}
    end = timeline.instant(float(rollout.times[-1]))
    for atom in _asserted(literal.clauses):
        if atom.predicate.function is in_region:
            thing, region = (None if v is None else str(v) for v in atom.arguments(binding))
            if next(in_region_by(end, thing, region, SURE), None) is None:
                least = " ".join(f"{1000 * v:g}" for v in SURE)
                return f"'{thing}' is less than {least} mm (x y z) inside of '{region}': another simulator may find it outside"
    for clause in literal.clauses:
        if _barely(clause, end, binding):
            return f"'{clause.text}' holds by less than {1000 * APART:g} mm: another simulator may find it false"
    return ""


def _barely(clause: Clause, end: Phase, binding: dict[str, str | float]) -> bool:
    """Check whether a condition on a distance would not hold if the distance were longer by ``APART``."""
    from cramlite.plugin import Atom, Compare

    match clause.condition:
        case Compare(Atom(predicate), "<=", float(most)) as asked if predicate.function is distance_seen_from_above:
            return next(replace(asked, right=most - APART).solve(end, binding), None) is None
    return False


def _asserted(clauses: Iterable[Clause]) -> Iterator[Atom]:
    """Generate the atoms of the clauses that are not denied."""
    from cramlite.plugin import atoms

    for clause in clauses:
        if not clause.text.startswith("not "):
            yield from atoms(clause.condition)


def _recorded(entity: str, episode: Episode) -> str:
    """Name under which a recording knows an entity.

    It is the robot's name for the hand, the vessel's for a filling, and the whole thing's for a feature
    without a shape, unless the feature is a place.
    """
    whole = thing_of(entity)
    if entity == EFFECTOR:
        return episode.effector or entity
    if entity == contents(whole):
        return contents_of(whole)
    known, owner = episode.known(entity), episode.known(whole)
    apart = known is not None and (known.geoms or set(known.types) & PLACES)
    return entity if owner is None or apart else whole


def _too_few(clause: Clause, literal: GoalLiteral, rollout: Rollout) -> str:
    """Describe a vessel into which too small a share of poured content has come; empty if enough has.

    Empty, too, for conditions that are about no content.
    """
    for atom in _asserted((clause,)):
        into, filling = (literal.binding.get(getattr(t, "name", ""), "") for t in (atom.terms[0], atom.terms[-1]))
        source = thing_of(filling)
        if atom.predicate.fluent.of_contents and source in rollout.grains:
            arrived, count = int(where(rollout, source)[into][-1]), rollout.grains[source].shape[1]
            if arrived < SHARE * count:
                return f"{arrived} of {count} grains of '{source}' are in '{into}', {math.ceil(SHARE * count - 1e-9)} are wanted"
    return ""


def _beside(literal: GoalLiteral, candidate: Candidate) -> str:
    """Describe a thing that is not on the wanted side of another, as seen from the robot's base; empty if it
    is."""
    if not literal.side:
        return ""
    one, other = (vector3(_at(candidate.ran, n)) for n in (literal.things[0], literal.other))
    return wrong_side(literal.side, literal.other, one, other, candidate.world.robots[0].base)


def _unsettled(literal: GoalLiteral, rollout: Rollout) -> str:
    """Describe the first thing of the literal that still moves at the end of the run; empty if all are at
    rest."""
    recent = rollout.times >= rollout.times[-1] - LASTS
    for name in dict.fromkeys(thing_of(t) for t in literal.things if thing_of(t) in rollout.poses):
        way = float(np.linalg.norm(np.ptp(rollout.poses[name][recent, :3], axis=0)))
        if way > STILL:
            return f"'{name}' moves by {1000 * way:.0f} mm in the last {LASTS:g} s, up to {1000 * STILL:.0f} mm count as at rest"
    return ""


def _badly_rests(literal: GoalLiteral, candidate: Candidate) -> str:
    """Describe a thing that rests wrongly on its support, such as on its edge; empty if it rests well."""
    rollout, there = candidate.ran, {t.name for t in candidate.ran.world.things}
    for atom in _asserted(literal.clauses):
        if atom.predicate.function is supports:
            below, above = (thing_of(str(v)) for v in atom.arguments(dict(literal.binding)))
            if {below, above} <= there and (wrong := wrongly_rests(candidate, at_the_end(rollout, above), at_the_end(rollout, below))):
                return wrong
    return ""


def _sprung_back(literal: GoalLiteral, candidate: Candidate) -> str:
    """Describe a knob that the goal wants off and that is not at the end of its range; empty if there is none."""
    rollout = candidate.ran
    for atom in _asserted(literal.clauses):
        if atom.predicate.function is joint_closed:
            (name,) = (str(v) for v in atom.arguments(dict(literal.binding)))
            thing, joint = rollout.world.thing(name), rollout.world.thing(name).joint
            if joint is None or name not in rollout.values or not candidate.taxonomy.any_is_a((thing.type,), CONTROL):
                continue
            share = joint.opening(float(rollout.values[name][-1]))
            if share > AT_STOP:
                return f"'{name}' is {100 * share:.2g} % of its range from its stop; up to {100 * AT_STOP:g} % count as off"
    return ""


def _tipped(literal: GoalLiteral, candidate: Candidate) -> str:
    """Describe a thing that tipped over after a task of the plan had released it and it had come to rest;
    empty if there is none.

    Also where bystanders only advise: how it then comes to rest is left to chance.
    """
    rollout, let_go = candidate.ran, {h.thing: h.by for h in candidate.handovers or () if not h.taken}
    names = {thing_of(t) for t in literal.things} & set(let_go)
    if not names:
        return ""
    moved, came_from = moved_by(candidate), np.array(origins(candidate))
    for name in sorted(names):
        released = np.flatnonzero(came_from == let_go[name])
        for stay in stays(rollout, rollout.world.thing(name), moved) if len(released) else ():
            if stay.leant > released[-1] and stay.tilt > LEAN:
                when = f"at {rollout.times[stay.leant]:.1f} s, after it had been put there and rested"
                return f"'{name}' leant over by {np.degrees(stay.tilt):.0f} deg {when}; up to {np.degrees(LEAN):.0f} deg count as standing"
    return ""


def _measured(literal: GoalLiteral, rollout: Rollout, episode: Episode) -> str:
    """Describe the things of a literal at the end of the run: openings of joints, and the position of a
    thing in the frame of its place."""
    said, last = [], float(rollout.times[-1])
    names = list(dict.fromkeys(thing_of(t) for t in literal.things if episode.known(thing_of(t)) is not None))
    for name in names:
        joint = rollout.world.thing(name).joint if name in rollout.values else None
        if joint is not None:
            share = joint.opening(float(rollout.values[name][-1]))
            said.append(f"'{name}' is open by {100 * share:.0f} % of its range")
    poses = [episode.pose_at(n, last) for n in names[:2]]
    if len(poses) == 2 and poses[0] is not None and poses[1] is not None:
        x, y, z = (1000 * v for v in poses[1].inverse().apply(poses[0].position))
        said.append(f"'{names[0]}' is at {x:+.0f} {y:+.0f} {z:+.0f} mm in the frame of '{names[1]}'")
    return " and ".join(said)


def _at(rollout: Rollout, name: str) -> Floats:
    """Position of a thing at the end of a run, (3,) in the world [m]."""
    return rollout.poses[name][-1, :3] if name in rollout.poses else np.asarray(rollout.world.thing(name).pose.position)


@hookimpl
def validators() -> Iterable[Validator]:
    return [Goal()]
