"""The command line: arguments -> engine -> explain. No logic of its own; heavy modules are imported when a command runs."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

from .errors import CramliteError, PluginError, UserError

Command = Callable[[argparse.Namespace], int]


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command.

    Returns:
        0 solved, 1 no solution, 2 the user's mistake, 3 a plugin's bug, 130 interrupted.
    """
    arguments = _parser().parse_args(argv)
    try:
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


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="cramlite", description="Demonstrations become robot programs whose text was proven in simulation."
    )
    parser.add_argument("--version", action="version", version=_version())
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    resolve = _add(commands, "resolve", _resolve, "make a proven robot program from a scenario")
    resolve.add_argument("scenario", help="a scenario file, or the name of a shipped one")
    resolve.add_argument("--out", type=Path, help="run directory; default runs/SCENARIO-SEED")
    resolve.add_argument("--seed", type=int, default=0, help="0 is the world as written; others vary it (default 0)")
    resolve.add_argument("--backend", help="code writer; default the robot's native language")
    resolve.add_argument("--demonstration", type=Path, help="another episode than the scenario's")
    resolve.add_argument("--no-report", action="store_true", help="do not write report.html and pictures")
    resolve.add_argument("--json", action="store_true", help="print the result as JSON")
    interpret = _add(commands, "interpret", _interpret, "say which tasks the actions of an episode may execute")
    interpret.add_argument("episode", type=Path, help="a NEEM: folder or file")
    interpret.add_argument("--why", metavar="TASK@ACTION", help="why an action is, or is not, a task")
    interpret.add_argument("--json", action="store_true")
    record = _add(commands, "record", _record, "let a simulated person demonstrate a scenario")
    record.add_argument("scenario")
    record.add_argument("--seed", type=int, default=0)
    record.add_argument("--out", type=Path, required=True, help="folder for the NEEM")
    execute = _add(commands, "execute", _execute, "run a program's text in a world")
    execute.add_argument("program", type=Path, help="the text, e.g. program.script of a run directory")
    execute.add_argument("--world", required=True, help="world.json of a run directory, or a scenario")
    execute.add_argument("--seed", type=int, default=0, help="of a scenario's world and of the sensors' noise")
    execute.add_argument("--out", type=Path, help="folder for the recorded run")
    execute.add_argument("--no-episode", action="store_true", help="write no episode into it")
    execute.add_argument("--json", action="store_true")
    controller = _add(commands, "controller", _controller, "open the ports of a virtual robot controller")
    controller.add_argument(
        "--world",
        default="grasp_one_thing",
        help="world.json of a run directory, or a scenario (default grasp_one_thing)",
    )
    controller.add_argument("--host", default="127.0.0.1", help="a loopback address (default 127.0.0.1)")
    controller.add_argument(
        "--seconds", type=float, default=0.0, help="close after this time; 0 (default) for no limit"
    )
    controller.add_argument("--idle", type=float, default=600.0, help="close after this time without a client")
    controller.add_argument("--seed", type=int, default=0)
    check = _add(commands, "check", _check, "check a scenario, a rule file or a program without running it")
    check.add_argument("file", help="a scenario's file or name, a rule file, or a program's text")
    schema = _add(commands, "schema", _schema, "print the JSON Schema of scenario or rule files")
    schema.add_argument("kind", choices=["scenario", "rule"])
    experiment = _add(commands, "experiment", _experiment, "run an experiment and print its tables")
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
    perceive = _add(commands, "perceive", _perceive, "ask what a camera sees")
    perceive.add_argument("view", help="a scenario with a camera, or a recorded view (NPZ, ...)")
    perceive.add_argument("--query", default="", help='e.g. "type=cram:TeaBox colour=red on=Hanger"; default everything')
    perceive.add_argument("--wants", default="type,pose", help="values that answers have beside (default type,pose)")
    perceive.add_argument("--seed", type=int, default=0, help="of the scenario's world and of the camera's noise")
    perceive.add_argument("--out", type=Path, help="folder for perception.html")
    perceive.add_argument("--json", action="store_true")
    tasks = _add(commands, "tasks", _tasks, "list the task types")
    tasks.add_argument("--json", action="store_true")
    plugins = _add(commands, "plugins", _plugins, "list the plugins, with their faults")
    plugins.add_argument("--json", action="store_true")
    explain = _add(commands, "explain", _explain, "print the decisions of a run")
    explain.add_argument("directory", type=Path, metavar="RUN", help="a run directory")
    explain.add_argument("designator", nargs="?", help="only this designator, e.g. object_1 or grasp")
    explain.add_argument("--json", action="store_true")
    query = _add(commands, "query", _query, "run SPARQL over the ontologies and episodes")
    query.add_argument("sparql", metavar="SPARQL", help="a query, or @FILE that holds one")
    query.add_argument(
        "--episode", type=Path, action="append", default=[], metavar="PATH", help="a NEEM to ask about as well"
    )
    query.add_argument("--json", action="store_true")
    ontology = _add(commands, "ontology", _ontology, "check ontologies")
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
    return parser


