"""Active perception: the camera is moved to see the objects of a plan, and its pictures become the
believed world.

Furniture is known from the map; things that can be moved are known only as far as they are perceived, and what is seen
but not recognised is in the way.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import islice
from typing import TYPE_CHECKING, Any

from msgspec.structs import replace

from ..base.errors import NoSolution, UserError
from ..base.value import Value
from ..model.belief import Estimate, Relation, initial_belief
from ..model.designators import Action, Location
from ..model.geometry import Pose
from ..model.world.thing import Thing
from ..model.world.world import Camera, World
from ..ontology.foundation import BEARS
from ..ontology.prefixes import local_name
from ..plugin.expert import RELATIONS, Judged
from ..scenario.scenario import Scenario
from ..scenario.worlds import camera_of
from .own_body import own_depth
from .query import Condition, ObjectQuery
from .recognition import SIGMA, estimates_of, facts, least_pose_confidence, renamed, thing_from_percept, unlocated
from .result import Perceived, Percept
from .runner import perceive
from .view_queries import HANGING, INSIDE, bears, queries_everywhere

if TYPE_CHECKING:
    from ..model.robot import Robot
    from ..model.view import Depth, View
    from ..planning.search.state import State
    from ..plugin.catalogue import Knowledge

UNEXPLAINED = "camera: nothing that is known explains it"
WANTED = ("type", "relations", "pose", "instance", "refined")
SURE, VIEWS = 0.6, 3
"""Confidence of a pose below which the camera looks again from another viewpoint, and the largest number of pictures. Of poses with scores
over 0.6 few are wrong (docs/figures/perception_pose.yaml)."""


class Picture(Value):
    """Camera image of the real world, with the camera, the fixtures and the robot's state at the time.

    Args:
        view: what the camera saw.
        camera: that took it.
        fixtures: things whose poses the map gives.
        state: what the robot had done until then; None for a fixed camera.
        robot: the depth at which the camera would see the robot itself as it stands, NaN beside it [m].
        perceived: what the experts say of it; None before they were asked.
        still: whether all stood as at the start; False where something was opened or put aside for it.
    """

    view: View
    camera: Camera
    fixtures: tuple[Thing, ...]
    state: State | None = None
    robot: Depth | None = None
    perceived: Perceived | None = None
    still: bool = True


class Look(Value):
    """Observations so far, and the world that is believed from them.

    Args:
        pictures: in the order in which they were taken.
        known: furniture, and the things that were recognised.
        relations: facts about these.
        estimates: of the perceived poses.
        real: the world as it is; things that were recognised have the names they are believed under.
        obstacles: bodies around what was seen and not recognised.
        hidden: places into which the camera could not look.
        shut: those of them that were to be opened -> why that, or the look into them, did not come off.
        since: where things are by the last picture that were moved so that it could look; ``known`` has them as at the start.
        later: names of those obstacles that only pictures show for which something was opened or put aside.
        missed: for each thing that was looked for in vain, and may be where no camera could look, why it could not.
        sought: fixed things whose places only a camera can tell, and that none has found yet -> the model of each.
    """

    pictures: tuple[Picture, ...]
    known: World
    relations: tuple[Relation, ...]
    estimates: Mapping[str, Estimate]
    real: World
    obstacles: tuple[Thing, ...] = ()
    hidden: tuple[str, ...] = ()
    shut: Mapping[str, str] = {}
    since: Mapping[str, Pose] = {}
    later: tuple[str, ...] = ()
    missed: tuple[str, ...] = ()
    sought: Mapping[str, str] = {}

    @property
    def world(self) -> World:
        """Believed world: furniture, recognised things and obstacles."""
        return replace(self.known, things=(*self.known.things, *self.obstacles))

    @property
    def unlocated(self) -> Mapping[str, str]:
        """Fixtures that were looked for and not located, each with the reason."""
        return unlocated((p.perceived for p in self.pictures if p.perceived), self.estimates)

    @property
    def camera(self) -> Camera | None:
        """Camera of the last picture; None without one."""
        return self.pictures[-1].camera if self.pictures else None

    @property
    def state(self) -> State | None:
        """Robot state at the last picture, with the steps that led to it; None without a picture."""
        return self.pictures[-1].state if self.pictures else None


def look(
    scenario: Scenario, wanted: Sequence[Sequence[ObjectQuery]], world: World, real: World, robot: Robot,
    knowledge: Knowledge, seed: int,
) -> Look:  # fmt: skip
    """Look for things with the scenario's camera, and return the belief afterwards.

    For each thing: bring the camera to where it sees the places that a query names, take a picture of the real world,
    and believe what the experts say of it.

    Args:
        wanted: for each, queries in the order in which they are asked until one is answered.
        world: as the scenario describes it; of this, only furniture is believed.

    Raises:
        UserError: a wrong query.
        NoPipeline: the experts cannot answer it.
        NoSolution: no picture shows a thing that the scenario's camera is to find.
    """
    seen = Look((), mapped(scenario, world), (), {}, real, sought=sought_in(scenario))
    waiting = [*wanted]
    while waiting:
        queries, before = waiting.pop(0), {t.name for t in seen.known.things}
        out_of_sight, answered = list[NoSolution](), False
        for query in queries:
            try:
                taken = _best(scenario, replace(query, wanted=WANTED), seen, robot, knowledge, seed)
            except NoSolution as nowhere:  # it may be elsewhere
                out_of_sight.append(nowhere)
                seen = replace(seen, hidden=(*seen.hidden, *places_of(query, seen.known, knowledge)))
                continue
            seen = _beware(_with(seen, taken, knowledge), knowledge)
            if answered := taken.perceived is not None and bool(taken.perceived.answers):
                break
        if out_of_sight and not answered and any(c.key not in RELATIONS for q in queries for c in q.conditions):
            seen = replace(seen, missed=(*seen.missed, str(out_of_sight[0])))  # what is only in the way need not be seen
        new = tuple(t for t in seen.known.things if t.furniture and t.name not in before)
        waiting += queries_everywhere(replace(seen.known, things=new), knowledge.taxonomy)
    for name, model in seen.sought.items():
        raise NoSolution(f"No picture shows '{name}', which the camera is to find: nothing was recognised as a '{model}'.")
    return replace(seen, real=renamed(real, seen.world))


def mapped(scenario: Scenario, world: World) -> World:
    """Return the world that is known before any picture: its furniture, but for pieces that the scenario's camera is to find."""
    found = set(scenario.spec.camera.finds if scenario.spec.camera else ())
    found |= {t.name for t in world.things if t.joint is not None and t.joint.parent in found}
    return replace(world, things=tuple(t for t in world.things if t.furniture and t.name not in found))


