"""Validators of effects: a run must satisfy the rules of its tasks, and what the plan predicts must hold in physics."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import TYPE_CHECKING, Any

from cramlite.model import (
    GRAVITY,
    Action,
    EntityName,
    Feature,
    Relation,
    Remedy,
    Rollout,
    Thing,
    Value,
    enclosing_names,
    is_part_of,
    thing_of,
)
from cramlite.plugin import Candidate, Cost, Finding, Validator, hookimpl

from .held_times import held_times, said_times, said_values
from .rest import at_the_end, restless
from .stance import near_tip, wrongly_rests
from .task_times import Span, span

if TYPE_CHECKING:
    from cramlite.plugin import Clause, Not, Phase, PhaseName, Rule, Timeline

NO_STEPS = "its program has no steps"
OPENING = 0.6  # a thing has left the hand so long before the fingers are open [s]: 85 mm at 150 mm/s, a 2F-85's whole stroke
LONGEST = 5.0  # or so long, where the hand has stayed since: fingers that are told to open in steps take 2 s [s]
STAYED = 0.005  # a hand that opens its fingers moves by less [m]
BORNE = 0.5  # share of a thing's weight below which a support only touches it


class EndState(Value):
    """Check that every relation that the plan predicts holds in physics at the end, with its thing
    released and at rest."""

    name: str = "end_state"
    cost: Cost = "rollout"

    def check(self, candidate: Candidate) -> Iterator[Finding]:
        rollout = candidate.ran
        tests: Mapping[str, Callable[[Rollout, str, Thing], str]] = {
            "in": _not_in, "on": _not_on, "hangs_on": _not_hanging,
        }  # fmt: skip
        held = candidate.belief.held  # what is still in the hand is nowhere at rest
        roles = {o.entity for a in candidate.actions for o in a.roles.values()} - {held.thing if held else None}
        for relation in sorted(candidate.belief.relations):
            predicate, subject, place = relation
            if predicate in tests and subject in roles:
                whole = at_the_end(rollout, thing_of(place))  # where it is by then, not where it was, or was believed
                wrong = tests[predicate](rollout, subject, whole) or _unsettled(
                    rollout, subject, hanging=predicate == "hangs_on"
                )
                if predicate == "on" and not wrong:
                    wrong = wrongly_rests(candidate, at_the_end(rollout, subject), whole)
                yield Finding(self.name, not wrong, wrong or _holds(relation), origin=_last_about(candidate, subject), things=True)


def _holds(relation: Relation) -> str:
    predicate, subject, place = relation
    verb = predicate.replace("_", " ") if "_" in predicate else f"rests {predicate}"
    return f"'{subject}' {verb} '{place}'"


def _last_about(candidate: Candidate, thing: str) -> str:
    about = [a.name for a in candidate.actions if thing in {o.entity for o in a.roles.values()}]
    return about[-1] if about else ""


def _not_in(rollout: Rollout, thing: str, container: Thing) -> str:
    """Describe where a thing is if its centre is in no cavity of the container; "" if it is in any of them.

    Which cavity is meant is checked with the goal.
    """
    found = [_beside(rollout, thing, container, f) for f in container.features if f.type == "cram:Cavity"]
    return "" if "" in found else next(iter(found), f"'{container.name}' has no cavity")


def _beside(rollout: Rollout, thing: str, container: Thing, cavity: Feature) -> str:
    row = rollout.poses[thing][-1]
    x, y, z = (container.pose * cavity.pose).inverse().apply(row[:3])
    width, depth, height = (cavity.size[k] for k in ("width", "depth", "height"))
    if abs(x) <= width / 2 and abs(y) <= depth / 2 and -height <= z <= 0.05:
        return ""
    where = f"'{thing}' is at {x:+.2f} {y:+.2f} {z:+.2f} m from the middle of the opening of '{container.name}'"
    return f"{where} ({width:.2f} x {depth:.2f} m, {height:.2f} m deep)"


def _not_on(rollout: Rollout, thing: str, support: Thing) -> str:
    """Describe a support that bears too little of the thing's weight; empty if it bears most of it."""
    weight, lift = (rollout.world.thing(thing).mass or 0.0) * GRAVITY, 0.0
    pair = {thing, support.name}
    for touch in rollout.touches[-1]:
        if {thing_of(touch.a), thing_of(touch.b)} == pair:
            lift += touch.lift if thing_of(touch.b) == thing else -touch.lift
    if lift > BORNE * weight:
        return ""
    if not any({thing_of(t.a), thing_of(t.b)} == pair for t in rollout.touches[-1]):
        return f"'{thing}' does not touch '{support.name}' at the end"
    return f"'{support.name}' bears {lift:.1f} N of the {weight:.1f} N that '{thing}' weighs at the end"


