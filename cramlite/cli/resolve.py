"""``cramlite resolve`` and ``cramlite record``: from a scenario to a run directory."""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable
from itertools import takewhile
from pathlib import Path
from typing import TYPE_CHECKING, Any

from msgspec import json

from ..base.errors import NoSolution, PluginError, UserError
from ..base.json_text import as_json
from ..base.resources import find_scenario
from ..base.run_directory import RunDirectory, content_key
from ..engine.engine import make_engine
from ..engine.intent import FILE as INTENT
from ..engine.intent import write_intent
from ..engine.recording import record_episode, tasks_in_words
from ..engine.scenario_doubts import doubts
from ..planning.budget import is_late
from ..planning.diagnosis import failure_text, how_it_ended, nearest_miss
from ..planning.goal_parts import goal_answers
from ..planning.heartbeat import heartbeat, interrupted_text
from ..planning.trace import Trace, read_trace
from ..plugin.selection import INSTALLED, PluginChoice
from ..scenario.scenario import read_scenario
from ..version import VERSION
from .arguments import Add, plugin_choice
from .texts import first_execution_failed, rollout_json, solution_text, warn_of

if TYPE_CHECKING:
    from rich.live import Live

    from ..engine.engine import Engine
    from ..engine.execution import Execution
    from ..engine.reading import Reading
    from ..engine.setting import Setting
    from ..engine.solution import Solution
    from ..model.twin_verdict import TwinVerdict
    from ..scenario.scenario import Scenario



def resolve_scenario(
    name: str,
    *,
    out: Path | None = None,
    seed: int = 0,
    backend: str | None = None,
    demonstration: Path | None = None,
    plan: Path | None = None,
    meant: str | None = None,
    plugins: PluginChoice = INSTALLED,
    report: bool = True,
    json_output: bool = False,
    twins: int | None = None,
) -> int:
    """Resolve a scenario, execute the first proven program once where there is a real world, and write the run directory.

    Args:
        meant: reading of the demonstration, by its number or a task; None for what the scenario says, or all.
        twins: in how many a program is tried before it counts as proven; None for what the scenario says, or 8.

    Returns:
        0 when a program was proven and its first execution, if there was one, succeeded.

    Raises:
        NoSolution: every candidate was refused; the run directory holds the trace. Or the first execution failed.
        PluginError: nothing was found, and a plugin broke on the way.
        UserError: the scenario cannot be used.
    """
    scenario = read_scenario(find_scenario(name))
    scenario = scenario.demonstrated_by(demonstration) if demonstration else scenario
    scenario = scenario.planned_by(plan) if plan else scenario
    scenario = scenario.read_as(meant) if meant else scenario
    engine = make_engine(scenario, plugins)
    reading = engine.read(scenario)
    setting = engine.setting(reading, seed=seed, backend=backend, twins=twins)  # a scenario that cannot be used claims no directory
    _say_notes(scenario, setting, engine)
    run = RunDirectory(out or Path("runs") / f"{scenario.name}-{seed}", run_key(scenario, setting, backend, engine))
    if run.complete and (not report or (run.path / "report.html").is_file()):
        return _solved_before(run, json_output=json_output)
    trace = _earlier_trace(run)
    with Progress(quiet=json_output) as say:
        solution, tried = _first_solution(run, reading, setting, engine, trace, say)
        if solution is not None:
            solution = _executed(solution, engine, say)
            write_solution(run, solution, engine, seed)
            _finish(run, solution, engine, say, report=report)
    if solution is None:
        if report:
            _report_nothing(run, reading, setting, engine, trace, tried)
        raise _no_solution(run, trace, engine, seed, json_output=json_output)
    print(as_json(_summary(solution, run, engine, seed)) if json_output else solution_text(solution, str(run.path)))
    if not solution.succeeded:
        raise NoSolution(first_execution_failed(solution, run.path, scenario))
    return 0


def _solved_before(run: RunDirectory, *, json_output: bool) -> int:
    print(f"{run.path} is complete and nothing has changed since.", file=sys.stderr)
    print((run.path / "summary.json").read_text() if json_output else f"Solved before: {run.path}")
    return 0


def _report_nothing(
    run: RunDirectory, reading: Reading, setting: Setting, engine: Engine, trace: Trace, tried: Solution | None
) -> None:
    """The page about a search that proved nothing, with the program that came nearest."""
    from ..report import Finished, write_page

    write_page(Finished(engine, run, setting, trace, tried, reading.interpretation, reading.episode))