def sought_in(scenario: Scenario) -> Mapping[str, str]:
    """Return the names of things that a scenario's camera is to find, each with its model."""
    named = scenario.spec.camera.finds if scenario.spec.camera else ()
    return {t.name: t.model for t in scenario.spec.things if t.name in named}


def _best(
    scenario: Scenario, query: ObjectQuery, seen: Look, robot: Robot, knowledge: Knowledge, seed: int
) -> Picture:
    """Return the first picture in which all poses are sufficiently confident, else the picture whose least
    confident pose is the most confident."""
    earlier = {t.name: (t.type, t.pose.position) for t in seen.known.things if not t.furniture or t.name in seen.estimates}
    best: tuple[float, Picture | None] = (-1.0, None)
    for taken in islice(pictures(scenario, query, seen, robot, knowledge, seed), VIEWS):
        perceived = ask(query, taken.view, taken.fixtures, knowledge, earlier=earlier, robot=taken.robot)
        best = max(best, (least_pose_confidence(perceived), replace(taken, perceived=perceived)), key=lambda b: b[0])
        if best[0] >= SURE:
            break
    assert best[1] is not None  # there is a view, or there was an error
    return best[1]


def look_into(
    seen: Look, place: str, state: State, camera: Camera, now: World, knowledge: Knowledge, seed: int
) -> Look:
    """Return the belief after a picture of the inside of furniture, such as a drawer, that could not be seen before.

    What is recognised there is believed to have been there at the start, where the furniture then was.

    Args:
        state: of the robot, with the steps that laid it open and brought the camera to a view of it.
        now: the world as it really is behind these steps.
    """
    furniture = (t for t in seen.known.things if t.furniture)
    fixtures = tuple(replace(t, pose=state.belief.poses[t.name].pose) for t in furniture)
    placed = replace(camera, joints=state.belief.joints)
    own = own_depth(now, placed, knowledge)
    view = knowledge.simulator.look(now, knowledge.robots_of(now), placed, seed=seed + 7919 * len(seen.pictures))
    hollow = bears(seen.known.thing(place), knowledge.taxonomy, INSIDE)
    query = ObjectQuery((Condition("in", "CONTAINS", place),)) if hollow else ObjectQuery()
    known = {t.name: state.belief.poses[t.name].pose for t in seen.known.things}
    earlier = {t.name: (t.type, known[t.name].position) for t in seen.known.things if not t.furniture}
    perceived = ask(replace(query, wanted=WANTED), view, fixtures, knowledge, earlier=earlier, robot=own)
    taken = Picture(view, placed, fixtures, state, own, perceived, still=False)
    after = _with(replace(seen, known=replace(seen.known, things=fixtures)), taken, knowledge)
    inside = {t.name: t.pose for t in after.known.things if not t.furniture and t.name not in earlier}
    back = seen.known.thing(place).pose * known[place].inverse()
    things = (*seen.known.things, *(replace(t, pose=back * t.pose) for t in after.known.things if t.name in inside))
    new = {n: replace(e, pose=back * e.pose) if n in inside else e for n, e in after.estimates.items() if n not in earlier}
    moved = {t.name: known[t.name] for t in seen.known.things if t.joint is not None or not t.furniture}
    found = replace(
        after, known=replace(seen.known, things=things), estimates={**seen.estimates, **new}, since={**seen.since, **moved, **inside}
    )
    there = (*after.known.things, *(t.moved_to(known[t.name]) for t in seen.known.things if not t.furniture))
    wary = _wary(_beware(found, knowledge), taken, there, place if hollow else "", knowledge)
    return replace(wary, real=renamed(seen.real, wary.world))


