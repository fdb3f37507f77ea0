"""Contract checks for plugin authors: call them in your tests; they raise AssertionError with what is wrong.

Example:
    >>> from cramlite.testing import check_plugin     # doctest: +SKIP
    >>> check_plugin("my_package.my_task")            # doctest: +SKIP
"""

from __future__ import annotations

import importlib
import inspect
import re
from collections.abc import Iterable
from pathlib import Path
from types import ModuleType

from msgspec.structs import replace

from . import hookspecs
from .belief import Belief, Estimate, Held
from .contracts import (
    CHECKS,
    check_backend,
    check_declared,
    check_expert,
    check_predicate,
    check_robot,
    check_validator,
    sample_program,
    sample_robot,
)
from .designators import Action, Late, Location, Motion, Object
from .errors import Unresolvable
from .geometry import Pose
from .registry import Registry
from .search import HOOKS
from .tasks import Decomposition, TaskType
from .world import Feature, Filling, Geom, RobotMount, Thing, World

__all__ = [
    "KINDS", "check_backend", "check_expert", "check_file", "check_plugin", "check_predicate", "check_robot",
    "check_task_type", "check_validator", "sample_action", "sample_belief", "sample_program", "sample_robot",
]  # fmt: skip

KINDS = (
    "transfer", "linear", "gripper", "until_contact", "force_path", "spiral_search", "force_insert", "force_extract",
    "compliant_slide", "payload", "zero_sensor", "hold", "tilt", "drive", "back",
)  # fmt: skip
"""Motion kinds that the motion plugins of cramlite resolve (``Motion.kind``)."""

_CURIE = re.compile(r"[a-z][\w-]*:\w+")


def sample_belief(held: str | None = None) -> Belief:
    """A cube with every filler's name on nothing, one arm, and, if wanted, the cube in its gripper. The cube is hollow, and
    there is a grain in it, so that tasks about contents have some."""
    hollow = Feature("cavity", "cram:Cavity", Pose((0, 0, 0.02)), {"width": 0.03, "depth": 0.03, "height": 0.03})
    geoms, grain = (Geom("box", (0.02, 0.02, 0.02)),), Filling(1, 0.005, 0.001)
    cube = Thing("cube", "dul:PhysicalObject", Pose((0.5, 0, 0.1)), geoms, (hollow,), 0.1, filling=grain)
    belief = Belief(World((cube,), (RobotMount("arm", "any"),)), {"cube": Estimate(cube.pose)}, "arm", (0.0,) * 6, 0.08)
    return belief.grasped(Held(held, Pose(), 0.04)) if held else belief


def sample_action(task: TaskType) -> Action:
    """An action whose roles all mean the cube, with every optional role filled."""
    cube = {r.name: Object(f"object_{k}", entity="cube") for k, r in enumerate(task.roles, 1) if not r.effector}
    return Action(f"1.{task.task.split(':')[-1]}", task.task, cube, goal=Location("home", "home"))


def check_task_type(task: TaskType, *, kinds: Iterable[str] = KINDS) -> None:
    """A task type keeps its contract.

    Its names are right, parameters have sources, and in an empty-handed and in a holding belief, and on a robot that
    drives, its decompositions are made of designators, or it says ``Unresolvable`` with a reason; any other exception is a bug.

    Raises:
        AssertionError: with what is wrong.
    """
    _check_declaration(task)
    ways: list[Decomposition] = []
    for belief in (sample_belief(), sample_belief("cube"), replace(sample_belief(), at=Pose())):
        try:
            ways += list(task.decompose(sample_action(task), belief))
        except Unresolvable as impossible:
            assert impossible.reason.strip(), f"{task.task}: Unresolvable needs a reason"  # noqa: PT017 - this is no test
        except Exception as error:
            raise AssertionError(f"{task.task}.decompose raised {error!r}; only Unresolvable is an answer") from error
    _check_effects(task)
    assert ways, f"{task.task}: neither an empty nor a holding gripper can do it, nor a robot that drives"
    for way in ways:
        _check_decomposition(task, way, set(kinds))


def _check_effects(task: TaskType) -> None:
    try:
        after = task.effects(sample_action(task), sample_belief("cube"))
    except Exception:
        return  # it may want more of its action than a cube can give; the run of a scenario shows that
    assert isinstance(after, Belief), f"{task.task}: effects gives a Belief, not {after!r}"


def _check_declaration(task: TaskType) -> None:
    assert _CURIE.fullmatch(task.task), f"'{task.task}' is no CURIE such as 'soma:Grasping'"
    names = [task.task.split(":")[-1], *task.aliases]
    assert len(set(names)) == len(names), f"{task.task}: names repeat: {names}"
    assert task.summary, f"{task.task}: no summary"
    roles = [r.name for r in task.roles]
    wrong = [n for n in roles if not re.fullmatch(r"[A-Z]\w*", n)]
    assert not wrong, f"{task.task}: a role is also a variable of rules, so '{wrong[0]}' must be one capitalised word"
    assert task.rule_file is None or task.rule_file.is_file(), f"{task.task}: there is no rule file '{task.rule_file}'"
    assert len(set(roles)) == len(roles), f"{task.task}: roles repeat: {roles}"
    for parameter in task.parameters:
        assert parameter.source, f"{task.task}: parameter '{parameter.name}' does not say where its default comes from"


def _check_decomposition(task: TaskType, way: Decomposition, kinds: set[str]) -> None:
    assert isinstance(way, Decomposition), f"{task.task}: decompose gives Decompositions, not {type(way).__name__}"
    assert way.reason, f"{task.task}: a way needs a reason"
    for step in way.steps:
        assert isinstance(step, tuple(HOOKS)), f"{task.task}: {step!r} is no designator"
        if isinstance(step, Motion):
            assert step.kind in kinds, f"{task.task}: no motion plugin knows kind '{step.kind}'"
            touched = step.may_touch
            assert not isinstance(touched, str), f"{task.task}: {step.name}: may_touch is a tuple of names, not '{touched}'"
            assert isinstance(step.to, Location | None), f"{task.task}: {step.name} leads to {step.to!r}"
    names = [s.name for s in way.steps if isinstance(s, Action | Motion | Late)]
    assert len(set(names)) == len(names), f"{task.task}: steps share a name: {names}"


def check_plugin(module: str | ModuleType) -> None:
    """A plugin module loads, its hooks exist and match their specifications, and what it declares keeps its contract.

    Raises:
        AssertionError: with what is wrong.
    """
    plugin = importlib.import_module(module) if isinstance(module, str) else module
    own = {n: f for n, f in vars(plugin).items() if hasattr(f, "cramlite_impl")}
    assert own, f"{plugin.__name__}: no function is marked with cramlite.hookimpl"
    for name, function in own.items():
        specification = getattr(hookspecs, name, None)
        assert specification is not None, f"{plugin.__name__}: there is no hook '{name}'"
        valid, given = (list(inspect.signature(f).parameters) for f in (specification, function))
        assert set(given) <= set(valid), f"{plugin.__name__}.{name}({', '.join(given)}): arguments are {valid}"
    for task in own["task_types"]() if "task_types" in own else ():
        check_task_type(task)
    for hook in CHECKS.keys() & own.keys():
        check_declared(hook, own[hook]())


def check_file(path: Path) -> None:
    """A plugin in a file loads beside all installed ones, without a fault and without a clash of names."""
    from .knowledge import Knowledge

    registry = Registry((path,), strict=False)
    _ = Knowledge(registry).tasks
    assert not registry.faults, "; ".join(str(f) for f in registry.faults)
