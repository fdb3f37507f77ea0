"""Validators of the goal: the rules that interpret demonstrations judge the run, and physics has the last word."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from cramlite.model import Action, EntityName, Pose, Relation, Rollout, Thing, Value, Vector3, thing_of
from cramlite.plugin import Candidate, Cost, Finding, Validator, hookimpl

from .held_times import MOMENT, Span, held_times, said_times, said_values

if TYPE_CHECKING:
    from cramlite.plugin import Clause, Phase, PhaseName, Rule, Timeline

REST = 0.01  # a thing at rest moves slower than this over the last half second [m/s]
SWING = 0.04
"""What hangs on a peg may swing by this [m/s], its hole at rest: a pendulum on a peg has nothing to brake it.

Source: a body whose centre is d below the peg and swings by +-A gains h = A^2 / (2 d) of height at its turning points
(pendulum, small angles), and comes off only if it rises by the r of the peg's bent tip. Its period
2 pi sqrt((k^2 + d^2) / (g d)) is about 0.55 s for the products here (d = 70 mm, radius of gyration k = 34 mm), so that half a
second shows nearly the whole 2 A: 0.04 m/s are A = 10 mm, h = 0.7 mm, an eighth of r = 6 mm. Measured: 4.3 mm to and fro after
letting go, 3.7 mm after 12 s and 2.8 mm after 19 s; the hole moved by 0.5 mm in all that time.
"""


class EndState(Value):
    """Check that every relation the plan predicts holds in physics at the end, with its thing at rest and let go."""

    name: str = "end_state"
    cost: Cost = "rollout"

    def check(self, candidate: Candidate) -> Iterator[Finding]:
        rollout = candidate.rollout
        assert rollout is not None
        tests: Mapping[str, Callable[[Rollout, str, Thing], str]] = {
            "in": _not_in, "on": _not_on, "hangs_on": _not_hanging,
        }  # fmt: skip
        held = candidate.belief.held  # what is still in the hand is nowhere at rest
        roles = {o.entity for a in candidate.actions for o in a.roles.values()} - {held.thing if held else None}
        for relation in sorted(candidate.belief.relations):
            predicate, subject, place = relation
            if predicate in tests and subject in roles:
                whole = rollout.world.thing(thing_of(place))  # where it really is, not where it was believed
                wrong = tests[predicate](rollout, subject, whole) or _unsettled(
                    rollout, subject, hanging=predicate == "hangs_on"
                )
                yield Finding(self.name, not wrong, wrong or _holds(relation), origin=_last_about(candidate, subject))


def _holds(relation: Relation) -> str:
    predicate, subject, place = relation
    verb = predicate.replace("_", " ") if "_" in predicate else f"rests {predicate}"
    return f"'{subject}' {verb} '{place}'"


def _last_about(candidate: Candidate, thing: str) -> str:
    about = [a.name for a in candidate.actions if thing in {o.entity for o in a.roles.values()}]
    return about[-1] if about else ""


def _not_in(rollout: Rollout, thing: str, container: Thing) -> str:
    """Empty when the thing's centre is inside the container's cavity."""
    cavity = container.feature("cram:Cavity")
    if cavity is None:
        return f"'{container.name}' has no cavity"
    row = rollout.poses[thing][-1]
    x, y, z = (container.pose * cavity.pose).inverse().apply(row[:3])
    width, depth, height = (cavity.size[k] for k in ("width", "depth", "height"))
    if abs(x) <= width / 2 and abs(y) <= depth / 2 and -height <= z <= 0.05:
        return ""
    where = f"'{thing}' is at {x:+.2f} {y:+.2f} {z:+.2f} m from the middle of the opening of '{container.name}'"
    return f"{where} ({width:.2f} x {depth:.2f} m, {height:.2f} m deep)"


def _not_on(rollout: Rollout, thing: str, support: Thing) -> str:
    """Empty when the thing touches what should carry it."""
    pairs = [{thing_of(t.a), thing_of(t.b)} for t in rollout.touches[-1]]
    return "" if {thing, support.name} in pairs else f"'{thing}' does not touch '{support.name}' at the end"


def _not_hanging(rollout: Rollout, thing: str, hanger: Thing) -> str:
    """Empty when a peg of the hanger passes through a hole of the thing and touches it."""
    from ..episodes.detection.threaded import threaded

    pairs = [(hole, peg, flags) for hole, peg, flags in threaded(rollout) if _of(hole, peg) == (thing, hanger.name)]
    if not any(flags[-1] for _, _, flags in pairs):
        return f"no peg of '{hanger.name}' passes through a hole of '{thing}' at the end"
    return _not_on(rollout, thing, hanger)


def _of(hole: str, peg: str) -> tuple[str, str]:
    return thing_of(hole), thing_of(peg)


def _unsettled(rollout: Rollout, thing: str, *, hanging: bool) -> str:
    """Empty when a thing is let go and at rest; of one that hangs, the hole must be at rest, and the rest may swing."""
    held = any(
        "effector" in (t.a + t.b) and thing in (thing_of(t.a), thing_of(t.b)) for t in rollout.touches[-1]
    )
    if held:
        return f"the gripper still touches '{thing}' at the end"
    hole = rollout.world.thing(thing).feature("vrps:Hole") if hanging else None
    speed = _speed(rollout, thing, hole.pose.position if hole else (0.0, 0.0, 0.0))
    if speed > REST:
        what = f"the hole of '{thing}'" if hole else f"'{thing}'"
        return f"{what} still moves at {1000 * speed:.0f} mm/s at the end"
    swing = _speed(rollout, thing, (0.0, 0.0, 0.0)) if hole else 0.0
    return f"'{thing}' still swings at {1000 * swing:.0f} mm/s at the end" if swing > SWING else ""


def _speed(rollout: Rollout, thing: str, point: Vector3) -> float:
    """How far a point of a thing gets about in the last half second [m/s]: the diagonal of the box around its way."""
    recent = rollout.times >= rollout.times[-1] - 0.5
    poses = [Pose(tuple(row[:3]), tuple(row[3:])) for row in rollout.poses[thing][recent]]
    way = float(np.linalg.norm(np.ptp([p.apply(point) for p in poses], axis=0)))
    return way / (float(np.ptp(rollout.times[recent])) or 1.0)


class TaskRules(Value):
    """Check that what each task's rule asks for while its code ran and afterwards holds.

    The rule is the one that interprets demonstrations.

    Runtime conditions count, too: an arm that stood at the park state all along has not been parked. A task that has
    nothing left to do after the code before it (the gripper is open already) is judged by its postconditions; where no
    code came before, nothing was done at all, and all its conditions count. What a rule asks for before is left to the
    planner: a robot's retreat may begin where nothing is touched any more. But where only that speaks of the things that the
    task is about, it must have held at some moment before: nobody withdraws from what the hand was never near.
    """

    name: str = "task_rules"
    cost: Cost = "rollout"

    def check(self, candidate: Candidate) -> Iterator[Finding]:
        from cramlite.plugin import Timeline

        assert candidate.episode is not None
        timeline = Timeline(candidate.episode, candidate.taxonomy)
        rules = {r.task: r for r in candidate.rules}
        assert candidate.rollout is not None
        now, idle = float(candidate.rollout.times[0]), True
        for action in candidate.actions:
            span = _span(candidate, action.name)
            if span is None and candidate.rollout.outcome != "finished":
                return  # the program ended before
            now, idle = (span[1], False) if span else (now, idle)
            if action.task in rules:
                rule, after_only = rules[action.task], span is None and not idle
                yield _judged(rule, action, timeline, span or (now, now), self.name, after_only=after_only)
                yield from _begun(rule, action, timeline, span[0] if span else now, self.name)


Way = tuple[Mapping["PhaseName", "Phase"], bool]
"""Phases, and whether what a rule asks for before counts, too."""


def _ways(timeline: Timeline, start: float, end: float) -> Iterator[Way]:
    """How a task's code may be taken, and its rule be met.

    As it ran; without its first moments, in which the arm still follows what the code before it commanded (up to 5 mm of
    servo lag after a fast motion, gone within 0.2 s: measured); with the moments after it, in which its effects may still
    appear (the padding of the published rule base); and from a change of state in it on, where, as for an action of a
    demonstration, the rule holds with all that it asks for before: a push begins when the fingers touch.
    """
    from cramlite.plugin import PADDING, Segment

    yield timeline.phases(Segment(start, end)), False
    if end - start > 2 * PADDING:
        yield timeline.phases(Segment(start + PADDING, end)), False
        yield timeline.phases(Segment(start, end + PADDING)), False
        yield from ((timeline.phases(Segment(cut, end)), True) for cut in timeline.cuts if start < cut < end - PADDING)


def _judged(rule: Rule, action: Action, timeline: Timeline, span: Span, name: str, *, after_only: bool) -> Finding:
    from cramlite.plugin import Segment

    phases = ("post",) if after_only else ("run", "post")
    clauses = [c for c in rule.written_order if c.phase in phases or _binds(c)]
    unmet = _unmet_in(rule, clauses, action, _ways(timeline, *span))
    if unmet is None:
        said = " and ".join(c.text for c in clauses if c.phase != "pre")
        return Finding(name, True, f"{action.name}: {said}", origin=action.name)
    roles = ", ".join(f"{k} = {o.entity}" for k, o in action.roles.items())
    clause, bindings = unmet
    when = "after" if clause.phase == "post" else "during"
    was = said_values(clause, bindings, timeline.phases(Segment(*span))[clause.phase])
    said = f"{when} {action.name} '{clause.text}' does not hold{was}" + (f" ({roles})" if roles else "")
    held = "" if _binds(clause) else said_times(held_times(clause, bindings, timeline))
    ran = f"; {action.name} ran from {span[0]:.2f} to {span[1]:.2f} s"
    return Finding(name, False, said + (f": {held}{ran}" if held else ""), origin=action.name)


def _begun(rule: Rule, action: Action, timeline: Timeline, start: float, name: str) -> Iterator[Finding]:
    """Whether what a rule asks for before held at some moment until a task's start, where it asks no more of its things."""
    from cramlite.plugin import Segment, atoms

    later = {v for c in rule.clauses if c.phase != "pre" for a in atoms(c.condition) for v in a.binds()}
    things = {k for k, o in action.roles.items() if k in rule.roles and o.entity}
    if not things or things & later:
        return
    before = [c for c in rule.written_order if c.phase == "pre"]
    moments = {start, *np.arange(timeline.cuts[0], start, MOMENT).tolist(), *(c for c in timeline.cuts if c < start)}
    unmet: Clause | None = None
    for moment in sorted(moments, reverse=True):
        found = _unmet(before, action, rule, timeline.phases(Segment(moment, moment)))
        if found is None:
            return
        unmet = unmet or found[0]
    assert unmet is not None
    roles = ", ".join(f"{k} = {o.entity}" for k, o in action.roles.items())
    yield Finding(name, False, f"before {action.name} '{unmet.text}' never held ({roles})", origin=action.name)


