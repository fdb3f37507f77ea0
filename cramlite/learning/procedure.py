"""Procedures: demonstrations of the same work as a partial order of steps, some of them optional, alternative
or repeated.

A step comes before another if it does so in every demonstration that has both; who was seen in both orders is exchangeable. Another
demonstration is compared with that.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from itertools import combinations

import yaml

from ..base.errors import UserError
from ..base.value import Value

SURE = 5
"""Number of demonstrations from which a constant order counts as required: by chance, one of 32 pairs would look
so."""


class Step(Value, order=True):
    """Step of a job: a task with the things that fill its roles.

    Args:
        task: its class.
        fillers: role and who fills it.
        number: of its occurrence, from 1: what is done twice is two steps.
    """

    task: str
    fillers: tuple[tuple[str, str], ...] = ()
    number: int = 1

    def __str__(self) -> str:
        who = "".join(f" {filler}" for _, filler in self.fillers)
        again = f" ({self.number}.)" if self.number > 1 else ""
        return f"{self.task.split(':')[-1]}{who}{again}"


class Deviation(Value):
    """Deviation of a demonstration from a procedure.

    Args:
        what: "step missing", "unknown step", "wrong order", "both alternatives", or "order not seen otherwise".
        steps: it is about.
        mistake: whether it is one; else a notice.
    """

    what: str
    steps: tuple[Step, ...]
    mistake: bool = True

    def __str__(self) -> str:
        return f"{self.what}: {', then '.join(map(str, self.steps))}"


class Procedure(Value):
    """Procedure that several demonstrations of the same work share: its steps, and which step comes before which.

    Args:
        steps: of all demonstrations, in an order that contradicts none.
        before: pairs of which the first always came first, each with how often that was seen.
        optional: steps that some demonstrations left out.
        alternatives: pairs of optional steps of which every demonstration has exactly one.
        count: of demonstrations.
    """

    steps: tuple[Step, ...]
    before: dict[tuple[Step, Step], int]
    optional: frozenset[Step]
    alternatives: frozenset[tuple[Step, Step]]
    count: int

    @property
    def order(self) -> frozenset[tuple[Step, Step]]:
        """Pairs of steps of which the first one was done before the second one in every demonstration."""
        return frozenset(self.before)

    def repeated(self) -> dict[tuple[str, tuple[tuple[str, str], ...]], tuple[int, int]]:
        """Return the steps that were done more than once: (task, things in its roles) -> least and greatest
        number of times."""
        most = Counter((s.task, s.fillers) for s in self.steps)
        least = Counter((s.task, s.fillers) for s in self.steps if s not in self.optional)
        return {key: (least[key], times) for key, times in most.items() if times > 1}


def numbered(steps: Sequence[Step]) -> tuple[Step, ...]:
    """Return the steps with numbers, which tell apart steps with the same task and things: the first is 1."""
    seen: Counter[tuple[str, tuple[tuple[str, str], ...]]] = Counter()
    found = []
    for step in steps:
        seen[step.task, step.fillers] += 1
        found.append(Step(step.task, step.fillers, seen[step.task, step.fillers]))
    return tuple(found)


def procedure(demonstrations: Sequence[Sequence[Step]]) -> Procedure:
    """Return the procedure that demonstrations share: the order of their steps, optional steps and alternatives.

    Raises:
        UserError: there is none, or one has no step.
    """
    shown = [numbered(steps) for steps in demonstrations]
    if not shown or not all(shown):
        raise UserError("A procedure is learned from one or more demonstrations, each with at least one step that a known task explains.")
    places = [{step: k for k, step in enumerate(steps)} for steps in shown]
    every = sorted({s for steps in shown for s in steps})
    before: dict[tuple[Step, Step], int] = {}
    for one, other in combinations(every, 2):
        ways = [p[one] < p[other] for p in places if one in p and other in p]
        if ways and all(ways):
            before[one, other] = len(ways)
        elif ways and not any(ways):
            before[other, one] = len(ways)
    optional = frozenset(s for s in every if any(s not in p for p in places))
    alternatives = frozenset(
        pair for pair in combinations(sorted(optional), 2) if all((pair[0] in p) != (pair[1] in p) for p in places)
    )
    return Procedure(_linear(every, before, shown), before, optional, alternatives, len(shown))


def _linear(every: Sequence[Step], before: dict[tuple[Step, Step], int], shown: Sequence[Sequence[Step]]) -> tuple[Step, ...]:
    """Sort steps so that no pair of a partial order is contradicted, as near to the first demonstrations'
    order as possible."""
    rank = {s: next((k, steps.index(s)) for k, steps in enumerate(shown) if s in steps) for s in every}
    left, found = list(every), list[Step]()
    while left:
        ready = [s for s in left if not any((other, s) in before for other in left)] or left
        found.append(min(ready, key=lambda s: (rank[s][1], rank[s][0], s)))
        left.remove(found[-1])
    return tuple(found)


def deviations(known: Procedure, steps: Sequence[Step]) -> Iterator[Deviation]:
    """Yield the deviations of a demonstration from a procedure: mistakes, and notices of an order not seen
    before."""
    done = numbered(steps)
    place = {s: k for k, s in enumerate(done)}
    for step in known.steps:
        if step not in place and step not in known.optional:
            yield Deviation("step missing", (step,))
    for one, other in sorted(known.alternatives):
        if one in place and other in place:
            yield Deviation("both alternatives", (one, other))
        elif one not in place and other not in place:
            yield Deviation("step missing", (one,))
    for step in done:
        if step not in known.steps:
            yield Deviation("unknown step", (step,))
    for (one, other), times in sorted(known.before.items()):
        if one in place and other in place and place[one] > place[other]:
            sure = times >= SURE
            yield Deviation("wrong order" if sure else "order not seen otherwise", (other, one), sure)


def plan_text(known: Procedure) -> str:
    """Return the procedure in the plan language of scenarios, in an order that contradicts no demonstration.

    Alternatives, and neighbours that are exchangeable, are a ``choose``; what was done several times in a row in every demonstration is a
    ``repeat``; optional steps are left out, and named in a comment.
    """
    chosen = {s: pair for pair in known.alternatives for s in pair}
    steps = [s for s in known.steps if s not in known.optional or s in chosen]
    entries: list[object] = []
    while steps:
        step = steps.pop(0)
        if step in chosen:
            pair = chosen[step]
            entries.append({"choose": [_entry(s) for s in pair]})
            steps = [s for s in steps if s not in pair]
        elif steps and steps[0] not in chosen and _exchangeable(known, step, steps[0]):
            other = steps.pop(0)
            entries.append({"choose": [[_entry(step), _entry(other)], [_entry(other), _entry(step)]]})
        else:
            times = 1
            while steps and (steps[0].task, steps[0].fillers) == (step.task, step.fillers):
                steps.pop(0)
                times += 1
            entries.append(_entry(step) if times == 1 else {"repeat": {"times": times, "do": [_entry(step)]}})
    left_out = [str(s) for s in known.steps if s in known.optional and s not in chosen]
    comment = f"# optional: {'; '.join(left_out)}\n" if left_out else ""
    return comment + yaml.safe_dump({"tasks": entries}, sort_keys=False, default_flow_style=None, width=110)


def _exchangeable(known: Procedure, one: Step, other: Step) -> bool:
    return (one, other) not in known.before and (other, one) not in known.before


def _entry(step: Step) -> dict[str, str]:
    return {"task": step.task, **dict(step.fillers)}
