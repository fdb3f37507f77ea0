"""The command line: arguments -> engine -> explain, and what goes wrong as one paragraph and an exit code."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence

from ..base.errors import CramliteError, PluginError
from .arguments import parser, plugin_choice
from .check import _check
from .execute import _controller, _execute
from .inspect import _explain, _interpret, _new, _ontology, _plugins, _schema, _tasks
from .perceive import _perceive
from .resolve import _resolve
from .serve import _serve
from .sparql import _query
from .view import _view


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command.

    Returns:
        0 solved, 1 no solution, 2 the user's mistake, 3 a plugin's bug, 130 interrupted.
    """
    if argv is None:
        _start_lightly()
    arguments = parser(COMMANDS).parse_args(argv)
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


def _heed(arguments: argparse.Namespace) -> None:
    """Plugins that are chosen can be had, also where a command asks none; the others see for themselves."""
    asks_none = arguments.run in (COMMANDS["explain"], COMMANDS["new"], COMMANDS["schema"])
    if asks_none and (arguments.plugin or arguments.block or arguments.prefer):
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


def _record(arguments: argparse.Namespace) -> int:
    from .resolve import record_demonstration

    return record_demonstration(
        arguments.scenario,
        seed=arguments.seed,
        out=arguments.out,
        plugins=plugin_choice(arguments),
    )


def _experiment(arguments: argparse.Namespace) -> int:
    from ..experiment.command import experiment_command

    return experiment_command(
        arguments.experiment,
        set_name=arguments.set,
        short=arguments.short,
        without=arguments.without,
        workers=arguments.workers,
        out=arguments.out,
        pictures=not arguments.no_pictures,
        keep_baseline=arguments.keep_baseline,
        json_output=arguments.json,
        plugins=plugin_choice(arguments),
    )


COMMANDS = {
    "check": _check,
    "controller": _controller,
    "execute": _execute,
    "experiment": _experiment,
    "explain": _explain,
    "interpret": _interpret,
    "new": _new,
    "ontology": _ontology,
    "perceive": _perceive,
    "plugins": _plugins,
    "query": _query,
    "record": _record,
    "resolve": _resolve,
    "schema": _schema,
    "serve": _serve,
    "tasks": _tasks,
    "view": _view,
}
