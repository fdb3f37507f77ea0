"""Demonstrations of what no rule and no task knows: stirring in a bowl, wiping lines on a board, weighing, sweeping grains into a pan, and
screwing a lid by two turns (``screwing_demonstrations.py``).

Each was written before what learns it, and without it. A person picks up the tool, as the scripts of known tasks do, and goes on with a
script of this file. Worlds differ by seed: places, turns and sizes; people by pace, size of the motion, where a circle begins, which way
round, and how often. What is true is when the script began and ended, and what it was told.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
import screwing_demonstrations as screwing

from cramlite import Engine, read_scenario
from cramlite.base.value import Value
from cramlite.model import Episode, Pose, Rollout, Thing, World
from cramlite.plugin import Performance, Performer, RecordScript, Shown
from cramlite.scenario.worlds import build_world
from cramlite_plugins.person import acts

FLOOR = "  - {name: floor, model: table, at: {position: [0.2, 0, -5 mm]}, with: {size: [1.6 m, 1.6 m, 20 mm]}}\n"
COUNTER = "  - {name: counter, model: table, at: {position: [0.5, 0, 0.15]}, with: {size: [0.5 m, 0.9 m, 40 mm]}}\n"
WORLDS: Mapping[str, str] = {
    "stirring": f"""scenario: stirring
tasks:
  - {{task: Grasping, Patient: spoon}}
  - {{task: PickingUp, Locatum: spoon, Relatum: counter}}
robot: {{type: ur5e}}
things:
{FLOOR}{COUNTER}  - {{name: spoon, model: block, at: {{position: [0.45, 0.2, 0.241]}}, with: {{size: [24 mm, 24 mm, 180 mm], mass: 80 g}}}}
  - {{name: bowl, model: bowl, at: {{position: [0.47, -0.12, 0.181]}}, with: {{radius: 85 mm, height: 60 mm, mass: 600 g}}}}
vary:
  - {{thing: spoon, position: 20 mm, yaw: 15 deg}}
  - {{thing: bowl, position: 40 mm, yaw: 90 deg, with: {{radius: [80 mm, 85 mm, 95 mm]}}}}
""",
    "wiping_lines": f"""scenario: wiping_lines
tasks:
  - {{task: Grasping, Patient: sponge}}
  - {{task: PickingUp, Locatum: sponge, Relatum: counter}}
robot: {{type: ur5e}}
things:
{FLOOR}{COUNTER}  - {{name: sponge, model: block, at: {{position: [0.42, 0.27, 0.181]}}, with: {{size: [50 mm, 50 mm, 60 mm], mass: 60 g}}}}
  - {{name: board, model: table, at: {{position: [0.48, -0.05, 0.17]}}, with: {{size: [0.24 m, 0.24 m, 18 mm]}}}}
vary:
  - {{thing: sponge, position: 20 mm, yaw: 15 deg}}
  - {{thing: board, position: 40 mm, yaw: 25 deg}}
""",
    "weighing": f"""scenario: weighing
tasks:
  - {{task: Grasping, Patient: box}}
  - {{task: PickingUp, Locatum: box, Relatum: counter}}
robot: {{type: ur5e}}
things:
{FLOOR}{COUNTER}  - {{name: box, model: block, at: {{position: [0.42, 0.22, 0.201]}}, with: {{size: [50 mm, 50 mm, 100 mm], mass: 250 g}}}}
  - {{name: scale, model: table, at: {{position: [0.48, -0.1, 0.19]}}, with: {{size: [0.2 m, 0.2 m, 38 mm]}}}}
vary:
  - {{thing: box, position: 20 mm, yaw: 15 deg, with: {{mass: [150 g, 250 g, 350 g]}}}}
  - {{thing: scale, position: 40 mm, yaw: 25 deg}}
""",
    "sweeping": f"""scenario: sweeping
tasks:
  - {{task: Grasping, Patient: brush}}
  - {{task: PickingUp, Locatum: brush, Relatum: counter}}
robot: {{type: ur5e}}
things:
{FLOOR}{COUNTER}  - {{name: brush, model: block, at: {{position: [0.43, 0.29, 0.216]}}, with: {{size: [0.14, 0.024, 0.13], mass: 120 g}}}}
  - {{name: board, model: table, at: {{position: [0.48, -0.04, 0.24]}}, with: {{size: [0.22 m, 0.26 m, 18 mm], grains: 24}}}}
  - {{name: pan, model: basket, at: {{position: [0.48, -0.23, 0.151]}}, with: {{size: [0.26 m, 0.18 m, 55 mm], wall: 6 mm}}}}