def _add(
    commands: argparse._SubParsersAction[argparse.ArgumentParser], name: str, run: Command, text: str
) -> argparse.ArgumentParser:
    parser = commands.add_parser(name, help=text, description=text[0].upper() + text[1:] + ".")
    parser.set_defaults(run=run)
    parser.add_argument(
        "--plugin", type=Path, action="append", default=[], metavar="FILE", help="load a plugin module from a file"
    )
    parser.add_argument("--block", action="append", default=[], metavar="NAME", help="do not load this plugin")
    return parser


def _version() -> str:
    from . import __version__

    return f"cramlite {__version__}"


def _resolve(arguments: argparse.Namespace) -> int:
    from .pipeline import resolve_scenario

    return resolve_scenario(
        arguments.scenario,
        out=arguments.out,
        seed=arguments.seed,
        backend=arguments.backend,
        demonstration=arguments.demonstration,
        plugins=arguments.plugin,
        block=arguments.block,
        report=not arguments.no_report,
        json_output=arguments.json,
    )


def _interpret(arguments: argparse.Namespace) -> int:
    from .engine import Engine
    from .explain import as_json, interpretation_text, repairs_json

    engine = Engine(files=arguments.plugin, blocked=arguments.block)
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
    from .engine import Engine
    from .explain import as_json
    from .query import ask, query_text, table, to_json

    engine = Engine(files=arguments.plugin, blocked=arguments.block)
    episodes = [engine.read_episode(path) for path in arguments.episode]
    found = ask(query_text(arguments.sparql), engine.knowledge.ontology_paths, episodes, engine.registry)
    print(as_json(to_json(found)) if arguments.json else table(found))
    return 0


def _ontology(arguments: argparse.Namespace) -> int:
    from .explain import as_json
    from .knowledge import Knowledge
    from .ontology_check import check_ontology, report_lines
    from .registry import Registry

    registry = Registry(tuple(arguments.plugin), tuple(arguments.block))
    report = check_ontology(arguments.files or Knowledge(registry).ontology_paths, arguments.against)
    print(as_json(report) if arguments.json else "\n".join(report_lines(report)))
    return 0 if report.sound else 2


def _record(arguments: argparse.Namespace) -> int:
    from .pipeline import record_demonstration

    return record_demonstration(
        arguments.scenario, seed=arguments.seed, out=arguments.out, plugins=arguments.plugin, block=arguments.block
    )


def _execute(arguments: argparse.Namespace) -> int:
    from .execution import execute_program

    return execute_program(
        arguments.program,
        world=arguments.world,
        seed=arguments.seed,
        out=arguments.out,
        episode=not arguments.no_episode,
        plugins=arguments.plugin,
        block=arguments.block,
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
        plugins=arguments.plugin,
        block=arguments.block,
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
        plugins=arguments.plugin,
        block=arguments.block,
    )


def _perceive(arguments: argparse.Namespace) -> int:
    from .seeing import perceive_view

    return perceive_view(
        arguments.view,
        arguments.query,
        wants=tuple(w for w in arguments.wants.split(",") if w),
        seed=arguments.seed,
        out=arguments.out,
        plugins=arguments.plugin,
        block=arguments.block,
        json_output=arguments.json,
    )


def _check(arguments: argparse.Namespace) -> int:
    from .checking import check_file

    return check_file(arguments.file, plugins=arguments.plugin, block=arguments.block)


def _schema(arguments: argparse.Namespace) -> int:
    from .explain import as_json
    from .schema import SCHEMAS

    print(as_json(SCHEMAS[arguments.kind]()))
    return 0


def _tasks(arguments: argparse.Namespace) -> int:
    from .explain import as_json, tasks_json, tasks_text
    from .knowledge import Knowledge
    from .registry import Registry

    registry = Registry(tuple(arguments.plugin), tuple(arguments.block))
    tasks = Knowledge(registry).tasks.values()
    print(as_json(tasks_json(tasks)) if arguments.json else tasks_text(tasks))
    for fault in dict.fromkeys(str(f) for f in registry.faults):
        print(f"cramlite: warning: {fault}", file=sys.stderr)
    return 0


def _plugins(arguments: argparse.Namespace) -> int:
    from .explain import as_json, plugins_text
    from .registry import Registry

    registry = Registry(tuple(arguments.plugin), tuple(arguments.block))
    print(as_json(registry.infos) if arguments.json else plugins_text(registry.infos))
    return 3 if registry.faults else 0


def _explain(arguments: argparse.Namespace) -> int:
    from .explain import as_json, trace_text
    from .run import read_json
    from .trace import Trace

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


if __name__ == "__main__":
    sys.exit(main())
