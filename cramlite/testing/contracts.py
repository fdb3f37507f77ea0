"""Checks of a whole plugin, and access to the declarations of installed plugins."""

from __future__ import annotations

import importlib
import inspect
import warnings
from collections.abc import Iterable, Mapping
from pathlib import Path
from types import ModuleType
from typing import Any

from ..planning.symbolic.symbolic_planner import has_planner
from ..plugin import hookspecs
from ..plugin.registry import Registry
from .plan_checks import plan_changes
from .plugin_checks import CHECKS, check_declared
from .task_checks import check_task_type, location_kinds, motion_kinds

KINDS: Mapping[str, tuple[str, ...]]
"""Kinds of motions that installed plugins declare, each with the names of its parameters."""
RELATIONS: tuple[str, ...]
"""Relations of locations that installed plugins declare."""


def __getattr__(name: str) -> Any:
    """Compute ``KINDS`` (of motions) and ``RELATIONS`` (of locations) from installed plugins at their first use."""
    if name not in ("KINDS", "RELATIONS"):
        raise AttributeError(f"module '{__name__}' has no attribute '{name}'")
    globals()[name] = motion_kinds() if name == "KINDS" else tuple(location_kinds())
    return globals()[name]


def check_plugin(
    module: str | ModuleType,
    *,
    kinds: Mapping[str, Iterable[str]] | None = None,
    relations: Iterable[str] | None = None,
    plans: bool = True,
) -> None:
    """Check that a plugin module loads, that its hooks match their specifications, and that it keeps its contracts.

    A warning lists the goals of shipped scenarios that are planned with other tasks when the plugin is installed
    (``plan_changes``); of a task with a rule that goals can use, this takes some seconds.

    Args:
        kinds, relations: as ``check_task_type`` takes them.
        plans: whether these goals are planned, where the planner of goals is installed.

    Raises:
        AssertionError: with what is wrong.
    """
    plugin = importlib.import_module(module) if isinstance(module, str) else module
    own = {n: f for n, f in vars(plugin).items() if hasattr(f, "cramlite_impl")}
    assert own, f"{plugin.__name__}: no function is marked with cramlite.plugin.hookimpl"
    for name, function in own.items():
        specification = getattr(hookspecs, name, None)
        assert specification is not None, f"{plugin.__name__}: there is no hook '{name}'"
        valid, given = (list(inspect.signature(f).parameters) for f in (specification, function))
        assert set(given) <= set(valid), f"{plugin.__name__}.{name}({', '.join(given)}): arguments are {valid}"
    for task in own["task_types"]() if "task_types" in own else ():
        check_task_type(task, kinds=kinds, relations=relations, hooks=own)
    for hook in CHECKS.keys() & own.keys():
        check_declared(hook, own[hook]())
    if plans and "task_types" in own and has_planner() and (changes := plan_changes(plugin)):
        warnings.warn(f"{plugin.__name__} changes plans: {'; '.join(map(str, changes))}", stacklevel=2)


def check_file(path: Path) -> None:
    """Check that a plugin file loads beside all installed plugins, without a fault and without a clash of
    names."""
    from ..plugin.catalogue import Knowledge

    registry = Registry((path,), strict=False)
    _ = Knowledge(registry).tasks
    assert not registry.faults, "; ".join(str(f) for f in registry.faults)
