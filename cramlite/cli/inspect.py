"""Commands that show what there is: interpretations, tasks, plugins, schemas, ontologies, decisions."""

from __future__ import annotations

import argparse
import sys

from ..base.errors import UserError
from .arguments import plugin_choice


def _interpret(arguments: argparse.Namespace) -> int:
    from ..base.json_text import as_json
    from .texts import interpretation_text, repairs_json, warn_of

    engine = plugin_choice(arguments).engine()
    episode = engine.read_episode(arguments.episode)
    found = engine.interpret(episode)
    if arguments.why:
        task, _, action = arguments.why.partition("@")
        if not action.isdigit():
            raise UserError(
                f"'--why {arguments.why}' should be TASK@ACTION, e.g. Grasping@3, with an action's number from 'cramlite interpret'."
            )
        print(found.why(task, int(action)))
    else:
        repairs = episode.repairs
        data = found.to_json() | {"repairs": repairs_json(repairs)} if arguments.json else None
        print(as_json(data) if data is not None else interpretation_text(found, repairs))
    warn_of(engine.registry.faults)
    return 0


def _ontology(arguments: argparse.Namespace) -> int:
    from ..base.json_text import as_json
    from ..ontology.check import check_ontology, report_lines
    from ..plugin.catalogue import Knowledge

    registry = plugin_choice(arguments).registry()
    report = check_ontology(arguments.files or Knowledge(registry).ontology_paths, arguments.against)
    print(as_json(report) if arguments.json else "\n".join(report_lines(report)))
    return 0 if report.sound else 2


def _schema(arguments: argparse.Namespace) -> int:
    from ..base.json_text import as_json
    from ..scenario.schema import SCHEMAS

    print(as_json(SCHEMAS[arguments.kind]()))
    return 0


def _new(arguments: argparse.Namespace) -> int:
    from ..testing.skeleton import skeleton_text, write_skeleton

    print(skeleton_text(arguments.kind, write_skeleton(arguments.kind, arguments.name, arguments.out)))
    return 0


def _tasks(arguments: argparse.Namespace) -> int:
    from ..base.json_text import as_json
    from ..plugin.catalogue import Knowledge
    from .texts import tasks_json, tasks_text

    registry = plugin_choice(arguments).registry()
    tasks = Knowledge(registry).tasks.values()
    print(as_json(tasks_json(tasks)) if arguments.json else tasks_text(tasks))
    for fault in dict.fromkeys(str(f) for f in registry.faults):
        print(f"cramlite: warning: {fault}", file=sys.stderr)
    return 0


def _plugins(arguments: argparse.Namespace) -> int:
    from ..base.json_text import as_json
    from .texts import plugins_json, plugins_text

    registry = plugin_choice(arguments).registry(strict=False)
    registry.examine()
    print(as_json(plugins_json(registry)) if arguments.json else plugins_text(registry, every=arguments.all))
    return 3 if registry.faults else 0


def _explain(arguments: argparse.Namespace) -> int:
    from ..base.json_text import as_json
    from ..planning.trace import read_trace
    from .trace_text import trace_text

    trace = read_trace(arguments.directory / "trace.json")
    entries = list(trace.about(arguments.designator)) if arguments.designator else trace.entries
    if not entries:
        names = ", ".join(dict.fromkeys(e.designator for e in trace.entries))
        raise UserError(f"Nothing in '{arguments.directory}' is called '{arguments.designator}'; there are: {names}.")
    print(as_json(entries) if arguments.json else trace_text(trace, arguments.designator))
    return 0
