"""Looking before planning: what is believed of a scenario's world is what its camera sees of it.

Furniture is known from the map; things that can be moved are known only as far as they are perceived.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from .belief import Estimate, Relation
from .object_query import ObjectQuery, parse_query
from .perception import Perceived, Percept, perceive
from .plugin_types import Camera
from .scenario import Scenario
from .world import Thing, World

if TYPE_CHECKING:
    from .knowledge import Knowledge
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
    """

    view: View
    perceived: Perceived
    world: World
    relations: tuple[Relation, ...]
    estimates: Mapping[str, Estimate]
    real: World


def look(scenario: Scenario, world: World, real: World, knowledge: Knowledge, seed: int) -> Look:
    """Take a picture of the real world and believe what the experts say of it.

    Args:
        world: as the scenario describes it; of this, only furniture is believed.

    Raises:
        UserError: no camera, a wrong query.
        NoPipeline: the experts cannot answer it.
    """
    camera = camera_of(scenario)
    assert camera is not None
    view = knowledge.simulator.look(real, knowledge.robots, camera, seed=seed)
    fixtures = tuple(t for t in world.things if not t.movable)
    spec = scenario.spec.camera
    query = replace(parse_query(spec.query if spec else "", knowledge.taxonomy), wanted=WANTED)
    perceived = ask(query, view, fixtures, knowledge)
    seen = {n: (t, p) for p in perceived.answers if (found := _believed(p, knowledge)) for n, t in [found]}
    believed = World((*fixtures, *(t for t, _ in seen.values())), world.robots, world.physics)
    estimates = {name: _estimate(percept) for name, (_, percept) in seen.items()}
    relations = tuple(dict.fromkeys(r for name, (_, percept) in seen.items() for r in _facts(name, percept, fixtures)))
    return Look(view, perceived, believed, relations, estimates, renamed(real, believed))


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
    """The scenario's camera: with joints to look from it is on the robot's flange."""
    spec = scenario.spec.camera
    if spec is None:
        return None
    return Camera(spec.at.pose(), scenario.spec.robot.name if spec.look else None, spec.look)


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
