"""Tasks that the simulated person shows, and what a person who watches says: for the tests and the benchmark of readings."""

from __future__ import annotations

import math
import tempfile
from pathlib import Path

import numpy as np
from msgspec.structs import replace

from cramlite import Engine, find_scenario, read_scenario
from cramlite.base.value import Value
from cramlite.engine.recording import record_episode, tasks_in_words
from cramlite.model import Floats, Thing
from cramlite.scenario.scenario import Scenario
from cramlite.scenario.thing_spec import ThingSpec
from cramlite.scenario.worlds import build_world
from cramlite_plugins.person.sight_of_person import half_extents


class Case(Value):
    """Demonstration of a task type.

    Args:
        scenario: below ``scenarios``.
        tasks: what the person is told, in words; "" for the scenario's own tasks.
        said: what the best reading is to say: tasks with what fills their roles, in order.
        also: what it may say besides, because that happened, too.
    """

    scenario: str
    tasks: str
    said: tuple[str, ...]
    also: tuple[str, ...] = ()


TAKEN = ("Grasping block", "PickingUp block floor")
JUG = ("Grasping jug", "PickingUp jug counter")
PUT = ("PuttingDown block shelf", "Releasing block shelf")
CARRIED, LEFT = "Transporting block shelf", "Retracting block hand"

CASES = {
    "Grasping": Case("tasks/grasping", "", ("Grasping block",)),
    "PickingUp": Case("tasks/picking_up", "PickingUp block floor", TAKEN),
    "Transporting": Case("tasks/transporting", "Transporting block shelf", (*TAKEN, CARRIED)),
    "PuttingDown": Case("tasks/putting_down", "", (*TAKEN, "PuttingDown block shelf"), (CARRIED,)),
    "Placing": Case("tasks/placing", "Placing block shelf", (*TAKEN, *PUT), (CARRIED, LEFT)),
    "PickAndPlace": Case("compound/pick_and_place", "", (*TAKEN, *PUT), (CARRIED, LEFT)),
    "PickAndPlace out of a drawer": Case(
        "compound/from_drawer", "",
        ("Grasping drawer", "Opening drawer", "Grasping tin", "PickingUp tin drawer", "PuttingDown tin tray", "Releasing tin tray",
         "Grasping drawer", "Closing drawer"),
        ("Transporting tin tray", "Retracting drawer hand"),
    ),
    "Releasing": Case("tasks/releasing", "", ("Grasping block", "Releasing block floor"), (LEFT,)),
    "Retracting": Case("tasks/retracting", "", ("Grasping block", "Releasing block floor", LEFT)),
    "Ungrasping": Case(
        "tasks/ungrasping", "Ungrasping block basket", (*TAKEN, "Ungrasping block basket"), ("Transporting block basket", LEFT)
    ),
    "ExtractHoleFromPeg": Case("tasks/extract_hole_from_peg", "", ("Grasping pack", "ExtractHoleFromPeg pack hook/peg")),
    "InsertHoleOntoPeg": Case(
        "tasks/insert_hole_onto_peg", "", ("Grasping pack", "PickingUp pack counter", "InsertHoleOntoPeg pack hook/peg"),
        ("Transporting pack hook",),
    ),
    "Pouring": Case("tasks/pouring", "Pouring jug bowl", (*JUG, "Pouring jug bowl"), ("Transporting jug bowl",)),
    "Shaking": Case("tasks/shaking", "", (*JUG, "Shaking jug")),
    "Pushing": Case("tasks/pushing", "", ("Pushing block",), ("Reaching block", LEFT)),
    "SlidingObject": Case("tasks/sliding_object", "", ("Grasping block", "SlidingObject block floor")),
    "SlidingGripper": Case("tasks/sliding_gripper", "", ("SlidingGripper hand plate",), ("Reaching plate",)),
    "Opening a drawer": Case("tasks/opening", "", ("Grasping drawer", "Opening drawer"), ("Retracting drawer hand",)),
    "Opening a door": Case("tasks/opening_door", "", ("Grasping door", "Opening door"), ("Retracting door hand",)),
    "Closing a drawer": Case("tasks/closing_drawer", "", ("Grasping drawer", "Closing drawer"), ("Retracting drawer hand",)),
    "Closing a door": Case("tasks/closing", "", ("Grasping door", "Closing door"), ("Retracting door hand",)),
    "Reaching": Case("tasks/reaching", "", ("Reaching block",)),
}  # fmt: skip
"""Name -> a demonstration with its expected reading, written down before the demonstration was made."""


