"""Contract checks of task types, as ``cramlite.testing`` offers them."""

from __future__ import annotations

import inspect
import re
import warnings
from collections.abc import Callable, Iterable, Mapping
from functools import cache
from typing import Any

from msgspec.structs import replace

from ..base.errors import Unresolvable, UserError, nearest
from ..base.value import Value
from ..model.belief import Belief, Estimate, Held
from ..model.designators import Action, Late, Location, Motion, Object
from ..model.geometry import Pose
from ..model.world.thing import Feature, Filling, Geom, Thing
from ..model.world.world import RobotMount, World
from ..ontology.foundation import OBJECT
from ..planning.search.alternatives import HOOKS
from ..plugin.catalogue import Knowledge
from ..plugin.location_kind import LocationKind
from ..plugin.registry import Registry
from ..plugin.task_type import Decomposition, TaskType

Hooks = Mapping[str, Callable[..., Any]]
"""Hooks of the plugin that is checked; the plugin need not be installed."""

_CURIE = re.compile(r"[a-z][\w-]*:\w+")


class _Missing(KeyError):
    """Error: ``effects`` asks for a role or parameter that the made-up action of a check does not have."""


class _Sample(dict[str, Any]):
    """Roles or parameters of the made-up action of a check; a missing key raises an error of its own class.

    A scenario would give that key.
    """

    def __missing__(self, key: str) -> Any:
        raise _Missing(key)


class _Known(Value):
    """Names that a checked task's designators may use: kinds of motions, relations, hooks."""

    kinds: Mapping[str, Iterable[str]]
    relations: Iterable[str]
    declared: Mapping[str, LocationKind]
    hooks: Hooks


@cache
def motion_kinds() -> Mapping[str, tuple[str, ...]]:
    """Return the kinds of motions that installed plugins declare, each with the names of its parameters."""
    return {name: kind.knows() for name, kind in Knowledge(Registry()).motion_kinds.items()}


@cache
def location_kinds() -> Mapping[str, LocationKind]:
    """Return the relations of locations that installed plugins declare."""
    return Knowledge(Registry()).location_kinds


def sample_belief(held: str | None = None) -> Belief:
    """Return a belief about a cube that fills every role, and about one arm, which holds the cube if wanted.

    The cube lies on nothing. It is hollow, and there is a grain in it, so that tasks about contents have some.
    """
    hollow = Feature("cavity", "cram:Cavity", Pose((0, 0, 0.02)), {"width": 0.03, "depth": 0.03, "height": 0.03})
    geoms, grain = (Geom("box", (0.02, 0.02, 0.02)),), Filling(1, 0.005, 0.001)
    cube = Thing("cube", OBJECT, Pose((0.5, 0, 0.1)), geoms, (hollow,), 0.1, filling=grain)
    belief = Belief(World((cube,), (RobotMount("arm", "any"),)), {"cube": Estimate(cube.pose)}, "arm", (0.0,) * 6, 0.08)
    return belief.grasped(Held(held, Pose(), 0.04)) if held else belief


def sample_action(task: TaskType) -> Action:
    """Return a made-up action for checking a task type: one cube fills every role, optional ones included."""
    cube = {r.name: Object(f"object_{k}", entity="cube") for k, r in enumerate(task.roles, 1) if not r.effector}
    return Action(f"1.{task.task.split(':')[-1]}", task.task, cube, goal=Location("home", "home"))