vary:
  - {{thing: brush, position: 20 mm, yaw: 15 deg}}
  - {{thing: board, position: 15 mm, yaw: 8 deg, with: {{grains: [18, 21, 24]}}}}
  - {{thing: pan, position: 10 mm}}
""",
    "screwing": screwing.WORLD,
}  # fmt: skip
"""Name of a motion -> scenario in which the tool is picked up; people take no notice of the robot."""
TOLD: Mapping[str, tuple[str, ...]] = {
    "stirring": ("spoon", "bowl"), "wiping_lines": ("sponge", "board"), "weighing": ("box", "scale"), "sweeping": ("brush", "board", "pan"),
    "screwing": ("lid",),
}  # fmt: skip
"""What is moved, about what, and where to."""
MOST_STROKES = 4
"""Strokes after which a person who sweeps gives up."""
LINES = ((-0.06, -0.05), (0.06, -0.05), (0.06, 0.0), (-0.06, 0.0), (-0.06, 0.05), (0.06, 0.05))
"""Corners of the pattern on the board [m]."""


class Shown_(Value):
    """Demonstration of a motion.

    Args:
        episode: of all that the person did.
        start, end: of the motion [s].
        rollout: what the episode was detected in.
        failure: what did not come off; "" where all did.
    """

    episode: Episode
    start: float
    end: float
    rollout: Rollout
    failure: str = ""


def shown(engine: Engine, motion: str, seed: int, folder: Path, scripts: Mapping[str, Script] | None = None) -> Shown_:
    """Record a person of a seed who shows a motion.

    Args:
        folder: for the scenario.
        scripts: instead of this file's own, for those who show it wrongly.
    """
    path = folder / f"{motion}.yaml"
    path.write_text(WORLDS[motion], encoding="utf-8")
    scenario, knowledge, times = read_scenario(path), engine.knowledge, list[float]()
    world, _ = build_world(scenario, scenario.spec.things, scenario.spec.vary, knowledge, seed)
    tool, about = of(motion, world)
    script = (scripts or SCRIPTS)[motion]

    def prepare(_world: World, _fillers: object, _rng: np.random.Generator) -> Performance:
        def act(person: Performer) -> None:
            times.append(float(person.data.time))  # type: ignore[attr-defined]
            script(person, world, tool, about)
            times.append(float(person.data.time))  # type: ignore[attr-defined]

        kept = motion not in ("weighing", "screwing")
        return Performance(act, missed=lambda person: "" if person.holds(tool.name) or not kept else f"'{tool.name}' was lost")

    known = [] if tool.joint else [
        Shown(knowledge.record_scripts["soma:Grasping"], {"Patient": tool.name}),
        Shown(knowledge.record_scripts["soma:PickingUp"], {"Locatum": tool.name, "Relatum": "counter"}),
    ]
    rollout = knowledge.simulator.demonstrate(world, [*known, Shown(RecordScript(f"shown:{motion}", prepare))], seed=seed)
    episode = knowledge.episodes.detect(rollout, f"{motion}_{seed}")
    start, end = times if len(times) == 2 else (0.0, 0.0)
    return Shown_(episode, start, min(end, episode.span[1]), rollout, rollout.reason)


def of(motion: str, world: World) -> tuple[Thing, Thing]:
    """What is moved in a world, and about what; the same thing where that is all."""
    first, second = (*TOLD[motion][:2], TOLD[motion][0])[:2]
    return world.thing(first), world.thing(second)


Script = Callable[[Performer, World, Thing, Thing], None]


def stir(person: Performer, world: World, spoon: Thing, bowl: Thing, rounds: int = 0) -> None:
    """Lower the spoon's end into a bowl, lead it around in circles, three to five unless told, and take it out."""
    cavity = bowl.feature("cram:Cavity")
    assert cavity is not None
    inside, deep = cavity.size["radius"], cavity.size["height"]
    radius, way = inside * person.between(0.42, 0.5), person.rng.choice([-1.0, 1.0])
    begin, turns = person.between(0, 2 * np.pi), rounds or int(person.rng.integers(3, 6))
    low = person.between(0.010, 0.016) - deep
    angles = begin + way * np.linspace(0, 2 * np.pi * turns, 32 * turns + 1)
    circle = [(radius * np.cos(a), radius * np.sin(a), low) for a in angles]
    frame = person.pose(bowl.name) * cavity.pose
    _bring(person, spoon, frame, [(circle[0][0], circle[0][1], person.between(0.03, 0.06))], 0.25)
    _bring(person, spoon, frame, [circle[0]], 0.12)
    _follow(person, spoon, frame, circle[1:], turns * person.between(1.3, 2.0))
    _bring(person, spoon, frame, [(circle[-1][0], circle[-1][1], person.between(0.04, 0.07))], 0.15)