def _no_solution(run: RunDirectory, trace: Trace, engine: Engine, seed: int, *, json_output: bool) -> NoSolution | PluginError:
    """What is raised where nothing was proven; as JSON it is printed before."""
    if json_output:
        print(as_json(_nothing(trace, run, engine, seed)))
    text = "\n".join([failure_text(trace, engine.registry.faults), *(f"  Goal: {a}" for a in goal_answers(trace))])
    text += f"\n  Every decision: cramlite explain {run.path}"
    return PluginError(text) if engine.registry.faults else NoSolution(text)


def _first_solution(
    run: RunDirectory, reading: Reading, setting: Setting, engine: Engine, trace: Trace, say: Progress
) -> tuple[Solution | None, Solution | None]:
    """The first proven program, and the last one that was refused of the first candidate that had one."""
    try:
        with heartbeat(trace, say) as heard:
            return _search(run, reading, setting, engine, trace, heard)
    except KeyboardInterrupt:
        trace.stopped()
        print(f"cramlite: {interrupted_text(trace)}.", file=sys.stderr)
        raise
    finally:
        write_trace(run, trace, engine)


def _search(
    run: RunDirectory, reading: Reading, setting: Setting, engine: Engine, trace: Trace, say: Callable[[str], None]
) -> tuple[Solution | None, Solution | None]:
    tried: Solution | None = None
    before = dict(run.spent)
    for candidate in engine.candidates(reading, setting=setting, trace=trace, progress=say):
        if candidate.resume(before.get(str(candidate.number))):
            said = "refused before this run was resumed"
            trace.add(0, "sequence", str(candidate.plan), "refused", "engine", said, kind="sequence")
            continue
        for attempt in candidate.attempts():
            if attempt.verdict.passed:
                return attempt, tried
            tried = attempt if tried is None or tried.number == attempt.number else tried
        if not is_late(trace):  # else it was not tried out
            write_trace(run, trace, engine)
            run.refuse(candidate.number, candidate.spent)
    return None, tried


def _executed(solution: Solution, engine: Engine, say: Progress) -> Solution:
    """The accepted program in the world as it really is, once; there is none where nothing but the belief is declared, and
    what cannot be run here is not executed either."""
    if solution.setting.real is None or solution.candidate.rollout is None:
        return solution
    say("executing it once in the real world")
    return engine.execute(solution)


def _say_notes(scenario: Scenario, setting: Setting, engine: Engine) -> None:
    """Doubts about the scenario, and repairs of things, once and whole, unlike progress: they change what is proven."""
    for doubt in doubts(scenario, setting, engine.knowledge):
        print(f"cramlite: doubt: {doubt}", file=sys.stderr)
    for thing in setting.world.things:
        for note in thing.notes:
            print(f"thing '{thing.name}': {note}.", file=sys.stderr)


def _finish(run: RunDirectory, solution: Solution, engine: Engine, say: Progress, *, report: bool) -> None:
    """The report, and a warning for every plugin that broke on the way without harm. A run whose program failed is not
    complete: asked for again, it is done again."""
    if report:
        from ..report import write_report

        say("writing the report")
        write_report(run, solution, engine)
    if solution.succeeded:
        run.finish()
    warn_of(engine.registry.faults)


def record_demonstration(
    name: str,
    *,
    seed: int,
    out: Path,
    tasks: str = "",
    plugins: PluginChoice = INSTALLED,
) -> int:
    """Record a demonstration of a scenario and write it as a NEEM.

    Args:
        tasks: what the person does, in words, in place of what the scenario says.

    Raises:
        UserError: nothing says what to record, or the folder is not empty.
    """
    scenario = read_scenario(find_scenario(name))
    if out.exists() and (not out.is_dir() or any(out.iterdir())):
        raise UserError(f"'{out}' exists and is not an empty folder; nothing was written. Choose another --out.")
    engine = make_engine(scenario, plugins)
    chosen = tasks_in_words(tasks, engine.knowledge.tasks) if tasks else ()
    recorded = record_episode(scenario, engine, seed=seed, out=out, tasks=chosen)
    episode = recorded.episode
    if recorded.failure:
        print(f"The demonstration did not come off: {recorded.failure}. It is kept as it is.")
    print(
        f"{out}: {len(episode.events)} events in {episode.span[1] - episode.span[0]:.1f} s; see 'cramlite interpret {out}'"
    )
    warn_of(engine.registry.faults)
    return 0