def _wary(seen: Look, taken: Picture, there: tuple[Thing, ...], container: str, knowledge: Knowledge) -> Look:
    """Return the belief with a picture's unrecognised bodies: those in a container become its parts, others fixed things.

    Args:
        there: what is known, as it stood when the picture was taken.
    """
    bodies = _unexplained(taken, (*(t for t in there if t.furniture), *seen.obstacles), [t for t in there if not t.furniture], knowledge)
    free, place = _free_names(seen, seen.obstacles), next((t for t in there if t.name == container), None)
    within = [b for b in bodies if place is not None and _is_in(b.pose, place, knowledge)]
    fixed = tuple(replace(b, name=next(free)) for b in bodies if b not in within)
    parts = tuple(replace(g, pose=place.pose.inverse() * b.pose * g.pose) for b in within for g in b.geoms) if place else ()
    things = tuple(replace(t, geoms=(*t.geoms, *parts)) if t.name == container else t for t in seen.known.things)
    estimates = {**seen.estimates, **{t.name: Estimate(t.pose, SIGMA, UNEXPLAINED) for t in fixed}}
    later = (*seen.later, *(t.name for t in fixed))
    known, obstacles = replace(seen.known, things=things), (*seen.obstacles, *fixed)
    return replace(seen, known=known, obstacles=obstacles, estimates=estimates, later=later)


def _is_in(pose: Pose, container: Thing, knowledge: Knowledge) -> bool:
    """Check whether a thing is in the cavity of a container, or protrudes from it by less than 0.1 m."""
    for feature in (f for f in container.features if INSIDE in knowledge.taxonomy.fillers(f.type, BEARS)):
        x, y, z = (container.pose * feature.pose).inverse().apply(pose.position)
        if abs(x) <= feature.size["width"] / 2 and abs(y) <= feature.size["depth"] / 2 and -feature.size["height"] <= z <= 0.1:
            return True
    return False


def _with(before: Look, taken: Picture, knowledge: Knowledge) -> Look:
    """Return the belief extended by what was perceived in one more picture."""
    assert taken.perceived is not None
    answers, sought = taken.perceived.answers, dict(before.sought)
    found = [(_named(t, p, sought), p) for p in answers if (t := thing_from_percept(p, knowledge.products)) and p.value("instance")]
    fixtures, estimates = _fixtures(taken, taken.perceived, before)
    old = [t for t in before.known.things if not t.furniture]
    known = {t.name: t for t in (*fixtures, *old, *(part for thing, _ in found for part in thing.as_parts()))}
    things = sorted(known.values(), key=lambda t: not t.furniture)
    new = (r for thing, percept in found if not thing.furniture for r in facts(thing.name, percept, fixtures))
    perceived = {n: e for thing, percept in found for n, e in estimates_of(percept, thing.as_parts()).items()}
    return replace(
        before,
        sought=sought,
        pictures=(*before.pictures, taken),
        known=replace(before.known, things=tuple(things)),
        relations=tuple(dict.fromkeys((*before.relations, *new))),
        estimates={**before.estimates, **estimates, **perceived},
    )