def wipe(person: Performer, world: World, sponge: Thing, board: Thing, deep: float = 0.002) -> None:
    """Put a sponge onto a board, lead it along the lines of a pattern, pressing lightly, and lift it."""
    frame, size = person.pose(board.name), person.between(0.95, 1.05)
    corners = [(size * x, size * y, -deep) for x, y in LINES]
    (x, y, _), up = corners[0], person.between(0.03, 0.05)
    _bring(person, sponge, frame, [(x, y, up)], 0.25)
    _bring(person, sponge, frame, [corners[0]], 0.06)
    for corner in corners[1:]:
        _bring(person, sponge, frame, [corner], person.between(0.08, 0.13))
    _bring(person, sponge, frame, [(corners[-1][0], corners[-1][1], up)], 0.15)


def weigh(person: Performer, world: World, box: Thing, scale: Thing) -> None:
    """Set a thing on a scale, let go, and wait beside it until the scale has come to rest."""
    acts.put_down(person, world, box, scale)
    acts.release(person, world, box)
    acts.withdraw(person, world)
    person.wait(person.between(2.0, 3.0))


def sweep(person: Performer, world: World, brush: Thing, board: Thing) -> None:
    """Put a brush down behind the grains and draw it over the edge under which the pan is, again until no grain is left: twice or more."""
    x, way = person.between(-0.004, 0.004), (person.between(0.100, 0.108), -person.between(0.124, 0.130))
    for k in range(MOST_STROKES):
        if k < 2 or _lying(person, board):
            _stroke(person, brush, board, x, way)


def _stroke(person: Performer, brush: Thing, board: Thing, x: float, way: tuple[float, float], low: float = -0.002) -> None:
    """Lead the brush, its broad side ahead, along a line of the board, and lift it."""
    frame, (first, last), up = person.pose(board.name), way, person.between(0.04, 0.06)
    for y, z, speed in ((first, up, 0.25), (first, low, 0.08), (last, low, person.between(0.1, 0.16)), (last, up, 0.2)):
        person.move([_turned_hand(person, brush, frame, (x, y, z))], speed)


def _lying(person: Performer, board: Thing) -> int:
    """How many grains lie on the board."""
    grains = person.compiled.things[board.name].grains  # type: ignore[attr-defined]
    return sum(float(person.data.xpos[body][2]) > board.pose.position[2] for body, _ in grains)  # type: ignore[attr-defined]


SCRIPTS: Mapping[str, Script] = {"stirring": stir, "wiping_lines": wipe, "weighing": weigh, "sweeping": sweep, "screwing": screwing.screw}


def stir_once(person: Performer, world: World, spoon: Thing, bowl: Thing) -> None:
    """Lower the spoon into a bowl, keep still, and take it out: no stirring."""
    cavity = bowl.feature("cram:Cavity")
    assert cavity is not None
    frame, low = person.pose(bowl.name) * cavity.pose, 0.012 - cavity.size["height"]
    _bring(person, spoon, frame, [(0.03, 0.0, 0.05)], 0.25)
    _bring(person, spoon, frame, [(0.03, 0.0, low)], 0.12)
    person.wait(2.0)
    _bring(person, spoon, frame, [(0.03, 0.0, 0.05)], 0.15)


def stir_beside(person: Performer, world: World, spoon: Thing, bowl: Thing) -> None:
    """Lead the spoon around in circles above the bowl: no stirring."""
    angles = np.linspace(0, 8 * np.pi, 129)
    circle = [(0.035 * np.cos(a), 0.035 * np.sin(a), 0.06) for a in angles]
    frame = person.pose(bowl.name) * bowl.feature("cram:Cavity").pose  # type: ignore[union-attr]
    _bring(person, spoon, frame, [circle[0]], 0.25)
    _follow(person, spoon, frame, circle[1:], 6.0)


