"""Classes of the upper ontologies DUL and SOMA that the code names.

All others are found by what ontologies say of them, or are named by plugins.
"""

from __future__ import annotations

TASK = "dul:Task"
"""Superclass of all tasks."""

ROLE = "dul:Role"
"""Superclass of all roles of tasks."""

OBJECT = "dul:PhysicalObject"
"""Class of a thing of which nothing more is known."""

AGENT = "dul:Agent"
"""Superclass of all agents. No thing of a world is an agent."""

ACTION = "soma:PhysicalAction"
"""Class of an event of which nothing more is known than that an agent acts."""

STATE = "soma:StateType"
"""Superclass of all states of an episode. Each state's own class names the state's roles by the property ``STATE_ROLES``."""

STATE_ROLES = "cram:stateRoles"
"""Property of a state's class: the names of its roles, in order."""

TELLS_APART = "cram:tellsActionsApart"
"""Property of a state's class: 1 where two actions are never joined if such a state begins or ends between them."""

BEARS = "cram:bears"
"""Property of a feature's class: how the feature supports things, "hanging", "standing" or "inside"."""
