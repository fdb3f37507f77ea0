"""Resolution: depth first, lazy, with backjumping, no-goods, caps and counted budgets.

Every designator is a choice point, identified by its name. A failure names the
choices it depends on (its conflict set); the search returns to the latest of
them and skips the rest, which is conflict-directed backjumping (Prosser 1993,
"Hybrid algorithms for the constraint satisfaction problem").
"""

from __future__ import annotations

import hashlib
import heapq
from collections.abc import Callable, Generator, Iterable, Iterator, Mapping
from typing import Any

from msgspec import Struct
from msgspec.structs import replace

from .answers import Context, Grounding, Refused
from .designators import Action, Designator, Late, Location, Motion, Object
from .errors import EARLIER_TASKS, Unresolvable
from .flow import Compound, Mark, Way, ways
from .nesting import misfit
from .program import Section
from .registry import Registry
from .state import Effect, Item, State, gripped, passed, renewed
from .tasks import Decomposition, TaskType
from .trace import Trace

Conflict = frozenset[str]
HOOKS: dict[type, str] = {
    Action: "resolve_action",
    Object: "resolve_object",
    Late: "resolve_object",
    Location: "resolve_location",
    Motion: "resolve_motion",
}
CAPS: dict[type, int] = {Action: 6, Object: 8, Late: 8, Location: 12, Motion: 4}


class Budget(Struct, frozen=True):
    """Counted work: the same seed gives the same program on any machine.

    Args:
        asks: designators that plugins may be asked about, over one task sequence.
        proofs: fully grounded candidates that may be executed, over one task sequence.
        samples: of a sampling planner, per query.
        sequences: candidate task sequences that are tried.
    """

    asks: int = 3000
    proofs: int = 8
    samples: int = 4000
    sequences: int = 12


STOPPED = "stopped by the caller"


class BudgetSpent(Exception):
    """The counted budget of a search is used up."""


def derive_seed(seed: int, choices: Iterable[tuple[str, str]], name: str) -> int:
    """A seed for one query, from the run's seed and the choice path: blake2b, so that it is the same everywhere."""
    text = repr((seed, tuple(choices), name)).encode()
    return int.from_bytes(hashlib.blake2b(text, digest_size=4).digest(), "big") & 0x7FFFFFFF


