"""Facts that should hold when a plan is done: its goal, or those at the end of its demonstration."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING

from ..interpretation.conditions import atoms, mentions
from ..interpretation.fluents import PLAIN, SymbolicWorld
from ..interpretation.goal_literal import GoalLiteral, clauses_of, entities_of
from ..interpretation.timeline import Timeline
from .goal_parser import parse_goal
from .operators import Grounder

if TYPE_CHECKING:
    from ..interpretation.matching import Match
    from ..interpretation.rules import Clause, Rule
    from ..model.designators import Action
    from ..model.plan import Plan
    from ..plugin.catalogue import Knowledge


def literals_of_goals(goals: Iterable[str], scene: SymbolicWorld, knowledge: Knowledge) -> tuple[GoalLiteral, ...]:
    """Return the facts that should hold when goals in words are achieved.

    Args:
        scene: with the things that they name.

    Raises:
        UserError: one is no goal, or names what there is not.
    """
    grounder, predicates = Grounder(scene, knowledge.predicates), {p.name: p for p in knowledge.predicates}
    said = [parse_goal(text, grounder) for text in goals]
    return tuple(
        GoalLiteral(s.text, s.things, clauses_of(s.meaning, predicates), entities_of(s.meaning), s.side, s.other) for s in said
    )


def literals_of_plan(
    plan: Plan, actions: Sequence[Action], scene: SymbolicWorld, knowledge: Knowledge
) -> tuple[GoalLiteral, ...]:
    """Return the facts that should hold when a plan has been carried out.

    Args:
        actions: the plan's, their roles bound to things of the scene. What lasts of others is left out.
    """
    wanted = literals_of_goals(plan.goal, scene, knowledge) if plan.goal else ()
    rules, named = {r.task: r for r in knowledge.rules}, {a.name: a for a in actions}
    known = [(named[name], text) for name, text in plan.lasting if name in named]
    lasting = [_lasting(action, _clause(rules[action.task], text)) for action, text in known if action.task in rules]
    return (*wanted, *{x.says: x for x in lasting if x is not None}.values())


def _lasting(action: Action, clause: Clause | None) -> GoalLiteral | None:
    """Return a postcondition of a task with the action's things in place of variables; None if ``clause`` is None."""
    if clause is None:
        return None
    binding = {r: str(o.entity) for r, o in action.roles.items() if r in mentions(clause.condition)}
    says = re.sub(r"\b[A-Z]\w*", lambda word: binding.get(word[0], word[0]), clause.text)
    return GoalLiteral(says, tuple(binding.values()), (clause,), binding, task=action.name)


def _clause(rule: Rule, text: str) -> Clause | None:
    return next((c for c in rule.clauses if c.phase == "post" and c.text == text), None)


def lasting_of(
    matches: Sequence[Match], actions: Sequence[Action], rules: Mapping[str, Rule], timeline: Timeline
) -> Iterator[tuple[str, str]]:
    """Generate the facts at the end of a demonstration: postconditions of its tasks that still hold when
    the recording ends.

    Only relations that tasks begin and end (``Predicate.fluent``) are meant. That a thing is near, in view or within reach is
    of the moment, and where the hand ended is judged with its task.

    Args:
        matches: the tasks that it was read as.
        actions: of the plan that was made of them, in the same order.
        timeline: of the demonstration.

    Yields:
        Name of the action, and the condition as its rule has it.
    """
    end = timeline.instant(timeline.cuts[-1])
    for match, action in zip(matches, actions, strict=True):
        for clause in rules[match.task].clauses if match.task in rules else ():
            about = mentions(clause.condition) & set(match.roles)
            if clause.phase == "post" and about and about <= set(action.roles) and _changed_by_tasks(clause):
                binding: dict[str, str | float] = {role: match.roles[role] for role in about}
                if next(clause.condition.solve(end, binding), None) is not None:
                    yield action.name, clause.text


def _changed_by_tasks(clause: Clause) -> bool:
    asked = [a.predicate for a in atoms(clause.condition) if not a.predicate.timeless and a.predicate.static is None]
    return bool(asked) and all(p.fluent != PLAIN for p in asked)
