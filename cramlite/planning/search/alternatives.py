"""Groundings (concrete answers) of a designator, which all plugins generate lazily, merged by cost."""

from __future__ import annotations

import heapq
import math
from collections.abc import Iterable, Iterator, Mapping
from functools import partial
from numbers import Real
from typing import Any, get_args

from msgspec.structs import replace

from ...base.errors import Unresolvable, nearest
from ...base.seeds import derive_seed
from ...base.value import Value
from ...model.belief import Belief
from ...model.collision import Collision
from ...model.control_flow import Compound, Mark, ways
from ...model.designator_name import is_part_of
from ...model.designators import Action, Designator, Late, Location, Motion, Object, Place, Stand
from ...model.program.steps import AnyStep
from ...model.remedy import Remedy
from ...plugin.grounding import Context, Grounding, Refused
from ...plugin.location_kind import LocationKind
from ...plugin.registry import Registry
from ...plugin.task_type import Decomposition, TaskType
from ...plugin.validation import WrongAnswer
from ..refutation import as_they_are
from .answers import Answers
from .choice_point import ChoicePoint
from .state import Effect, State, ground_roles

HOOKS: dict[type, str] = {
    Action: "resolve_action",
    Object: "resolve_object",
    Late: "resolve_object",
    Location: "resolve_location",
    Motion: "resolve_motion",
}
VALUES: dict[type, tuple[type, ...]] = {Action: (Decomposition,), Object: (str,), Late: (str,), Location: (Place, Stand)}
"""Type of the value that grounds each designator; that of a motion is the steps of the program."""
Alternative = tuple[str, Grounding]
"""Name of a plugin, and a grounding that the plugin gave."""


class Alternatives(Value):
    """Source of the groundings of designators: registry, task types and context.

    Args:
        registry: the plugins.
        tasks: task types by class.
        owners: which plugin declared each task type.
        context: for plugins; bindings and seed are set for each question.
        answers: that were given so far.
        relations: relation -> the plugin that declares it, and its kind.
    """

    registry: Registry
    tasks: Mapping[str, TaskType]
    owners: Mapping[str, str]
    context: Context
    answers: Answers
    relations: Mapping[str, tuple[str, LocationKind]]

    def of(self, point: ChoicePoint) -> Iterator[Alternative]:
        """Generate the groundings of a designator, the cheapest first.

        What was refused goes to the trace, its causes to the point's conflict set.
        """
        if isinstance(point.item, Compound):
            yield from (("engine", Grounding(way, way.reason, way.cost, key=way.reason)) for way in ways(point.item))
            return
        if isinstance(point.item, Action) and not self._fits(point, point.item):
            return
        faults = len(self.registry.faults)
        streams = [self._accepted(plugin, answers, point) for plugin, answers in self._asked(point)]
        if not streams:  # of a motion only its kind says so, which the task that asked for it chose
            point.conflict |= (point.asked_by if isinstance(point.item, Motion) else set()) or point.domain
            point.say("impossible", "engine", f"no plugin resolves {point.item}{self._instead(point.item)}")
        yield from heapq.merge(*streams, key=lambda pair: pair[1].cost)
        for fault in self.registry.faults[faults:]:
            point.say("fault", fault.plugin, str(fault))

    def _fits(self, point: ChoicePoint, action: Action) -> bool:
        """Check that the action's task exists, and that the action is not inside an action with the same task
        and things."""
        opened = (i.action for i in point.state.agenda if isinstance(i, Effect))
        above = [a for a in opened if is_part_of(action.name, a.name)]
        reason = misfit(action, above, self.tasks)
        if reason:
            point.conflict |= {a.name for a in above} | point.domain
            point.say("impossible", "engine", reason)
        return not reason

    def _asked(self, point: ChoicePoint) -> Iterator[tuple[str, Iterable[Any]]]:
        """Yield the answers of each plugin that grounds the designator; for an action those of the
        plugin that declares its task type come last."""
        item, state = point.item, point.state
        context = replace(
            self.context,
            bindings=state.bindings,
            agenda=tuple(i for i in state.agenda if not isinstance(i, Effect | Mark)),
            seed=derive_seed(self.context.seed, state.choices, item.name),
        )
        again, told = self.answers.of(item, state.belief, context, partial(self._plugins, item, state.belief))
        if again:
            point.trace.answered_before(point.node)
        yield from told
        if isinstance(item, Action):
            owner = self.owners[item.task]
            yield owner, self.registry.guarded(owner, "decompose", item.name, self._own(item, state))

    def _plugins(self, item: Designator, belief: Belief, context: Context) -> Iterator[tuple[str, Iterable[Any] | Unresolvable]]:
        """Yield the answers of plugins to a designator, from the hook for its type.

        For a location, the function of its relation answers, too.
        """
        hook = HOOKS[type(item)]
        yield from self.registry.alternatives(hook, item, belief=belief, context=context)
        if isinstance(item, Location) and item.relation in self.relations:
            plugin, kind = self.relations[item.relation]
            if wrong := kind.misfit(item.parameters):
                yield plugin, Unresolvable(wrong)
            else:
                yield from self.registry.ask(plugin, hook, item.name, partial(kind.ground, item, belief, context))

    def _instead(self, item: Designator) -> str:
        """Return words on a location's unknown relation, with the nearest known names; "" for other designators."""
        return f": no relation '{item.relation}'; {nearest(item.relation, self.relations)}" if isinstance(item, Location) else ""

    def _accepted(self, plugin: str, answers: Iterable[Any], point: ChoicePoint) -> Iterator[Alternative]:
        """Yield the valid answers of one plugin, and record which earlier choices its refusals depend on.

        These join the point's conflict set: choices that a refusal names, else all that the question depends on
        (``ChoicePoint.domain``).
        """
        made = {name for name, _ in point.state.choices}
        earlier = point.domain if isinstance(point.item, Motion) else made
        try:
            said_any = False
            for answer in answers:
                said_any = True
                point.conflict |= point.blamed(answer)
                if isinstance(answer, Refused):
                    point.conflict |= made & set(answer.because) | as_they_are(answer.blocking)
                    point.say(
                        "refused", plugin, answer.reason, answer.value,
                        passed=answer.passed, numbers=answer.numbers, collision=answer.collision, remedy=answer.remedy,
                    )  # fmt: skip
                    continue
                if wrong := wrong_with(answer, point.item):
                    self.registry.fault(plugin, HOOKS[type(point.item)], point.item.name, WrongAnswer(wrong))
                    return
                yield plugin, answer
            point.conflict |= set() if said_any else point.domain | as_they_are(None)
        except Unresolvable as impossible:
            collision = impossible.collision if isinstance(impossible.collision, Collision) else None
            remedy = impossible.remedy if isinstance(impossible.remedy, Remedy) else None
            point.say("impossible", plugin, impossible.reason, numbers=impossible.numbers, collision=collision, remedy=remedy)
            said = {*impossible.because, *(point.state.opened if impossible.earlier_tasks else ())}
            point.conflict |= ((made & said) if said else earlier) | as_they_are(impossible.blocking)

    def _own(self, action: Action, state: State) -> Iterator[Grounding]:
        """Generate the decompositions of an action that its own task type offers."""
        grounded = ground_roles(action, state.bindings)
        found = self.tasks[action.task].decompose(grounded, state.belief)
        if isinstance(found, Decomposition):
            raise TypeError("decompose returned a Decomposition; it has to yield it, as there may be several")
        for way in found:
            _check_way(way)
            yield Grounding(way, way.reason, way.cost, key=way.reason)