Unmet = tuple["Clause", list[dict[str, Any]]]
"""A condition that does not hold, and the fillings of variables for which it was asked."""


def _unmet_in(rule: Rule, clauses: list[Clause], action: Action, ways: Iterable[Way]) -> Unmet | None:
    """None where the rule is met in one of the ways, else what the first one lacks."""
    first: Unmet | None = None
    starts = any(c.phase == "pre" and not _binds(c) for c in rule.written_order)
    for phases, before in ways:
        if before and not starts:
            continue
        unmet = _unmet(rule.written_order if before else clauses, action, rule, phases)
        if unmet is None:
            return None
        first = first or unmet
    return first


def _unmet(clauses: Iterable[Clause], action: Action, rule: Rule, phases: Mapping[PhaseName, Phase]) -> Unmet | None:
    """The first condition that no filling of the open variables satisfies; roles are the objects that were meant."""
    bindings: list[dict[str, Any]] = [
        {k: _felt(o.entity or "", phases) for k, o in action.roles.items() if k in rule.roles}
    ]
    for clause in clauses:
        found = [f for b in bindings for f in clause.condition.solve(phases[clause.phase], b)]
        if not found:
            return clause, bindings
        bindings = found
    return None


def _binds(clause: Clause) -> bool:
    """Whether a clause says which entities are meant (the effector, a class), rather than what holds."""
    from cramlite.plugin import atoms

    return all(a.predicate.timeless for a in atoms(clause.condition))


def _felt(entity: str, phases: Mapping[PhaseName, Phase]) -> str:
    """The entity that contacts name: a feature without a shape of its own, a table's top say, is felt as its thing."""
    known = phases["post"].timeline.entities
    name = EntityName.parse(entity)
    own = not name.part or name.thing not in known or any(g.part == name.part for g in known[name.thing].geoms)
    return entity if own else name.thing


def _span(candidate: Candidate, task: str) -> tuple[float, float] | None:
    """When the code of a task ran; None when it has no code or never ran."""
    rollout, code = candidate.rollout, candidate.code
    assert rollout is not None and code is not None
    lines = {int(line) for line in np.unique(rollout.lines) if code.task_of(int(line)) == task}
    samples = np.flatnonzero(np.isin(rollout.lines, list(lines))) if lines else np.array([])
    return (float(rollout.times[samples[0]]), float(rollout.times[samples[-1]])) if len(samples) > 1 else None


@hookimpl
def validators() -> Iterable[Validator]:
    return [EndState(), TaskRules()]
