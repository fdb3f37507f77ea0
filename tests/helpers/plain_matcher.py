"""The definition of a match: every condition of one rule is solved in turn, nothing is shared between rules.

The decision tree, which the product uses, must find the same (tests/interpretation/test_rules_oracle.py).
"""

from __future__ import annotations

from cramlite.interpretation.conditions import Binding
from cramlite.interpretation.matching import Match, Phases, matches_of
from cramlite.interpretation.rules import Rule


def match(rule: Rule, phases: Phases) -> tuple[Match, ...]:
    """Return all matches of a rule with the phases of an action: one for each distinct filling of the roles."""
    bindings: list[Binding] = [{}]
    for clause in rule.quick_order:
        phase, condition = phases[clause.phase], clause.condition
        bindings = [found for binding in bindings for found in condition.solve(phase, binding)]
        if not bindings:
            return ()
    return matches_of(rule, bindings)
