"""Exploration before a plan: the robot opens or puts aside occluders and looks behind or into them, until all
wanted things were seen.

Opening, putting aside and looking become the first steps of every program. The picture is taken of the real world as these steps
leave it, once they were proven in what is believed.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice
from typing import TYPE_CHECKING

from msgspec.structs import replace

from ..base.errors import UserError
from ..base.value import Value
from ..model.designators import Action, Location, Object
from ..model.plan import Plan
from ..model.run.rollout import world_after_run
from ..ontology.prefixes import local_name
from ..perception.view_queries import INSIDE, bears
from ..planning.diagnosis import nearest_miss
from ..planning.search.search import Search
from ..planning.trace import Trace
from ..plugin.grounding import Context
from .proof.proof import assemble, prove, text_that_runs
from .search_in_setting import are_there
from .setting import Setting

if TYPE_CHECKING:
    from ..model.view import Points
    from ..model.world.thing import Thing
    from ..planning.search.state import State
    from ..plugin.catalogue import Knowledge
    from ..plugin.protocols import Candidate
    from ..scenario.scenario import Scenario

TRIED, VIEWED = 4, 12
"""Largest number of proven programs, and of estimated views, when one hidden place is to be uncovered. Views are estimated before a program
is proven."""
LEAST, ENOUGH = 4, 0.5
"""Least number of points (``unseen.places_above``) that a thing must hide to be put aside, and least share of them that the new view must
show."""


class Reveal(Value, eq=False):
    """Means to see a hidden place: which thing hides it, and which tasks uncover it and look.

    Args:
        name: of the thing that hides it.
        place: furniture where it is.
        objects, actions: how it is laid open and looked at.
        points: places (n, 3) [m] that the view is to show; None where a free view of ``place`` is enough.
    """

    name: str
    place: str
    objects: tuple[Object, ...]
    actions: tuple[Action, ...]
    points: Points | None = None


def explored(setting: Setting, scenario: Scenario, plan: Plan | None, knowledge: Knowledge) -> Setting:
    """Return the setting after the robot has opened closed things (nearest first), then put occluders aside
    (largest first), and looked there, until all wanted things were seen.

    What cannot be laid open, or looked at, is left as it is, and the look says why (``Look.shut``). It ends when all that is asked
    for was seen.

    Args:
        plan: that is likeliest to be carried out; None for a goal.
    """
    base = setting.world.robots[0].base
    for container in sorted(closed(setting, knowledge), key=lambda t: base.distance(t.pose)[0]):
        if is_meant(setting, scenario, plan, knowledge):
            return setting
        setting = _revealed(setting, _opening(container, setting, knowledge), knowledge)
    put_aside = set[str]()
    while not is_meant(setting, scenario, plan, knowledge):
        reveals = [r for r in _asides(setting, knowledge) if r.name not in put_aside]
        if not reveals:
            return setting
        put_aside.add(reveals[0].name)
        setting = _revealed(setting, reveals[0], knowledge)
    return setting


def closed(setting: Setting, knowledge: Knowledge) -> Iterator[Thing]:
    """Generate closed things that hide a place from every camera pose and that a task's rule lets the robot
    open."""
    from ..planning.operators import Grounder

    assert setting.look is not None
    task, role = next(((n, t.lays_open) for n, t in knowledge.tasks.items() if t.lays_open), ("", ""))
    grounder = Grounder(setting.symbolic(knowledge.taxonomy), knowledge.predicates)
    facts, rules = grounder.initial, [r for r in knowledge.rules if r.task == task]
    names = {o.roles[role] for o in grounder.ground(rules, knowledge.tasks) if o.applies(facts)}
    for thing in setting.world.things:
        hollow = bears(thing, knowledge.taxonomy, INSIDE)
        if thing.name in names and thing.joint is not None and (thing.name in setting.look.hidden if hollow else thing.joint.parent):
            yield thing


def _opening(container: Thing, setting: Setting, knowledge: Knowledge) -> Reveal:
    """Return how to see inside a closed thing: inside a drawer that is opened, or inside the cupboard
    behind a door."""
    assert container.joint is not None
    place = container.name if bears(container, knowledge.taxonomy, INSIDE) else container.joint.parent
    task, role = next((n, t.lays_open) for n, t in knowledge.tasks.items() if t.lays_open)
    one = Object(container.name, entity=container.name)
    return Reveal(container.name, place, (one,), _and_look(task, {role: one}, place, setting, knowledge))


def _asides(setting: Setting, knowledge: Knowledge) -> list[Reveal]:
    """Ways to see what is hidden behind movable things: put a thing aside, then look.

    The thing that hides most comes first.
    """
    from ..perception.unseen import hidden_behind, places_above

    found: list[Reveal] = []
    task, roles = next(((n, t.puts_aside) for n, t in knowledge.tasks.items() if t.puts_aside), ("", None))
    if setting.look is None or roles is None:
        return found
    furniture = {t.name: t for t in setting.now.things if t.furniture}
    for thing in (t for t in setting.now.things if t.movable):
        for place in dict.fromkeys(o for _, s, o in setting.relations if s == thing.name and o in furniture):
            points = hidden_behind(thing, places_above(furniture[place], knowledge.taxonomy), setting.look.pictures)
            objects = (Object(thing.name, entity=thing.name), Object(place, entity=place))
            if len(points) >= LEAST:
                actions = _and_look(task, dict(zip(roles, objects, strict=True)), place, setting, knowledge)
                found.append(Reveal(thing.name, place, objects, actions, points))
    return sorted(found, key=lambda r: (-len(r.points) if r.points is not None else 0, r.name))


def _and_look(task: str, roles: dict[str, Object], place: str, setting: Setting, knowledge: Knowledge) -> tuple[Action, ...]:
    """Return the given task, and the task that looks at the place which it reveals; () where no plugin offers
    a task that looks."""
    looking = next((name for name, t in knowledge.tasks.items() if t.looks), None)
    if looking is None or setting.look is None:
        return ()
    number = len(setting.look.pictures) + 1
    view = Location(f"view_of_{place}", "view", parameters={"around": (place,)})
    return (Action(f"0.{local_name(task)}_{number}", task, roles), Action(f"0.{local_name(looking)}_{number}", looking, goal=view))


def is_meant(setting: Setting, scenario: Scenario, plan: Plan | None, knowledge: Knowledge) -> bool:
    """Check whether the things of a goal or a plan are among the believed ones."""
    if plan is not None:
        return are_there(plan, setting, knowledge, Trace())
    from ..language.sentence import NotUnderstood
    from ..planning.scenario_goals import meanings

    scene = setting.symbolic(knowledge.taxonomy)
    try:
        return next(meanings(scenario, scene, knowledge), None) is not None
    except NotUnderstood as error:
        return error.ambiguous  # it is asked back
    except UserError:
        return False


def _revealed(setting: Setting, reveal: Reveal, knowledge: Knowledge) -> Setting:
    """Prove and run a program that uncovers a hidden place; return the setting after the camera has looked there.

    If that fails, the setting's ``look`` has the reason.
    """
    from ..perception.active_perception import look_into

    seen, trace = setting.look, Trace()
    assert seen is not None
    proven = next(_proven(setting, reveal, knowledge, trace), None)
    if proven is None or seen.camera is None:
        miss = nearest_miss(trace.entries)
        return _shut(setting, reveal.name, f"{miss.designator}: {miss.reason}" if miss else "no view shows what it hides")
    state, candidate = proven
    text = text_that_runs(candidate, setting.backend)
    assert text is not None  # it ran in the proof
    ran = knowledge.run(text.text, seen.real, setting.seed)
    if ran.outcome != "finished":
        return _shut(setting, reveal.name, f"the proven program did not come to its end ({ran.outcome}): {ran.reason}")
    looked = look_into(seen, reveal.place, state, seen.camera, world_after_run(ran, seen.real), knowledge, setting.seed)
    return replace(setting, world=looked.world, relations=looked.relations, real=looked.real, look=looked)


def _shut(setting: Setting, container: str, why: str) -> Setting:
    assert setting.look is not None
    return replace(setting, look=replace(setting.look, shut={**setting.look.shut, container: why}))


def _proven(setting: Setting, reveal: Reveal, knowledge: Knowledge, trace: Trace) -> Iterator[tuple[State, Candidate]]:
    """Generate proven ways to uncover a hidden place and to bring the camera to a view of it.

    In the proof the unseen place counts as filled by a body.
    """
    from ..perception.unseen import unknown_body

    if reveal.points is not None:
        unknown = unknown_body(f"unseen_behind_{reveal.name}", reveal.points)
        setting = replace(setting, world=replace(setting.world, things=(*setting.world.things, unknown)))
    took = setting.look.camera if setting.look else None
    context = Context(setting.robot, setting.world.robots[0], {}, knowledge.taxonomy, seed=setting.seed, camera=took)
    search = Search(knowledge.registry, knowledge.tasks, knowledge.task_owners, context, trace)
    plan, tried = Plan(setting.name, reveal.objects, reveal.actions), 0
    for state in islice(search.solve(setting.start(plan)) if reveal.actions else (), VIEWED):
        if tried == TRIED:
            return
        if (share := _would_show(state, reveal, setting, knowledge)) < ENOUGH:
            why = f"the camera would see {share:.0%} of the place that '{reveal.name}' hides, {ENOUGH:.0%} is needed"
            trace.add(0, f"view_of_{reveal.place}", str(plan), "refused", "engine", why, kind="location")
            continue
        tried += 1
        candidate, verdict = prove(assemble(plan, state, setting, knowledge), knowledge, setting.backend, setting.seed)
        if verdict.passed:
            yield state, candidate
        else:
            trace.add(0, "proof", str(plan), "failed", setting.backend.name, verdict.reason, kind="proof", numbers=verdict.measured)


def _would_show(state: State, reveal: Reveal, setting: Setting, knowledge: Knowledge) -> float:
    """Return the share of a hidden place that the camera would see from its planned pose, with the known
    things in view."""
    from ..perception.unseen import share_shown

    camera = setting.look.camera if setting.look else None
    if reveal.points is None or camera is None:
        return 1.0
    known = [t for t in setting.look.world.things if t.name in state.belief.poses] if setting.look else []
    things = tuple(t.moved_to(state.belief.poses[t.name].pose) for t in known)
    placed = replace(camera, joints=state.belief.joints, noise=False)
    view = knowledge.simulator.look(replace(setting.world, things=things), knowledge.robots_of(setting.world), placed, seed=0)
    return share_shown(reveal.points, view.depth, view.camera, view.intrinsics)
