"""Runs that one server proved; only these can be executed through it.

What may move is kept in memory: a program that this process proved, and the setting that it proved it in. What lies in the run
directory is for readers; before anything moves it is compared with what was proven, as is the world of the scenario.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import closing
from typing import TYPE_CHECKING, Any

from msgspec import json

from ...base.errors import NoSolution, UserError
from ...base.pulse import Stop
from ...base.run_directory import RunDirectory, content_key
from ...base.seeds import derive_seed
from ...base.value import Value
from ...engine.solution import Solution
from ...planning.failure import failure_text
from ...planning.trace import Trace
from ..run_files import run_key, write_execution, write_solution, write_trace
from .client_files import ClientFiles, quoted

if TYPE_CHECKING:
    from ...engine.engine import Engine
    from ...engine.proof.executor import Executor
    from ...engine.reading import Reading
    from ...engine.recovery.time_line import Moment
    from ...engine.setting import Setting
    from ...scenario.scenario import Scenario

KEPT = 16
"""Number of proven runs whose records are kept in memory, the latest ones: each takes some megabytes."""
Say = Callable[[str], None]


class Asked(Value):
    """Request of a server's client for a proven program: the scenario, its seed, and a goal in place of its own.

    Args:
        files: that the client may name.
        scenario: name, data or text of the scenario.
        seed: of its world.
        goal: sentences that stand for what the scenario starts from; none for the scenario's own start.
    """

    files: ClientFiles
    scenario: str | Mapping[str, Any]
    seed: int
    goal: tuple[str, ...] = ()

    def read(self) -> Scenario:
        """Read the scenario again, as its file is now.

        Raises:
            UserError: it cannot be used, or the goal is none.
        """
        scenario = self.files.read(self.scenario, self.goal)
        return scenario.with_goal(self.goal) if self.goal else scenario

    def key(self, scenario: Scenario, setting: Setting, engine: Engine) -> dict[str, Any]:
        """Return the inputs that identify a run: its files, seed, plugins, goal and world."""
        said = {"goal": list(self.goal)} if self.goal else {}
        given = {} if scenario.path.is_file() else {"given": self.scenario}
        return run_key(scenario, setting, None, engine) | said | given


class ProvenRun(Value):
    """Run whose program this server process has proven.

    Args:
        directory: its files.
        asked: what was to be proven.
        key: of the run: files, seed, plugins, goal.
        written: hash of text, plan and world as they were written.
        solution: what was proven, and where.
    """

    directory: RunDirectory
    asked: Asked
    key: dict[str, Any]
    written: str
    solution: Solution
    engine: Engine

    @property
    def name(self) -> str:
        """Name of the run."""
        return self.directory.path.name


class ProvenRuns:
    """Register of the programs that this process has proven.

    Args:
        engine: for scenarios that ask for none of their own.
        files: where scenarios and runs are.
    """

    def __init__(self, engine: Engine, files: ClientFiles) -> None:
        self._engine, self._files = engine, files
        self._proven: dict[str, ProvenRun] = {}

    @property
    def names(self) -> list[str]:
        """Names of the runs whose programs this process has proven, and may therefore execute."""
        return list(self._proven)

    def prove(self, scenario: str | Mapping[str, Any], seed: int, say: Say, stop: Stop, goal: tuple[str, ...] = ()) -> ProvenRun:
        """Resolve a scenario into a run directory, with its report; nothing of it is executed.

        Args:
            scenario: its name; or the scenario itself, as data or as the text of a file.
            goal: sentences that stand for what the scenario starts from.

        Raises:
            NoSolution: every candidate was refused, or it was stopped.
            UserError: the scenario cannot be used.
        """
        asked = Asked(self._files, scenario, seed, goal)
        read = asked.read()
        engine = self._engine.suited(read)
        reading = engine.read(read)
        setting = engine.setting(reading, seed=seed)
        key = asked.key(read, setting, engine)
        directory = RunDirectory(self._files.runs / _name(read.name, seed, key), key)
        self._proven.pop(directory.path.name, None)
        solution = _first(engine, reading, setting, directory, say, stop)
        written = _write(directory, solution, engine, seed, say)
        proven = ProvenRun(directory, asked, key, written, solution, engine)
        self._proven[proven.name] = proven
        for old in list(self._proven)[:-KEPT]:
            del self._proven[old]
        return proven

    def recall(self, name: str) -> ProvenRun:
        """Return the run with a given name, whose program this server process has proven.

        Raises:
            UserError: nothing was, by this process.
        """
        if name not in self._proven:
            raise UserError(
                f"No program was proven as {quoted(name)} since this server started, so nothing moves; proven were: "
                f"{', '.join(self._proven) or 'none'}. 'resolve' proves a scenario's program and gives the name of its run; with "
                "the same seed it is the same program."
            )
        return self._proven[name]

    def execute(self, name: str, executor: Executor, say: Say) -> Solution:
        """Execute a proven program once, in the world that its scenario declares, and write the record
        into its run.

        Args:
            executor: the process that runs the text; killing it ends the execution.

        Raises:
            UserError: nothing was proven under the name; or the text, or the world, is no longer what was proven.
        """
        proven = self.recall(name)
        say("comparing text and world with what was proven")
        _require_unaltered(proven)
        say("running the program's text")
        solution = proven.engine.execute(proven.solution, executor)
        assert solution.execution is not None
        write_execution(proven.directory, solution.execution, proven.engine)
        return solution


    def go_on(self, name: str, say: Say) -> tuple[list[Moment], str]:
        """Run a proven program in its scenario's world; where it deviates from the proof, prove the rest from
        there and run that.

        Returns:
            Its time line, which is written into its run, too; and why it could not go on, "" where it came to its end.

        Raises:
            UserError: as ``execute``.
        """
        from ...engine.recovery.going_on import GoingOn
        from ...engine.recovery.time_line import gone_on, write_time_line

        proven = self.recall(name)
        say("comparing text and world with what was proven")
        _require_unaltered(proven)
        say("running the program's text")
        moments, why = gone_on(GoingOn(proven.asked.read(), proven.engine, proven.asked.seed, say), proven.solution)
        write_time_line(moments, proven.directory.path)
        return moments, why


def _name(scenario: str, seed: int, key: dict[str, Any]) -> str:
    """Name of a run: its scenario and seed, and a hash of what identifies its inputs, such as files and
    plugins."""
    return f"{scenario[:60]}-{str(seed)[:20]}-{derive_seed(0, (), json.encode(key).hex()):08x}"


def _first(engine: Engine, reading: Reading, setting: Setting, run: RunDirectory, say: Say, stop: Stop) -> Solution:
    """Resolve a client's goal, and return the first proven program; raise NoSolution if there is none.

    Every decision of the search is written into the run directory, also if nothing is proven.
    """
    trace = Trace()
    try:
        with closing(engine.resolve(reading, setting=setting, trace=trace, progress=say, stop=stop)) as found:  # type: ignore[type-var]
            solution: Solution | None = next(found, None)
    finally:
        write_trace(run, trace, engine)
    if stop():
        raise NoSolution("cancelled")
    if solution is None:
        raise NoSolution(failure_text(trace, engine.registry.faults) + f"\n  Every decision: explain(run='{run.path.name}')")
    return solution


def _write(run: RunDirectory, solution: Solution, engine: Engine, seed: int, say: Say) -> str:
    """Write the files of a run; return the hash of the files on which executing its program depends."""
    from ...report import write_report

    write_solution(run, solution, engine, seed)
    written = _hash(run, solution)
    say("writing the report")
    write_report(run, solution, engine)
    run.finish()
    return written


def _hash(run: RunDirectory, solution: Solution) -> str:
    code = solution.candidate.written
    return content_key(*(run.path / n for n in (f"program{code.suffix}", "program.json", "plan.json", "world.json")))


def _require_unaltered(proven: ProvenRun) -> None:
    """Refuse to run a program if the files of its run, or the scenario's world, have changed since the proof."""
    solution = proven.solution
    if not solution.verdict.passed:
        raise UserError(f"The program of '{proven.name}' was refused, so it is not run: {solution.verdict.reason}.")
    try:
        same = _hash(proven.directory, solution) == proven.written
    except OSError:
        same = False
    if not same:
        raise UserError(
            f"The files of '{proven.name}' differ from those of the proof: someone altered program, plan or "
            "world. Nothing was run; 'resolve' proves the scenario anew."
        )
    scenario = proven.asked.read()
    engine = proven.engine.suited(scenario)
    now = engine.setting(scenario, seed=proven.asked.seed)
    if proven.asked.key(scenario, now, engine) != proven.key or _place(now) != _place(solution.setting):
        raise UserError(
            f"The world of '{scenario.path}' is not the one that the program of '{proven.name}' was proven in: the scenario, or a file "
            "that it names, was altered since. Nothing was run; 'resolve' proves a program for the world as it is now."
        )


def _place(setting: Setting) -> bytes:
    """Encode believed world, real world, robot type and relations as bytes, so that a change of them is noticed."""
    return json.encode((setting.world, setting.real, setting.robot.type, setting.relations))
