"""Contract checks for plugin authors, to be called in their tests; an AssertionError names the defect.

Example:
    >>> from cramlite.testing import check_plugin     # doctest: +SKIP
    >>> check_plugin("my_package.my_task")            # doctest: +SKIP
"""

# ruff: noqa: I001  # names of one module stay together, each with the alias that exports it

from __future__ import annotations

from typing import TYPE_CHECKING

from ..base.lazy_names import LazyNames

if TYPE_CHECKING:
    from .contracts import KINDS as KINDS, RELATIONS as RELATIONS, check_file as check_file, check_plugin as check_plugin
    from .plan_checks import plan_changes as plan_changes
    from .plugin_checks import (
        check_backend as check_backend, check_expert as check_expert, check_predicate as check_predicate,
        check_robot as check_robot, check_validator as check_validator, sample_program as sample_program,
        sample_robot as sample_robot,
    )
    from .task_checks import check_task_type as check_task_type, sample_action as sample_action, sample_belief as sample_belief

_NAMES = LazyNames(__name__)

if not TYPE_CHECKING:  # else any name would do
    __getattr__, __dir__ = _NAMES.load, _NAMES.known
