"""Task types: base classes of task plugins."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping
from itertools import combinations_with_replacement
from pathlib import Path
from typing import Any, ClassVar

from ..base.errors import UserError, nearest
from ..base.value import Value
from ..model.belief import Belief
from ..model.designators import Action, Designator, Location, Object
from ..ontology.foundation import TASK
from .allowance import HAND, HELD, Allowance

FORCE_LIMIT = "force_limit_n"
"""Parameter of tasks that limit the force of their contacts [N]."""


class Role(Value):
    """Role of a task type.

    Args:
        name: "Patient", "Locatum", "Relatum", "Agent", ...
        types: classes that a filler may have; any one will do.
        features: features that a filler must have, e.g. a hole for a peg.
        affords: affordances that a filler must offer.
        required: whether the task makes sense without it.
        effector: the filler is the hand or gripper itself, never an object of the world.
        filled: the task is about what is in the filler, so one that has contents comes first.
        aliases: further names that scenarios may use, such as "object" or "target".
    """

    name: str
    types: tuple[str, ...] = ()
    features: tuple[str, ...] = ()
    affords: tuple[str, ...] = ()
    required: bool = True
    effector: bool = False
    filled: bool = False
    aliases: tuple[str, ...] = ()

    def constrain(self, designator: Object) -> Object:
        """Return an object designator with this role's requirements added."""
        return designator.merged(Object(designator.name, (), self.features, self.affords, filled=self.filled))


class Decomposition(Value):
    """One way to do a task: designators in order.

    Args:
        steps: actions, locations and motions.
        reason: why this way.
        cost: lower is tried first.
    """

    steps: tuple[Designator, ...]
    reason: str
    cost: float = 0.0


class Parameter(Value):
    """Numeric parameter of a task.

    Args:
        name: with its unit, e.g. "speed_m_s".
        default: in that unit.
        source: where the default comes from.
    """

    name: str
    default: float
    source: str


class TaskType(ABC):
    """Task type: a kind of task, and how it can be done.

    A plugin subclasses this and overrides ``decompose`` and ``effects``; fields have class defaults.
    """

    task: ClassVar[str] = ""
    """Class of the task, e.g. "soma:Grasping"."""
    aliases: ClassVar[tuple[str, ...]] = ()
    """Further names of the task that scenarios may use."""
    roles: ClassVar[tuple[Role, ...]] = ()
    """Roles of the task."""
    summary: ClassVar[str] = ""
    """Action of the task, as a clause for people."""
    parameters: ClassVar[tuple[Parameter, ...]] = ()
    """Numeric parameters of the task; scenarios may change them."""
    above: ClassVar[str] = TASK
    """Class above ``task``, for tasks that no ontology has; a class that an ontology states has priority."""
    rule_file: ClassVar[Path | None] = None
    """File of the task's rule, next to the plugin's module. None for shipped tasks, whose rules are in ``task_rules/``."""
    places: ClassVar[bool] = False
    """True for tasks that choose where to put something: their ``where`` constrains it (``Action.parameters``)."""
    looks: ClassVar[bool] = False
    """True for the task that brings a camera to a pose from which it sees given places. The engine uses this task to take pictures."""
    lays_open: ClassVar[str] = ""
    """Role of the drawer or door that the task opens, if opening it makes hidden content visible. The engine asks for such a task when the
    camera does not find a thing anywhere else."""
    puts_aside: ClassVar[tuple[str, str] | None] = None
    """Roles of the payload and of its new place, for a task that begins and ends with an empty hand: the engine puts
    occluders aside with it."""
    leads_on: ClassVar[bool] = False
    """True for motions through free space, which by default lead to the place where the next task begins."""
    touches: ClassVar[tuple[tuple[str, str], ...] | None] = None
    """Pairs of bodies that may touch while the task runs: names of roles, ``HAND``, and ``HELD`` for the payload. None: any two of the
    hand, the payload, and the things of all roles; the payload may also touch its old support. () for free motions: nothing. The
    validator of collisions objects to every other touch."""
    carries_on: ClassVar[bool] = False
    """True for a task that declares its ``touches`` and lets the payload touch its old support until it is lifted from it."""
    moves: ClassVar[tuple[str, ...]] = ()
    """Roles whose things the task moves without holding them, such as one that is pushed. The validator of bystanders
    objects where any other thing moves that is not held."""

    slides: ClassVar[bool] = True
    """Whether the task may drag its payload along a thing that it touches, as wiping does. The validator of tracks objects
    where another task does so."""

    @abstractmethod
    def decompose(self, action: Action, belief: Belief) -> Iterable[Decomposition]:
        """Yield the ways to do ``action``, best first.

        Raises:
            Unresolvable: it cannot be done in this belief, with the reason.
        """

    def effects(self, action: Action, belief: Belief) -> Belief:
        """Return the belief after the task succeeded; ``belief`` already contains the changes of the task's
        motions."""
        return belief

    def begins_at(self, action: Action) -> Location | None:
        """Return the place where the hand must be when the task begins; None if it may be anywhere.

        An earlier task's motion through free space leads there.
        """
        return None

    def leads_to(self, action: Action, following: Action | None, goal: Location) -> Location:
        """Return the place to which the task's motion through free space leads: by default ``goal``, where
        the next task begins.

        A task type whose roles name another place returns that.

        Args:
            following: the next task that says where it begins; None if no other follows, and ``goal`` is home.
        """
        return goal

    def allowance(self, action: Action, bindings: Mapping[str, Any]) -> Allowance:
        """Return the things that ``action`` may touch and move, as the task declares in ``touches``,
        ``moves`` and "force_limit_n".

        Args:
            action: with its roles grounded.
            bindings: designator name -> grounding.
        """
        things = {HAND: HAND, HELD: HELD} | {
            name: HAND if role and role.effector else o.thing
            for name, o in action.roles.items()
            for role in (self.role(name),)
            if o.entity or (role and role.effector)
        }
        pairs = combinations_with_replacement(things, 2) if self.touches is None else self.touches
        touches = frozenset(frozenset({things[a], things[b]}) for a, b in pairs if a in things and b in things)
        limited = any(p.name == FORCE_LIMIT for p in self.parameters)
        return Allowance(
            touches | {frozenset({HAND, HELD})},
            frozenset(things[r] for r in self.moves if r in things),
            self.touches is None or self.carries_on,
            self.parameter(action, FORCE_LIMIT) if limited else None,
            self.slides,
        )

    def role(self, name: str) -> Role | None:
        """Return the role with a given name; None if there is none."""
        return next((r for r in self.roles if r.name == name), None)

    def parameter(self, action: Action, name: str) -> float:
        """Return the value of a parameter in the unit that its name ends with: the action's value, else the
        declared default."""
        declared = next(p for p in self.parameters if p.name == name)
        return float(action.parameters.get(name, declared.default))


def task_type(tasks: Mapping[str, TaskType], name: str) -> TaskType:
    """Find a task type by class, local name or alias.

    Raises:
        UserError: there is none; the nearest valid names are listed.
    """
    table = {alias: t for t in tasks.values() for alias in (t.task, t.task.split(":")[-1], *t.aliases)}
    if name not in table:
        shown = [alias for alias in table if (":" in alias) == (":" in name)]
        raise UserError(f"There is no task type '{name}'; {nearest(name, shown)}.")
    return table[name]
