"""Entry point of the command line: a command is run, and what goes wrong becomes one paragraph and an exit code."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from ..base.errors import CramliteError, PluginError
from ..version import VERSION
from . import check, execute, experiment, inspect, perceive, resolve, serve, sparql, view
from .arguments import Command, Parser, plugin_choice

MODULES = (resolve, inspect, execute, check, experiment, perceive, view, sparql, serve)
"""Each declares its commands with ``add_commands``."""


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command.

    Returns:
        0 solved, 1 no solution, 2 the user's mistake, 3 a plugin's bug, 130 interrupted.
    """
    if argv is None:
        _start_lightly()
    arguments = parser().parse_args(argv)
    try:
        _heed(arguments)
        return int(arguments.run(arguments))
    except BrokenPipeError:
        return 0
    except CramliteError as error:
        print(f"cramlite: {error}", file=sys.stderr)
        return error.exit_code
    except Exception as error:
        print(f"cramlite: {_bug(error)}", file=sys.stderr)
        return PluginError.exit_code
    except KeyboardInterrupt:
        print("cramlite: interrupted; what was written so far is kept.", file=sys.stderr)
        return 130


def parser() -> argparse.ArgumentParser:
    """Return the parser of all commands."""
    whole = Parser(
        prog="cramlite", description="Demonstrations become robot programs whose text was proven in simulation."
    )
    whole.add_argument("--version", action="version", version=f"cramlite {VERSION}")
    group = whole.add_subparsers(required=True, metavar="COMMAND")

    def add(name: str, text: str, run: Command, *, asks_plugins: bool = True) -> argparse.ArgumentParser:
        command = group.add_parser(name, help=text, description=text[0].upper() + text[1:] + ".")
        command.set_defaults(run=run, asks_plugins=asks_plugins)
        command.add_argument(
            "--plugin", type=Path, action="append", default=[], metavar="FILE", help="load a plugin module from a file"
        )
        command.add_argument("--block", action="append", default=[], metavar="NAME", help="do not load this plugin")
        command.add_argument("--prefer", action="append", default=[], metavar="NAME", help="ask this plugin first")
        return command

    for module in MODULES:
        module.add_commands(add)
    return whole


def _heed(arguments: argparse.Namespace) -> None:
    """Plugins that are chosen can be had, also where a command asks none; the others see for themselves."""
    if not arguments.asks_plugins and (arguments.plugin or arguments.block or arguments.prefer):
        plugin_choice(arguments).registry()


def _start_lightly() -> None:
    """Settings of a process that is ours alone, so nothing of this is done on import.

    Most objects stay, modules first of all: of the CPU time of ``cramlite check`` looking for cycles took 8 % (after every
    700 new objects), and 15 % once more at the end, for nothing; the thresholds are mypy's. For plugins of its own
    pydantic reads the metadata of every installed package, 13 % with 130 of them.
    """
    import atexit
    import gc
    import os

    gc.set_threshold(200_000, 30, 30)
    atexit.register(_leave)
    os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")


def _leave() -> None:
    """Nanobind calls what was not collected a leak, on standard error; of the packages here OMPL's is made with it."""
    import gc

    if "ompl" not in sys.modules:
        gc.freeze()


def _bug(error: Exception) -> str:
    """A defect that nobody foresaw, with its place; CRAMLITE_DEBUG=1 shows everything."""
    import os

    if os.environ.get("CRAMLITE_DEBUG"):
        raise error
    last = error.__traceback__
    while last is not None and last.tb_next is not None:
        last = last.tb_next
    place = f"{last.tb_frame.f_code.co_filename}:{last.tb_lineno}" if last else "?"
    said = str(error).strip().split("\n")[0]
    return f"a defect at {place}: {type(error).__name__}: {said}. Set CRAMLITE_DEBUG=1 to see the calls that led to it, and report it."


