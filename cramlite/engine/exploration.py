"""Exploration before a plan: what hides things is opened, and the camera looks into it, until the goal can be meant in what was seen.

Opening and looking become the first steps of every program for the goal. The picture is taken of the real world as these steps
leave it, once they were proven in what is believed.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from msgspec.structs import replace

from ..base.errors import UserError
from ..model.designators import Action, Location, Object
from ..model.plan import Plan
from ..model.rollout import world_after_run
from ..ontology.prefixes import local_name
from ..planning.diagnosis import nearest_miss
from ..planning.search import Search
from ..planning.trace import Trace
from ..plugin.grounding import Context
from .proof import assemble, prove, text_that_runs
from .setting import Setting

if TYPE_CHECKING:
    from ..planning.state import State
    from ..plugin.catalogue import Knowledge
    from ..plugin.protocols import Candidate
    from ..scenario.scenario import Scenario

TRIED = 4
"""Ways to open and look into one thing that are proven at most."""


def explored(setting: Setting, scenario: Scenario, knowledge: Knowledge) -> Setting:
    """Return the setting with what the camera saw in containers that were opened for it, one after another, the nearest first.

    It ends when all that the goal is about was seen. A container that cannot be opened, or looked into, is left as it is, and the look
    says why (``Look.shut``).
    """
    assert setting.look is not None
    base = setting.world.robots[0].base
    hidden = [t for t in setting.world.things if t.name in setting.look.hidden and t.joint is not None]
    for container in sorted(hidden, key=lambda t: base.distance(t.pose)[0]):
        if can_be_meant(setting, scenario, knowledge):
            break
        setting = _looked_into(setting, container.name, knowledge)
    return setting


def can_be_meant(setting: Setting, scenario: Scenario, knowledge: Knowledge) -> bool:
    """Check whether the things that a scenario's goal is about are among those that are believed."""
    from ..planning.goal_planner import ground_goal
    from ..planning.operators import Grounder
    from ..planning.task_goals import Goal

    grounder = Grounder(setting.symbolic(knowledge.taxonomy), knowledge.predicates)
    try:
        return next(ground_goal(Goal(scenario.spec.goal or ()), scenario.spec.objects, grounder), None) is not None
    except UserError:
        return False


def _looked_into(setting: Setting, container: str, knowledge: Knowledge) -> Setting:
    """With what is seen in a container; or why not, where no way to open and look into it is proven, or does what it should."""
    from ..perception.active_perception import look_into

    seen, backend, trace = setting.look, setting.backend, Trace()
    assert seen is not None
    proven = next(_proven(setting, container, knowledge, trace), None)
    if proven is None or seen.camera is None:
        miss = nearest_miss(trace.entries)
        return _shut(setting, container, f"{miss.designator}: {miss.reason}" if miss else "no task opens it and looks into it")
    state, candidate = proven
    text = text_that_runs(candidate, backend)
    assert text is not None  # it ran in the proof
    mount = seen.real.robots[0].name
    ran = knowledge.simulator.execute(text.text, seen.real, knowledge.robots_of(seen.real), mount=mount, seed=setting.seed)
    if ran.outcome != "finished":
        return _shut(setting, container, f"what was proven did not come off ({ran.outcome}): {ran.reason}")
    looked = look_into(seen, container, state, seen.camera, world_after_run(ran, seen.real), knowledge, setting.seed)
    return replace(setting, world=looked.world, relations=looked.relations, real=looked.real, look=looked)


def _shut(setting: Setting, container: str, why: str) -> Setting:
    assert setting.look is not None
    return replace(setting, look=replace(setting.look, shut={**setting.look.shut, container: why}))


def _proven(setting: Setting, container: str, knowledge: Knowledge, trace: Trace) -> Iterator[tuple[State, Candidate]]:
    """Ways to open a container and to bring the camera to a view into it, each proven in what is believed."""
    actions = _opening_and_looking(container, len(setting.look.pictures) if setting.look else 0, knowledge)
    took = setting.look.camera if setting.look else None
    context = Context(setting.robot, setting.world.robots[0], {}, knowledge.taxonomy, seed=setting.seed, camera=took)
    search = Search(knowledge.registry, knowledge.tasks, knowledge.task_owners, context, trace)
    plan = Plan(setting.name, (Object(container, entity=container),), actions)
    for number, state in enumerate(search.solve(setting.start(plan)) if actions else ()):
        candidate, verdict = prove(assemble(plan, state, setting, knowledge), knowledge, setting.backend, setting.seed)
        if verdict.passed:
            yield state, candidate
        else:
            trace.add(0, "proof", str(plan), "failed", setting.backend.name, verdict.reason, kind="proof", numbers=verdict.measured)
        if number + 1 == TRIED:
            return


def _opening_and_looking(container: str, number: int, knowledge: Knowledge) -> tuple[Action, ...]:
    """The tasks; () where no plugin offers them."""
    opening = next(((name, t.lays_open) for name, t in knowledge.tasks.items() if t.lays_open), None)
    looking = next((name for name, t in knowledge.tasks.items() if t.looks), None)
    if opening is None or looking is None:
        return ()
    task, role = opening
    view = Location(f"view_into_{container}", "view", parameters={"around": (container,)})
    return (
        Action(f"0.{local_name(task)}_{number + 1}", task, {role: Object(container, entity=container)}),
        Action(f"0.{local_name(looking)}_{number + 1}", looking, goal=view),
    )
