"""``cramlite resolve``: searches for a proven program for a scenario, and writes it into a run directory."""

from __future__ import annotations

import argparse
import json
import sys
from itertools import takewhile
from pathlib import Path
from typing import NamedTuple

from ..base.errors import NoSolution, PluginError
from ..base.json_text import as_json
from ..base.pulse import Stopped, pulse
from ..base.resources import find_scenario
from ..base.run_directory import RunDirectory
from ..engine.engine import Engine, make_engine
from ..engine.reading import Reading
from ..engine.relaxing import relaxations
from ..engine.scenario_doubts import changes_of_things, doubts, doubts_of_files
from ..engine.setting import Setting
from ..engine.solution import Solution
from ..planning.failure import brief_failure_text, failure_text
from ..planning.heartbeat import interrupted_text
from ..planning.search.budget import is_late
from ..planning.trace import Trace, read_trace
from ..scenario.scenario import Scenario
from .arguments import Add, plugin_choice
from .progress import Progress
from .run_files import failure_summary, run_key, solution_summary, write_solution, write_trace
from .say import add_say, said_in, said_of, understood_text
from .signals import Interrupted, Signals, interruptible
from .texts import counted, first_execution_failed, solution_text, warn_of


def _resolve(arguments: argparse.Namespace) -> int:
    """Resolve a scenario, execute the first proven program once where there is a real world, and write the run directory.

    Returns:
        0 when a program was proven and its first execution, if there was one, succeeded.

    Raises:
        NoSolution: every candidate was refused; the run directory holds the trace. Or the first execution failed.
        Interrupted: a signal came; the run directory holds trace and report of what was tried until then.
        PluginError: nothing was found, and a plugin broke on the way.
        UserError: the scenario cannot be used.
    """
    backend, report, json_output = arguments.backend, not arguments.no_report, arguments.json
    scenario = said_in(find_scenario(arguments.scenario), said_of(arguments))
    scenario = _started_from(scenario, arguments.demonstration, arguments.plan, arguments.reading)
    engine = make_engine(scenario, plugin_choice(arguments))
    reading = engine.read(scenario)
    with interruptible() as came:
        with pulse(came.one):  # first of all: a scenario that cannot be used claims no directory
            setting = _noted_setting(scenario, reading, engine, seed=arguments.seed, backend=backend, twins=arguments.twins)
        out = arguments.out or Path("runs") / f"{scenario.name}-{arguments.seed}"
        run = RunDirectory(out, run_key(scenario, setting, backend, engine))
        if run.complete and (not report or (run.path / "report.html").is_file()):
            return _solved_before(run, json_output=json_output)
        job = _Job(run, scenario, reading, setting, engine, _earlier_trace(run), came)
        solution = _accepted_solution(job, report=report, quiet=json_output)
        if solution is None:
            raise _no_solution(job, json_output=json_output, verbose=arguments.verbose, relax=arguments.relax)
    return _ended(job, solution, json_output=json_output)


class _Job(NamedTuple):
    """Resolution of a scenario by a command: its inputs, its run directory, and the process signals that were received."""

    run: RunDirectory
    scenario: Scenario
    reading: Reading
    setting: Setting
    engine: Engine
    trace: Trace
    came: Signals


def _accepted_solution(job: _Job, *, report: bool, quiet: bool) -> Solution | None:
    """Return the first proven program and write its files, after its execution in the real world if the
    scenario declares one.

    If nothing was proven, write the report about the search and return None.
    """
    with Progress(quiet=quiet) as say:
        solution, tried = _first_solution(job, say)
        if solution is None:
            if report:
                _report_nothing(job, tried)
            return None
        try:
            with pulse(job.came.one):
                solution = _executed(solution, job.engine, say)
                write_solution(job.run, solution, job.engine, job.setting.seed)
                _finish(job.run, solution, job.engine, say, report=report)
        except Stopped:
            raise _interrupted_behind(job, solution, report=report) from None
        return solution


def _interrupted_behind(job: _Job, solution: Solution, *, report: bool) -> Interrupted:
    """Return the error for Ctrl+C or SIGTERM after a program was proven; write the program's files, and its
    report without drawings."""
    write_solution(job.run, solution, job.engine, job.setting.seed)
    if report:
        from ..report import write_report

        write_report(job.run, solution, job.engine, drawn=False)
    left = "" if solution.setting.real is None or solution.execution else ", and was not executed"
    return Interrupted(f"A program was proven{left}; interrupted before the report was complete: {job.run.path}.", job.came.number)