def wrong_with(answer: object, item: Designator) -> str:
    """Return why a plugin's answer is no valid grounding, in words; "" if it is one.

    An invalid answer is refused at once, so that plugins which would use it later are not blamed.
    """
    kind, value = type(item).__name__, getattr(answer, "value", None)
    if not isinstance(answer, Grounding):
        return f"an answer is a Grounding or a Refused, not {_short(answer)}"
    if isinstance(item, Motion):
        steps = value if isinstance(value, tuple) else (value,)
        stray = [s for s in steps if not isinstance(s, get_args(AnyStep))]
        if stray or not isinstance(value, tuple):
            return f"the Grounding of a Motion has a tuple of steps, not {_short(stray[0] if stray else value)}"
    elif not isinstance(value, VALUES[type(item)]):
        said = " or a ".join(t.__name__ for t in VALUES[type(item)])
        return f"the Grounding of {'an' if kind[0] in 'AO' else 'a'} {kind} has a {said}, not {_short(value)}"
    if answer.belief is not None and not isinstance(answer.belief, Belief):
        return f"the belief of a Grounding is a Belief or None, not {_short(answer.belief)}"
    if isinstance(answer.cost, bool) or not isinstance(answer.cost, Real) or not math.isfinite(answer.cost):
        return f"the cost of a Grounding is a finite number, not {_short(answer.cost)}"
    return ""


def _short(value: object) -> str:
    return repr(value)[:80]


def _check_way(way: Any) -> None:
    """Check that the decomposition of an action, as a plugin gives it, consists of designators.

    Raises:
        TypeError: it is not; the task type's plugin is to blame.
    """
    if not isinstance(way, Decomposition):
        raise TypeError(f"decompose yields Decompositions, not {type(way).__name__}")
    for step in way.steps:
        if not isinstance(step, Designator):
            raise TypeError(f"a step of a Decomposition is an Action, Object, Location or Motion, not {step!r}"[:200])


def misfit(action: Action, inside: Iterable[Action], tasks: Mapping[str, object]) -> str:
    """Return why an action cannot be a part of the actions around it: its task is unknown, or the
    decomposition would never end; "" if it can.

    Args:
        inside: the actions that it is a part of, the innermost first.
        tasks: the task types that there are.

    Returns:
        A clause: the task is unknown, with the nearest name; or it comes round to an action of the same task with the same
        objects and parameters, which would go on for ever.
    """
    if isinstance(action, Compound):
        return ""
    above = list(inside)
    if action.task not in tasks:
        whose = f", which the decomposition of '{above[0].task}' names" if above else ""
        return f"there is no task '{action.task}'{whose}; {nearest(action.task, tasks)}"
    for k, one in enumerate(above):
        if _meaning(one) == _meaning(action):
            way = " > ".join(a.task for a in (*reversed(above[: k + 1]), action))
            return f"a cyclic decomposition: {way}, with the same objects and parameters"
    return ""


def _meaning(action: Action) -> tuple[object, ...]:
    fillers = {k: (v.name, v.entity) for k, v in action.roles.items()}
    return action.task, fillers, dict(action.parameters), action.goal