def wipe_one_line(person: Performer, world: World, sponge: Thing, board: Thing) -> None:
    """Wipe the first line only."""
    frame = person.pose(board.name)
    (x, y), (there, _) = LINES[:2]
    _bring(person, sponge, frame, [(x, y, 0.04)], 0.25)
    _bring(person, sponge, frame, [(x, y, -0.002)], 0.06)
    _bring(person, sponge, frame, [(there, y, -0.002)], 0.1)
    _bring(person, sponge, frame, [(there, y, 0.04)], 0.15)


def wipe_in_the_air(person: Performer, world: World, sponge: Thing, board: Thing) -> None:
    """Follow the whole pattern without touching the board."""
    frame = person.pose(board.name)
    _bring(person, sponge, frame, [(*LINES[0], 0.05)], 0.25)
    for corner in LINES:
        _bring(person, sponge, frame, [(*corner, 0.03)], 0.1)


def weigh_in_passing(person: Performer, world: World, box: Thing, scale: Thing) -> None:
    """Set a thing on a scale and leave without waiting."""
    acts.put_down(person, world, box, scale)
    acts.release(person, world, box)
    acts.withdraw(person, world)
    person.move([Pose(tuple(np.add(person.aim.position, (-0.1, 0.1, 0.1))), person.aim.quaternion)], 0.2)


def weigh_in_the_hand(person: Performer, world: World, box: Thing, scale: Thing) -> None:
    """Press a thing onto a scale and wait, without letting go."""
    acts.put_down(person, world, box, scale)
    person.wait(3.0)


def sweep_beside(person: Performer, world: World, brush: Thing, board: Thing) -> None:
    """Sweep the grains over the other edge, where there is no pan."""
    for _ in range(3):
        _stroke(person, brush, board, 0.0, (-0.104, 0.127))


def sweep_short(person: Performer, world: World, brush: Thing, board: Thing) -> None:
    """Sweep the grains together, and leave them on the board."""
    for _ in range(3):
        _stroke(person, brush, board, 0.0, (0.104, -0.06))


def sweep_above(person: Performer, world: World, brush: Thing, board: Thing) -> None:
    """Lead the brush above the grains."""
    for _ in range(3):
        _stroke(person, brush, board, 0.0, (0.104, -0.127), low=0.025)


WRONG: Mapping[str, Mapping[str, Script]] = {
    "stirring": {"kept still": stir_once, "above the bowl": stir_beside},
    "wiping_lines": {"one line": wipe_one_line, "in the air": wipe_in_the_air},
    "weighing": {"in passing": weigh_in_passing, "in the hand": weigh_in_the_hand},
    "sweeping": {"beside the pan": sweep_beside, "short of the pan": sweep_short, "above the grains": sweep_above},
    "screwing": screwing.WRONG,
}
"""Motion -> those who do something else, by what."""


def _foot(thing: Thing) -> Pose:
    """The middle of the face that a block stands on, in its frame."""
    return Pose((0.0, 0.0, thing.features[0].pose.position[2]))


def _hand(person: Performer, tool: Thing, frame: Pose, point: tuple[float, float, float]) -> Pose:
    """Target of the hand that brings the tool's foot to a point of a frame, the tool turned as it is."""
    foot = np.array((person.pose(tool.name) * _foot(tool)).position)
    offset = np.subtract(person.tool().position, foot)
    lag = np.subtract(person.aim.position, person.tool().position)
    return Pose(tuple(np.add(frame.apply(point), offset + 0.5 * lag)), person.aim.quaternion)


def _turned_hand(person: Performer, tool: Thing, frame: Pose, point: tuple[float, float, float]) -> Pose:
    """Target of the hand that brings the tool's foot to a point of a frame, the tool turned as the frame is."""
    upright = Pose((0.0, 0.0, 0.0), frame.quaternion)
    there = Pose(tuple(np.subtract(frame.apply(point), upright.rotate(_foot(tool).position))), frame.quaternion)
    lag = np.subtract(person.aim.position, person.tool().position)
    target = there * person.pose(tool.name).inverse() * person.tool()
    return Pose(tuple(np.add(target.position, 0.5 * lag)), target.quaternion)


def _bring(person: Performer, tool: Thing, frame: Pose, points: list[tuple[float, float, float]], speed: float) -> None:
    person.move([_hand(person, tool, frame, p) for p in points], speed)


def _follow(person: Performer, tool: Thing, frame: Pose, points: list[tuple[float, float, float]], seconds: float) -> None:
    person.follow([_hand(person, tool, frame, p) for p in points], seconds)
