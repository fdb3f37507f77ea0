"""What the command line takes: every command with its arguments."""

from __future__ import annotations

import argparse
import re
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, NoReturn

from ..base.errors import UserError, did_you_mean
from ..plugin.selection import PluginChoice

Command = Callable[[argparse.Namespace], int]
Add = Callable[[str, str], argparse.ArgumentParser]
"""Adds a command: its name, and what it does in one clause."""


class Parser(argparse.ArgumentParser):
    """Names the nearest right option or command, where argparse only says that one is wrong."""

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> tuple[argparse.Namespace, list[str]]:  # type: ignore[override]
        found, left = super().parse_known_args(args, namespace)
        wrong = next((word.partition("=")[0] for word in left if word.startswith("-")), None)
        if wrong is not None:
            valid = sorted(o for o in self._option_string_actions if o.startswith("--"))
            hint = did_you_mean(wrong.strip("-"), [o.strip("-") for o in valid]).replace("mean '", "mean '--")
            self.error(f"there is no option '{wrong}'; {hint}valid are: {', '.join(valid)}")
        return found, left

    def error(self, message: str) -> NoReturn:
        wrong = re.search(r"invalid choice: '([^']*)' \(choose from (.*)\)", message)
        hint = did_you_mean(wrong[1], re.findall(r"[\w.-]+", wrong[2])).strip() if wrong else ""
        super().error(f"{message}; {hint}" if hint else message)


def parser(commands: Mapping[str, Command]) -> argparse.ArgumentParser:
    """The parser of all commands.

    Args:
        commands: what each of them runs, by name.
    """
    whole = Parser(
        prog="cramlite", description="Demonstrations become robot programs whose text was proven in simulation."
    )
    whole.add_argument("--version", action="version", version=_version())
    group = whole.add_subparsers(required=True, metavar="COMMAND")

    def add(name: str, text: str) -> argparse.ArgumentParser:
        command = group.add_parser(name, help=text, description=text[0].upper() + text[1:] + ".")
        command.set_defaults(run=commands[name])
        command.add_argument(
            "--plugin", type=Path, action="append", default=[], metavar="FILE", help="load a plugin module from a file"
        )
        command.add_argument("--block", action="append", default=[], metavar="NAME", help="do not load this plugin")
        command.add_argument("--prefer", action="append", default=[], metavar="NAME", help="ask this plugin first")
        return command

    for part in (_making, _running, _trying, _asking, _writing):
        part(add)
    return whole


def _version() -> str:
    from ..version import VERSION

    return f"cramlite {VERSION}"


def _making(add: Add) -> None:
    """From demonstrations to programs."""
    resolve = add("resolve", "make a proven robot program from a scenario")
    resolve.add_argument("scenario", help="a scenario file, or the name of a shipped one")
    resolve.add_argument("--out", type=Path, help="run directory; default runs/SCENARIO-SEED")
    resolve.add_argument("--seed", type=int, default=0, help="0 is the world as written; others vary it (default 0)")
    resolve.add_argument("--backend", help="code writer; default the robot's native language")
    resolve.add_argument("--demonstration", type=Path, help="another episode than the scenario's")
    resolve.add_argument("--no-report", action="store_true", help="do not write report.html and pictures")
    resolve.add_argument("--json", action="store_true", help="print the result as JSON")
    interpret = add("interpret", "say which tasks the actions of an episode may execute")
    interpret.add_argument("episode", type=Path, help="a NEEM: folder or file")
    interpret.add_argument("--why", metavar="TASK@ACTION", help="why an action is, or is not, a task")
    interpret.add_argument("--json", action="store_true")
    record = add("record", "let a simulated person demonstrate a scenario")
    record.add_argument("scenario")
    record.add_argument("--seed", type=int, default=0)
    record.add_argument("--out", type=Path, required=True, help="folder for the NEEM")


def _running(add: Add) -> None:
    """Programs, and files that are only checked."""
    execute = add("execute", "run a program's text in a world")
    execute.add_argument("program", type=Path, help="the text, e.g. program.script of a run directory")
    execute.add_argument("--world", required=True, help="a run directory, its world.json, or a scenario")
    execute.add_argument("--seed", type=int, default=0, help="of a scenario's world and of the sensors' noise")
    execute.add_argument(
        "--replan", metavar="SCENARIO", help="where the program stops, look again and resolve the rest of this scenario"
    )
    execute.add_argument("--rounds", type=int, default=3, help="programs that may run with --replan (default 3)")
    execute.add_argument("--out", type=Path, help="folder for the recorded run")
    execute.add_argument("--no-episode", action="store_true", help="write no episode into it")
    execute.add_argument("--json", action="store_true")
    controller = add("controller", "open the ports of a virtual robot controller")
    controller.add_argument(
        "--world",
        default="grasp_one_thing",
        help="a run directory, its world.json, or a scenario (default grasp_one_thing)",
    )
    controller.add_argument("--host", default="127.0.0.1", help="a loopback address (default 127.0.0.1)")
    controller.add_argument(
        "--seconds", type=float, default=0.0, help="close after this time; 0 (default) for no limit"
    )
    controller.add_argument("--idle", type=float, default=600.0, help="close after this time without a client")
    controller.add_argument("--seed", type=int, default=0)
    check = add("check", "check a scenario, a rule file or a program without running it")
    check.add_argument("file", help="a scenario's file or name, a rule file, or a program's text")
    schema = add("schema", "print the JSON Schema of scenario or rule files")
    schema.add_argument("kind", choices=["scenario", "rule"])


