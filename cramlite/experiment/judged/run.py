"""Parallel run of a judged experiment: episodes spread over processes, each with a judge of its own; nothing is played twice or lost."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable, Sequence
from concurrent.futures import Future, as_completed
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path
from typing import Any

from msgspec import DecodeError, ValidationError, json

from ...base.errors import UserError
from ...base.json_text import as_json
from ...base.resources import data_folder
from ...base.run_directory import RunDirectory, content_key, write_whole
from ...base.value import Value
from ...plugin.registry import Registry
from ...plugin.selection import INSTALLED, PluginChoice
from ...version import VERSION
from ..progress import clock
from ..store import code_key, locked
from ..worker_pool import stop_workers, worker_pool
from .judge import connect
from .play import BEGUN, MOVED, Trial, died, play
from .results import EpisodeResult, plain_reason
from .spec import Episode, JudgedExperiment

RESULT = "result.json"
DEATHS = 2
"""An episode whose robot was not yet moved when workers died so often is given up, and counts as failed."""
STOPPED = "the process that played it ended after the robot had moved (killed, out of memory, or stopped by hand); it is not played again"
MOST_LOST = 3
"""Episodes that could not begin, after which the others are not tried."""


class Order(Value):
    """Order for a run.

    Args:
        episodes: that shall be there in the end.
        out: the run directory, which may hold those of other suites.
        workers: processes, each with a judge of its own.
        environment, twins, attempt_refused, pictures, plugins: as a ``Trial`` has them.
    """

    experiment: JudgedExperiment
    episodes: tuple[Episode, ...]
    out: Path
    workers: int = 2
    environment: Path | None = None
    twins: int = 0
    attempt_refused: bool = False
    pictures: bool = True
    plugins: PluginChoice = INSTALLED

    def trial(self, episode: Episode) -> Trial:
        """Return what a worker is given for an episode."""
        folder = folder_of(self.out.resolve(), episode)
        return Trial(
            self.experiment, episode, folder, self.environment, self.twins, self.attempt_refused, self.pictures, self.plugins
        )


def run_judged(order: Order, say: Callable[[str], None]) -> tuple[EpisodeResult, ...]:
    """Play the episodes of an order that have no result yet.

    Args:
        say: is told a line for each episode.

    Returns:
        All results that the directory holds, by suite, task and state, those of earlier runs among them.

    Raises:
        UserError: an episode could not begin, since the judge is not there or refuses it; a worker died; or the directory holds
            something else, is in use or damaged. What is finished is kept.
        KeyboardInterrupt: the workers were stopped; what is finished is kept.
    """
    directory = RunDirectory(order.out, run_key(order))
    lock = locked(order.out)
    try:
        _settle(order, say)
        if left := [e for e in order.episodes if not (folder_of(order.out, e) / RESULT).exists()]:
            connect(order.experiment.beside(order.experiment.spec.judge), order.environment).close()
            _play_all(order, left, say)
        directory.finish()
        return results_in(order.out, order.experiment)
    finally:
        lock.close()


def folder_of(out: Path, episode: Episode) -> Path:
    """Return the folder of an episode's files."""
    return out / "episodes" / episode.name


def results_in(out: Path, experiment: JudgedExperiment) -> tuple[EpisodeResult, ...]:
    """Read the results that a run directory holds, in the order of the experiment's suites, then by task and state.

    Raises:
        UserError: one is damaged.
    """
    order = list(experiment.spec.suites)
    found = [_read(path) for path in (out / "episodes").glob(f"*/{RESULT}")]
    return tuple(sorted(found, key=lambda r: (order.index(r.suite), r.task, r.state)))


def run_key(order: Order) -> dict[str, Any]:
    """Return what results depend on: files and code, and what is asked of each program. Episodes and workers are none of it."""
    spec, path = order.experiment.spec, order.experiment.path.resolve()
    infos = Registry(order.plugins.files, order.plugins.blocked, order.plugins.preferred).infos
    files = [path, *sorted(path.parent.glob("*.py")), *sorted(data_folder("experiments").glob("*.py"))]  # the last are shared by all
    code = [Path(__file__).resolve().parents[2], *(Path(i.file).resolve().parent for i in infos)]
    return {
        "cramlite": VERSION, "experiment": spec.experiment, "files": content_key(*files),
        "code": code_key(code), "twins": order.twins, "attempt_refused": order.attempt_refused,
    }  # fmt: skip


