"""Looking before planning: what is believed of a scenario's world is what its camera sees of it.

Furniture is known from the map; things that can be moved are known only as far as they are perceived.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import islice
from typing import TYPE_CHECKING, Any

from .belief import Estimate, Relation, initial_belief
from .designators import Action, Location
from .errors import NoSolution, UserError
from .experts import Judged
from .object_query import RELATIONS, UNKNOWN, ObjectQuery, parse_query
from .perception import Perceived, Percept, perceive
from .scenario import Scenario
from .scenario_world import camera_of
from .world import Camera, Thing, World

if TYPE_CHECKING:
    from .knowledge import Knowledge
    from .robots import Robot
    from .state import State
    from .view import View

WANTED = ("type", "relations", "pose", "instance", "refined")
SIGMA = 0.002
"""Standard deviation of a perceived position [m]: twice the median error of confident poses at 0.6 m
(docs/explanation/figures.md), which leaves room for the tail."""
SURE, VIEWS = 0.6, 3
"""Where a pose is less sure than this, the camera looks from elsewhere, this many times in all: of scores over 0.6 few are
wrong (docs/explanation/figures.md)."""
SAME = 0.10
"""A thing whose centre is farther than this from where one is believed is another one [m]: the least distance of
neighbouring products is 70 mm along a peg, 160 mm across."""


@dataclass(frozen=True)
class Picture:
    """A view of the real world.

    Args:
        view: what the camera saw.
        camera: that took it.
        fixtures: things whose poses the map gives.
        state: what the robot had done until then; None for a fixed camera.
        perceived: what the experts say of it; None before they were asked.
    """

    view: View
    camera: Camera
    fixtures: tuple[Thing, ...]
    state: State | None = None
    perceived: Perceived | None = None


@dataclass(frozen=True)
class Look:
    """What was seen, and what is believed since.

    Args:
        pictures: in the order in which they were taken.
        world: furniture, and the things that were recognised.
        relations: facts about these.
        estimates: of the perceived poses.
        real: the world as it is; things that were recognised have the names they are believed under.
    """

    pictures: tuple[Picture, ...]
    world: World
    relations: tuple[Relation, ...]
    estimates: Mapping[str, Estimate]
    real: World

    @property
    def camera(self) -> Camera:
        return self.pictures[-1].camera

    @property
    def state(self) -> State | None:
        """Where the robot stands since the last picture, and the steps that led there."""
        return self.pictures[-1].state


def look(scenario: Scenario, world: World, real: World, robot: Robot, knowledge: Knowledge, seed: int) -> Look:
    """For each query of the scenario's camera: bring it to where it sees the places that the query names, take a picture
    of the real world, and believe what the experts say of it.

    Args:
        world: as the scenario describes it; of this, only furniture is believed.

    Raises:
        UserError: a wrong query.
        NoPipeline: the experts cannot answer it.
        NoSolution: the camera cannot be brought there.
    """
    assert scenario.spec.camera is not None
    furniture = replace(world, things=tuple(t for t in world.things if not t.movable))
    seen = Look((), furniture, (), {}, real)
    for text in scenario.spec.camera.look or ("",):
        query = replace(parse_query(text, knowledge.taxonomy), wanted=WANTED)
        earlier = {t.name: (t.type, t.pose.position) for t in seen.world.things if t.movable}
        best: tuple[float, Picture | None] = (-1.0, None)
        views = pictures(scenario, query, seen.world, real, robot, knowledge, seed, seen.pictures)
        for taken in islice(views, VIEWS):
            perceived = ask(query, taken.view, taken.fixtures, knowledge, earlier=earlier)
            best = max(best, (_surety(perceived), replace(taken, perceived=perceived)), key=lambda b: b[0])
            if best[0] >= SURE:
                break
        assert best[1] is not None and best[1].perceived is not None
        seen = _with(seen, best[1], best[1].perceived, knowledge)
    return replace(seen, real=renamed(real, seen.world))


def _surety(perceived: Perceived) -> float:
    """Of the pose that is least sure; 0 where something that could be an answer has none, 1 where nothing is seen."""
    things = [p for p in perceived.answers if p.value("type") != UNKNOWN and not p.value("fixture")]
    return min((p.values["pose"].judged.confidence if "pose" in p.values else 0.0 for p in things), default=1.0)


def _with(before: Look, taken: Picture, perceived: Perceived, knowledge: Knowledge) -> Look:
    """What is believed after one more picture."""
    found = {n: (t, p) for p in perceived.answers if (known := _believed(p, knowledge)) for n, t in [known]}
    fixtures, estimates = _fixtures(taken, perceived, before)
    old = {t.name: t for t in before.world.things if t.movable}
    things = (*fixtures, *{**old, **{n: t for n, (t, _) in found.items()}}.values())
    facts = (r for name, (_, percept) in found.items() for r in _facts(name, percept, fixtures))
    return Look(
        (*before.pictures, taken),
        replace(before.world, things=things),
        tuple(dict.fromkeys((*before.relations, *facts))),
        {**before.estimates, **estimates, **{name: _estimate(percept) for name, (_, percept) in found.items()}},
        before.real,
    )


def _fixtures(taken: Picture, perceived: Perceived, before: Look) -> tuple[tuple[Thing, ...], dict[str, Estimate]]:
    """The furniture, some of it moved to where it was seen: once, in the picture that was taken of it."""
    said = perceived.scene.get("refined")
    seen: Mapping[str, Judged] = said.value if said is not None else {}
    moved = {n: judged for n, judged in seen.items() if n not in before.estimates}
    expert = said.expert if said is not None else ""
    estimates = {
        n: Estimate(j.value, SIGMA, f"camera: {j.reason}, by expert {expert}, confidence {j.confidence:.2f}")
        for n, j in moved.items()
    }
    return tuple(replace(t, pose=moved[t.name].value) if t.name in moved else t for t in taken.fixtures), estimates


def pictures(
    scenario: Scenario,
    query: ObjectQuery,
    world: World,
    real: World,
    robot: Robot,
    knowledge: Knowledge,
    seed: int,
    before: tuple[Picture, ...] = (),
) -> Iterator[Picture]:
    """What the scenario's camera sees of the real world, a flange camera from one place after another from which it sees
    the places of the query.

    Args:
        world: as it is believed.
        before: pictures that were taken before: the robot starts from where it took the last.

    Raises:
        UserError: the scenario has no camera.
        NoSolution: the camera cannot be brought there.
    """
    camera, fixtures = camera_of(scenario), tuple(t for t in world.things if not t.movable)
    if camera is None:
        raise UserError(
            f"{scenario.path}: the scenario has no camera, so nothing can be seen; add 'camera: {{mount: flange}}', or a "
            "fixed one with its pose under 'at'."
        )
    states: Iterable[State | None] = [None]
    if camera.mount is not None:
        states = go_and_look(places_of(query, world, knowledge), world, robot, camera, knowledge, seed, before)
    for number, state in enumerate(states, 1):
        placed = replace(camera, joints=state.belief.joints) if state else camera
        noise = seed + 7919 * len(before) + 104729 * number
        yield Picture(knowledge.simulator.look(real, knowledge.robots, placed, seed=noise), placed, fixtures, state)


def places_of(query: ObjectQuery, furniture: World, knowledge: Knowledge) -> tuple[str, ...]:
    """The furniture that a query names, by name or class; all that something can hang from or stand in, else."""
    classes = knowledge.taxonomy
    wanted = [str(c.value) for c in query.conditions if c.key in RELATIONS]
    known = [classes.resolve(w) for w in wanted]
    named = [t.name for t in furniture.things if t.name in wanted or any(k and classes.is_a(t.type, k) for k in known)]
    return tuple(named or [t.name for t in furniture.things if t.feature("vrps:Peg") or t.feature("cram:Cavity")])


def go_and_look(
    around: tuple[str, ...],
    world: World,
    robot: Robot,
    camera: Camera,
    knowledge: Knowledge,
    seed: int,
    before: tuple[Picture, ...] = (),
) -> Iterator[State]:
    """The task LookingFor, resolved in a world of which only furniture, and what was seen before, is known: motions to
    where the camera sees some places, as program steps, one alternative after another.

    Raises:
        NoSolution: it cannot be brought there, with the nearest miss.
    """
    from .answers import Context
    from .explain import failure_text
    from .search import Search
    from .state import State
    from .trace import Trace

    mount, trace, done = world.robots[0], Trace(), before[-1].state if before else None
    belief = initial_belief(world, mount.name, done.belief.joints if done else robot.home, robot.gripper.opening[1])
    context = Context(robot, mount, {}, knowledge.taxonomy, seed=seed, camera=camera)
    search = Search(knowledge.registry, knowledge.tasks, knowledge.task_owners, context, trace)
    name = f"view_{len(before) + 1}"
    action = Action(
        f"0.LookingFor_{len(before) + 1}", "soma:LookingFor", goal=Location(name, "view", parameters={"around": around})
    )
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


def ask(query: ObjectQuery, view: View, fixtures: tuple[Thing, ...], knowledge: Knowledge, **more: Any) -> Perceived:
    """A query about a view, with what an engine knows beforehand: models, classes, and a map."""
    priors = {
        "view": view, "fixtures": fixtures, "models": knowledge.products, "query": query,
        "taxonomy": knowledge.taxonomy, **more,
    }  # fmt: skip
    owners = knowledge.expert_owners

    def fault(expert: str, error: Exception) -> str:
        return str(knowledge.registry.fault(owners.get(expert, expert), "experts", expert, error))

    return perceive(query, knowledge.experts, priors, knowledge.taxonomy, fault)


def _believed(percept: Percept, knowledge: Knowledge) -> tuple[str, Thing] | None:
    """A recognised object as a thing of the world; None for what no model explains, or has no pose."""
    model = next((t for t in knowledge.products if t.name == percept.value("model")), None)
    pose, name = percept.value("pose"), percept.value("instance")
    if model is None or pose is None or name is None:
        return None
    return name, replace(model, name=name, pose=pose)


def _estimate(percept: Percept) -> Estimate:
    said = percept.values["pose"]
    sure = said.judged.confidence
    source = f"camera: {percept.value('model')} by expert {said.expert}, confidence {sure:.2f}"
    return Estimate(said.value, SIGMA / max(sure, 0.1), source)


def _facts(name: str, percept: Percept, fixtures: tuple[Thing, ...]) -> tuple[Relation, ...]:
    known = {t.name for t in fixtures}
    facts = percept.value("relations", ())
    hanging = {n for p, n, _ in facts if p == "hangs_on"}
    return tuple((p, name, n) for p, n, _ in facts if n in known and not (p == "on" and n in hanging))


def renamed(real: World, believed: World) -> World:
    """The real world under the names of the believed one, for judges: a believed thing is the nearest real one.

    Nobody who decides sees this: physics and controllers do not know names.
    """
    mine = {t.name: t for t in believed.things if t.movable}
    theirs = {t.name: t for t in real.things if t.movable}
    pairs = sorted(
        (math.dist(a.pose.position, b.pose.position), a.name, b.name) for a in mine.values() for b in theirs.values()
    )
    names: dict[str, str] = {}
    for gap, own, other in pairs:
        if gap <= SAME and own not in names.values() and other not in names:
            names[other] = own
    taken = {t.name for t in believed.things}
    for other in theirs:
        names.setdefault(other, other if other not in taken else f"unseen_{other}")
    return replace(real, things=tuple(replace(t, name=names.get(t.name, t.name)) for t in real.things))
