"""Commands that inspect: interpretations, tasks, plugins, schemas, ontologies, decisions."""

from __future__ import annotations

import argparse
from pathlib import Path

from ..base.errors import UserError
from ..base.json_text import as_json
from ..plugin.catalogue import Knowledge, examine
from .arguments import Add, plugin_choice
from .texts import interpretation_text, plugins_json, plugins_text, repairs_json, tasks_json, tasks_text, warn_of


def _interpret(arguments: argparse.Namespace) -> int:
    from ..engine.engine import Engine
    engine = Engine.with_plugins(plugin_choice(arguments))
    episode = engine.read_episode(arguments.episode)
    found = engine.interpret(episode)
    if arguments.why:
        task, _, action = arguments.why.partition("@")
        if not action.isdigit():
            raise UserError(
                f"'--why {arguments.why}' should be TASK@ACTION, e.g. Grasping@3, with an action's number from 'cramlite interpret'."
            )
        print(found.why(task, int(action)))
    elif arguments.html is not None:
        from ..report.interpretation_page import write_interpretation_page

        write_interpretation_page(arguments.html, episode, found)
        print(f"The picture of '{episode.name}' is in {arguments.html}.")
    else:
        data = found.to_json() | {"repairs": repairs_json(episode.repairs)} if arguments.json else None
        print(as_json(data) if data is not None else interpretation_text(found, episode.repairs))
    warn_of(engine.registry.faults)
    return 0


def _ontology(arguments: argparse.Namespace) -> int:
    from ..ontology.check import check_ontology, report_lines
    registry = plugin_choice(arguments).registry()
    report = check_ontology(arguments.files or Knowledge(registry).ontology_paths, arguments.against)
    print(as_json(report) if arguments.json else "\n".join(report_lines(report)))
    return 0 if report.sound else 2


def _schema(arguments: argparse.Namespace) -> int:
    from ..scenario.schema import SCHEMAS

    print(as_json(SCHEMAS[arguments.kind]()))
    return 0


def _tasks(arguments: argparse.Namespace) -> int:
    registry = plugin_choice(arguments).registry()
    tasks = Knowledge(registry).tasks.values()
    print(as_json(tasks_json(tasks)) if arguments.json else tasks_text(tasks))
    warn_of(registry.faults)
    return 0


def _plugins(arguments: argparse.Namespace) -> int:
    registry = plugin_choice(arguments).registry(strict=False)
    examine(registry)
    print(as_json(plugins_json(registry)) if arguments.json else plugins_text(registry, every=arguments.all))
    return 3 if registry.faults else 0


def _explain(arguments: argparse.Namespace) -> int:
    from ..planning.trace import read_trace
    from .trace_text import trace_text

    if arguments.failures:
        from msgspec import to_builtins

        from ..engine.recovery.time_line import read_time_line

        moments = read_time_line(arguments.directory)
        print(as_json(to_builtins(moments)) if arguments.json else "\n".join(map(str, moments)))
        return 0
    trace = read_trace(arguments.directory / "trace.json")
    entries = list(trace.about(arguments.designator)) if arguments.designator else trace.entries
    if not entries:
        names = ", ".join(dict.fromkeys(e.designator for e in trace.entries))
        raise UserError(f"Nothing in '{arguments.directory}' is called '{arguments.designator}'; there are: {names}.")
    print(as_json(entries) if arguments.json else trace_text(trace, arguments.designator))
    return 0


def add_commands(add: Add) -> None:
    """Add the commands that inspect, such as ``tasks`` and ``explain``, with their arguments, to the command line."""
    _add_interpret(add("interpret", _interpret))
    tasks = add("tasks", _tasks)
    tasks.add_argument("--json", action="store_true", help="print as JSON, with parameters")
    plugins = add("plugins", _plugins)
    plugins.add_argument("--all", action="store_true", help="the shipped ones one by one, too")
    plugins.add_argument(
        "--json", action="store_true", help="print all of them as JSON, with file, load time and faults"
    )
    _add_explain(add("explain", _explain, asks_plugins=False))
    schema = add("schema", _schema, asks_plugins=False)
    schema.add_argument("kind", choices=["scenario", "rule"], help="scenario or rule")
    _add_ontology(add("ontology", _ontology))


def _add_interpret(interpret: argparse.ArgumentParser) -> None:
    interpret.add_argument("episode", type=Path, help="an episode (NEEM): folder or file")
    interpret.add_argument(
        "--why", metavar="TASK@ACTION", help="why an action is, or is not, a task, such as Grasping@0"
    )
    interpret.add_argument(
        "--html", type=Path, metavar="FILE",
        help="write a page with a picture: states, actions, the best reading and the runner-up over time, and "
            "why that lost",
    )
    interpret.add_argument("--json", action="store_true", help="print as JSON")


def _add_explain(explain: argparse.ArgumentParser) -> None:
    explain.add_argument("directory", type=Path, metavar="RUN", help="a run directory")
    explain.add_argument(
        "designator", nargs="?", help="only designators whose name contains this, such as object_1 or grasp"
    )
    explain.add_argument(
        "--failures", action="store_true",
        help="print instead what an execution with --replan noticed and decided; RUN is its --out",
    )
    explain.add_argument("--json", action="store_true", help="print as JSON")


def _add_ontology(ontology: argparse.ArgumentParser) -> None:
    ontology.add_argument(
        "action", choices=["check"], help="check: consistency, and agreement of the fast closure with OWL-RL"
    )
    ontology.add_argument(
        "files", nargs="*", type=Path, metavar="FILES", help="ontologies; default the shipped ones and those of plugins"
    )
    ontology.add_argument(
        "--against", type=Path, action="append", metavar="PATH",
        help="originals of SOMA and DUL to compare with; may be given several times",
    )
    ontology.add_argument("--json", action="store_true", help="print the report as JSON")