def _trying(add: Add) -> None:
    """Experiments and cameras."""
    experiment = add("experiment", "run an experiment and print its tables")
    experiment.add_argument("experiment", help="a file, its folder, or the name of a shipped one")
    experiment.add_argument("--set", default="main", metavar="NAME", help="which demonstrations (default main)")
    experiment.add_argument("--short", action="store_true", help="only the first of each object, against thresholds")
    experiment.add_argument("--without", metavar="ABLATION", help="take something away, e.g. force_control or search")
    experiment.add_argument("--workers", type=int, default=2, help="processes (default 2)")
    experiment.add_argument("--out", type=Path, help="run directory; default runs/EXPERIMENT-SET")
    experiment.add_argument("--no-pictures", action="store_true", help="draw no pictures of the outcomes")
    experiment.add_argument(
        "--keep-baseline", action="store_true", help="store these tables to compare later ones with"
    )
    experiment.add_argument("--json", action="store_true")
    perceive = add("perceive", "ask what a camera sees")
    perceive.add_argument("view", help="a scenario with a camera, or a recorded view (NPZ, ...)")
    perceive.add_argument(
        "--query", default="", help='e.g. "type=cram:TeaBox colour=red on=Hanger"; default everything'
    )
    perceive.add_argument("--wants", default="type,pose", help="values that answers have beside (default type,pose)")
    perceive.add_argument("--seed", type=int, default=0, help="of the scenario's world and of the camera's noise")
    perceive.add_argument("--out", type=Path, help="folder for perception.html")
    perceive.add_argument("--json", action="store_true")


def _asking(add: Add) -> None:
    """What there is, and why."""
    tasks = add("tasks", "list the task types")
    tasks.add_argument("--json", action="store_true")
    plugins = add("plugins", "list the plugins, with their faults")
    plugins.add_argument("--all", action="store_true", help="the shipped ones one by one, too")
    plugins.add_argument("--json", action="store_true", help="all of them, with file, load time and faults")
    view = add("view", "look at a run in an interactive 3D viewer")
    view.add_argument("directory", type=Path, metavar="RUN", help="a folder of 'resolve --out' or 'execute --out'")
    view.add_argument("--world", help="a run directory, its world.json, or a scenario, where RUN holds no world; default RUN/world.json")
    view.add_argument("--seed", type=int, default=0, help="of a scenario's world (default 0)")
    view.add_argument("--host", default="127.0.0.1", help="address to serve at (default 127.0.0.1)")
    view.add_argument("--port", type=int, default=8080, help="the first port to try (default 8080)")
    view.add_argument("--no-browser", action="store_true", help="print the address and open no browser")
    view.add_argument("--seconds", type=float, default=0.0, help="close after this time; 0 (default) for no limit")
    explain = add("explain", "print the decisions of a run")
    explain.add_argument("directory", type=Path, metavar="RUN", help="a run directory")
    explain.add_argument("designator", nargs="?", help="only this designator, e.g. object_1 or grasp")
    explain.add_argument("--json", action="store_true")
    query = add("query", "run SPARQL over the ontologies and episodes")
    query.add_argument("sparql", metavar="SPARQL", help="a query, or @FILE that holds one")
    query.add_argument(
        "--episode", type=Path, action="append", default=[], metavar="PATH", help="a NEEM to ask about as well"
    )
    query.add_argument("--json", action="store_true")
    ontology = add("ontology", "check ontologies")
    ontology.add_argument(
        "action", choices=["check"], help="consistency, and agreement of the fast closure with OWL-RL"
    )
    ontology.add_argument(
        "files", nargs="*", type=Path, metavar="FILES", help="ontologies; default the shipped ones and those of plugins"
    )
    ontology.add_argument(
        "--against", type=Path, action="append", metavar="PATH", help="originals of SOMA and DUL to compare with"
    )
    ontology.add_argument("--json", action="store_true")


def _writing(add: Add) -> None:
    """For authors of plugins, and of programs around cramlite."""
    new = add("new", "write a package for a new plugin: complete, installable and tested")
    new.add_argument("kind", choices=["backend", "expert", "predicate", "robot", "task", "validator"])
    new.add_argument("name", metavar="NAME", help="of the plugin, in small letters, e.g. wiping or no_spill")
    new.add_argument("--out", type=Path, metavar="DIR", help="the package's folder; default cramlite-NAME")
    add("serve", "answer requests of programs in other languages: JSON lines on standard input and output")


def plugin_choice(arguments: argparse.Namespace) -> PluginChoice:
    """The plugins that a command line chooses.

    Raises:
        UserError: it names a file and blocks it.
    """
    for file in arguments.plugin:
        if file.stem in arguments.block:
            raise UserError(
                f"'--plugin {file}' asks for the plugin '{file.stem}', and '--block {file.stem}' blocks it; leave one of them "
                "out. If the file is to stand for an installed plugin of that name, rename the file."
            )
    return PluginChoice(tuple(arguments.plugin), tuple(arguments.block), tuple(arguments.prefer))