def run_key(scenario: Scenario, setting: Setting, backend: str | None, engine: Engine) -> dict[str, Any]:
    """Return what a run depends on: files, seed, doubts, code writer and plugins."""
    files = [scenario.path, *(Path(t.mesh.path) for t in setting.world.things if t.mesh)]
    if scenario.spec.demonstration and scenario.resolve_path(scenario.spec.demonstration).exists():
        files.append(scenario.resolve_path(scenario.spec.demonstration))
    if scenario.spec.plan and scenario.resolve_path(scenario.spec.plan).is_file():
        files.append(scenario.resolve_path(scenario.spec.plan))
    plugins = [f"{i.name} {i.version}" for i in engine.registry.infos]
    return {
        "cramlite": VERSION, "scenario": scenario.name, "content": content_key(*files),
        "seed": setting.seed, "blocked": sorted(engine.registry.blocked),
        "reading": scenario.spec.reading, "doubts": json.decode(json.encode(setting.doubts)), "backend": backend,
        "plugins": content_key(*engine.registry.files) if engine.registry.files else len(plugins),
    }  # fmt: skip


def _earlier_trace(run: RunDirectory) -> Trace:
    """What an interrupted run found out about the candidates that it refused; they come first and are not tried again."""
    if not run.refused:
        return Trace()
    entries = read_trace(run.path / "trace.json").entries
    return Trace(list(takewhile(lambda e: e.candidate in run.refused, entries)))


def write_trace(run: RunDirectory, trace: Trace, engine: Engine) -> None:
    """Write every decision of a search, and the plugins that broke on the way, into its run directory."""
    faults = [str(f) for f in engine.registry.faults]
    run.write("trace.json", as_json({"entries": trace.to_json(), "faults": faults}))


def write_solution(run: RunDirectory, solution: Solution, engine: Engine, seed: int) -> None:
    """Write the values of a solution's stages into a run directory, each in its file."""
    from ..model.program_json import write_program
    from ..model.rollout import save_rollout

    candidate = solution.candidate
    assert candidate.code is not None
    run.write(f"program{candidate.code.suffix}", candidate.code.text)
    run.write("program.json", write_program(candidate.program))
    run.write("world.json", json.format(json.encode(candidate.world), indent=1))
    run.write("plan.json", as_json(candidate.plan))
    run.write(INTENT, write_intent(candidate))
    run.write("verdict.json", as_json(solution.verdict))
    if candidate.rollout is not None:
        save_rollout(candidate.rollout, run.path / "rollout.npz")
    run.write("summary.json", as_json(_summary(solution, run, engine, seed)))
    if solution.interpretation is not None:
        run.write("interpretation.json", as_json(solution.interpretation.to_json()))
    if candidate.episode is not None and not (run.path / "episode").exists():
        engine.knowledge.episodes.write(candidate.episode, run.path / "episode")
    if solution.execution is not None:
        write_execution(run, solution.execution, engine)


def write_execution(run: RunDirectory, execution: Execution, engine: Engine) -> None:
    """Write an execution, with the real world that it was in, into a folder as ``cramlite execute --out`` writes one."""
    from ..model.rollout import save_rollout

    candidate, place = execution.candidate, "execution"
    assert candidate.rollout is not None and candidate.code is not None and candidate.episode is not None
    run.write(f"{place}/execution.json", as_json(rollout_json(candidate.rollout)))
    run.write(f"{place}/world.json", json.format(json.encode(candidate.rollout.world), indent=1))
    run.write(f"{place}/verdict.json", as_json(execution.verdict))
    run.write(f"{place}/program{candidate.code.suffix}", candidate.code.text)
    save_rollout(candidate.rollout, run.path / place / "rollout.npz")
    if not (run.path / place / "episode").exists():
        engine.knowledge.episodes.write(candidate.episode, run.path / place / "episode")


def _summary(solution: Solution, run: RunDirectory, engine: Engine, seed: int) -> dict[str, Any]:
    entities = {k: v for k, v in solution.candidate.bindings.items() if isinstance(v, str)}
    return {
        "solved": solution.succeeded, "proven": True, "execution": _execution(solution.execution),
        "directory": str(run.path), "seed": seed, "candidate": solution.number, "plan": str(solution.plan),
        "objects": entities, "steps": len(solution.program.steps), "findings": solution.verdict.findings,
        "left_out": solution.verdict.left_out, "twins": twins_json(solution.verdict.twins),
        "goal": goal_answers(solution.trace, solution.number),
        "reason": _reason(solution), "nearest": None, "faults": _faults(engine),
    }  # fmt: skip


def _execution(execution: Execution | None) -> dict[str, Any] | None:
    """How the first execution went; None where there is no real world, or nothing could be run."""
    if execution is None:
        return None
    verdict = execution.verdict
    return {"succeeded": verdict.passed, "reason": verdict.reason, "findings": verdict.findings}


def twins_json(found: TwinVerdict | None) -> dict[str, Any] | None:
    """Return how a program fared in twins; None where it ran in none. What was drawn for each stands in verdict.json."""
    if found is None:
        return None
    return {
        "succeeded": found.succeeded, "ran": found.ran, "of": found.doubts.runs, "interval": found.interval,
        "at_least": found.doubts.at_least, "failed": [{"twin": t.number, "reason": t.text} for t in found.failed],
    }  # fmt: skip