def _not_hanging(rollout: Rollout, thing: str, hanger: Thing) -> str:
    """Describe why a thing does not hang: no peg of the hanger is in a hole of the thing, or the peg does not bear it; "" if it hangs.

    Whether an upright peg bears the thing is not checked.
    """
    from ..episodes.detection.threaded import around_standing, threaded

    pairs = [(hole, peg, flags) for hole, peg, flags in threaded(rollout) if _of(hole, peg) == (thing, hanger.name)]
    if not any(flags[-1] for _, _, flags in pairs):
        return f"no peg of '{hanger.name}' passes through a hole of '{thing}' at the end"
    if around_standing(hanger):
        return ""
    return _not_on(rollout, thing, hanger) or near_tip(at_the_end(rollout, thing), hanger)


def _of(hole: str, peg: str) -> tuple[str, str]:
    return thing_of(hole), thing_of(peg)


def _unsettled(rollout: Rollout, thing: str, *, hanging: bool) -> str:
    """Describe a thing that is not released and at rest at the end; empty if it is. Of a hanging thing
    the hole must be at rest, and the rest may swing."""
    held = any(
        "effector" in (t.a + t.b) and thing in (thing_of(t.a), thing_of(t.b)) for t in rollout.touches[-1]
    )
    if held:
        return f"the gripper still touches '{thing}' at the end"
    return restless(rollout, thing, hanging=hanging)


class TaskRules(Value):
    """Check that the conditions of each task's rule hold before, while and after its code ran.

    The rule is the one that interprets demonstrations.

    Every action of the plan, and every part that it was decomposed into, must have run: one that has steps in the program
    and left no trace in the run, or of one of whose steps no code is left, was not done, whatever holds afterwards. One that needed no
    steps (the gripper is open already) is judged by what it asks for afterwards, and the finding says so; where no code
    came before, nothing was done at all, and all its conditions count: an arm that stood at the park state all along has
    not been parked. What a task is to end may have ended before: fingers that close may lift a thing off what it leans on. It is still
    asked for that the thing is in the hand then, and that nothing else had it last.
    """

    name: str = "task_rules"
    cost: Cost = "rollout"

    def check(self, candidate: Candidate) -> Iterator[Finding]:
        from cramlite.plugin import Timeline

        assert candidate.episode is not None
        timeline = Timeline(candidate.episode, candidate.taxonomy)
        rules = {r.task: r for r in candidate.rules}
        for action, ran, now in _in_order(candidate):
            if ran is None and candidate.ran.outcome != "finished":
                return  # the program ended before
            missing = no_trace(candidate, action.name, ran)
            if missing:
                yield Finding(self.name, False, missing, origin=action.name)
            elif action.task in rules:
                already = _already(candidate, action) if ran else NO_STEPS if now > candidate.ran.times[0] else ""
                done = ran or Span(now, now)
                yield _judged(rules[action.task], action, timeline, done, self.name, already)
                yield from _as_many(rules[action.task], action, timeline, done, self.name)


def _already(candidate: Candidate, action: Action) -> str:
    """Say which subtask of the previous action already did this action's task with the same things; empty
    if none did.

    The effect of the action is then not demanded once more.
    """
    names = [a.name for a in candidate.actions]
    if action.name not in names[1:]:
        return ""
    before = names[names.index(action.name) - 1]
    same = (p.name for p in candidate.parts if is_part_of(p.name, before) and (p.task, _fillers(p)) == (action.task, _fillers(action)))
    done = next(same, "")
    return f"{done} did it already" if done else ""


def _fillers(action: Action) -> dict[str, str | None]:
    return {role: o.entity for role, o in action.roles.items()}


def _in_order(candidate: Candidate) -> Iterator[tuple[Action, Span | None, float]]:
    """Actions and their parts, each with the span in which its code ran (None if it did not), and the time at
    which earlier code ended [s]."""
    now = float(candidate.ran.times[0])
    for action in candidate.actions:
        for one in (*(p for p in candidate.parts if is_part_of(p.name, action.name)), action):
            ran = span(candidate, one.name)
            yield one, ran, now
            now = max(now, ran.end) if ran else now


def no_trace(candidate: Candidate, task: str, ran: Span | None) -> str:
    """Describe a task whose steps are in the program while none of their code ran; empty if some
    ran, or if it has no steps."""
    steps = [s.origin for s in candidate.program.steps if task in enclosing_names(s.origin)]  # what the run decides about may be left out
    if steps and ran is None:
        return f"{task} was not executed: none of the code of its {len(steps)} steps ran"
    return ""


