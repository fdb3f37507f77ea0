"""Trials of a learned task: a robot does the task in new worlds, and the learned rule must recognise the run."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from ..base.errors import UserError
from ..base.value import Value
from ..engine.engine import Engine
from ..interpretation.timeline import Timeline
from ..model.designator_name import task_of
from ..planning.diagnosis import nearest_miss
from ..planning.trace import Trace
from ..plugin.task_type import task_type
from ..scenario.task_specs import TaskSpec
from .learner import covers
from .proposal import Proposal
from .span import Span

if TYPE_CHECKING:
    from ..model.world.world import World
    from ..ontology.taxonomy import Taxonomy
    from ..plugin.protocols import Candidate
    from ..scenario.scenario import Scenario


class Trial(Value):
    """Trial of a learned task in one world.

    Args:
        seed: of the world.
        passed: whether a program was proven, and the learned rule recognises its run with the same things in the roles.
        reason: what came of it, a clause.
    """

    seed: int
    passed: bool
    reason: str


def trials(proposal: Proposal, module: Path, scenario: Scenario, seeds: range) -> Iterator[Trial]:
    """Yield a trial of a learned task for each seed, in the worlds of a scenario.

    The scenario's own tasks are done where the learned task is one of them; else it is done alone. Goals do not count.

    Args:
        module: the plugin that was written.

    Raises:
        UserError: the world has nothing for a role.
    """
    engine = Engine(files=[module])
    for seed in seeds:
        setting = engine.setting(scenario, seed=seed, twins=0)
        tasks = _own(proposal, scenario, engine)
        tasks = tasks or [TaskSpec(task=proposal.task, roles=dict(_fillers(proposal, setting.world, engine.knowledge.taxonomy)))]
        task = next(t for t in tasks if _is(t, proposal, engine))
        trace = Trace()
        solution = next(engine.resolve(tasks, setting=setting, seed=seed, trace=trace), None)
        if solution is None or solution.candidate.rollout is None:
            miss = nearest_miss(trace.entries)
            yield Trial(seed, False, f"no program was proven: {miss.reason if miss else 'nothing was tried'}")
            continue
        episode = engine.knowledge.episodes.detect(solution.candidate.rollout, f"run_{seed}")
        span = Span(Timeline(episode, engine.knowledge.taxonomy), *_when(solution.candidate, tasks.index(task), len(tasks), episode.span))
        found = covers(proposal.learned, span)
        right = tuple(task.roles.get(r, "") for r in proposal.roles) in found
        yield Trial(seed, right, "proven, and recognised by the learned rule" if right else _unread(proposal, span, task, len(found)))


def _own(proposal: Proposal, scenario: Scenario, engine: Engine) -> list[TaskSpec]:
    """Return the tasks of a scenario if they are a plain list that contains the learned task; else an empty list."""
    entries = scenario.spec.tasks or ()
    tasks = [t for t in entries if isinstance(t, TaskSpec)]
    return tasks if len(tasks) == len(entries) and any(_is(t, proposal, engine) for t in tasks) else []


def _is(task: TaskSpec, proposal: Proposal, engine: Engine) -> bool:
    return task_type(engine.knowledge.tasks, task.task).task == proposal.task


def _when(candidate: Candidate, place: int, count: int, whole: tuple[float, float]) -> tuple[float, float]:
    """Return start and end of one task of a run [s]; if the run has a single task, those of the whole run."""
    rollout, code = candidate.rollout, candidate.code
    if count == 1 or rollout is None or code is None:
        return whole
    names = [task_of(code.origin_of(int(line))) if line else "" for line in rollout.lines]
    ran = [float(t) for t, name in zip(rollout.times, names, strict=True) if name.startswith(f"{place + 1}.")]
    return (ran[0], ran[-1]) if ran else whole


def _fillers(proposal: Proposal, world: World, taxonomy: Taxonomy) -> Iterator[tuple[str, str]]:
    """Yield each role with a thing of the world that can fill it: one named as in an example, else one of the class in that example."""
    taken: set[str] = set()
    for k, role in enumerate(proposal.roles):
        names = [f[k] for f in proposal.fillers]
        types = [t for e, n in zip(proposal.learned.examples, names, strict=True) for t in e.span.timeline.types(n)[:1]]
        alike = [t.name for t in world.things if any(taxonomy.is_a(t.type, c) for c in types)]
        free = [n for n in (*(t.name for t in world.things if t.name in names), *alike) if n not in taken]
        if not free:
            wanted = types[0] if types else "such thing"
            raise UserError(f"The world has nothing for the role {role}: neither '{names[0]}' nor any {wanted}.")
        taken.add(free[0])
        yield role, free[0]


def _unread(proposal: Proposal, span: Span, task: TaskSpec, found: int) -> str:
    """Return a sentence on the rule's condition that the run does not fulfil, with advice which demonstration
    to show next."""
    if found:
        return "proven, but the learned rule finds other things in the roles; show what tells them apart"
    for evidence, literal in zip(proposal.evidence, proposal.learned.literals, strict=True):
        if tuple(task.roles.get(r, "") for r in proposal.roles) not in covers(proposal.learned, span, [literal]):
            said = " and ".join(f"{phase}: {text}" for phase, text in evidence.texts)
            return (f"proven, but '{said}' does not hold in the run: if it does not belong to the task, "
                    "show an example in which it does not hold")  # fmt: skip
    return "proven, but no condition alone fails: the run is none of this task"