def check_task_type(
    task: TaskType,
    *,
    kinds: Mapping[str, Iterable[str]] | None = None,
    relations: Iterable[str] | None = None,
    hooks: Hooks | None = None,
) -> None:
    """Check that a task type answers as the plugin interface requires: names, classes, parameters, decompositions, effects.

    Its names are right, its classes are in an ontology, parameters have sources, and in an empty-handed and in a holding
    belief, and on a robot that drives, its decompositions are made of designators that some plugin resolves, or it says
    ``Unresolvable`` with a reason; any other exception is a bug. What `effects` gives after each of them is a Belief; where it
    asks for a role or parameter that the sample action has not, a warning says that it was not checked.

    Args:
        kinds: motion kinds with the parameters that each knows; by default those that installed plugins declare.
        relations: relations of places; by default those that installed plugins declare.
        hooks: functions of the plugin itself by hook, which are asked too; ``check_plugin`` gives them.

    Raises:
        AssertionError: with what is wrong.
    """
    known, beliefs = _known(kinds, relations, hooks or {}), _beliefs()
    _check_declaration(task)
    _check_classes(task, known.hooks)
    found = [(belief, _decompositions(task, belief)) for belief in beliefs]
    assert any(ways for _, ways in found), (
        f"{task.task}: decompose gives no way to do it: neither with an empty gripper, nor with a holding one, nor with a robot that drives"
    )
    for belief, ways in found:
        for way in ways:
            _check_decomposition(task, way, known)
        if ways:
            _check_effects(task, beliefs if any(map(_regrasps, ways)) else (belief,))


def _known(kinds: Mapping[str, Iterable[str]] | None, relations: Iterable[str] | None, hooks: Hooks) -> _Known:
    """Return the names that designators may use: the given ones, else those that installed plugins and the
    checked plugin declare."""
    own = {hook: {k.name: k for k in hooks[hook]()} for hook in ("motion_kinds", "location_kinds") if hook in hooks}
    declared = {**location_kinds(), **own.get("location_kinds", {})}
    motions = {**motion_kinds(), **{name: kind.knows() for name, kind in own.get("motion_kinds", {}).items()}}
    return _Known(motions if kinds is None else kinds, declared if relations is None else tuple(relations), declared, hooks)


def _beliefs() -> tuple[Belief, ...]:
    return sample_belief(), sample_belief("cube"), replace(sample_belief(), at=Pose())


def _decompositions(task: TaskType, belief: Belief) -> list[Decomposition]:
    try:
        return list(task.decompose(sample_action(task), belief))
    except Unresolvable as impossible:
        assert impossible.reason.strip(), f"{task.task}: Unresolvable needs a reason"  # noqa: PT017 - this is no test
        return []
    except Exception as error:
        raise AssertionError(f"{task.task}.decompose raised {error!r}; the only exception that it may raise is Unresolvable") from error


def _regrasps(way: Decomposition) -> bool:
    """Check whether a task's steps may change the payload, so that ``effects`` gets another belief than
    ``decompose`` got."""
    return any(isinstance(s, Action) or (isinstance(s, Motion) and s.kind == "gripper") for s in way.steps)


def _check_effects(task: TaskType, beliefs: Iterable[Belief]) -> None:
    """Check that ``effects`` works on a made-up action in one of the beliefs that the task may lead to."""
    action, wrong = sample_action(task), []
    action = replace(action, roles=_Sample(action.roles), parameters=_Sample())
    for belief in beliefs:
        try:
            after = task.effects(action, belief)
        except _Missing as missing:
            _excuse(task, str(missing.args[0]))
            return
        except Exception as error:
            wrong.append(error)
            continue
        assert isinstance(after, Belief), f"{task.task}: effects must give a Belief, not {after!r}"
        return
    raise AssertionError(
        f"{task.task}.effects raised {wrong[0]!r} for the sample action; it must return the belief after the action"
    ) from wrong[0]


def _excuse(task: TaskType, name: str) -> None:
    """Report that a task type's ``effects`` reads a key that is missing in the sample action of its check.

    A declared parameter or an unknown role is an error, a key that only scenarios give a warning.
    """
    declared = [p.name for p in task.parameters]
    assert name not in declared, (
        f"{task.task}.effects asks for action.parameters['{name}'], which is there only where a scenario gives it; "
        f"self.parameter(action, '{name}') has the default too"
    )
    role, roles = task.role(name), [r.name for r in task.roles]
    assert role is not None or not name[:1].isupper(), f"{task.task}.effects asks for a role '{name}'; {nearest(name, roles)}"
    warnings.warn(
        f"{task.task}: effects was not checked: it asks for '{name}', which the sample action does not have", stacklevel=4
    )


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
    for role in task.roles:
        for attribute in ("types", "features", "affords"):
            said = getattr(role, attribute)
            assert not isinstance(said, str), f"{task.task}: role '{role.name}': {attribute} must be a tuple of classes, not '{said}'"
    for parameter in task.parameters:
        assert parameter.source, f"{task.task}: parameter '{parameter.name}' does not say where its default comes from"


