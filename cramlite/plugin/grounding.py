"""Values with which plugins answer a query for a designator: groundings, refusals, and the query's context."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from msgspec import field
from msgspec.structs import replace

from ..base.errors import InTheWay, Unresolvable, checked_numbers
from ..base.value import Value
from ..model.belief import Belief
from ..model.collision import Collision
from ..model.designators import Action, Designator
from ..model.entity_name import thing_of
from ..model.motion_words import Stage
from ..model.remedy import Remedy
from ..model.robot import Robot
from ..model.run.judging_limits import JudgingLimits
from ..model.twins.error_model import ErrorModel
from ..model.world.world import RobotMount

if TYPE_CHECKING:
    from ..model.world.world import Camera
    from ..ontology.taxonomy import Taxonomy


class Grounding(Value):
    """Grounding: one concrete alternative for a designator.

    Args:
        value: for an object its entity name; for a location a Place; for an action its
            Decomposition; for a motion the steps of the program.
        reason: why this one, a clause with numbers and units.
        cost: alternatives of one plugin come best first; costs of different plugins are compared.
        belief: the belief after a motion; None when nothing changed.
        key: identifies the alternative among its siblings; text of the value if empty.
        anew: of a location: whether it is where it is wherever the arm comes from; of a motion: whether it ends where it does then.
            What fails later does not depend on the motions before such a one, nor on the places that they only led through.
    """

    value: Any
    reason: str
    cost: float = 0.0
    belief: Belief | None = None
    key: str = ""
    anew: bool = False


class Refused(Value):
    """Refused alternative of a designator, with the reason that explanations show.

    Args:
        value: the alternative in words.
        reason: a clause with numbers and units.
        passed: how many checks it passed before: the nearest miss passed most.
        because: designators whose choices are to blame, beyond those that the asked one refers to: without them the
            search would not go back and change them.
        numbers: those of the reason, by name, with units in the names, e.g. {"reach_m": 0.91, "limit_m": 0.85}.
        blocking: what stands in the way, closed or full (``InTheWay``), so that it may do once a task has changed it. Where that
            is not known the search goes back to all that was chosen before, else to what settled where these things, the asked
            one and the held one are.
        collision: the state to blame where two bodies would be too near one another; the report draws it.
        remedy: what is missing and what to try, for the end of a search that found nothing.
        check: name of the check that objects; "" where there is one only.
        where: stage of the way to a place at which it objects; None where that makes no difference.
    """

    value: str
    reason: str
    passed: int = 0
    because: tuple[str, ...] = ()
    numbers: Mapping[str, float] = field(default_factory=dict)
    blocking: InTheWay = None
    collision: Collision | None = None
    remedy: Remedy | None = None
    check: str = ""
    where: Stage | None = None

    def __post_init__(self) -> None:
        checked_numbers(self.numbers)

    def of(self, value: str, passed: int = 0) -> Refused:
        """Return a copy of this refusal, with the same reason, for another alternative.

        Args:
            value: the alternative in words.
        """
        return replace(self, value=value, passed=passed)

    @property
    def in_the_way(self) -> frozenset[str]:
        """Return the names of all things in ``blocking``; none if it is not known or empty."""
        return frozenset(name for one in self.blocking or () for name in ((one,) if isinstance(one, str) else one))

    def impossible(self, reason: str, because: tuple[str, ...] = ()) -> Unresolvable:
        """Return the error for a designator that this refusal makes infeasible, with the refusal's obstacles, collision and remedy.

        Args:
            reason: a clause with numbers and units.
            because: names of the designators or roles whose choices this depends on; empty means all earlier ones.
        """
        return Unresolvable(reason, because, blocking=self.blocking, collision=self.collision, remedy=self.remedy)


Answer = Grounding | Refused
"""One answer to a designator: a grounding of it, or the refusal of one."""
Answers = Iterable[Answer] | None
"""Answers of a ``resolve_...`` hook: ``Grounding`` and ``Refused``, best first, or None for "not mine"."""


class LaterTask(Value):
    """Task of the plan that comes after the one that is being grounded.

    Args:
        action: as it is planned.
        bindings: of the context.
    """

    action: Action
    bindings: Mapping[str, Any]

    @property
    def entities(self) -> Mapping[str, str]:
        """Role of the action -> name of the thing that fills it; "" if that is unknown."""
        return {role: str(self.bindings.get(o.name, o.entity or "")) for role, o in self.action.roles.items()}

    @property
    def things(self) -> frozenset[str]:
        """Names of the things that fill the task's roles."""
        return frozenset(thing_of(entity) for entity in self.entities.values())


class Context(Value):
    """Context of a query: what a plugin knows besides the designator and the belief.

    Args:
        robot: the acting robot's model.
        mount: where it stands.
        bindings: designator name -> what it was grounded to, so far.
        agenda: what is still to be resolved, in order; experts may look ahead, never change it.
        taxonomy: classes and affordances.
        seed: derived from scenario, choice path and attempt; the only randomness a plugin may use.
        camera: that the robot may look with; None where there is none.
        samples: how many samples a sampling planner may draw (counted work, never seconds).
        limits: how far a run may disturb what its tasks are not about.
        errors: of the twins in which a program will run; None where it runs in none.
    """

    robot: Robot
    mount: RobotMount
    bindings: Mapping[str, Any]
    taxonomy: Taxonomy
    agenda: Sequence[Designator] = ()
    seed: int = 0
    samples: int = 4000
    camera: Camera | None = None
    limits: JudgingLimits = JudgingLimits()
    errors: ErrorModel | None = None

    @property
    def later(self) -> Iterator[LaterTask]:
        """Tasks of the plan that come after the one that is being grounded, in order."""
        return (LaterTask(item, self.bindings) for item in self.agenda if isinstance(item, Action))