Way = Mapping["PhaseName", "Phase"]
"""Name of a phase -> the facts that hold before, while or after a task's code runs."""


def _ways(timeline: Timeline, start: float, end: float) -> Iterator[Way]:
    """Time spans of the run in which a task's rule may be satisfied, one after the other.

    As it ran; without its first moments, in which the arm still follows what the code before it commanded (up to 5 mm of servo
    lag after a fast motion, gone within 0.2 s: measured); with the moments after it, in which its effects may still appear (the
    padding of the published rule base); without its last ones, since the detector takes changes of state within ``SNAP`` for
    one, the first (a thing that is lowered onto a peg and let go at once); and from a change of state in it on, where, as for
    an action of a demonstration, the rule holds with all that it asks for before: a push begins when the fingers touch. What is
    asked for before may have ended in the moments before: fingers that let go leave a thing before the next task begins.
    """
    from cramlite.plugin import PADDING, Segment

    from ..episodes.detection.detect import SNAP

    spans = [(start, end)]
    if end - start > 2 * PADDING:
        spans += [(start + PADDING, end), (start, end + PADDING), (start, end - SNAP)]
        spans += [(cut, end) for cut in timeline.cuts if start < cut < end - PADDING]
    since = _opened(timeline, start)
    before = [start, *(cut for cut in reversed(timeline.cuts) if since <= cut < start), since]
    for a, b in spans:
        own = timeline.phases(Segment(a, b))
        for moment in (*before, a) if a <= start + PADDING else (a,):
            yield {**own, "pre": timeline.instant(max(moment, timeline.cuts[0]))}


def _opened(timeline: Timeline, start: float) -> float:
    """Time at which the fingers opened before ``start`` [s]: that of the last release if the hand has not
    moved since, and at least ``OPENING`` earlier than ``start``."""
    from ..predicates.phase_poses import pose_of

    hand = timeline.episode.effector
    ends = [s.end for s in timeline.active_between("cram:GraspState", timeline.cuts[0], start) if s.end <= start]
    last = max((t for t in ends if t >= start - LONGEST), default=start)
    then, now = (pose_of(timeline.instant(t), hand or "", t) for t in (last, start))
    still = then is not None and now is not None and math.dist(then.position, now.position) < STAYED
    return min(last, start - OPENING) if still else start - OPENING


def _judged(rule: Rule, action: Action, timeline: Timeline, ran: Span, name: str, already: str) -> Finding:
    from cramlite.plugin import Segment

    clauses = [c for c in rule.written_order if _asked(c, action, rule) and (not already or c.phase == "post" or _binds(c))]
    unmet = _unmet_in(rule, clauses, action, _ways(timeline, *ran))
    if unmet is None:
        said = " and ".join(dict.fromkeys(f"({c.text})" if " or " in c.text else c.text for c in clauses if c.phase != "pre"))
        nothing = f"nothing was left to do, {already}; {'afterwards: ' if said else ''}" if already else ""
        return Finding(name, True, f"{action.name}: {nothing}{said}".rstrip("; "), origin=action.name)
    roles = ", ".join(f"{k} = {o.entity}" for k, o in action.roles.items())
    clause, bindings = unmet
    when = {"pre": "before", "run": "during", "post": "after"}[clause.phase]
    was = said_values(clause, bindings, timeline.phases(Segment(*ran))[clause.phase])
    said = f"{when} {action.name} '{clause.text}' does not hold{was}" + (f" ({roles})" if roles else "")
    held = "" if _binds(clause) else said_times(held_times(clause, bindings, timeline))
    then = f"; {action.name} ran from {ran.start:.2f} to {ran.end:.2f} s"
    return Finding(name, False, said + (f": {held}{then}" if held else ""), origin=action.name, remedy=_own_rule(rule, clause, when))


def _own_rule(rule: Rule, clause: Clause, when: str) -> Remedy | None:
    """Return the advice about a condition of a user's own rule that did not hold; None for a rule of cramlite's own."""
    where = f"{rule.path}:{clause.line}"
    says = f"'{clause.text}' at {where} does not hold {when} {rule.task}: change what the task does, or this condition of its rule"
    return None if rule.shipped else Remedy(f"rule {where}", says)


def _as_many(rule: Rule, action: Action, timeline: Timeline, ran: Span, name: str) -> Iterator[Finding]:
    """Check that the run reached each number that the task wants and its rule measures, such as a number of swings."""
    from cramlite.plugin import Segment, measured

    roles = {r: o.entity for r, o in action.roles.items() if o.entity}
    for value, count in measured(rule, roles, timeline.phases(Segment(*ran))).items():
        wanted = action.parameters.get(value)
        if isinstance(wanted, int | float):
            said = f"{action.name}: {value} {count:g}, {wanted:g} are wanted"
            yield Finding(name, count >= wanted, said, count, float(wanted), "", action.name)


