"""Classes of the upper ontologies DUL and SOMA that the code names.

All others are found by what ontologies say of them, or are named by plugins.
"""

from __future__ import annotations

TASK = "dul:Task"
"""Class of every task."""

ROLE = "dul:Role"
"""Class of every role of a task."""

OBJECT = "dul:PhysicalObject"
"""Class of a thing of which nothing more is known."""

AGENT = "dul:Agent"
"""Class of agents; no thing is one."""

ACTION = "soma:PhysicalAction"
"""Class of an event of which only an agent's action is known."""

STATE = "soma:StateType"
"""Class of every state of an episode; its own class names its roles by ``STATE_ROLES``."""

STATE_ROLES = "cram:stateRoles"
"""Property of a state's class: the names of its roles, in order."""

TELLS_APART = "cram:tellsActionsApart"
"""Property of a state's class: 1 where no joined action may hide that such a state began or ended."""

BEARS = "cram:bears"
"""Property of a feature's class: how it bears things, "hanging", "standing" or "inside"."""
