"""``cramlite show``: draws the world of a scenario before anything is resolved."""

from __future__ import annotations

import argparse
from pathlib import Path

from ..base.errors import UserError
from ..engine.engine import Engine
from .arguments import Add, plugin_choice

SIZE = (960, 720)
"""Width and height of the picture [pixel]."""


def _show(arguments: argparse.Namespace) -> int:
    """Draw the believed world of a scenario at its start as a PNG whose view is fitted to the movable things;
    print its path.

    Raises:
        UserError: the scenario cannot be used, the file exists, or it cannot be written.
    """
    from PIL import Image

    from ..base.resources import find_scenario
    from ..engine.start_record import start_record
    from ..scenario.scenario import read_scenario

    out = arguments.out or Path(f"{Path(arguments.scenario).stem}.png")
    if out.exists():
        raise UserError(f"'{out}' exists already and nothing was written; delete it, or choose another place with --out.")
    scenario = read_scenario(find_scenario(arguments.scenario))
    engine = Engine.with_plugins(plugin_choice(arguments)).suited(scenario)
    start, knowledge = start_record(engine.setting(scenario, seed=arguments.seed)), engine.knowledge
    movable = [t.name for t in start.world.things if t.movable]
    pixels = knowledge.simulator.picture(start, 0, knowledge.robots_of(start.world), SIZE, movable)
    try:
        Image.fromarray(pixels).save(out, "PNG")
    except OSError as error:
        raise UserError(f"'{out}' cannot be written: {error.strerror or error}; choose another place with --out.") from error
    print(out)
    return 0


def add_commands(add: Add) -> None:
    """Add the command ``show``, with its arguments, to the command line."""
    show = add("show", _show)
    show.add_argument("scenario", metavar="SCENARIO", help="a scenario file, or the name of a shipped one")
    show.add_argument("--out", type=Path, metavar="FILE", help="picture to write; default: the scenario's name and .png, here")
    show.add_argument("--seed", type=int, default=0, help="seed of the scenario's world; default 0")
