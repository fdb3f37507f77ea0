"""Task types: base classes of task plugins."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import ClassVar

from ..base.errors import UserError, nearest
from ..base.value import Value
from ..model.belief import Belief
from ..model.designators import Action, Designator, Location, Object
from ..ontology.foundation import TASK


class Role(Value):
    """Role of a task type.

    Args:
        name: "Patient", "Locatum", "Relatum", "Agent", ...
        types: classes that a filler may have; any one will do.
        features: features that a filler must have, e.g. a hole for a peg.
        affords: affordances that a filler must offer.
        required: whether the task makes sense without it.
        effector: the filler is the hand or gripper itself, never an object of the world.
    """

    name: str
    types: tuple[str, ...] = ()
    features: tuple[str, ...] = ()
    affords: tuple[str, ...] = ()
    required: bool = True
    effector: bool = False

    def constrain(self, designator: Object) -> Object:
        """Return the designator with what this role requires added."""
        return designator.merged(Object(designator.name, (), self.features, self.affords))


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
    """Kind of task, and how it can be done.

    A plugin subclasses this and overrides ``decompose`` and ``effects``; fields have class defaults.
    """

    task: ClassVar[str] = ""
    """Its class, e.g. "soma:Grasping"."""
    aliases: ClassVar[tuple[str, ...]] = ()
    """Further names that scenarios may use."""
    roles: ClassVar[tuple[Role, ...]] = ()
    """Who takes part."""
    summary: ClassVar[str] = ""
    """What it does, in a clause for people."""
    parameters: ClassVar[tuple[Parameter, ...]] = ()
    """Numbers that it uses; scenarios may change them."""
    above: ClassVar[str] = TASK
    """The class above ``task``, for tasks that no ontology has; where an ontology has it, that one is believed."""
    rule_file: ClassVar[Path | None] = None
    """The task's rule, beside the plugin's module; the shipped ones are in ``task_rules/``."""
    places: ClassVar[bool] = False
    """True for tasks that choose where to put something: their ``where`` constrains it (``Action.parameters``)."""
    looks: ClassVar[bool] = False
    """True for the task that brings a camera to where it sees some places: the engine asks it for pictures."""
    leads_on: ClassVar[bool] = False
    """True for free motions: their goal, unless given, is where the next task begins."""

    @abstractmethod
    def decompose(self, action: Action, belief: Belief) -> Iterable[Decomposition]:
        """Yield the ways to do ``action``, best first.

        Raises:
            Unresolvable: it cannot be done in this belief, with the reason.
        """

    def effects(self, action: Action, belief: Belief) -> Belief:
        """Return the belief after the task succeeded, beyond what its motions already changed."""
        return belief

    def begins_at(self, action: Action) -> Location | None:
        """Return where the arm stands when the task begins: the goal of a free motion that leads to it; None if anywhere."""
        return None

    def leads_to(self, action: Action, following: Action | None, goal: Location) -> Location:
        """Return the goal of a free motion: ``goal``, where the next task begins, unless the motion's own roles say else.

        Args:
            following: the next task that says where it begins; None if no other follows, and ``goal`` is home.
        """
        return goal

    def role(self, name: str) -> Role | None:
        """Return the role of that name, or None."""
        return next((r for r in self.roles if r.name == name), None)

    def parameter(self, action: Action, name: str) -> float:
        """Return the value of a parameter: the action's own, else the declared default."""
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
