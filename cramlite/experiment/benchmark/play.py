"""One episode: a program for its goal is searched in the benchmark's scene, and the first proven one is run there once.

Runs in a worker process. Nothing is searched, tried or reset in the benchmark's simulator.
"""

from __future__ import annotations

import os
import time
import traceback
from functools import lru_cache
from pathlib import Path

from msgspec.structs import replace

from ...base.errors import ProcessGone, UserError
from ...base.run_directory import write_whole
from ...base.value import Value
from ...engine.engine import Engine
from ...engine.setting import Setting
from ...engine.solution import Solution
from ...model.run.rollout import save_rollout
from ...model.run.verdict import ADVICE
from ...planning.diagnosis import nearest_miss
from ...planning.failure import failure_text
from ...planning.trace import Trace
from ...plugin.selection import INSTALLED, PluginChoice
from ...scenario.scenario import read_scenario
from ..page import jpeg, last_picture
from ..store import MOVED
from .going_on import Played, holds_here, play_on
from .protocol import Benchmark, connect
from .results import BENCHMARK_DIED, Attempt, EpisodeResult, plain_reason
from .spec import BenchmarkExperiment, Episode

DEFECT = "defect"
"""Class of failures that are defects of cramlite."""
BROKEN_OFF = "broken off"
SEEN, MISS = "scene.png", "miss.jpg"
"""Names of an episode's picture files: what the benchmark's camera sees if no program runs, and the collision of the nearest miss."""
PICTURE = (320, 320)
"""Width and height of the picture of how a proof ended [pixel]."""


class Trial(Value):
    """Trial of one episode in the benchmark's simulator.

    Args:
        experiment: that the episode is of.
        folder: of the episode's files.
        environment: of the benchmark; None for its usual place.
        twins: in how many a program is tried before it is played.
        attempt_refused: where no program is proven, the best one that was refused is played, too.
        pictures: keep what the benchmark's camera sees at the end.
        plugins: of the engine, beside those of the experiment.
    """

    experiment: BenchmarkExperiment
    episode: Episode
    folder: Path
    environment: Path | None = None
    twins: int = 0
    attempt_refused: bool = False
    pictures: bool = True
    plugins: PluginChoice = INSTALLED


def died(episode: Episode, budget: int, reason: str) -> EpisodeResult:
    """Return the result of an episode that was ended by a defect of cramlite."""
    return EpisodeResult(
        suite=episode.suite, task=episode.task, state=episode.state, name=episode.name, budget=budget, reason=reason, failure=DEFECT
    )


def play(trial: Trial) -> EpisodeResult:
    """Return the result of an episode: a program is searched and proven, and run once in the benchmark's simulator.

    Raises:
        UserError: it could not begin: the benchmark is not installed, refuses it, or does not answer as it must.
    """
    benchmark, episode = _benchmark(trial.experiment.beside(trial.experiment.spec.benchmark), trial.environment), trial.episode
    budget = trial.experiment.suite(episode.suite).budget
    try:
        name = benchmark.reset(episode.suite, episode.task, episode.state)
        result = EpisodeResult(suite=episode.suite, task=episode.task, state=episode.state, name=name, budget=budget)
        result = _resolved(trial, benchmark, result)
    except UserError:
        _end(benchmark)
        raise
    except Exception as error:  # a defect fails its episode, and not the run
        write_whole(trial.folder / "defect.txt", traceback.format_exc())
        return died(episode, budget, f"{type(error).__name__}: {error} (defect.txt has the traceback)")
    return replace(result, failure=_failure(result, trial.experiment))


@lru_cache(maxsize=1)
def _benchmark(file: Path, environment: Path | None) -> Benchmark:
    """Return this process's connection to the benchmark; the benchmark is started once, and again only after it stopped
    replying."""
    return connect(file, environment)


def _end(benchmark: Benchmark) -> None:
    """End a benchmark that does not reply as it must; the next episode starts another one."""
    benchmark.close()
    _benchmark.cache_clear()


def _engine(trial: Trial) -> Engine:
    own = tuple(trial.experiment.beside(name) for name in trial.experiment.spec.plugins)
    return Engine.with_plugins(replace(trial.plugins, files=(*own, *trial.plugins.files)))


def _resolved(trial: Trial, benchmark: Benchmark, result: EpisodeResult) -> EpisodeResult:
    """Search for a program that reaches the episode's goal, play it once, and return the episode's result."""
    engine, trace, clock = _engine(trial), Trace(), time.monotonic()
    try:
        path, setting = benchmark.setting(engine, trial.folder, trial.twins)
        scenario = read_scenario(path)
        result = replace(result, goal=tuple(map(str, scenario.spec.goal or ())))
        proven, refused = _search(engine, scenario, setting, trace)
    except UserError as error:
        benchmark.check()  # one that no longer answers has not shown a scene that could be refused
        seen = _kept(trial.folder / SEEN, benchmark.picture()) if trial.pictures else ""
        reason = str(error).replace(f"{trial.folder}{os.sep}", "")
        return replace(result, reason=reason, wall=time.monotonic() - clock, picture=seen)
    result = replace(result, wall=time.monotonic() - clock, seconds=_seconds(trace))
    if proven is None:
        result = replace(result, reason=failure_text(trace, engine.registry.faults))
        if trial.pictures:
            miss = _refused_state(engine, setting, trace)
            result = replace(result, picture=_kept(trial.folder / SEEN, benchmark.picture()), miss=_kept(trial.folder / MISS, miss))
        again = trial.attempt_refused and refused is not None
        return replace(result, refused=_attempt(trial, benchmark, engine, refused, "refused")) if again and refused else result
    advice = tuple(f"{f.validator}: {f.reason.removeprefix(ADVICE)}" for f in proven.verdict.advice)
    return replace(result, proven=True, advice=advice, attempt=_attempt(trial, benchmark, engine, proven, "program"))