class Search(Struct, dict=True):
    """One search over one plan.

    Args:
        registry: whom to ask.
        tasks: task types by class.
        owners: which plugin declared each task type.
        context: for plugins; bindings and seed are set for each question.
        trace: filled as the search goes.
        stop: asked before each question to plugins; True ends the search.
    """

    registry: Registry
    tasks: Mapping[str, TaskType]
    owners: Mapping[str, str]
    context: Context
    trace: Trace
    budget: Budget = Budget()
    progress: Callable[[str], None] = lambda _: None
    stop: Callable[[], bool] = lambda: False

    def __post_init__(self) -> None:
        self._asks = 0
        self._nogoods: dict[tuple[str, str], list[frozenset[tuple[str, str]]]] = {}

    def solve(self, state: State) -> Generator[State, Conflict | None, None]:
        """Fully grounded states, lazily. Send the conflict of one that could not be proven, or nothing to go on."""
        try:
            yield from self._descend(state, 0)
        except BudgetSpent as spent:
            self.trace.add(0, "budget", "", "capped", "engine", str(spent))

    def _descend(self, state: State, parent: int) -> Generator[State, Conflict | None, Conflict]:
        if not state.agenda:
            everything = frozenset(name for name, _ in state.choices)
            conflict = yield state
            return everything if conflict is None else conflict & everything
        item, rest = renewed(state.agenda[0], state), state.agenda[1:]
        if isinstance(item, Effect):
            try:
                closed = self._close(state, item, rest)
            except Exception as error:
                fault = self.registry.fault(
                    self.owners.get(item.action.task, "engine"), "effects", item.action.name, error
                )
                self.trace.add(parent, item.action.name, str(item.action), "fault", fault.plugin, str(fault))
                return frozenset(name for name, _ in state.choices)
            return (yield from self._descend(closed, parent))
        if isinstance(item, Mark):
            return (yield from self._passed(state, item, parent))
        if not isinstance(item, Action | Motion) and item.name in state.bindings:
            return (yield from self._descend(replace(state, agenda=rest), parent))
        if isinstance(item, Motion) and item.to and item.to.name not in state.bindings:
            return (yield from self._descend(replace(state, agenda=(item.to, *state.agenda)), parent))
        return (yield from self._choose(item, replace(state, agenda=rest), parent))

    def _passed(self, state: State, mark: Mark, parent: int) -> Generator[State, Conflict | None, Conflict]:
        """Go on behind a mark; how branches end depends on everything in them."""
        try:
            after = passed(state, mark)
        except Unresolvable as impossible:
            self.trace.add(parent, mark.compound.name, str(mark.compound), "impossible", "engine", impossible.reason)
            return frozenset(name for name, _ in state.choices)
        return (yield from self._descend(after, parent))

    def _choose(self, item: Designator, state: State, parent: int) -> Generator[State, Conflict | None, Conflict]:
        """Try the alternatives of one designator; return the choices that its failure depends on."""
        node = self.trace.add(parent, item.name, str(item), "asked", "engine", "")
        conflict = {f.compound.name for f in state.frames}  # without them it would not be asked for
        conflict |= {state.stand} if state.stand else set()  # what the arm can do depends on where the robot stands
        tried = 0
        answers = _ways(item) if isinstance(item, Compound) else self._alternatives(item, state, node, conflict)
        for plugin, answer in answers:
            key = answer.key or _key(answer.value)
            choices = (*state.choices, (item.name, key))
            if (nogood := self._nogood(choices)) is not None:
                conflict |= nogood - {item.name}
                self.trace.add(
                    node, item.name, key, "nogood", "engine", "the same combination failed before", answer.cost
                )
                continue
            if tried == _cap(item):
                self.trace.add(
                    node, item.name, "", "capped", "engine", f"{tried} alternatives tried, the rest left out"
                )
                break
            tried += 1
            chosen = self.trace.add(node, item.name, key, "chosen", plugin, answer.reason, answer.cost)
            self.progress(f"{item.name}: {answer.reason}")
            below = yield from self._descend(self._apply(item, answer, state, choices), chosen)
            if item.name not in below:
                return below
            conflict |= below - {item.name}
        self._remember(frozenset(conflict), state.choices)
        self.trace.add(node, item.name, str(item), "failed", "engine", _exhausted(tried, conflict))
        return frozenset(conflict)

    def _alternatives(
        self, item: Designator, state: State, node: int, conflict: set[str]
    ) -> Iterator[tuple[str, Grounding]]:
        """Groundings of all plugins, merged by cost; what was refused goes to the trace, its causes to ``conflict``."""
        self._asks += 1
        if self.stop():
            raise BudgetSpent(STOPPED)
        if self._asks > self.budget.asks:
            raise BudgetSpent(f"{self.budget.asks} designators were asked about, the budget of one task sequence")
        if isinstance(item, Action):
            above = [i.action for i in state.agenda if isinstance(i, Effect) and item.name.startswith(f"{i.action.name}/")]
            if reason := misfit(item, above, self.tasks):
                conflict |= {a.name for a in above} | _domain(item, state)
                self.trace.add(node, item.name, str(item), "impossible", "engine", reason)
                return
        context = replace(
            self.context,
            bindings=state.bindings,
            agenda=tuple(i for i in state.agenda if not isinstance(i, Effect | Mark)),
            seed=derive_seed(self.context.seed, state.choices, item.name),
        )
        streams, faults = [], len(self.registry.faults)
        asked = self.registry.alternatives(HOOKS[type(item)], item, belief=state.belief, context=context)
        for plugin, answers in asked:
            streams.append(self._accepted(plugin, answers, item, state, node, conflict))
        if isinstance(item, Action):
            owner = self.owners[item.task]
            ways = self.registry.guarded(owner, "decompose", item.name, self._own(item, state))
            streams.append(self._accepted(owner, ways, item, state, node, conflict))
        if not streams:  # of a motion only its kind says so, which the task that asked for it chose
            asked_by = {name for name, _ in state.choices if item.name.startswith(f"{name}/")}
            conflict |= (asked_by if isinstance(item, Motion) else set()) or _domain(item, state)
            self.trace.add(node, item.name, str(item), "impossible", "engine", f"no plugin resolves {item}")
        yield from heapq.merge(*streams, key=lambda pair: pair[1].cost)
        for fault in self.registry.faults[faults:]:
            self.trace.add(node, item.name, str(item), "fault", fault.plugin, str(fault))

    def _accepted(
        self,
        plugin: str,
        answers: Iterable[Any] | Unresolvable,
        item: Designator,
        state: State,
        node: int,
        conflict: set[str],
    ) -> Iterator[tuple[str, Grounding]]:
        """One plugin's answers. What they are depends on the item's domain, unless the plugin itself says on what."""
        try:
            if isinstance(answers, Unresolvable):
                raise answers
            for answer in answers:
                conflict |= _domain(item, state)
                if isinstance(answer, Refused):
                    conflict |= {name for name, _ in state.choices} & set(answer.because)
                    self.trace.add(node, item.name, answer.value, "refused", plugin, answer.reason, None, answer.passed)
                elif isinstance(answer, Grounding):
                    yield plugin, answer
                else:
                    wrong = TypeError(f"an answer is a Grounding or a Refused, not {type(answer).__name__}")
                    self.registry.fault(plugin, HOOKS[type(item)], item.name, wrong)
                    return
            conflict |= _domain(item, state)
        except Unresolvable as impossible:
            self.trace.add(node, item.name, str(item), "impossible", plugin, impossible.reason)
            names = frozenset(name for name, _ in state.choices)
            said = set(impossible.because) | (set(state.opened) if EARLIER_TASKS in impossible.because else set())
            conflict |= (names & said) if said else names

    def _own(self, action: Action, state: State) -> Iterator[Grounding]:
        """The task type's own decompositions."""
        grounded = ground_roles(action, state.bindings)
        ways = self.tasks[action.task].decompose(grounded, state.belief)
        if isinstance(ways, Decomposition):
            raise TypeError("decompose returned a Decomposition; it has to yield it, as there may be several")
        for way in ways:
            _check_way(way)
            yield Grounding(way, way.reason, way.cost, key=way.reason)

    def _apply(self, item: Designator, answer: Grounding, state: State, choices: tuple[tuple[str, str], ...]) -> State:
        after = replace(state, choices=choices, belief=answer.belief or state.belief)
        if isinstance(item, Action):
            way: Decomposition | Way = answer.value
            opened = {**state.opened, item.name: len(state.steps)}
            return replace(after, agenda=(*way.steps, Effect(item), *state.agenda), opened=opened)
        bindings = {**state.bindings, item.name: answer.value}
        if isinstance(item, Motion):
            steps = (*state.steps, *answer.value)
            drove = item.to is not None and after.belief.at != state.belief.at
            stand = item.to.name if item.to is not None and drove else state.stand
            return replace(after, bindings=bindings, steps=steps, motions=state.motions | {item.name}, stand=stand)
        return replace(after, bindings=bindings)

    def _close(self, state: State, effect: Effect, rest: tuple[Item, ...]) -> State:
        """The end of an action: its effects on the belief, its section of the program."""
        action = ground_roles(effect.action, state.bindings)
        section = Section(action.name, describe(action), state.opened[action.name], len(state.steps))
        top = "/" not in action.name
        if top and not state.folding and not (isinstance(action, Compound) and not action.decided_at_run_time):
            state = replace(state, sections=(*state.sections, section))
        if isinstance(action, Compound):
            return replace(state, agenda=rest)
        belief = self.tasks[action.task].effects(action, state.belief)
        after = replace(state, agenda=rest, belief=belief, actions=(*state.actions, action) if top else state.actions)
        return gripped(after, state.opened[action.name]) if top else after

    def _nogood(self, choices: tuple[tuple[str, str], ...]) -> Conflict | None:
        """The names of the choices in a combination that failed before and is made again with the last choice."""
        made = set(choices)
        found = next((nogood for nogood in self._nogoods.get(choices[-1], ()) if nogood <= made), None)
        return frozenset(name for name, _ in found) if found is not None else None

    def _remember(self, conflict: Conflict, choices: tuple[tuple[str, str], ...]) -> None:
        nogood = frozenset(c for c in choices if c[0] in conflict)
        for choice in nogood:
            self._nogoods.setdefault(choice, []).append(nogood)


