"""Exploration before a plan: what hides things is opened, and the camera looks into it, until all that is asked for was seen.

Opening and looking become the first steps of every program. The picture is taken of the real world as these steps
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
from ..perception.view_queries import INSIDE, bears
from ..planning.budget import Budget
from ..planning.diagnosis import nearest_miss
from ..planning.search import Search
from ..planning.trace import Trace
from ..plugin.grounding import Context
from .candidates import search_in
from .proof import assemble, prove, text_that_runs
from .setting import Setting

if TYPE_CHECKING:
    from ..model.world import Thing
    from ..planning.state import State
    from ..plugin.catalogue import Knowledge
    from ..plugin.protocols import Candidate
    from ..scenario.scenario import Scenario

TRIED = 4
"""Ways to open and look into one thing that are proven at most."""


def explored(setting: Setting, scenario: Scenario, plan: Plan | None, knowledge: Knowledge) -> Setting:
    """Return the setting with what the camera saw behind and in what was opened for it, one after another, the nearest first.

    What cannot be opened, or looked into, is left as it is, and the look says why (``Look.shut``).

    It ends when all that is asked for was seen.

    Args:
        plan: that is likeliest to be carried out; None for a goal.
    """
    base = setting.world.robots[0].base
    for container in sorted(closed(setting, knowledge), key=lambda t: base.distance(t.pose)[0]):
        if is_meant(setting, scenario, plan, knowledge):
            break
        setting = _looked_into(setting, container.name, _hidden_by(container, knowledge), knowledge)
    return setting


def closed(setting: Setting, knowledge: Knowledge) -> Iterator[Thing]:
    """Generate what hides something: what a task can lay open as it stands, by its rule, and no camera could look into."""
    from ..planning.operators import Grounder

    assert setting.look is not None
    task, role = next(((n, t.lays_open) for n, t in knowledge.tasks.items() if t.lays_open), ("", ""))
    grounder = Grounder(setting.symbolic(knowledge.taxonomy), knowledge.predicates)
    facts, rules = grounder.initial(), [r for r in knowledge.rules if r.task == task]
    names = {o.roles[role] for o in grounder.ground(rules, knowledge.tasks) if o.applies(facts)}
    for thing in setting.world.things:
        hollow = bears(thing, knowledge.taxonomy, INSIDE)
        if thing.name in names and thing.joint is not None and (thing.name in setting.look.hidden if hollow else thing.joint.parent):
            yield thing


def _hidden_by(container: Thing, knowledge: Knowledge) -> str:
    """The furniture where it hides things: itself, such as a drawer, or what it closes, such as the cupboard of a door."""
    assert container.joint is not None
    return container.name if bears(container, knowledge.taxonomy, INSIDE) else container.joint.parent


def is_meant(setting: Setting, scenario: Scenario, plan: Plan | None, knowledge: Knowledge) -> bool:
    """Check whether the things that a goal or a plan is about are among those that are believed."""
    if plan is not None:
        search = search_in(setting, knowledge, Budget(), Trace())
        return next(search.solve(replace(setting.start(plan), agenda=plan.objects)), None) is not None
    from ..planning.goal_planner import ground_goal
    from ..planning.operators import Grounder
    from ..planning.task_goals import Goal

    grounder = Grounder(setting.symbolic(knowledge.taxonomy), knowledge.predicates)
    try:
        return next(ground_goal(Goal(scenario.spec.goal or ()), scenario.spec.objects, grounder), None) is not None
    except UserError:
        return False


def _looked_into(setting: Setting, container: str, place: str, knowledge: Knowledge) -> Setting:
    """With what is seen at a place that a container hides; or why not, where no way to open and look is proven, or does what it should."""
    from ..perception.active_perception import look_into

    seen, backend, trace = setting.look, setting.backend, Trace()
    assert seen is not None
    proven = next(_proven(setting, container, place, knowledge, trace), None)
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
    looked = look_into(seen, place, state, seen.camera, world_after_run(ran, seen.real), knowledge, setting.seed)
    return replace(setting, world=looked.world, relations=looked.relations, real=looked.real, look=looked)


def _shut(setting: Setting, container: str, why: str) -> Setting:
    assert setting.look is not None
    return replace(setting, look=replace(setting.look, shut={**setting.look.shut, container: why}))


def _proven(setting: Setting, container: str, place: str, knowledge: Knowledge, trace: Trace) -> Iterator[tuple[State, Candidate]]:
    """Ways to open a container and to bring the camera to a view into it, each proven in what is believed."""
    actions = _opening_and_looking(container, place, len(setting.look.pictures) if setting.look else 0, knowledge)
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


def _opening_and_looking(container: str, place: str, number: int, knowledge: Knowledge) -> tuple[Action, ...]:
    """The tasks; () where no plugin offers them."""
    opening = next(((name, t.lays_open) for name, t in knowledge.tasks.items() if t.lays_open), None)
    looking = next((name for name, t in knowledge.tasks.items() if t.looks), None)
    if opening is None or looking is None:
        return ()
    task, role = opening
    view = Location(f"view_into_{place}", "view", parameters={"around": (place,)})
    return (
        Action(f"0.{local_name(task)}_{number + 1}", task, {role: Object(container, entity=container)}),
        Action(f"0.{local_name(looking)}_{number + 1}", looking, goal=view),
    )
