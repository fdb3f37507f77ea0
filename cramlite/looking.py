"""Looking before planning: what is believed of a scenario's world is what its camera sees of it.

Furniture is known from the map; things that can be moved are known only as far as they are perceived.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from .belief import Estimate, Relation, initial_belief
from .designators import Action, Location
from .errors import NoSolution, UserError
from .object_query import RELATIONS, ObjectQuery, parse_query
from .perception import Perceived, Percept, perceive
from .plugin_types import Camera
from .scenario import Scenario
from .world import Thing, World

if TYPE_CHECKING:
    from .knowledge import Knowledge
    from .robots import Robot
    from .state import State
    from .view import View

WANTED = ("type", "relations", "pose", "instance")
SIGMA = 0.002
"""Standard deviation of a perceived position [m]: twice the median error of confident poses at 0.6 m
(docs/explanation/figures.md), which leaves room for the tail."""
SAME = 0.10
"""A thing whose centre is farther than this from where one is believed is another one [m]: the least distance of
neighbouring products is 70 mm along a peg, 160 mm across."""


@dataclass(frozen=True)
class Look:
    """What was seen, and what is believed since.

    Args:
        view: the picture.
        perceived: everything in it.
        world: furniture, and the things that were recognised.
        relations: facts about these.
        estimates: of the perceived poses.
        real: the world as it is; things that were recognised have the names they are believed under.
        camera: that took the picture.
        state: what the robot did before: the steps to the view; None for a fixed camera.
    """

    view: View
    perceived: Perceived
    world: World
    relations: tuple[Relation, ...]
    estimates: Mapping[str, Estimate]
    real: World
    camera: Camera
    state: State | None = None


def look(scenario: Scenario, world: World, real: World, robot: Robot, knowledge: Knowledge, seed: int) -> Look:
    """Bring the camera to where it sees the places that the query names, take a picture of the real world, and believe
    what the experts say of it.

    Args:
        world: as the scenario describes it; of this, only furniture is believed.

    Raises:
        UserError: a wrong query.
        NoPipeline: the experts cannot answer it.
        NoSolution: the camera cannot be brought there.
    """
    assert scenario.spec.camera is not None
    query = replace(parse_query(scenario.spec.camera.query, knowledge.taxonomy), wanted=WANTED)
    view, camera, state, fixtures = picture(scenario, query, world, real, robot, knowledge, seed)
    perceived = ask(query, view, fixtures, knowledge)
    seen = {n: (t, p) for p in perceived.answers if (found := _believed(p, knowledge)) for n, t in [found]}
    believed = replace(world, things=(*fixtures, *(t for t, _ in seen.values())))
    estimates = {name: _estimate(percept) for name, (_, percept) in seen.items()}
    relations = tuple(dict.fromkeys(r for name, (_, percept) in seen.items() for r in _facts(name, percept, fixtures)))
    return Look(view, perceived, believed, relations, estimates, renamed(real, believed), camera, state)


def picture(
    scenario: Scenario, query: ObjectQuery, world: World, real: World, robot: Robot, knowledge: Knowledge, seed: int
) -> tuple[View, Camera, State | None, tuple[Thing, ...]]:
    """What the scenario's camera sees of the real world, a flange camera from where it sees the places of the query.

    Returns:
        The view, the camera, what the robot did before, and the furniture.

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
    furniture, state = replace(world, things=fixtures), None
    if camera.mount is not None:
        state = go_and_look(places_of(query, furniture, knowledge), furniture, robot, camera, knowledge, seed)
        camera = replace(camera, joints=state.belief.joints)
    return knowledge.simulator.look(real, knowledge.robots, camera, seed=seed), camera, state, fixtures


def places_of(query: ObjectQuery, furniture: World, knowledge: Knowledge) -> tuple[str, ...]:
    """The furniture that a query names, by name or class; all that something can hang from or stand in, else."""
    classes = knowledge.taxonomy
    wanted = [str(c.value) for c in query.conditions if c.key in RELATIONS]
    known = [classes.resolve(w) for w in wanted]
    named = [t.name for t in furniture.things if t.name in wanted or any(k and classes.is_a(t.type, k) for k in known)]
    return tuple(named or [t.name for t in furniture.things if t.feature("vrps:Peg") or t.feature("cram:Cavity")])


def go_and_look(
    around: tuple[str, ...], furniture: World, robot: Robot, camera: Camera, knowledge: Knowledge, seed: int
) -> State:
    """The task LookingFor, resolved in a world of which only furniture is known: the motion to where the camera sees
    some places, as program steps.

    Raises:
        NoSolution: it cannot be brought there, with the nearest miss.
    """
    from .answers import Context
    from .explain import failure_text
    from .search import Search
    from .state import State
    from .trace import Trace

    mount, trace = furniture.robots[0], Trace()
    belief = initial_belief(furniture, mount.name, robot.home, robot.gripper.opening[1])
    context = Context(robot, mount, {}, knowledge.taxonomy, seed=seed, camera=camera)
    search = Search(knowledge.registry, knowledge.tasks, knowledge.task_owners, context, trace)
    view = Location("view", "view", parameters={"around": around})
    found = next(search.solve(State((Action("0.LookingFor", "soma:LookingFor", goal=view),), belief)), None)
    if found is None:
        raise NoSolution(f"The camera cannot be brought to a view of {', '.join(around)}.\n" + failure_text(trace, []))
    return found


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


def camera_of(scenario: Scenario) -> Camera | None:
    """The scenario's camera."""
    spec = scenario.spec.camera
    if spec is None:
        return None
    return Camera(spec.at.pose(), scenario.spec.robot.name if spec.mount == "flange" else None)


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