def _started_from(scenario: Scenario, demonstration: Path | None, plan: Path | None, meant: str | None) -> Scenario:
    """Return the scenario with the demonstration, plan or reading from the command line instead of those
    in its file."""
    scenario = scenario.demonstrated_by(demonstration) if demonstration else scenario
    scenario = scenario.planned_by(plan) if plan else scenario
    return scenario.read_as(meant) if meant else scenario


def _ended(job: _Job, solution: Solution, *, json_output: bool) -> int:
    """Print a proven program and return exit code 0; raise NoSolution if its run in the real world failed."""
    summary = as_json(solution_summary(solution, job.run, job.engine, job.setting.seed)) if json_output else ""
    print(summary or solution_text(solution, str(job.run.path)))
    if not solution.succeeded:
        raise NoSolution(first_execution_failed(solution, job.run.path, job.scenario))
    return 0


def _solved_before(run: RunDirectory, *, json_output: bool) -> int:
    print(f"{run.path} is complete and nothing has changed since.", file=sys.stderr)
    summary = (run.path / "summary.json").read_text(encoding="utf-8")
    advised = ", with advice" if json.loads(summary).get("advice") else ""
    print(summary if json_output else f"Solved before{advised}: {run.path}")
    return 0


def _report_nothing(job: _Job, tried: Solution | None) -> None:
    """Write the report about a search that proved nothing, with the last refused program; without drawings after Ctrl+C or SIGTERM."""
    from ..report import Finished, write_page

    reading = job.reading
    found = Finished(job.engine, job.run, job.setting, job.trace, tried, reading.interpretation, reading.episode)
    write_page(found, drawn=not job.came.one())


def _changes(scenario: Scenario, setting: Setting, engine: Engine, *, json_output: bool) -> str:
    """Changes that would make a scenario solvable, as lines to be printed after the refusal."""
    found = relaxations(scenario, setting, engine, lambda _: None if json_output else print(f"tried: {_}", flush=True))
    lines = [f"\n  The scenario could be solved if you {r}." for r in found]
    none = "neither base nor things, by up to 0.64 m, nor a gripper up to twice as wide"
    return "".join(lines) or f"\n  No declared change makes it solvable: {none}."


def _no_solution(job: _Job, *, json_output: bool, verbose: bool, relax: bool) -> NoSolution | PluginError | Interrupted:
    """Return the error for a search that proved nothing; with ``json_output`` print its summary as JSON
    first."""
    run, trace, came, faults = job.run, job.trace, job.came, job.engine.registry.faults
    changes = _changes(job.scenario, job.setting, job.engine, json_output=json_output) if relax and not came.one() else ""
    if json_output:
        print(as_json(failure_summary(trace, run, job.engine, job.setting.seed)))
    if came.one():
        return Interrupted(f"What was tried until then: {run.path}. The same command goes on there.", came.number)
    if verbose:
        text = f"{failure_text(trace, faults)}\n  Every decision: cramlite explain {run.path}"
    else:
        text = brief_failure_text(trace, faults, str(run.path))
    return PluginError(text) if faults else NoSolution(text + changes)


def _first_solution(job: _Job, say: Progress) -> tuple[Solution | None, Solution | None]:
    """Return the first proven program, and the last refused program of the first candidate that had one."""
    try:
        return _search(job, say)
    finally:
        if job.came.one():
            print(f"cramlite: {interrupted_text(job.trace)}.", file=sys.stderr, flush=True)
        write_trace(job.run, job.trace, job.engine)


def _search(job: _Job, say: Progress) -> tuple[Solution | None, Solution | None]:
    run, engine, trace, came = job.run, job.engine, job.trace, job.came
    tried: Solution | None = None
    before = dict(run.spent)
    for candidate in engine.candidates(job.reading, setting=job.setting, trace=trace, progress=say, stop=came.one):
        if candidate.resume(before.get(str(candidate.number))):
            said = "refused before this run was resumed"
            trace.add(0, "sequence", str(candidate.plan), "refused", "engine", said, kind="sequence")
            continue
        for attempt in candidate.attempts():
            if attempt.verdict.passed:
                return attempt, tried
            tried = attempt if tried is None or tried.number == attempt.number else tried
        if not is_late(trace) and not came.one():  # else it was not tried out
            write_trace(run, trace, engine)
            run.refuse(candidate.number, candidate.spent)
    return None, tried


def _executed(solution: Solution, engine: Engine, say: Progress) -> Solution:
    """Return a proven program with its execution in the real world; unchanged if no real world is declared,
    or its text cannot be run here."""
    if solution.setting.real is None or solution.candidate.rollout is None:
        return solution
    say("executing it once in the real world")
    return engine.execute(solution)


