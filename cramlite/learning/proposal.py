"""Proposal of a task: the learned rule with names for its roles, a superclass, and the evidence for each condition."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping, Sequence

import numpy as np

from ..base.value import Value
from ..interpretation.conditions import atoms
from ..interpretation.rules import Rule
from ..ontology.foundation import ROLE, TASK
from ..ontology.taxonomy import Taxonomy
from .example import Example, solutions
from .learner import Learned, conditions, of_motion
from .literal import Literal
from .procedure import Procedure, Step, procedure
from .shown_motion import ShownMotion
from .shown_rest import ShownRest
from .shown_turn import ShownTurn
from .span import Span
from .tables import Tables

HAND = "Gripper"
"""Variable of a proposed rule that stands for the hand that acts."""
ACCIDENTAL = 12
"""Largest number of dropped conditions that a proposal lists."""


class Evidence(Value):
    """Evidence for one condition of a rule.

    Args:
        texts: as the rule file has it, each with its phase.
        holds_in: examples, those also that were left out as wrong.
        excludes: stretches that no other condition tells from the examples.
        without: what the rule would be without it, a sentence.
    """

    texts: tuple[tuple[str, str], ...]
    holds_in: tuple[str, ...]
    excludes: tuple[str, ...]
    without: str


class Proposal(Value, eq=False):
    """Proposal of a learned task, to be read and changed by a knowledge engineer.

    Args:
        task: its class.
        above: class above it.
        roles: name -> class.
        fillers: of the roles in each example.
        rule: conditions by phase.
        evidence: for each condition.
        dropped: conditions that hold in all examples and that nothing needs.
        undecided: what one more demonstration could decide.
        covered: stretches that are no examples and that the rule covers all the same.
        wrong: examples that it does not cover.
        procedure: the known tasks that explain the examples, as a partial order; None where they explain none of one.
        learned: what it was made of.
        motion: that all examples show and no known task explains, their turn of a thing, or the rest with which they end; None where
            there is none.
    """

    task: str
    above: str
    roles: Mapping[str, str]
    fillers: tuple[tuple[str, ...], ...]
    rule: Mapping[str, Sequence[str]]
    evidence: tuple[Evidence, ...]
    dropped: tuple[str, ...]
    undecided: tuple[str, ...]
    covered: tuple[str, ...]
    wrong: tuple[str, ...]
    procedure: Procedure | None
    learned: Learned
    motion: ShownMotion | ShownTurn | ShownRest | None = None

    @property
    def told(self) -> Literal | None:
        """Condition of the learned rule on the motion that all examples show; None if the rule has none."""
        return next((one for one in self.learned.literals if of_motion(self.learned.language, one)), None)

    @property
    def moving(self) -> tuple[ShownMotion, str, str] | None:
        """Learned path, the role that moves along it, and the role of the reference thing, which may be the
        same; None if the rule asks for no path."""
        names = list(self.roles)
        if self.told is None or not isinstance(self.motion, ShownMotion):
            return None
        return self.motion, names[self.told.slots[0] - 1], names[self.told.slots[-1] - 1]

    @property
    def rest(self) -> ShownRest | None:
        """Learned pause of the hand at the end of the task; None if the rule has no condition on it."""
        return self.motion if self.told is not None and isinstance(self.motion, ShownRest) else None

    @property
    def turning(self) -> tuple[ShownTurn, str] | None:
        """Rotation that a learned rule requires of a thing, and the role of this thing; None if the rule requires none."""
        if self.told is None or not isinstance(self.motion, ShownTurn):
            return None
        return self.motion, list(self.roles)[self.told.slots[0] - 1]

    @property
    def done(self) -> bool:
        """Whether it is known how the task is done: by known tasks, by a motion, by a turn, or just by resting."""
        return bool(self.steps or self.moving or self.turning or (self.rest and not self.learned.cast.changes))

    @property
    def steps(self) -> tuple[Step, ...]:
        """Known tasks that every example contains, in an order that contradicts no example; empty if a motion or turn defines the task."""
        if self.moving or self.turning:
            return ()
        return tuple(s for s in self.procedure.steps if s not in self.procedure.optional) if self.procedure else ()


def propose(
    task: str, learned: Learned, rules: Sequence[Rule], taxonomy: Taxonomy, wrong: Sequence[Span] = (),
    motion: ShownMotion | ShownTurn | ShownRest | None = None,
) -> Proposal:
    """Return the proposal of a new task, with the roles, conditions and evidence of a learned rule.

    Args:
        task: its class, such as "cram:Stirring".
        rules: of the known tasks.
        wrong: the examples that were left out.
        motion: that the examples share.
    """
    roles = _called(learned, _names(rules))
    names = [HAND, *roles]
    evidence = _evidence(learned, names, wrong)
    return Proposal(
        task, _above(learned, rules, taxonomy), roles, learned.cast.fillers, conditions(learned, names), evidence,
        _dropped(learned, names), _undecided(learned, evidence, names), tuple(_covered(learned)), tuple(map(str, wrong)),
        _procedure(learned, roles), learned, motion,
    )  # fmt: skip


def _called(learned: Learned, names: Sequence[tuple[str, str]]) -> dict[str, str]:
    """Return the role names with their classes, in the order of a learned rule's variables; the first of ``names``
    goes to the role whose thing moves farthest.

    Of roles that move equally far, those in the condition on the learned motion come first.
    """
    shown = list(zip(learned.examples, learned.cast.fillers, strict=True))
    told = {s - 1 for one in learned.literals if of_motion(learned.language, one) for s in one.slots}
    order = sorted(range(learned.cast.roles), key=lambda k: (-max(_moved(e.span, f[k]) for e, f in shown), k not in told, k))
    called = dict(zip(order, names, strict=False))
    return dict(called[k] for k in range(learned.cast.roles))


def _moved(span: Span, thing: str) -> float:
    """Return how far a thing was moved between start and end of a span [m], rounded to a millimetre."""
    before, after = (span.timeline.episode.pose_at(thing, t) for t in (span.start, span.end))
    return 0.0 if before is None or after is None else round(math.dist(before.position, after.position), 3)


def _names(rules: Sequence[Rule]) -> list[tuple[str, str]]:
    """Return names of roles with their classes, in the order in which most known tasks name their roles."""
    found: list[tuple[str, str]] = []
    for place in range(max((len(r.roles) for r in rules), default=0)):
        asked = Counter(pair for r in rules for pair in list(r.roles.items())[place : place + 1] if pair[0] not in dict(found))
        found += [pair for pair, _ in asked.most_common(1)]
    spare = Counter(pair for r in rules for pair in list(r.roles.items())[1:] if pair[0] not in dict(found))
    found += [pair for pair, _ in sorted(spare.items(), key=lambda p: (-p[1], p[0]))]
    return [*dict(found).items(), *((f"Other_{k}", ROLE) for k in range(1, 4))]


def _above(learned: Learned, rules: Sequence[Rule], taxonomy: Taxonomy) -> str:
    """Return the superclass of the learned task: the most special known task that covers all examples,
    else the class of all tasks.

    The rule of that task holds in all examples and mentions every predicate that changes in all of them. Where nothing changes in all
    of them, too many rules hold to say anything.
    """
    changes = {c.predicate for c in learned.cast.changes}
    if not changes:
        return TASK
    spoken = [r for r in rules if r.roles and changes <= {a.predicate.name for c in r.clauses for a in atoms(c.condition)}]
    found = [r.task for r in spoken if all(_recognised(r, e.span, f) for e, f in zip(learned.examples, learned.cast.fillers, strict=True))]
    return max(found, key=lambda t: (taxonomy.depth(t), t), default=TASK)


def _recognised(rule: Rule, span: Span, fillers: Sequence[str]) -> bool:
    role = next(iter(rule.roles))
    return any(span.timeline.episode.whole(str(b[role])) in fillers for b in solutions(rule, span))


def _evidence(learned: Learned, names: Sequence[str], wrong: Sequence[Span]) -> tuple[Evidence, ...]:
    """Return the evidence for each condition: examples in which it holds, and counterexamples that only this
    condition excludes."""
    roles, rest = learned.cast.roles, [k.span for k in learned.others]
    shown = [e.span for e in learned.examples]
    tables = Tables(learned.language, [*rest, *shown])
    holds = tables.truths(learned.literals, roles)
    usable = tables.valid(roles).copy()
    for k, place in enumerate(learned.cast.fillers):
        usable[len(rest) + k, tables.place(len(rest) + k, place)] = False
    found = []
    for k, one in enumerate(learned.literals):
        others = [i for i in range(len(learned.literals)) if i != k]
        passed = (holds[others].all(axis=0) & usable & ~holds[k]).any(axis=1)
        excludes = tuple(str(s) for s, p in zip(tables.spans, passed[: len(rest)], strict=False) if p)
        fillers = tuple(str(s) for s, p in zip(shown, passed[len(rest) :], strict=True) if p)
        found.append(Evidence(tuple(one.texts(names)), tuple(map(str, shown)), (*excludes, *(f"other things in {f}" for f in fillers)),
                              _without(excludes, fillers, one, roles)))  # fmt: skip
    return tuple(found)


def _without(excludes: Sequence[str], fillers: Sequence[str], literal: Literal, roles: int) -> str:
    if excludes:
        also = f", such as {excludes[0]}" if excludes else ""
        return f"{len(excludes)} stretch{'es' if len(excludes) > 1 else ''} that are no examples would be recognised{also}"
    if fillers:
        return "the fillers of the roles would be open"
    if literal.kind in ("begins", "ends"):
        return "no other stretch would be recognised, but the effect of the task would not be stated"
    return "no other stretch would be recognised yet: the condition keeps a margin from stretches that are no examples"


def _dropped(learned: Learned, names: Sequence[str]) -> tuple[str, ...]:
    """Return the conditions about a role that hold in all examples but exclude no counterexample."""
    bits = learned.language.bits
    left = sorted((one for one in learned.cast.common if one not in learned.literals and one.binds and "_" not in _said(one, names)),
                  key=lambda one: (one.kind == "holds", bits(one, learned.cast.roles), one))  # fmt: skip
    return tuple(_said(one, names) for one in left[:ACCIDENTAL])


def _said(literal: Literal, names: Sequence[str]) -> str:
    return " and ".join(f"{phase}: {text}" for phase, text in literal.texts(names))


def _undecided(learned: Learned, evidence: Sequence[Evidence], names: Sequence[str]) -> tuple[str, ...]:
    """Return open questions that another demonstration may answer: on conditions with little evidence, and on
    bounds."""
    found = []
    for one, known in zip(learned.literals, evidence, strict=True):
        said = _said(one, names)
        if one.kind in ("at_least", "at_most"):
            found.append(f"where the bound of '{said}' lies: show an example with a value nearer to {one.bound:g}")
        elif len(known.excludes) <= 1 and one not in learned.cast.changes:
            found.append(f"whether '{said}' belongs to the task: show an example in which it does not hold")
    for k, name in enumerate(names[1:]):
        if len({f[k] for f in learned.cast.fillers}) == 1:
            found.append(f"whether the thing in the role {name} must be '{learned.cast.fillers[0][k]}': show an example with another thing")
    return tuple(found)


def _covered(learned: Learned) -> list[str]:
    roles = learned.cast.roles
    if not learned.others:
        return []
    tables = Tables(learned.language, [k.span for k in learned.others])
    holds = np.asarray((tables.truths(learned.literals, roles).all(axis=0) & tables.valid(roles)).any(axis=1))
    return [str(k.span) for k, true in zip(learned.others, holds, strict=True) if true]


def _procedure(learned: Learned, roles: Mapping[str, str]) -> Procedure | None:
    """Return the procedure by which known tasks do what the examples show; None unless known tasks explain
    all examples.

    Their roles are filled by roles of the learned task, or by classes.
    """
    shown = [steps_of(e, f, roles) for e, f in zip(learned.examples, learned.cast.fillers, strict=True)]
    return procedure(shown) if all(shown) else None


def steps_of(one: Example, fillers: Sequence[str], roles: Mapping[str, str]) -> tuple[Step, ...]:
    """Return the known tasks that explain an example, in order, with the learned task's roles in place of the things.

    Args:
        fillers: of the roles in the example.
    """
    said = [(task, [(role, _ours(one.span, fillers, name, roles)) for role, name in known.items()]) for task, known in one.tasks]
    return tuple(Step(task, tuple((role, filler) for role, filler in who if filler)) for task, who in said)


def _ours(span: Span, fillers: Sequence[str], name: str, roles: Mapping[str, str]) -> str:
    """Return the role that a thing fills in the proposed task; else the thing's class; "" for the hand that acts."""
    whole = span.timeline.episode.whole(name)
    if whole in fillers:
        return list(roles)[fillers.index(whole)]
    return "" if whole == span.effector else next(iter(span.timeline.types(name)), "")