def _play_all(order: Order, left: Sequence[Episode], say: Callable[[str], None]) -> None:
    """Hand out the episodes until each has a result; those that kill their worker get one, too.

    Raises:
        UserError: some could not begin.
    """
    deaths, missing = Counter[Episode](), list(left)
    while missing:
        for episode in missing:  # marks of a run that was killed
            (folder_of(order.out, episode) / BEGUN).unlink(missing_ok=True)
        if lost := _round(order, missing, say):
            raise UserError(f"{len(lost)} of {len(missing)} episodes could not begin, the first one: {lost[0]} What is finished is kept in "
                            f"'{order.out}'; start the same command again for the rest.")  # fmt: skip
        _settle(order, say)
        missing = [e for e in missing if not (folder_of(order.out, e) / RESULT).exists()]
        deaths.update(e for e in missing if (folder_of(order.out, e) / BEGUN).exists())
        for episode in [e for e in missing if deaths[e] >= DEATHS]:
            missing.remove(episode)
            budget = order.experiment.suite(episode.suite).budget
            say(_keep(order, died(episode, budget, f"the process that played it died {DEATHS} times (out of memory, or killed)")))


def _settle(order: Order, say: Callable[[str], None]) -> None:
    """Give a result to the episodes whose robot was moved by a process that ended before it had one: one attempt each."""
    for mark in sorted((order.out / "episodes").glob(f"*/{MOVED}")):
        suite, task, state = mark.parent.name.rsplit("-", 2)
        if not (mark.parent / RESULT).exists():
            episode = Episode(suite, int(task), int(state))
            say(_keep(order, died(episode, order.experiment.suite(suite).budget, STOPPED)))


def _round(order: Order, left: Sequence[Episode], say: Callable[[str], None]) -> list[str]:
    """Hand out episodes, until all have ended or a worker dies; gives why some could not begin."""
    begin, lost = time.monotonic(), list[str]()
    pool = worker_pool(min(order.workers, len(left)))
    try:
        waiting = {pool.submit(play, order.trial(e)): e for e in left}
        for done, future in enumerate(as_completed(waiting), 1):
            said = _finished(order, waiting[future], future, lost)
            passed = time.monotonic() - begin
            say(f"[{done}/{len(left)}] {said}; {clock(passed)} passed, about {clock(passed / done * (len(left) - done))} left")
            if len(lost) == MOST_LOST:
                break
    except BrokenProcessPool:
        say("a worker process died; what it was at is begun anew, unless the robot had moved")
    finally:
        stop_workers(pool)
    return lost


def _finished(order: Order, episode: Episode, future: Future[EpisodeResult], lost: list[str]) -> str:
    """Keep the result of an episode, and say it in a line."""
    try:
        result = future.result()
    except UserError as error:
        lost.append(str(error))
        return f"{episode.name}: not begun: {error}"
    return _keep(order, result)


def _keep(order: Order, result: EpisodeResult) -> str:
    """Write the result of an episode, and say it in a line."""
    folder = folder_of(order.out, Episode(result.suite, result.task, result.state))
    write_whole(folder / RESULT, as_json(result))
    (folder / MOVED).unlink(missing_ok=True)
    return said(result)


def said(result: EpisodeResult) -> str:
    """Return an episode's result in a line."""
    name = f"{result.suite} {result.task} {result.state} {result.name}"
    if result.attempt is None:
        return f"{name}: no program ({result.failure}): {plain_reason(result.reason)}"
    a = result.attempt
    truth = f"first at {a.first}, {'true' if a.rest else 'not true'} at rest" if a.first is not None else "never true"
    return f"{name}: {a.outcome} after {a.steps} of {result.budget} steps, {truth}{f' ({result.failure})' if result.failure else ''}"


def _read(path: Path) -> EpisodeResult:
    try:
        return json.decode(path.read_bytes(), type=EpisodeResult)
    except (OSError, DecodeError, ValidationError) as error:
        why = str(error).splitlines()[0]
        raise UserError(f"'{path}' is damaged ({why}). Delete this one file and start again: only that episode is played anew.") from error
