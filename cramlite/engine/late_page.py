"""Report of a solution, written by a package that is imported only when a page is asked for.

That package lies in a layer above the engine.
"""

from __future__ import annotations

from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ..plugin.catalogue import Knowledge

WRITER = "cramlite.report"
"""Module whose ``write_one_page`` writes a report."""


def write_page_of(solution: object, knowledge: Knowledge, path: Path) -> Path:
    """Write the report of a solution to a file; return its path."""
    import_module(WRITER).write_one_page(solution, knowledge, path)
    return path