def _check_classes(task: TaskType, hooks: Hooks) -> None:
    """Check that every class that a role requires is in a shipped ontology or in one of the plugin."""
    asked = [(r.name, c) for r in task.roles for c in (*r.types, *r.features, *r.affords)]
    if not asked:
        return
    own = hooks["ontologies"]() if "ontologies" in hooks else ()
    taxonomy = Knowledge(Registry(), own).taxonomy
    for role, name in asked:
        try:
            taxonomy.known(name, f"{task.task}: role '{role}'")
        except UserError as error:
            raise AssertionError(str(error)) from error


def _check_decomposition(task: TaskType, way: Decomposition, known: _Known) -> None:
    assert isinstance(way, Decomposition), f"{task.task}: decompose gives Decompositions, not {type(way).__name__}"
    assert way.reason, f"{task.task}: a way needs a reason"
    for step in way.steps:
        assert isinstance(step, tuple(HOOKS)), f"{task.task}: {step!r} is no designator"
        match step:
            case Motion():
                _check_motion(task, step, known)
            case Location():
                _check_location(task, step, known)
            case Action():
                if step.goal is not None:
                    _check_location(task, step.goal, known)
    names = [s.name for s in way.steps if isinstance(s, Action | Motion | Late)]
    assert len(set(names)) == len(names), f"{task.task}: steps share a name: {names}"


def _check_motion(task: TaskType, motion: Motion, known: _Known) -> None:
    said, touched = f"{task.task}: {motion.name}", motion.may_touch
    assert not isinstance(touched, str), f"{said}: may_touch must be a tuple of names, not '{touched}'"
    assert isinstance(motion.to, Location | None), f"{said} leads to {motion.to!r}"
    if motion.kind not in known.kinds:
        assert _answered(motion, known.hooks), f"{said}: no plugin knows kind '{motion.kind}'; {nearest(motion.kind, known.kinds)}"
        return
    valid = tuple(known.kinds[motion.kind])
    for name in motion.parameters:
        assert name in valid, f"{said}: a motion of kind '{motion.kind}' has no parameter '{name}'; {nearest(name, valid)}"
    if motion.to is not None:
        _check_location(task, motion.to, known)


def _check_location(task: TaskType, location: Location, known: _Known) -> None:
    relation = location.relation
    assert relation in known.relations or _answered(location, known.hooks), (
        f"{task.task}: {location.name}: no plugin answers the relation '{relation}'; {nearest(relation, known.relations)}"
    )
    wrong = known.declared[relation].misfit(location.parameters) if relation in known.declared else ""
    assert not wrong or _answered(location, known.hooks), f"{task.task}: {location.name}: {wrong}"


def _answered(designator: Location | Motion, hooks: Hooks) -> bool:
    """Check whether the plugin under test or an installed plugin answers a designator; an error counts as an answer, as the check gives no
    context."""
    hook, registry = HOOKS[type(designator)], Registry()
    asked = {"designator": designator, "location": designator, "motion": designator, "belief": sample_belief(), "context": None}
    if hook in hooks:
        try:
            if hooks[hook](**{n: asked[n] for n in inspect.signature(hooks[hook]).parameters}) is not None:
                return True
        except Exception:
            return True
    faults = len(registry.faults)
    answers = registry.alternatives(hook, designator, belief=asked["belief"], context=None)
    return next(answers, None) is not None or len(registry.faults) > faults
