"""Symbolic planning: goals as facts, task rules as planning actions, PDDL, and the plans of a planner."""
