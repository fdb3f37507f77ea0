"""``cramlite perceive``: answers to queries about a camera's view."""

from __future__ import annotations

import argparse
from pathlib import Path

from msgspec.structs import replace

from ..base.errors import NoSolution, UserError
from ..base.json_text import as_json
from ..base.resources import find_scenario
from ..engine.engine import Engine
from ..model.world.thing import Thing
from ..model.world.world import Camera
from ..perception.active_perception import Look, Picture, ask, pictures
from ..perception.camera_check import camera_warning
from ..perception.query import ObjectQuery, parse_query
from ..perception.result import perceived_json, perceived_text
from ..plugin.catalogue import Knowledge
from ..scenario.robots import robot_of
from ..scenario.scenario import Scenario, read_scenario
from ..scenario.worlds import build_world, real_world
from .arguments import Add, plugin_choice
from .texts import warn_of


def _perceive(arguments: argparse.Namespace) -> int:
    """Answer a query about a scenario's camera, or about a recorded view.

    Raises:
        NoSolution: nothing was found; the message has the reasons.
        NoPipeline: the experts cannot answer it.
        UserError: a query or a source that cannot be used.
    """
    source, seed = arguments.view, arguments.seed
    engine = Engine.with_plugins(plugin_choice(arguments).extended((), (), tuple(arguments.models)))
    if (scenario := _scenario_of(source)) is not None:
        engine = engine.suited(scenario)
    knowledge = engine.knowledge
    wanted = tuple(w for w in arguments.attributes.split(",") if w)
    query = replace(parse_query(arguments.query, knowledge.taxonomy, knowledge.experts), wanted=wanted)
    taken = picture_of(source, query, engine, seed)
    if arguments.fixtures is not None:
        taken = replace(taken, fixtures=fixtures_of(arguments.fixtures, knowledge, seed))
    found = ask(query, taken.view, taken.fixtures, knowledge, robot=taken.robot)
    if arguments.out is not None:
        from ..report.perception_page import write_page

        write_page(arguments.out, found, taken.view, knowledge.products)
    print(as_json(perceived_json(found)) if arguments.json else perceived_text(found))
    off = camera_warning(taken.view, taken.fixtures, knowledge, taken.robot)
    warn_of((*([off] if off else []), *engine.registry.faults))
    if not found.answers:
        raise NoSolution("Nothing was found; the reasons are above." if not arguments.json else found.remarks[0])
    return 0


def picture_of(source: str, query: ObjectQuery, engine: Engine, seed: int) -> Picture:
    """Return the picture on which a perception query is to be answered: a recorded view, or one taken in a scenario.

    Its fixtures are those of a scenario, with known poses; a recording has none.
    """
    knowledge, path = engine.knowledge, Path(source)
    scenario = _scenario_of(source)
    if scenario is None:
        view = engine.registry.first("read_view", path=path)
        if view is not None:
            return Picture(view, Camera(view.camera, intrinsics=view.intrinsics), ())
        if path.is_file():
            raise UserError(f"'{path}' is in no format that a plugin reads as a view; see 'cramlite plugins'.")
        scenario = read_scenario(find_scenario(source))
    robot = robot_of(scenario, knowledge)
    world, relations = build_world(scenario, scenario.spec.things, scenario.spec.vary, knowledge, seed)
    real = real_world(scenario, world, relations, seed)
    return next(pictures(scenario, query, Look((), world, relations, {}, real), robot, knowledge, seed))


def _scenario_of(source: str) -> Scenario | None:
    """Return the scenario of a path or name; None for a file or folder that may be a recorded view."""
    path = Path(source)
    recorded = path.exists() and path.suffix not in (".yaml", ".yml")
    return None if recorded else read_scenario(find_scenario(source))


def fixtures_of(source: str, knowledge: Knowledge, seed: int) -> tuple[Thing, ...]:
    """Return the furniture of a scenario, given the path of its file or the name of a shipped one."""
    scenario = read_scenario(find_scenario(source))
    world, _ = build_world(scenario, scenario.spec.things, scenario.spec.vary, knowledge, seed)
    return tuple(t for t in world.things if t.furniture)


def add_commands(add: Add) -> None:
    """Add the command ``perceive``, with its arguments, to the command line."""
    perceive = add("perceive", _perceive)
    perceive.add_argument("view", help="a scenario with a camera, or a recorded view that a plugin reads")
    perceive.add_argument(
        "--query", default="", help='such as "type=cram:TeaBox colour=red on=Hanger"; default everything'
    )
    perceive.add_argument(
        "--attributes", default="type,pose",
        help="values of answers beside those that decide, with commas; default type,pose",
    )
    perceive.add_argument("--fixtures", metavar="SCENARIO", help="scenario whose furniture is in a recorded view, as from a map")
    perceive.add_argument("--seed", type=int, default=0, help="seed of the scenario's world and of the camera's noise")
    perceive.add_argument(
        "--out", type=Path,
        help="folder for perception.html: image, depth, cloud, pipeline and hypotheses on one page",
    )
    perceive.add_argument(
        "--models", type=Path, action="append", default=[], metavar="LIB", help="a library of known kinds; may be repeated"
    )
    perceive.add_argument("--json", action="store_true", help="print as JSON")
