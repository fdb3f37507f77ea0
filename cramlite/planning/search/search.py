"""Search for groundings: depth first and lazy, with backjumping, no-goods, limits on alternatives, and counted budgets.

A failure names the choices it depends on (its conflict set); the search returns to
the latest of them and skips the rest, which is conflict-directed backjumping (Prosser
1993, "Hybrid algorithms for the constraint satisfaction problem").
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Mapping

from msgspec import Struct, field
from msgspec.structs import replace

from ...base.errors import DEFECTS, Unresolvable
from ...base.pulse import checkpoint
from ...model.control_flow import Compound, Mark
from ...model.designators import Action, Designator, Motion
from ...plugin.grounding import Context
from ...plugin.registry import Registry
from ...plugin.task_type import TaskType
from ..refutation import WHOLE, Capped, InTask, Later, Part, as_they_are
from ..trace import Trace
from .alternatives import Alternatives
from .answers import Answers
from .budget import PROOF, Budget, BudgetSpent
from .choice_point import ChoicePoint, Conflict, Nogoods, key_of
from .control_steps import state_after_mark
from .state import Effect, State, ground_roles, renewed, state_after_action, state_after_choice

WORK_SPENT = "the budget of work over all task sequences is used up"
"""Reason for the end of a search that has task sequences left."""
Below = Generator[State, Conflict | None, Conflict]
"""Generator of grounded states below a choice: it receives the conflict set of each state, and returns their union."""


class WholeWork(Struct):
    """Work of a whole search so far, over all task sequences, in expansions.

    Args:
        most: its budget; 0 for no limit.
    """

    most: int = 0
    done: int = 0

    @property
    def spent(self) -> bool:
        """Whether the budget is used up."""
        return 0 < self.most <= self.done


class Effort(Struct):
    """Work that the search has spent on one task sequence so far, with the no-goods that it found.

    Args:
        breadth: how many times as many alternatives are tried as in the first round.
        expanded, proofs: nodes that were expanded, and programs that were run.
        nogoods: choices that do not go together.
        capped: whether the last round left out alternatives, so that a wider one may find more.
        objected: tasks of the plan, from 1, that the validators of every program objected to; None before one ran.
        whole: work that was spent on all task sequences.
    """

    breadth: int = 1
    expanded: int = 0
    proofs: int = 0
    nogoods: Nogoods = field(default_factory=Nogoods)
    capped: bool = False
    objected: frozenset[int] | None = None
    whole: WholeWork = field(default_factory=WholeWork)

    def expand(self) -> None:
        """Count one more node that is expanded."""
        self.expanded += 1
        self.whole.done += 1

    def prove(self) -> None:
        """Count one more program that is run."""
        self.proofs += 1
        self.whole.done += PROOF

    def judged(self, conflict: Conflict) -> None:
        """Record the tasks of the plan to which the validators of a further program objected.

        Only tasks that were objected to in every program are kept.
        """
        tasks = frozenset(c.number for c in conflict if isinstance(c, InTask))
        self.objected = tasks if self.objected is None else self.objected & tasks

    def widened(self) -> Effort:
        """Return the record of work with which a wider search begins: it tries twice as many alternatives of each designator."""
        return Effort(2 * self.breadth, self.expanded, self.proofs, self.nogoods.lasting(), whole=self.whole)


class Search(Struct, dict=True):
    """Conflict-directed backjumping search over one plan.

    Args:
        registry: whom to ask.
        tasks: task types by class.
        owners: which plugin declared each task type.
        context: for plugins; bindings and seed are set for each question.
        trace: filled as the search goes.
        answers: of plugins, from this search and others for the same goal.
        effort: that was spent on the plan in earlier rounds; what this search spends is added to it.
    """

    registry: Registry
    tasks: Mapping[str, TaskType]
    owners: Mapping[str, str]
    context: Context
    trace: Trace
    budget: Budget = Budget()
    progress: Callable[[str], None] = lambda _: None
    answers: Answers = field(default_factory=Answers)
    effort: Effort = field(default_factory=Effort)

    def __post_init__(self) -> None:
        self.refuted: Conflict | None = None
        """Conflict set of the end of the search, when there is no further grounded state; None before. Where a budget ended
        the search: that of the failures of the farthest task, or else of the parts of it that failed; None if none did, or if
        there was a grounded state."""
        self._planned = 0
        self._farthest = 0  # task of the plan that was come to, from 1; the next number behind the last
        self._failures: list[Conflict] = []  # of that task, one for each situation in which it was tried
        self._open: Conflict = frozenset()  # of what failed in it where a budget ended the search before the task was refused
        self._put_off: bool | None = False  # whether choices were gone past that may change a failure; None: none is
        self._nogoods = self.effort.nogoods
        relations = self.registry.owned("location_kinds", "name")
        self._alternatives = Alternatives(self.registry, self.tasks, self.owners, self.context, self.answers, relations)

    def solve(self, state: State) -> Generator[State, Conflict | None, None]:
        """Generate search states in which every designator is grounded, each only when it is asked for.

        Send the conflict of one that could not be proven, or nothing to go on. Choices that it names for later are varied once all
        others were.
        """
        self._planned = sum(isinstance(i, Action) for i in state.agenda)
        self.refuted, self._farthest, self._failures, self._open = None, 0, [], frozenset()
        try:
            self.refuted = yield from self._descend(state, 0)
            if self._put_off:
                self._put_off = None
                self._nogoods = self.effort.nogoods = self._nogoods.lasting()
                self.refuted = yield from self._descend(state, 0)
        except BudgetSpent as spent:
            self.trace.spent(spent.budget, getattr(self.budget, spent.budget), str(spent))
            self.refuted = frozenset().union(*self._failures or [self._open]) or None

    def _descend(self, state: State, parent: int) -> Below:
        if not state.agenda:
            self._come_to(self._planned + 1)
            return self._failed(state, (yield state))
        item, behind = renewed(state.agenda[0], state), replace(state, agenda=state.agenda[1:])
        if isinstance(item, Effect):
            return (yield from self._closed(behind, item, parent))
        if isinstance(item, Mark):
            return (yield from self._passed(state, item, parent))
        if not isinstance(item, Action | Motion) and item.name in state.bindings:
            return (yield from self._descend(behind, parent))
        if isinstance(item, Motion) and item.to and item.to.name not in state.bindings:
            return (yield from self._descend(replace(state, agenda=(item.to, *state.agenda)), parent))
        if not isinstance(item, Action) or any(isinstance(i, Effect) for i in behind.agenda):
            return (yield from self._choose(item, behind, parent))
        number = self._come_to(self._planned - sum(isinstance(i, Action) for i in behind.agenda))
        conflict = yield from self._choose(item, behind, parent)
        self._failures += [conflict] if number == self._farthest else []
        return conflict

    def _come_to(self, number: int) -> int:
        """Record that the search has reached a task of the plan, and forget failures in earlier tasks; return
        the task's number."""
        if number > self._farthest:
            self._farthest, self._failures = number, []
        return number

    def _failed(self, state: State, conflict: Conflict | None) -> Conflict:
        """Record that a fully grounded state failed; return the choices to blame.

        ``Capped()`` is among them if alternatives of some of these choices are tried only later.
        """
        everything = _everything(state)
        said = everything if conflict is None else conflict
        later = frozenset(c.choice for c in said if isinstance(c, Later)) & everything
        found = frozenset(c for c in said if not isinstance(c, Later) and (c in everything or not isinstance(c, str)))
        self._nogoods.remember(found | later, state.choices)  # a later round comes by here again
        if not later or self._put_off is None:
            return found | later
        self._put_off = True
        return found | {Capped()}

    def _closed(self, state: State, effect: Effect, parent: int) -> Below:
        """Continue the search after an action; if the task type's ``effects`` raises, blame everything that
        was chosen."""
        action = effect.action
        try:
            after = state_after_action(state, action, self.tasks)
        except DEFECTS as error:
            fault = self.registry.fault(self.owners.get(action.task, "engine"), "effects", action.name, error)
            self.trace.add(parent, action.name, str(action), "fault", fault.plugin, str(fault), kind="action")
            return _everything(state) | as_they_are(None)
        return (yield from self._descend(after, parent))

    def _passed(self, state: State, mark: Mark, parent: int) -> Below:
        """Continue the search where a branch of a control structure begins or ends.

        If the branches do not fit together, all choices so far are to blame.
        """
        try:
            after = state_after_mark(state, mark)
        except Unresolvable as impossible:
            name, said = mark.compound.name, impossible.reason
            self.trace.add(parent, name, str(mark.compound), "impossible", "engine", said, kind="compound")
            return _everything(state) | as_they_are(None)
        return (yield from self._descend(after, parent))

    def _choose(self, item: Designator, state: State, parent: int) -> Below:
        """Try the alternatives of one designator; return the choices that its failure depends on."""
        within = self._within(item, state)
        point = ChoicePoint.asked(item, state, self.trace, parent, within, self.effort.breadth)
        if not isinstance(item, Compound):
            self._count()
        tried = 0
        for plugin, answer in self._alternatives.of(point):
            key = answer.key or key_of(answer.value)
            choices = (*state.choices, (item.name, key))
            if (nogood := self._nogoods.made_again(choices)) is not None:
                point.conflict |= nogood - {item.name}
                point.say("nogood", "engine", "the same combination failed before", key, answer.cost)
                continue
            if tried == point.cap:
                point.say("capped", "engine", f"{tried} alternatives tried, the rest left out", "", numbers={"tried": tried})
                point.conflict.add(Capped())
                self.effort.capped = True
                break
            tried += 1
            node = point.say("chosen", plugin, answer.reason, key, answer.cost)
            self.progress(f"{item.name}: {answer.reason}")
            try:
                below = yield from self._descend(state_after_choice(state, item, answer, choices), node)
            except BudgetSpent:
                self._left_open(point, within.get("task"))
                raise
            if item.name not in below:
                return below
            point.conflict |= below - {item.name}
        point.conflict |= {InTask(number, self._part(item, state, tried))} if (number := within.get("task")) else set()
        point.conflict |= set() if tried else point.unfit
        self._nogoods.remember(frozenset(point.conflict), state.choices)
        point.exhausted(tried)
        return frozenset(point.conflict)

    def _left_open(self, point: ChoicePoint, number: int | None) -> None:
        """Record why a choice in the farthest task that was reached has failed so far, when a budget ends the search there."""
        failed = any(isinstance(c, InTask) and c.number == number for c in point.conflict)
        self._open |= point.conflict if number == self._farthest and failed else frozenset()

    def _within(self, item: Designator, state: State) -> dict[str, int]:
        """Return the number of the plan's task that an agenda item belongs to, and how many unfinished actions
        contain the item.

        Control structures are not counted as actions. For an object that is chosen before all tasks, return the
        numbers of the first and the last task that need it.
        """
        behind = [k for k, i in enumerate(state.agenda, 1) if isinstance(i, Effect)]
        if not behind and not isinstance(item, Action):
            return _needed_by(item, state)
        left = sum(isinstance(i, Action) for i in state.agenda[max(behind, default=0) :])
        depth = sum(isinstance(i, Effect) and not isinstance(i.action, Compound) for i in state.agenda)
        return {"task": self._planned - left, "depth": depth}

    def _part(self, item: Designator, state: State, tried: int) -> Part | None:
        """Return the subtask that was refused inside a task of the plan, with the things in its roles.

        It is ``WHOLE`` if that task itself was refused, and None if decompositions of it were tried.
        """
        opened = [i.action for i in reversed(state.agenda) if isinstance(i, Effect)]
        tasks = [a for a in (*opened, item) if isinstance(a, Action) and not isinstance(a, Compound)]
        inner = tasks[1] if len(tasks) > 1 else None
        if inner is None:
            return None if tried and not opened else WHOLE
        roles = ground_roles(inner, state.bindings).roles
        return inner.task, tuple(sorted((name, filler.entity or "") for name, filler in roles.items()))

    def _count(self) -> None:
        """Count an expanded node: a designator for which plugins are asked.

        Raises:
            BudgetSpent: there are too many.
            Stopped: the caller no longer wants it.
        """
        self.effort.expand()
        checkpoint()
        if self.effort.whole.spent:
            raise BudgetSpent("work", WORK_SPENT)
        if self.effort.expanded > self.budget.expansions:
            reason = f"{self.budget.expansions} nodes were expanded, the budget of one task sequence"
            raise BudgetSpent("expansions", reason)


def _needed_by(item: Designator, state: State) -> dict[str, int]:
    """Return the numbers of the first and the last task in which an object plays a role.

    Such objects are chosen before all tasks.
    """
    actions = [i for i in state.agenda if isinstance(i, Action)]
    tasks = [k for k, action in enumerate(actions, 1) if item.name in {o.name for o in action.roles.values()}]
    return {"first_task": tasks[0], "last_task": tasks[-1]} if tasks else {}


def _everything(state: State) -> Conflict:
    return frozenset(name for name, _ in state.choices)
