"""Shared parts of commands: their declaration, the plugins that they choose, and hints at misspelt options."""

from __future__ import annotations

import argparse
import math
import re
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any, NoReturn, Protocol

from ..base.errors import UserError, did_you_mean
from ..plugin.selection import PluginChoice

Command = Callable[[argparse.Namespace], int]
RENAMED = {"--wants": "--attributes"}
"""Former names of options, which are refused with a hint, and the present names."""
DEPRECATED = {"--judge": "--benchmark"}
"""Former names of options, which are still read with a warning, and the present names."""


class Add(Protocol):
    """Protocol of the function with which a module declares a command: its name, and the function that runs it."""

    def __call__(self, name: str, run: Command, *, asks_plugins: bool = True) -> argparse.ArgumentParser:
        """Declare a command and return its argument parser, to which the caller adds the command's own options.

        With ``asks_plugins`` the command loads plugins by itself.
        """
        ...


class Parser(argparse.ArgumentParser):
    """Argument parser whose errors name the nearest valid option or command, which those of argparse do not."""

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> tuple[argparse.Namespace, list[str]]:  # type: ignore[override]
        """Parse arguments, and reject unknown options with the nearest right one."""
        known = [self._new_name(word) for word in args] if args is not None else None
        found, left = super().parse_known_args(known, namespace)
        wrong = next((word.partition("=")[0] for word in left if word.startswith("-")), None)
        if wrong is not None:
            valid = sorted(o for o in self._option_string_actions if o.startswith("--"))
            if RENAMED.get(wrong) in valid:
                self.error(f"the option '{wrong}' is called '{RENAMED[wrong]}' now")
            hint = did_you_mean(wrong.strip("-"), [o.strip("-") for o in valid]).replace("mean '", "mean '--")
            self.error(f"there is no option '{wrong}'; {hint}valid are: {', '.join(valid)}")
        return found, left

    def _new_name(self, word: str) -> str:
        """Return a word of the command line; replace a deprecated option's name by its new name, with a warning."""
        old, equals, value = word.partition("=")
        new = DEPRECATED.get(old)
        if new is None or new not in self._option_string_actions:
            return word
        print(f"cramlite: warning: the option '{old}' is called '{new}' now; write that in its place", file=sys.stderr)
        return f"{new}{equals}{value}"

    def error(self, message: str) -> NoReturn:
        """Print the usage and the mistake, with the nearest right word, and exit."""
        wrong = re.search(r"invalid choice: '([^']*)' \(choose from (.*)\)", message)
        hint = did_you_mean(wrong[1], re.findall(r"[\w.-]+", wrong[2])).strip() if wrong else ""
        super().error(f"{message}; {hint}" if hint else message)


def duration(text: str) -> float:
    """Read an option that is a time [s], 0 or more.

    Raises:
        argparse.ArgumentTypeError: it is none; argparse adds the option's name.
    """
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not value >= 0.0:
        raise argparse.ArgumentTypeError(f"'{text}' is no time; write a number of seconds, 0 or more")
    return value


def add_plugin_choice(command: argparse.ArgumentParser) -> None:
    """Add the options that choose plugins, which every command has."""
    command.add_argument(
        "--plugin", type=Path, action="append", default=[], metavar="FILE", help="load a plugin module from a file"
    )
    command.add_argument("--block", action="append", default=[], metavar="NAME", help="do not load this plugin")
    command.add_argument("--prefer", action="append", default=[], metavar="NAME", help="ask this plugin first")


def add_seed(command: argparse.ArgumentParser) -> None:
    """Add the option for the seed of a command that runs a text in a world."""
    command.add_argument("--seed", type=int, default=0, help="seed of a scenario's world and of the sensors' noise; default 0")


def plugin_choice(arguments: argparse.Namespace) -> PluginChoice:
    """Return the plugins that a command line chooses.

    Raises:
        UserError: it names a file and blocks it.
    """
    for file in arguments.plugin:
        if file.stem in arguments.block:
            raise UserError(
                f"'--plugin {file}' asks for the plugin '{file.stem}', and '--block {file.stem}' blocks it; leave one of them "
                "out. If the file is to replace an installed plugin of that name, rename the file."
            )
    return PluginChoice(tuple(arguments.plugin), tuple(arguments.block), tuple(arguments.prefer))