def _check_way(way: Any) -> None:
    """A decomposition is made of designators.

    Raises:
        TypeError: it is not; the task type's plugin is to blame.
    """
    if not isinstance(way, Decomposition):
        raise TypeError(f"decompose yields Decompositions, not {type(way).__name__}")
    for step in way.steps:
        if not isinstance(step, tuple(HOOKS)):
            raise TypeError(f"a step of a Decomposition is an Action, Object, Location or Motion, not {step!r}"[:200])


def ground_roles(action: Action, bindings: Mapping[str, Any]) -> Action:
    """The action with the entity that each role was bound to."""
    roles = {k: replace(v, entity=bindings.get(v.name, v.entity)) for k, v in action.roles.items()}
    return replace(action, roles=roles)


def describe(action: Action) -> str:
    """A line for people: the task and its objects."""
    fillers = ", ".join(f"{k} {v.entity or v.name}" for k, v in action.roles.items())
    if isinstance(action, Compound):
        return str(action)
    return f"{action.task.split(':')[-1]}" + (f": {fillers}" if fillers else "")


def _ways(item: Compound) -> Iterator[tuple[str, Grounding]]:
    """A compound's ways, which the engine itself knows."""
    for way in ways(item):
        yield "engine", Grounding(way, way.reason, way.cost, key=way.reason)


def _cap(item: Designator) -> int:
    """How many alternatives are tried; those of a compound were written down and are all meant."""
    return len(item.branches) if isinstance(item, Compound) else CAPS[type(item)]


def _domain(item: Designator, state: State) -> set[str]:
    """The choices that the set of alternatives itself depends on: places do not depend on how the arm got there."""
    made = {name for name, _ in state.choices}
    if isinstance(item, Object | Late):
        part_of = item.part_of if isinstance(item, Object) else None
        return made & ({part_of} if part_of else set())
    if isinstance(item, Action):
        return made & {o.name for o in item.roles.values()}
    return {n for n in made if n not in state.motions} if isinstance(item, Location) else made


def _key(value: Any) -> str:
    text = str(value)
    return text if len(text) <= 60 else hashlib.blake2b(text.encode(), digest_size=6).hexdigest()


def _exhausted(tried: int, conflict: set[str]) -> str:
    causes = ", ".join(sorted(conflict)) or "nothing before it"
    return f"{tried} alternatives failed; it depends on {causes}"
