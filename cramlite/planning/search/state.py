"""Search states, and their successors after a choice, a motion, an action or a change of grip.

The search works off the agenda from the front and appends steps.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from msgspec import field
from msgspec.structs import replace

from ...base.value import Value
from ...model.control_flow import Compound, Mark
from ...model.designator_name import task_of
from ...model.designators import Action, Designator, Location, Motion, Place, Stand
from ...model.handover import Handover, handovers
from ...model.program.program import Section
from ...model.program.steps import MoveJoints, MoveLinear, SetGripper, walk

if TYPE_CHECKING:
    from ...model.belief import Belief
    from ...model.program.steps import AnyStep
    from ...plugin.grounding import Grounding
    from ...plugin.task_type import TaskType


class Effect(Value):
    """Agenda item after an action's steps, at which the action's effects change the belief."""

    action: Action


Item = Designator | Effect | Mark


class Frame(Value):
    """Control structure whose steps the search is collecting: where each branch's steps begin, and the
    beliefs before and after the branches."""

    compound: Compound
    starts: tuple[int, ...]
    begin: Belief
    ends: tuple[Belief, ...] = ()


class State(Value):
    """State of the search: the groundings and steps so far, and the agenda of what is still to be resolved.

    Args:
        grip: what was held when the last action of the plan ended.
        again: names of places that were bound before the grip last changed -> the how manieth the next one will be.
        stand: the place that the robot drove to last, by name; "" where it has not driven.
        stood: ``stand`` when the last action of the plan ended.
        parts: what the plan's actions were decomposed into, without what the run decides about.
        led: motions that moved the arm and changed nothing else.
        reached: places that the arm was led to since anything else was moved.
        here: the place that the arm was led to last, by name; "" before the first.
        used: places at which more was done than lead the arm to them and on, such as closing the fingers.
        handovers: what passed into the hand and out of it so far, in order.
        passed: what of both came before the last motion that ends where it does from wherever the arm comes.
    """

    agenda: tuple[Item, ...]
    belief: Belief
    bindings: Mapping[str, Any] = field(default_factory=dict)
    steps: tuple[AnyStep, ...] = ()
    sections: tuple[Section, ...] = ()
    actions: tuple[Action, ...] = ()
    opened: Mapping[str, int] = field(default_factory=dict)
    motions: frozenset[str] = frozenset()
    choices: tuple[tuple[str, str], ...] = ()
    frames: tuple[Frame, ...] = ()
    grip: str = ""
    again: Mapping[str, int] = field(default_factory=dict)
    stand: str = ""
    stood: str = ""
    parts: tuple[Action, ...] = ()
    led: frozenset[str] = frozenset()
    reached: frozenset[str] = frozenset()
    passed: frozenset[str] = frozenset()
    here: str = ""
    used: frozenset[str] = frozenset()
    handovers: tuple[Handover, ...] = ()

    @property
    def folding(self) -> bool:
        """Whether the steps being collected belong to a control structure that is decided when the program runs."""
        return any(f.compound.decided_at_run_time for f in self.frames)


def state_after_choice(state: State, item: Designator, answer: Grounding, choices: tuple[tuple[str, str], ...]) -> State:
    """Return the state of the search after an alternative was chosen for a designator.

    An action's steps come next on the agenda; all else is bound.
    """
    after = _state_believed(state, answer.belief or state.belief, item.name, choices=choices)
    if isinstance(item, Action):
        opened = {**state.opened, item.name: len(state.steps)}
        return replace(after, agenda=(*answer.value.steps, Effect(item), *state.agenda), opened=opened)
    bindings = {**state.bindings, item.name: answer.value}
    if isinstance(item, Motion):
        steps = (*state.steps, *answer.value)
        drove = item.to is not None and after.belief.at != state.belief.at
        stand = item.to.name if item.to is not None and drove else state.stand
        after = replace(after, bindings=bindings, steps=steps, motions=state.motions | {item.name}, stand=stand)
        return _state_led_on(state, item, after, answer.anew)
    return replace(after, bindings=bindings)


def _state_believed(state: State, belief: Belief, by: str, **changes: Any) -> State:
    """Return a search state with its belief replaced, and with a handover added for each thing that only one
    of the two beliefs has in the hand."""
    new = handovers(state.belief, belief, by, optional=state.folding)
    return replace(state, belief=belief, handovers=(*state.handovers, *new), **changes)


def state_after_action(state: State, done: Action, tasks: Mapping[str, TaskType]) -> State:
    """Return the state after an action: its effects change the belief, and its steps become a section of the
    program."""
    action, first, top = ground_roles(done, state.bindings), state.opened[done.name], task_of(done.name) == done.name
    if top and not state.folding and not (isinstance(action, Compound) and not action.decided_at_run_time):
        section = Section(action.name, describe(action), first, len(state.steps))
        state = replace(state, sections=(*state.sections, section))
    if isinstance(action, Compound):
        return state
    belief = tasks[action.task].effects(action, state.belief)
    if top:
        state = replace(state, actions=(*state.actions, action))
    elif not state.folding:
        state = replace(state, parts=(*state.parts, action))
    after = _state_believed(state, belief, action.name)
    after = after if _at_rest(state, after) else replace(after, reached=frozenset())
    return renew_places(after, first) if top else after


def _state_led_on(state: State, motion: Motion, after: State, anew: bool) -> State:
    """Return the state of the search after a motion, with the choices that now decide where the arm is.

    Earlier choices that only led the arm elsewhere no longer decide where the arm is.
    """
    place = frozenset({motion.to.name}) if motion.to is not None else frozenset()
    moved = after.belief.joints != state.belief.joints
    only = moved and replace(after.belief, joints=state.belief.joints) == state.belief
    passed = state.passed
    if anew and not state.frames:  # whoever goes back to where a compound began asks for what came before
        passed |= state.led | state.reached
    reached = state.reached | place if moved else state.reached
    led = state.led | {motion.name} if only else state.led
    after = _state_used_at(state, motion, after)
    return replace(after, led=led, reached=reached if _at_rest(state, after) else frozenset(), passed=passed - place)


def _state_used_at(state: State, motion: Motion, after: State) -> State:
    """Return the search state after a motion; it records the place at which the motion ends as used, if more was
    done there than moving the arm.

    It is not marked if the motion only moved the arm there.
    """
    place = motion.to.name if motion.to is not None else state.here
    leads = all(isinstance(s, MoveJoints | MoveLinear) for s in after.bindings[motion.name]) and _at_rest(state, after)
    return replace(after, here=place, used=state.used if leads else state.used | {place})


def _at_rest(state: State, after: State) -> bool:
    """Check whether two search states differ in nothing but the arm's position and the gripper's opening."""
    one, other = state.belief, after.belief
    return one.poses == other.poses and one.held == other.held and one.at == other.at


def ground_roles(action: Action, bindings: Mapping[str, Any]) -> Action:
    """Return the action with the entity that each role was bound to."""
    roles = {k: replace(v, entity=bindings.get(v.name, v.entity)) for k, v in action.roles.items()}
    return replace(action, roles=roles)


def describe(action: Action) -> str:
    """Return an action as a line for people: the task and its objects."""
    fillers = ", ".join(f"{k} {v.entity or v.name}" for k, v in action.roles.items())
    if isinstance(action, Compound):
        return str(action)
    return f"{action.task.split(':')[-1]}" + (f": {fillers}" if fillers else "")


def renew_places(state: State, first: int = 0) -> State:
    """Return the state after an action; if the payload changed or the robot drove, the places found so far get new names.

    Under new names they are grounded anew.

    If it took or let go of something, or drove, the places bound so far are history: the same thing stands elsewhere,
    or is held in another way, and whoever asks for its grasp again gets a new answer.

    Args:
        first: where the action's steps begin: it may have taken something and let go of it again.
    """
    held = state.belief.held.thing if state.belief.held else ""
    took = any(isinstance(s, SetGripper) and s.expect == "object" for s in walk(state.steps[first:]))
    if held == state.grip and not took and state.stand == state.stood:
        return state
    bound = Counter(k.split("#")[0] for k, v in state.bindings.items() if isinstance(v, Place | Stand))
    again = {name: count + 1 for name, count in bound.items()}
    return replace(state, grip=held, stood=state.stand, again=again)


def renewed(item: Item, state: State) -> Item:
    """Return a place, or a motion to a place, under a new name if the place was found before the payload changed or the robot drove."""
    if isinstance(item, Location):
        return _renewed(item, state)
    if isinstance(item, Motion) and item.to is not None:
        return replace(item, to=_renewed(item.to, state))
    return item


def _renewed(place: Location, state: State) -> Location:
    return replace(place, name=f"{place.name}#{state.again[place.name]}") if place.name in state.again else place
