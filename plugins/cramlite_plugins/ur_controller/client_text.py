"""Python programs that speak to a controller, told from URScript by their text alone."""

from __future__ import annotations

import re

CLIENTS = re.compile(r"^\s*(?:from|import)\s+(rtde_control|rtde_receive|rtde_io|dashboard_client|rtde|socket)\b", re.MULTILINE)
"""Imports by which a Python program is known that speaks to a controller; URScript has no imports."""


def is_client_program(text: str) -> bool:
    """Check whether a text is a Python program that speaks to a controller."""
    return CLIENTS.search(text) is not None