def _seconds(trace: Trace) -> dict[str, float]:
    """Return the CPU time of the search by stage [s], and the time of planning before the first program
    was complete."""
    first = {} if trace.first_program is None else {"planning, until the first program": trace.first_program}
    return {name: seconds for name, seconds in (trace.seconds | first).items() if seconds or name != "twins"}


def _search(engine: Engine, scenario: object, setting: Setting, trace: Trace) -> tuple[Solution | None, Solution | None]:
    """Return the first proven program, and the refused program that ran with the fewest objections."""
    best: Solution | None = None
    for candidate in engine.candidates(scenario, setting=setting, trace=trace):  # type: ignore[arg-type]
        for one in candidate.attempts():
            if one.verdict.passed:
                return one, best
            ran = one.candidate.rollout is not None
            if ran and (best is None or len(one.verdict.objections) < len(best.verdict.objections)):
                best = one
    return None, best


def _attempt(trial: Trial, benchmark: Benchmark, engine: Engine, solution: Solution, name: str) -> Attempt:
    """Run a program in the benchmark's simulator; check the state at its end, and again when all things are at rest."""
    code = solution.candidate.written
    write_whole(trial.folder / f"{name}{code.suffix}", code.text)
    write_whole(trial.folder / MOVED, name)
    watched = trial.experiment.suite(trial.episode.suite).watched
    try:
        played = (
            play_on(benchmark, engine, solution, trial.folder, trial.twins) if watched
            else Played(benchmark.play(code.text, solution.setting))
        )  # fmt: skip
        rollout = replace(played.rollout, reason=played.reason or played.rollout.reason)
        save_rollout(rollout, trial.folder / f"{name}.npz")
        ended = benchmark.check()
        benchmark.rest()
        rested = benchmark.check()
    except UserError as error:
        _end(benchmark)
        return Attempt(outcome=BENCHMARK_DIED if isinstance(error, ProcessGone) else BROKEN_OFF, reason=str(error))
    ours = None if rested.success else holds_here(benchmark, engine, trial.folder / "end")
    proof = solution.candidate.rollout if trial.pictures else None
    seen, believed = benchmark.picture() if trial.pictures else b"", last_picture(proof, engine.knowledge, PICTURE) if proof else b""
    thought, times = played.thought, rollout.times
    return Attempt(
        outcome=rollout.outcome, reason=rollout.reason, first=rested.first, rest=rested.success, steps=ended.steps, ours=ours,
        picture=_kept(trial.folder / f"{name}.png", seen), believed=_kept(trial.folder / f"{name}_believed.jpg", believed),
        changed=ended.changed, avoided=rested.avoided, notices=played.notices, thought=thought,
        decisions=played.decisions, corrections=played.corrections,
        waited=round(sum(thought) / float(times[1] - times[0])) if thought and len(times) > 1 else 0,
    )  # fmt: skip


def _kept(path: Path, picture: bytes) -> str:
    """Write a picture to a file and return the file's name; "" for an empty picture."""
    if picture:
        write_whole(path, picture)
    return path.name if picture else ""


def _refused_state(engine: Engine, setting: Setting, trace: Trace) -> bytes:
    """Return a picture of the collision in the nearest miss, the refusal at which the search had come
    furthest.

    It is empty if no refusal has a collision.
    """
    missed = nearest_miss([e for e in trace.entries if e.collision is not None])
    if missed is None or missed.collision is None:
        return b""
    knowledge = engine.knowledge
    return jpeg(knowledge.simulator.collision_picture(setting.world, knowledge.robots_of(setting.world), missed.collision, PICTURE))


def _failure(result: EpisodeResult, experiment: BenchmarkExperiment) -> str:
    """Return the class of an episode's failure; "" if it succeeded.

    It follows from the reason why there was no program or why the program stopped; without one, from the benchmark's check.
    """
    attempt = result.attempt
    if result.rest():
        return ""
    if result.apart:
        return BENCHMARK_DIED
    if attempt is None:
        return experiment.failure(plain_reason(result.reason), "goal" if not result.goal else "path")
    if result.rest(unlimited=True):
        return "time"
    if attempt.reason:
        return experiment.failure(attempt.reason, "physics")
    return "goal" if attempt.ours else "physics"