def reading(engine: Engine, case: Case, seed: int, distractors: int = 0) -> tuple[tuple[str, ...], str]:
    """Return the best reading of a demonstration, without permitted extra tasks, and the reason if the demonstration failed.

    Args:
        distractors: further things that stand within reach of what is handled.
    """
    scenario = read_scenario(find_scenario(case.scenario))
    if distractors:
        scenario = with_distractors(engine, scenario, distractors, np.random.default_rng([seed, 5]))
    tasks = tasks_in_words(case.tasks, engine.knowledge.tasks) if case.tasks else ()
    with tempfile.TemporaryDirectory() as folder:
        recorded = record_episode(scenario, engine, seed=seed, out=Path(folder) / "shown", tasks=tasks)
        episode = engine.read_episode(Path(folder) / "shown")
    best = next(engine.interpret(episode).sequences(), None)
    said = [" ".join((m.task.split(":")[1], *m.roles.values())) for m in best.matches] if best else []
    return tuple(s for s in said if s in case.said or s not in case.also), recorded.failure


def with_distractors(engine: Engine, scenario: Scenario, count: int, rng: np.random.Generator) -> Scenario:
    """Return a scenario with cans and blocks added around the handled thing, 0.1 to 0.3 m from it, on its support."""
    spec = scenario.spec
    world, _ = build_world(scenario, spec.things, (), engine.knowledge, 0)
    tables = [t for t in world.things if t.type == "cram:Table"]
    others = [t for t in world.things if t not in tables]
    handled = next((t for t in others if t.movable or t.joint is not None), world.things[-1])
    middle, things, spots = np.array(handled.pose.position), list(spec.things), list[Floats]()
    while len(spots) < count:
        angle, off = rng.uniform(0, 2 * np.pi), rng.uniform(0.1, 0.3)
        spot = middle[:2] + off * np.array([np.cos(angle), np.sin(angle)])
        tops = [t.pose.position[2] for t in tables if _over(t, spot) < 0.0 and t.pose.position[2] <= middle[2]]
        if tops and all(_over(t, spot) > ROOM for t in others) and all(math.dist(spot, other) > 0.1 for other in spots):
            spots.append(spot)
            things.append(_other(len(spots), spot, max(tops)))
    return replace(scenario, spec=spec.model_copy(update={"things": tuple(things)}))


ROOM = 0.075
"""Least distance from a thing to the middle of a distractor [m]: half a can, and the displacement of things by seeds."""


def _over(thing: Thing, spot: Floats) -> float:
    """Return the horizontal distance of a point from a thing's outline [m], negative over the thing."""
    x, y, _ = thing.pose.inverse().apply((spot[0], spot[1], thing.pose.position[2]))
    beside = np.abs((x, y)) - half_extents(thing)[:2]
    return float(np.linalg.norm(np.maximum(beside, 0.0))) if beside.max() > 0 else float(beside.max())


def _other(number: int, spot: Floats, top: float) -> ThingSpec:
    """Return the description of a can or a block that stands at a position."""
    model, height, size = ("can", 0.115, {}) if number % 2 else ("block", 0.08, {"size": ["40 mm", "40 mm", "80 mm"]})
    at = {"position": [float(spot[0]), float(spot[1]), float(top + height / 2 + 0.001)]}
    return ThingSpec.model_validate({"name": f"other_{number}", "model": model, "at": at, "with": size})