def _asked(clause: Clause, action: Action, rule: Rule) -> bool:
    """Whether a precondition of a task's rule must hold when the robot begins the task.

    Two negations need not: that the task's result does not hold yet, as a program may find it done; and one
    about a role without a filler, which would be about everything.
    """
    from cramlite.plugin import Not, atoms

    if clause.phase != "pre" or not isinstance(clause.condition, Not):
        return True
    if clause.text in {f"not {c.text}" for c in rule.written_order if c.phase == "post"}:
        return False
    named = {v for a in atoms(clause.condition) for v in a.binds() if v in rule.roles}
    return named <= {k for k, o in action.roles.items() if o.entity}


Unmet = tuple["Clause", list[dict[str, Any]]]
"""A condition that does not hold, and the fillings of variables for which it was asked."""


def _unmet_in(rule: Rule, clauses: list[Clause], action: Action, ways: Iterable[Way]) -> Unmet | None:
    """Unsatisfied condition in the span that satisfies most of a rule; None if one span satisfies all of
    it."""
    furthest: tuple[int, Unmet] | None = None
    for phases in ways:
        unmet = _unmet(clauses, action, rule, phases)
        if unmet is None:
            return None
        met = clauses.index(unmet[0])
        if furthest is None or met > furthest[0]:
            furthest = met, unmet
    return furthest[1] if furthest else None


def _unmet(clauses: Iterable[Clause], action: Action, rule: Rule, phases: Mapping[PhaseName, Phase]) -> Unmet | None:
    """First condition of a rule that cannot be met, with the plan's objects bound to the roles; None if all
    can be met.

    A condition is met if it holds for some values of the variables that are no roles.
    """
    bindings: list[dict[str, Any]] = [
        {k: _felt(o.entity or "", phases) for k, o in action.roles.items() if k in rule.roles}
    ]
    for clause in clauses:
        found = [f for b in bindings for f in clause.condition.solve(phases[clause.phase], b)]
        found = found or [b for end in _ends(rule, clause) for b in bindings if _has_ended(clause, end, phases["pre"], b)]
        if not found:
            return clause, bindings
        bindings = found
    return None


def _ends(rule: Rule, clause: Clause) -> list[Not]:
    """Negated effects of a task that end one of its preconditions, such as the support of a thing that the
    task lifts.

    A robot may find such a precondition ended already, as closing fingers can lift a thing off its support,
    and has nothing left to end then. Preconditions about a thing in the hand are left out: once it has left
    the hand, it is lost.
    """
    from cramlite.plugin import Compare, Not, atoms

    if clause.phase != "pre" or isinstance(clause.condition, Not | Compare):
        return []
    (own, *others) = atoms(clause.condition)
    if others or own.predicate.fluent.in_hand:
        return []
    anyone = [{getattr(t, "name", t), "_"} for t in own.terms]
    after = [c.condition for c in rule.written_order if c.phase == "post"]
    denied = [(c, a) for c in after if isinstance(c, Not) for a in atoms(c) if a.predicate is own.predicate]
    return [c for c, a in denied if all(getattr(t, "name", t) in which for t, which in zip(a.terms, anyone, strict=True))]


def _has_ended(clause: Clause, end: Not, now: Phase, binding: dict[str, Any]) -> bool:
    """Whether a precondition held until an effect of its task, which holds now, ended it."""
    before = [now.timeline.instant(cut) for cut in reversed(now.timeline.cuts) if cut < now.start]
    ended = [next(end.solve(then, binding), None) is not None for then in (now, *before)]
    if False not in ended or not ended[0]:
        return False
    return next(clause.condition.solve((now, *before)[ended.index(False)], binding), None) is not None


def _binds(clause: Clause) -> bool:
    """Whether a clause only identifies entities (the effector, a class), and states no condition on them."""
    from cramlite.plugin import atoms

    return all(a.predicate.timeless for a in atoms(clause.condition))


def _felt(entity: str, phases: Mapping[PhaseName, Phase]) -> str:
    """Entity whose name contacts use: a feature without a shape of its own, such as a table's top, is felt as its thing."""
    known = phases["post"].timeline.entities
    name = EntityName.parse(entity)
    own = not name.part or name.thing not in known or any(g.part == name.part for g in known[name.thing].geoms)
    return entity if own else name.thing


@hookimpl
def validators() -> Iterable[Validator]:
    return [EndState(), TaskRules()]