def _named(thing: Thing, percept: Percept, sought: dict[str, str]) -> Thing:
    """Return a recognised thing under the name of one that is sought, and take that from those, if it is of its model."""
    meant = next((n for n, model in sought.items() if model == percept.value("model")), None)
    if meant is None:
        return thing
    del sought[meant]
    return replace(thing, name=meant)


def _beware(seen: Look, knowledge: Knowledge) -> Look:
    """Return the belief with obstacles at those points of the pictures that known things do not explain."""
    if not any("obstacles" in e.outputs for e in knowledge.experts):
        return seen
    fixed, moved = (tuple(t for t in seen.known.things if t.furniture == kind) for kind in (True, False))
    found: list[Thing] = []
    for taken in (p for p in seen.pictures if p.still):
        found += _unexplained(taken, (*fixed, *found), moved, knowledge)
    kept = tuple(t for t in seen.obstacles if t.name in seen.later)
    free = _free_names(seen, kept)
    bodies = tuple(replace(t, name=next(free)) for t in found)
    before = {t.name for t in seen.obstacles if t not in kept}  # some of them may have been recognised since
    estimates = {n: e for n, e in seen.estimates.items() if n not in before}
    estimates |= {t.name: Estimate(t.pose, SIGMA, UNEXPLAINED) for t in bodies}
    return replace(seen, obstacles=(*bodies, *kept), estimates=estimates)


def _free_names(seen: Look, obstacles: Iterable[Thing]) -> Iterator[str]:
    taken = {t.name for t in (*seen.known.things, *seen.real.things, *obstacles)}
    return (n for k in range(1, 10**6) if (n := f"obstacle_{k}") not in taken)


def _unexplained(taken: Picture, fixed: Iterable[Thing], moved: Iterable[Thing], knowledge: Knowledge) -> tuple[Thing, ...]:
    """Return bodies around the points of a picture that fixed and recognised things do not explain; () if no
    expert can tell."""
    if not any("obstacles" in e.outputs for e in knowledge.experts):
        return ()
    query = ObjectQuery(wanted=("obstacles",))
    said = ask(query, taken.view, tuple(fixed), knowledge, recognised=tuple(moved), robot=taken.robot).scene.get("obstacles")
    return tuple(said.value) if said is not None else ()


def _fixtures(taken: Picture, perceived: Perceived, before: Look) -> tuple[tuple[Thing, ...], dict[str, Estimate]]:
    """Return the furniture; its moved parts are at the poses at which a picture first showed them."""
    said = perceived.scene.get("refined")
    seen: Mapping[str, Judged] = said.value if said is not None else {}
    moved = {n: judged for n, judged in seen.items() if judged.value is not None and n not in before.estimates}
    by = f"by expert {said.expert if said is not None else ''}"
    estimates = {n: Estimate(j.value, SIGMA, f"camera: {j.reason}, {by}, confidence {j.confidence:.2f}") for n, j in moved.items()}
    return tuple(replace(t, pose=moved[t.name].value) if t.name in moved else t for t in taken.fixtures), estimates


