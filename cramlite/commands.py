"""What each command of the command line does with its arguments; heavy modules are imported when it runs."""

from __future__ import annotations

import argparse
import sys

from .errors import UserError
from .plugin_choice import PluginChoice


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


def _resolve(arguments: argparse.Namespace) -> int:
    from .pipeline import resolve_scenario

    return resolve_scenario(
        arguments.scenario,
        out=arguments.out,
        seed=arguments.seed,
        backend=arguments.backend,
        demonstration=arguments.demonstration,
        plugins=plugin_choice(arguments),
        report=not arguments.no_report,
        json_output=arguments.json,
    )


def _interpret(arguments: argparse.Namespace) -> int:
    from .explain import as_json, interpretation_text, repairs_json

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
    return 0


def _query(arguments: argparse.Namespace) -> int:
    from .explain import as_json
    from .query import ask, query_text, table, to_json

    engine = plugin_choice(arguments).engine()
    episodes = [engine.read_episode(path) for path in arguments.episode]
    found = ask(query_text(arguments.sparql), engine.knowledge.ontology_paths, episodes, engine.registry)
    print(as_json(to_json(found)) if arguments.json else table(found))
    return 0


def _ontology(arguments: argparse.Namespace) -> int:
    from .explain import as_json
    from .knowledge import Knowledge
    from .ontology_check import check_ontology, report_lines

    registry = plugin_choice(arguments).registry()
    report = check_ontology(arguments.files or Knowledge(registry).ontology_paths, arguments.against)
    print(as_json(report) if arguments.json else "\n".join(report_lines(report)))
    return 0 if report.sound else 2


def _record(arguments: argparse.Namespace) -> int:
    from .pipeline import record_demonstration

    return record_demonstration(
        arguments.scenario,
        seed=arguments.seed,
        out=arguments.out,
        plugins=plugin_choice(arguments),
    )


def _execute(arguments: argparse.Namespace) -> int:
    from .execution import execute_and_replan, execute_program

    if arguments.replan:
        return execute_and_replan(
            arguments.program,
            scenario=arguments.replan,
            world=arguments.world,
            seed=arguments.seed,
            rounds=arguments.rounds,
            out=arguments.out,
            episode=not arguments.no_episode,
            plugins=plugin_choice(arguments),
            json_output=arguments.json,
        )
    return execute_program(
        arguments.program,
        world=arguments.world,
        seed=arguments.seed,
        out=arguments.out,
        episode=not arguments.no_episode,
        plugins=plugin_choice(arguments),
        json_output=arguments.json,
    )


def _controller(arguments: argparse.Namespace) -> int:
    from .execution import serve_controller

    return serve_controller(
        world=arguments.world,
        host=arguments.host,
        seconds=arguments.seconds,
        idle=arguments.idle,
        seed=arguments.seed,
        plugins=plugin_choice(arguments),
    )


def _experiment(arguments: argparse.Namespace) -> int:
    from .experiment.command import experiment_command

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


def _perceive(arguments: argparse.Namespace) -> int:
    from .seeing import perceive_view

    return perceive_view(
        arguments.view,
        arguments.query,
        wants=tuple(w for w in arguments.wants.split(",") if w),
        seed=arguments.seed,
        out=arguments.out,
        plugins=plugin_choice(arguments),
        json_output=arguments.json,
    )


def _check(arguments: argparse.Namespace) -> int:
    from .checking import check_file

    return check_file(arguments.file, plugins=plugin_choice(arguments))


def _schema(arguments: argparse.Namespace) -> int:
    from .explain import as_json
    from .schema import SCHEMAS

    print(as_json(SCHEMAS[arguments.kind]()))
    return 0


def _new(arguments: argparse.Namespace) -> int:
    from .skeleton import skeleton_text, write_skeleton

    print(skeleton_text(arguments.kind, write_skeleton(arguments.kind, arguments.name, arguments.out)))
    return 0


def _serve(arguments: argparse.Namespace) -> int:
    from .service import serve

    return serve(plugin_choice(arguments).engine())


def _tasks(arguments: argparse.Namespace) -> int:
    from .explain import as_json, tasks_json, tasks_text
    from .knowledge import Knowledge

    registry = plugin_choice(arguments).registry()
    tasks = Knowledge(registry).tasks.values()
    print(as_json(tasks_json(tasks)) if arguments.json else tasks_text(tasks))
    for fault in dict.fromkeys(str(f) for f in registry.faults):
        print(f"cramlite: warning: {fault}", file=sys.stderr)
    return 0


def _plugins(arguments: argparse.Namespace) -> int:
    from .explain import as_json, plugins_json, plugins_text

    registry = plugin_choice(arguments).registry(strict=False)
    registry.examine()
    print(as_json(plugins_json(registry)) if arguments.json else plugins_text(registry, every=arguments.all))
    return 3 if registry.faults else 0


def _view(arguments: argparse.Namespace) -> int:
    from .viewing import view_run

    return view_run(
        arguments.directory,
        world=arguments.world,
        seed=arguments.seed,
        host=arguments.host,
        port=arguments.port,
        browser=not arguments.no_browser,
        seconds=arguments.seconds,
        plugins=plugin_choice(arguments),
    )


def _explain(arguments: argparse.Namespace) -> int:
    from .explain import as_json
    from .run import read_json
    from .trace import Trace
    from .trace_text import trace_text

    path = arguments.directory / "trace.json"
    data = read_json(path, "trace")
    try:
        trace = Trace.from_json(data["entries"])
    except (KeyError, TypeError) as error:
        raise UserError(
            f"'{path}' is no trace of a run; give a directory that 'cramlite resolve --out' wrote."
        ) from error
    entries = list(trace.about(arguments.designator)) if arguments.designator else trace.entries
    if not entries:
        names = ", ".join(dict.fromkeys(e.designator for e in trace.entries))
        raise UserError(f"Nothing in '{arguments.directory}' is called '{arguments.designator}'; there are: {names}.")
    print(as_json(entries) if arguments.json else trace_text(trace, arguments.designator))
    return 0


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