def _reason(solution: Solution) -> str:
    """Of the proof; of the execution where that failed."""
    failed = solution.execution is not None and not solution.succeeded
    return f"first execution: {solution.execution.verdict.reason}" if failed and solution.execution else solution.verdict.reason


def _nothing(trace: Trace, run: RunDirectory, engine: Engine, seed: int) -> dict[str, Any]:
    """The same keys where nothing was proven."""
    return {
        "solved": False, "proven": False, "execution": None,
        "directory": str(run.path), "seed": seed, "candidate": None, "plan": None,
        "objects": {}, "steps": 0, "findings": [], "left_out": [], "twins": None, "goal": goal_answers(trace),
        "reason": how_it_ended(trace.entries), "nearest": nearest_miss(trace.entries),
        "faults": _faults(engine),
    }  # fmt: skip


def _faults(engine: Engine) -> list[str]:
    return list(dict.fromkeys(map(str, engine.registry.faults)))


SHOWN = ("candidate", "refused", "twins", "writing", "executing", "searching", "planning")
"""How lines of progress begin that are written where there is no terminal to draw on."""


class Progress:
    """Progress lines on standard error, with the time since the start; on a terminal the last one stays, in its place."""

    def __init__(self, *, quiet: bool) -> None:
        self._begin, self._quiet = time.monotonic(), quiet
        self._live = _live_line() if sys.stderr.isatty() and not quiet else None

    def __call__(self, text: str) -> None:
        line = f"[{time.monotonic() - self._begin:5.1f} s] {text}"
        if self._live is not None:
            from rich.text import Text

            self._live.update(Text(line, no_wrap=True, overflow="ellipsis"), refresh=True)
        elif not self._quiet and text.startswith(SHOWN):
            print(line, file=sys.stderr, flush=True)

    def __enter__(self) -> Progress:
        return self

    def __exit__(self, *error: object) -> None:
        """Clear the last progress line of a terminal, and show its cursor again."""
        if self._live is not None:
            self._live.stop()


def _live_line() -> Live:
    """A line that is drawn when it changes, by no thread: workers may be forked meanwhile."""
    from rich.console import Console
    from rich.live import Live

    line = Live(console=Console(stderr=True), auto_refresh=False, transient=True, redirect_stdout=False, redirect_stderr=False)
    line.start()
    return line


def _resolve(arguments: argparse.Namespace) -> int:

    return resolve_scenario(
        arguments.scenario,
        out=arguments.out,
        seed=arguments.seed,
        backend=arguments.backend,
        demonstration=arguments.demonstration,
        plan=arguments.plan,
        meant=arguments.reading,
        plugins=plugin_choice(arguments),
        report=not arguments.no_report,
        json_output=arguments.json,
        twins=arguments.twins,
    )


def _record(arguments: argparse.Namespace) -> int:
    return record_demonstration(
        arguments.scenario,
        seed=arguments.seed,
        out=arguments.out,
        tasks=arguments.tasks,
        plugins=plugin_choice(arguments),
    )


def add_commands(add: Add) -> None:
    """Declare ``resolve``, ``record`` with their arguments."""
    resolve = add("resolve", _resolve)
    resolve.add_argument("scenario", help="a scenario file, or the name of a shipped one")
    resolve.add_argument("--out", type=Path, help="run directory; default runs/SCENARIO-SEED")
    resolve.add_argument("--seed", type=int, default=0, help="0 is the world as written; others vary it (default 0)")
    resolve.add_argument("--backend", help="code writer; default the robot's native language")
    resolve.add_argument("--demonstration", type=Path, help="another episode than the scenario's")
    resolve.add_argument(
        "--twins", type=int, metavar="N",
        help="worlds drawn from the error model that a program is tried in, 0 for none (default: what the scenario says, or 8)",
    )  # fmt: skip
    resolve.add_argument("--plan", type=Path, help="a PDDL plan for the scenario's goal, see 'cramlite goal --pddl'")
    resolve.add_argument(
        "--reading", metavar="READING", help="of the demonstration: its number as 'cramlite interpret' lists them, or a task that it has"
    )
    resolve.add_argument("--no-report", action="store_true", help="do not write report.html and pictures")
    resolve.add_argument("--json", action="store_true", help="print the result as JSON")
    record = add("record", _record)
    record.add_argument("scenario")
    record.add_argument("--seed", type=int, default=0)
    record.add_argument("--out", type=Path, required=True, help="folder for the NEEM")
    record.add_argument(
        "--tasks", default="", help="what the person does: 'PickingUp cup, Pouring cup bowl' (default: what the scenario says)"
    )
