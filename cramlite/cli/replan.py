"""``cramlite execute --replan``: runs a program, and goes on from where it is stopped."""

from __future__ import annotations

import argparse
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

from msgspec import to_builtins
from msgspec.structs import replace

from ..base.errors import UserError
from ..base.json_text import as_json
from ..base.resources import find_scenario
from ..base.run_directory import require_vacant
from ..engine.engine import Engine, make_engine
from ..engine.proof.intent import FILE, read_intent
from ..engine.proof.judging import Purpose, candidate_of_text
from ..engine.recovery import replanning
from ..engine.recovery.going_on import GoingOn, Stretch
from ..engine.recovery.replanning import Attempt, Round
from ..engine.recovery.time_line import Moment, events_of, time_line, write_time_line
from ..model.episode import Event
from ..model.program.program_json import read_program
from ..plugin.selection import PluginChoice
from ..report.time_line_page import TimeLinePage
from ..scenario.faults import faulty, read_fault_text
from ..scenario.scenario import Scenario, read_scenario
from ..scenario.worlds import read_world
from .arguments import plugin_choice
from .program_input import read_text
from .run_files import write_run
from .texts import rollout_json, rollout_text


def execute_and_replan(arguments: argparse.Namespace) -> int:
    """Run a program of a run directory; after each stop, observe the world, resolve the rest of the plan, and
    continue.

    In a scenario with ``poses: camera`` its camera looks where a program stops by itself, else poses are readings, and watched.

    Raises:
        NoSolution: no program came to its end; why each one ended was printed.
        UserError: a file that cannot be used.
    """
    program, rounds, seed = arguments.program, arguments.rounds, arguments.seed
    require_vacant(arguments.out, "run")
    scene, engine = _who_replans(arguments.replan, rounds, plugin_choice(arguments))
    first = _first_attempt(program, scene, engine, arguments.world, seed)
    first = replace(first, world=faulty(first.world, map(read_fault_text, arguments.fault)))
    account = _Account(engine, arguments.out, program.stem, episode=not arguments.no_episode, json_output=arguments.json)
    try:
        for one in _executed(first, scene, engine, account, seed=seed, most=rounds, verbose=arguments.verbose):
            account.add(one)
    finally:
        account.close()
    if not arguments.json:
        count = len(account.done)
        print("Came to its end " + ("at the first execution" if count == 1 else f"after {count} executions"))
    return 0


class _Account:
    """Lines, rounds and time line of an execution with replanning: printed as they come, or at its end as JSON.

    Args:
        out: folder of the rounds' files; None writes none.
        name: of the program.
        episode: whether each round gets its ``episode/``.
    """

    def __init__(self, engine: Engine, out: Path | None, name: str, *, episode: bool, json_output: bool) -> None:
        self.engine, self.out, self.name, self.episode, self.json_output = engine, out, name, episode, json_output
        self.said: list[str] = []
        self.done: list[Round] = []
        self.moments: list[Moment] = []
        self.page = TimeLinePage(engine.knowledge)

    def say(self, text: str) -> None:
        """Collect a line about the execution; print it at once, unless all is printed as JSON."""
        self.said.append(text)
        if not self.json_output:
            print(text, flush=True)

    def add(self, one: Round) -> None:
        """Print a round that has ended; write its files, and the time line so far."""
        self.done.append(one)
        if not self.json_output:
            print(rollout_text(one.rollout))
        if self.out is not None:
            number = len(self.done)
            happened = events_of(self.moments, number, one.rollout)
            _write_round(self.out / f"round_{number}", one, self.name, self.engine, episode=self.episode, events=happened)
            if self.moments:
                write_time_line(self.moments, self.out)
                self.page.write(self.moments, one.rollout, self.out)

    def close(self) -> None:
        """Print the whole execution, if it is printed as JSON."""
        if self.json_output:
            rows = [rollout_json(one.rollout) for one in self.done]
            print(as_json({"said": self.said, "executions": len(rows), "rounds": rows, "time_line": to_builtins(self.moments)}))


def _executed(
    first: Attempt, scene: Scenario, engine: Engine, account: _Account, *, seed: int, most: int, verbose: bool
) -> Iterable[Round]:
    """Return the rounds of an execution, lazily; the world is observed with a camera after each stop, or by poses that are read during each
    run."""
    if scene.spec.poses == "camera":
        return replanning.rounds(first, scene, engine, seed=seed, most=most, say=account.say, verbose=verbose)
    return _stretches(GoingOn(scene, engine, seed, account.say, verbose=verbose), first, most, account.moments)


def _stretches(going_on: GoingOn, first: Attempt, rounds: int, moments: list[Moment]) -> Iterator[Round]:
    """Yield the rounds (one run each) of an execution with replanning.

    ``moments`` holds the time line so far.
    """
    done: list[Stretch] = []
    for stretch in going_on.stretches(first, rounds):
        done.append(stretch)
        moments[:] = time_line(done)
        yield stretch.round


def _who_replans(name: str, rounds: int, plugins: PluginChoice) -> tuple[Scenario, Engine]:
    """Read a scenario by path or name; return it, and an engine with its plugins."""
    scenario = read_scenario(find_scenario(name))
    if rounds < 1:
        raise UserError(f"--rounds {rounds}: the number of programs that may run is at least 1.")
    return scenario, make_engine(scenario, plugins)


def _write_round(folder: Path, done: Round, name: str, engine: Engine, *, episode: bool, events: Sequence[Event]) -> None:
    """Write all files of a round (one run of an execution with replanning), or, if the process is killed
    meanwhile, none of them."""
    part = folder.with_name(f".{folder.name}.part")
    write_run(part, done.rollout, name, engine.knowledge, episode=episode, events=events)
    (part / f"program{done.attempt.code.suffix}").write_text(done.attempt.code.text, encoding="utf-8", newline="\n")
    part.rename(folder)


def _first_attempt(program: Path, scenario: Scenario, engine: Engine, world: str, seed: int) -> Attempt:
    """Program and plan of a run directory, in the world of its execution."""
    beside = {name: read_text(program.parent / name) for name in ("program.json", "plan.json")}
    typed = read_program(beside["program.json"]).program
    plan, code = replanning.planned(read_text(program), typed, beside["plan.json"], scenario, engine, seed)
    attempt = replanning.Attempt(plan, typed, code, read_world(world, engine.knowledge, seed))
    if not (program.parent / FILE).is_file():  # of an older version: its rest is resolved anew
        return attempt
    purpose = Purpose(read_intent(program.parent))
    candidate, _ = candidate_of_text(code.text, attempt.world, purpose, engine.knowledge)
    return replace(attempt, candidate=replace(candidate, plan=plan, proven=None))