def _noted_setting(scenario: Scenario, reading: Reading, engine: Engine, *, seed: int, backend: str | None, twins: int | None) -> Setting:
    """Return a scenario's setting; print notes on the scenario, and how its sentence was understood."""
    setting = engine.setting(reading, seed=seed, backend=backend, twins=twins)
    _say_notes(scenario, setting, engine)
    _say_understood(scenario, setting, engine)
    return setting


def _say_understood(scenario: Scenario, setting: Setting, engine: Engine) -> None:
    """Print how a sentence was understood, before anything is searched.

    Raises:
        NotUnderstood: it is ambiguous, false of the scene, or in words that are not known.
    """
    for line in understood_text(scenario, setting, engine.knowledge):
        print(f"cramlite: {line}", file=sys.stderr)


def _say_notes(scenario: Scenario, setting: Setting, engine: Engine) -> None:
    """Print warnings about the scenario, changes to its things, and how many stages listed under 'then' in its file
    stay unresolved.

    Doubts about files of robot and scene are only counted; 'cramlite check' prints them.
    """
    for doubt in doubts(scenario, setting, engine.knowledge):
        print(f"cramlite: doubt: {doubt}", file=sys.stderr)
    for change in changes_of_things(scenario, setting):
        print(f"{change}.", file=sys.stderr)
    if read := doubts_of_files(scenario, setting):
        where = f"'cramlite check {scenario.path}' prints the doubts, the report lists them"
        print(f"cramlite: {counted(len(read), 'doubt')} about files of robot and scene: {where}", file=sys.stderr)
    if scenario.spec.then:
        camera = scenario.spec.poses == "camera"
        who = "GoingOn(scenario, engine).execute(solution) in Python" if camera else f"'cramlite execute PROGRAM --replan {scenario.path}'"
        ends = f"the proven program does not contain {counted(len(scenario.spec.then), 'stage')} of the scenario's 'then'"
        print(f"cramlite: {ends}: {who} resolves and runs one stage after the other", file=sys.stderr)


def _finish(run: RunDirectory, solution: Solution, engine: Engine, say: Progress, *, report: bool) -> None:
    """Write the report, warn of plugins that failed without ending the command, and mark the run as complete.

    A run whose program failed in the real world is not marked, so that the next call runs it again.
    """
    if report:
        from ..report import write_report

        say("writing the report")
        write_report(run, solution, engine)
    if solution.succeeded:
        run.finish()
    warn_of(engine.registry.faults)


def _earlier_trace(run: RunDirectory) -> Trace:
    """Return that part of an interrupted run's trace that is about refused candidates, which are not tried again."""
    if not run.refused:
        return Trace()
    entries = read_trace(run.path / "trace.json").entries
    return Trace(list(takewhile(lambda e: e.candidate in run.refused, entries)))


def add_commands(add: Add) -> None:
    """Add the command ``resolve``, with its arguments, to the command line."""
    resolve = add("resolve", _resolve)
    resolve.add_argument("scenario", help="a scenario file, or the name of a shipped one")
    resolve.add_argument("--out", type=Path, help="run directory; default runs/SCENARIO-SEED")
    resolve.add_argument("--seed", type=int, default=0, help="0 (default) is the world as written; others vary it")
    resolve.add_argument("--backend", help="code writer; default the robot's native language")
    resolve.add_argument("--demonstration", type=Path, help="another episode than the scenario's")
    resolve.add_argument(
        "--twins", type=int, metavar="N",
        help="worlds drawn from the error model in which a program is tried, 0 for none; default what the "
            "scenario says, or 8",
    )
    add_say(resolve)
    resolve.add_argument("--plan", type=Path, help="a PDDL plan for the scenario's goal, see 'cramlite goal --pddl'")
    resolve.add_argument(
        "--reading", metavar="READING",
        help="reading of the demonstration: its number as 'cramlite interpret' lists them, or a task that it has; "
            "also reading: in the scenario",
    )
    resolve.add_argument("--no-report", action="store_true", help="do not write report.html and pictures")
    resolve.add_argument("--verbose", action="store_true", help="where nothing is proven, print every cause and not the first alone")
    resolve.add_argument(
        "--relax", action="store_true",
        help="also look for the smallest change that solves an unsolved scenario: base or things in steps of 20 mm, or a wider gripper",
    )
    resolve.add_argument("--json", action="store_true", help="print the result as JSON")
