"""Reasons why no task sequence achieves a goal."""

from __future__ import annotations

from collections.abc import Iterable

from ...interpretation.fluents import Fact, pattern_text
from ...model.entity_name import thing_of
from .action_schema import ActionSchema, action_schemas
from .planning_problem import PlanningProblem
from .schema_effects import fillers, may_make, misfits

NAMED = 3
"""Largest number of things that a reason lists."""


def why_unreachable(problem: PlanningProblem) -> str:
    """Explain why no task sequence was found: no task brings a goal fact about, or no sequence leads to the
    goal."""
    schemas = action_schemas(problem.grounder, problem.knowledge.goal_rules, problem.knowledge.tasks)
    made = [(s, f) for s in schemas for f in s.change.adds]
    missing = [f for f in sorted(problem.wanted.needs - problem.facts) if not any(may_make(s, a, f) for s, a in made)]
    missing = [f for f in missing if f not in problem.wanted.constraints]
    if missing:
        why = _keeping(problem, map(thing_of, missing[0][1:])) or _unfit(problem, made, missing[0])
        return f"no task's rule makes {pattern_text(missing[0])} true with the things of this world{why}"
    why = _keeping(problem, problem.grounder.things)
    return f"no sequence of tasks leads from the initial state to the goal, with whatever things{why}"


def _keeping(problem: PlanningProblem, things: Iterable[str]) -> str:
    """Return a clause that names those of some things that must keep their place; "" if none must."""
    kept = ", ".join(f"'{name}'" for name in sorted(problem.grounder.scene.kept.intersection(things)))
    return f"; not to be moved (limits: keep): {kept}" if kept else ""


def _unfit(problem: PlanningProblem, made: Iterable[tuple[ActionSchema, Fact]], fact: Fact) -> str:
    """Describe the only thing that keeps all rules from making a goal fact; "" if several things do.

    It is a fixed thing that would have to be moved, or a thing in whose place only a few others can be.
    """
    others = set[str]()
    entities = set[str]()
    for schema, added in made:
        unfit = misfits(schema, added, fact) if added[0] == fact[0] else {}
        for term, entity in unfit.items() if len(unfit) == 1 else ():
            thing = problem.grounder.things.get(thing_of(entity))
            if term in schema.in_hand and thing is not None and not thing.movable:
                return f": '{thing.name}' is fixed, since it has no mass"
            entities.add(entity)
            others |= fillers(schema).get(term, frozenset()) - {*fact}
    if len(entities) != 1 or not 0 < len(others) <= NAMED:
        return ""
    named = " or ".join(f"'{other}'" for other in sorted(others))
    return f": only {named} can be in the place of '{entities.pop()}'"
