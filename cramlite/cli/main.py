"""Entry point of the command line: run a command; an error is printed as one paragraph, with an exit code."""

from __future__ import annotations

import argparse
import importlib
import sys
from collections.abc import Collection, Mapping, Sequence

from ..base.errors import DEFECTS, CramliteError, PluginError, UserError
from ..base.seeds import whole_seed
from ..version import VERSION
from .arguments import Command, Parser, add_plugin_choice, plugin_choice

COMMANDS: Mapping[str, tuple[str, str]] = {
    "resolve": ("resolve", "make a proven robot program from a scenario"),
    "import": ("import_scene", "write a scenario around an MJCF or URDF scene, and say what was understood of it"),
    "record": ("record", "let a simulated person demonstrate a scenario"),
    "goal": ("goal", "plan the tasks for a scenario's goal; write it as PDDL, check a planner's plan"),
    "interpret": ("inspect", "name the tasks that each action of a recorded episode may have been"),
    "learn": ("learn", "learn a task from demonstrations, and write it as a package"),
    "tasks": ("inspect", "list the task types"),
    "plugins": ("inspect", "list the plugins, with their faults"),
    "explain": ("inspect", "print what the search behind a run decided, and why"),
    "schema": ("inspect", "print the JSON Schema of scenario or rule files"),
    "ontology": ("inspect", "check ontologies"),
    "new": ("new", "write a package for a new plugin: complete, installable and tested"),
    "execute": ("execute", "run a program's text in a world"),
    "judge": ("judge", "run any program's text and print the findings of the validators"),
    "preflight": ("preflight", "print one page about a program before a real arm runs it; dry run at a share of its speed"),
    "controller": ("execute", "open the ports of a virtual robot controller"),
    "compare": ("compare", "compare a real arm's log with the run that was proven"),
    "check": ("check", "check a scenario, a rule file or a program without running it"),
    "experiment": ("experiment", "run an experiment and print its tables"),
    "library": ("library", "make a library of known kinds from meshes and MJCF files"),
    "perceive": ("perceive", "ask what a camera sees"),
    "calibrate": ("calibrate", "say where a camera is, from pictures of a printed board"),
    "show": ("show", "draw the world of a scenario before anything is resolved"),
    "view": ("view", "look at a run in an interactive 3D viewer"),
    "export": ("export", "write a run as a GIF, MP4, MCAP recording, CSV tables or a behaviour tree, for other software"),
    "query": ("sparql", "run SPARQL over the ontologies and episodes"),
    "doctor": ("doctor", "say what this machine has and lacks"),
    "mcp": ("serving.mcp", "answer clients of the Model Context Protocol: tools and resources for language models"),
    "serve": ("serving.serve", "answer requests of other software, in any language: JSON lines on standard input and output"),
}
"""Each command with the module of this package that declares its arguments and runs it (``add_commands``), and a clause on what the command
does.

Only the module of the command that is asked for is imported: ``cramlite --help`` loads none of them.
"""


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command.

    Returns:
        0 solved, 1 no solution, 2 the user's mistake, 3 a plugin's bug, 130 interrupted, 143 terminated.
    """
    if argv is None:
        _start_lightly()
    words = sys.argv[1:] if argv is None else argv
    arguments = parser([w for w in words[:1] if w in COMMANDS]).parse_args(words)
    try:
        _check_common_options(arguments)
        return int(arguments.run(arguments))
    except BrokenPipeError:
        return 0
    except CramliteError as error:
        return _told(error)
    except DEFECTS as error:
        if isinstance(error, OSError) and error.filename is not None:
            return _told(UserError(f"'{error.filename}' cannot be used: {error.strerror}. Give a path that can be read and written."))
        print(f"cramlite: {_bug(error)}", file=sys.stderr)
        return PluginError.exit_code
    except KeyboardInterrupt:
        print("cramlite: interrupted; what was written so far is kept.", file=sys.stderr)
        return 130


def _told(error: CramliteError) -> int:
    """Print an error for people, control characters escaped, and return the exit code."""
    said = "".join(c if c.isprintable() or c in "\n\t" else repr(c)[1:-1] for c in str(error))
    print(f"cramlite: {said}", file=sys.stderr)
    return error.exit_code


def parser(asked: Collection[str] = COMMANDS.keys()) -> argparse.ArgumentParser:
    """Return the parser of all commands.

    Args:
        asked: commands whose arguments are needed; of the others only names are known.
    """
    whole = Parser(
        prog="cramlite", description="Demonstrations become robot programs whose text was proven in simulation."
    )
    whole.add_argument("--version", action="version", version=f"cramlite {VERSION}")
    group = whole.add_subparsers(required=True, metavar="COMMAND")
    parsers = {n: group.add_parser(n, help=t, description=f"{t[0].upper()}{t[1:]}.") for n, (_, t) in COMMANDS.items()}

    def add(name: str, run: Command, *, asks_plugins: bool = True) -> argparse.ArgumentParser:
        command = parsers[name]
        if name in asked:
            command.set_defaults(run=run, asks_plugins=asks_plugins)
            add_plugin_choice(command)
            return command
        return argparse.ArgumentParser()  # declared beside the one that is asked for

    for module in dict.fromkeys(COMMANDS[name][0] for name in asked):
        importlib.import_module(f".{module}", __package__).add_commands(add)
    return whole


def _check_common_options(arguments: argparse.Namespace) -> None:
    """Check the seed and the options that choose plugins, also for commands that load no plugins."""
    whole_seed(getattr(arguments, "seed", 0))
    if not arguments.asks_plugins and (arguments.plugin or arguments.block or arguments.prefer):
        plugin_choice(arguments).registry()


def _start_lightly() -> None:
    """Set up garbage collection and pydantic's plugins for a process that runs only one command.

    Importing this module does neither.

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
    """Keep nanobind, with which OMPL's Python package is made, from reporting uncollected objects as leaks at
    the end."""
    import gc

    if "ompl" not in sys.modules:
        gc.freeze()


def _bug(error: BaseException) -> str:
    """Return the message about a defect of cramlite, with its place in the code; with CRAMLITE_DEBUG=1
    raise the error."""
    import os

    if os.environ.get("CRAMLITE_DEBUG"):
        raise error
    last = error.__traceback__
    while last is not None and last.tb_next is not None:
        last = last.tb_next
    place = f"{last.tb_frame.f_code.co_filename}:{last.tb_lineno}" if last else "?"
    said = str(error).strip().split("\n")[0]
    return f"a defect at {place}: {type(error).__name__}: {said}. Set CRAMLITE_DEBUG=1 to see the calls that led to it, and report it."


