"""Remainders of a plan whose program was stopped: task sequences that may still have to be done."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import takewhile
from typing import TYPE_CHECKING

from msgspec.structs import replace

from ...base.errors import Unresolvable
from ...model.designator_name import freed_name, is_part_of
from ...model.designators import Action
from ...planning.operators import Grounder

if TYPE_CHECKING:
    from ...model.plan import Plan
    from ...plugin.catalogue import Knowledge
    from ..setting import Setting


def rests_of_plan(plan: Plan, at: int, step: str, setting: Setting, knowledge: Knowledge) -> Iterator[Plan]:
    """Generate the task sequences that could complete a plan after a stop, shortest first.

    First tasks are left out as far as their effects hold already.

    With a payload: the task under way and all later ones; instead of that task its parts from the one under way, or
    from a later one on; or the later tasks alone. With an empty hand: the tasks from the one under way or an earlier one on.

    Args:
        at: index of the task under way.
        step: designator of the step under way.
        setting: as believed after the stop.
    """
    grounder = Grounder(setting.symbolic(knowledge.taxonomy), knowledge.predicates)
    given: list[Plan] = []
    for actions in _rests(plan, at, step, setting, knowledge):
        needless = sum(1 for _ in takewhile(lambda a: _is_done(a, grounder, knowledge), actions))
        rest = replace(plan, actions=actions[needless:])
        if rest.actions and rest not in given:
            given.append(rest)
            yield rest


def _rests(plan: Plan, at: int, step: str, setting: Setting, knowledge: Knowledge) -> Iterator[tuple[Action, ...]]:
    """Generate the task sequences with which a plan could go on; some of their tasks may have their effects already."""
    actions = plan.actions
    if setting.world.robots[0].holds is None:
        yield from (actions[k:] for k in range(at, -1, -1))
        return
    yield actions[at:]
    parts = _parts(actions[at], setting, knowledge) if isinstance(actions[at], Action) else ()
    first = next((k for k, p in enumerate(parts) if is_part_of(step, p.name)), 0)
    rests = ((*parts[k:], *actions[at + 1 :]) for k in range(first, len(parts)))
    yield from (tuple(_renamed(a) for a in rest) for rest in (*rests, actions[at + 1 :]))


def _parts(action: Action, setting: Setting, knowledge: Knowledge) -> tuple[Action, ...]:
    """Return the tasks of the first decomposition that a task's plugin offers for an empty hand; () if there is
    none."""
    mount, *others = setting.world.robots
    empty = replace(setting, world=replace(setting.world, robots=(replace(mount, holds=None), *others)))
    task = knowledge.tasks.get(action.task)
    try:
        way = next(iter(task.decompose(action, empty.belief())), None) if task else None
    except Unresolvable:
        return ()
    return tuple(s for s in way.steps if isinstance(s, Action)) if way else ()


def _is_done(action: Action, grounder: Grounder, knowledge: Knowledge) -> bool:
    """Check whether a task is needless: its effects hold in the believed world and its preconditions do not."""
    rule, task = next((r for r in knowledge.rules if r.task == action.task), None), knowledge.tasks.get(action.task)
    if rule is None or task is None:
        return False
    known = {r: o.entity for r, o in action.roles.items() if o.entity}
    others = {n: c for n, c in grounder.candidates(rule, task).items() if n not in known}
    if any(len(c) != 1 for c in others.values()):
        return False
    found, facts = grounder.operator(rule, task, known | {n: c[0] for n, c in others.items()}), grounder.initial
    return found is not None and bool(found.adds) and found.adds <= facts and not found.applies(facts)


def _renamed(item: Action) -> Action:
    """Return a part of a task under a name of its own, "3.Placing" for "3.PickAndPlace/Placing"."""
    return replace(item, name=freed_name(item.name))