def pictures(
    scenario: Scenario, query: ObjectQuery, seen: Look, robot: Robot, knowledge: Knowledge, seed: int
) -> Iterator[Picture]:
    """Yield pictures that the scenario's camera takes of the world as it really is, not as the robot believes it to be.

    A flange camera is brought to one place after another from which it sees the places of the query.

    Args:
        seen: what is believed, and the pictures that were taken before: the robot starts from where it took the last.

    Raises:
        UserError: the scenario has no camera.
        NoSolution: the camera cannot be brought there.
    """
    camera, fixtures = camera_of(scenario), tuple(t for t in seen.known.things if t.furniture)
    if camera is None:
        raise UserError(
            f"{scenario.path}: the scenario has no camera, so nothing can be seen; add 'camera: {{mount: flange}}', or a "
            "fixed one with its pose under 'at'."
        )
    states: Iterable[State | None] = [None]
    if camera.mount is not None:
        states = go_and_look(places_of(query, seen.known, knowledge), seen, robot, camera, knowledge, seed)
    robots = knowledge.robots_of(seen.known)
    for number, state in enumerate(states, 1):
        placed = replace(camera, joints=state.belief.joints) if state else camera
        noise = seed + 7919 * len(seen.pictures) + 104729 * number
        view = knowledge.simulator.look(seen.real, robots, placed, seed=noise)
        yield Picture(view, placed, fixtures, state, own_depth(seen.real, placed, knowledge))


def places_of(query: ObjectQuery, furniture: World, knowledge: Knowledge) -> tuple[str, ...]:
    """Return the furniture that a query names; if it names none, all furniture on which things can hang or into
    which they can be put."""
    classes = knowledge.taxonomy
    wanted = [str(c.value) for c in query.conditions if c.key in RELATIONS]
    known = [classes.resolve(w) for w in wanted]
    named = [t.name for t in furniture.things if t.name in wanted or any(k and classes.is_a(t.type, k) for k in known)]
    return tuple(named or [t.name for t in furniture.things if bears(t, classes, HANGING, INSIDE)])


def go_and_look(
    around: tuple[str, ...], seen: Look, robot: Robot, camera: Camera, knowledge: Knowledge, seed: int
) -> Iterator[State]:
    """Yield robot states in which the camera sees some places, one viewpoint after another.

    The task that looks is resolved in a world of which only furniture, and what was seen before, is known.

    Raises:
        NoSolution: it cannot be brought there, with the nearest miss.
    """
    from ..planning.failure import failure_text
    from ..planning.search.search import Search
    from ..planning.search.state import State
    from ..planning.trace import Trace
    from ..plugin.grounding import Context

    mount, trace, done = seen.known.robots[0], Trace(), seen.state
    at = robot.arm_at(mount.base) if robot.platform else None
    home, opening = robot.start(mount)
    joints = done.belief.joints if done else home
    belief = initial_belief(seen.world, mount.name, joints, opening, seen.relations, at)
    belief = replace(belief, poses={**belief.poses, **seen.estimates})
    context = Context(robot, mount, {}, knowledge.taxonomy, seed=seed, camera=camera)
    search = Search(knowledge.registry, knowledge.tasks, knowledge.task_owners, context, trace)
    number, task = len(seen.pictures) + 1, _looking(knowledge)
    name = f"view_{number}"
    goal = Location(name, "view", parameters={"around": around})
    action = Action(f"0.{local_name(task)}_{number}", task, goal=goal)
    start = replace(done or State((), belief), agenda=(action,), belief=belief, choices=())
    found = search.solve(start)
    first = next(found, None)
    if first is None:
        raise NoSolution(f"The camera cannot be brought to a view of {', '.join(around)}.\n" + failure_text(trace, []))
    state: State | None = first
    while state is not None:
        yield state
        try:
            state = found.send(frozenset({name}))  # another view, not another way to the same
        except StopIteration:
            state = None


def _looking(knowledge: Knowledge) -> str:
    """Return the name of the task that brings a camera to a viewpoint.

    Raises:
        UserError: no plugin offers one.
    """
    found = next((name for name, task in knowledge.tasks.items() if task.looks), None)
    if found is None:
        raise UserError("No plugin offers a task that looks (TaskType.looks), so the arm's camera cannot be brought anywhere.")
    return found


def ask(query: ObjectQuery, view: View, fixtures: tuple[Thing, ...], knowledge: Knowledge, **more: Any) -> Perceived:
    """Answer a query about a view, with the prior knowledge of the engine: models, classes, and a map."""
    priors = {
        "view": view, "fixtures": fixtures, "models": knowledge.products, "query": query,
        "taxonomy": knowledge.taxonomy, **more,
    }  # fmt: skip
    owners = knowledge.expert_owners

    def fault(expert: str, error: BaseException) -> str:
        return str(knowledge.registry.fault(owners.get(expert, expert), "experts", expert, error))

    return perceive(query, knowledge.experts, priors, knowledge.taxonomy, fault)
