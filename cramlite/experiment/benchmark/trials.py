"""Episodes of a benchmark as trials of an experiment's run."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from ...base.resources import data_folder
from ...base.value import Value
from ...model.twins.proof_doubts import ProofDoubts
from ...plugin.registry import Registry
from ...plugin.selection import INSTALLED, PluginChoice
from ..figure import Published
from ..order import Report
from ..store import Store, run_key
from .outcomes import in_a_line, outcomes_page
from .play import Trial, died, play
from .protocol import connect
from .report import markdown, numbers
from .results import EpisodeResult
from .spec import BenchmarkExperiment, Episode
from .tables import tables


class Episodes(Value):
    """Episodes of a benchmark that an experiment is to play; each episode is one trial.

    Args:
        episodes: none for the tables of what the run directory holds.
        environment, twins, attempt_refused, pictures, plugins: as a ``Trial`` has them.
        fail: whether episodes that are not true at rest within their budget are a failure of the run.
    """

    experiment: BenchmarkExperiment
    episodes: tuple[Episode, ...]
    environment: Path | None = None
    twins: int = 0
    attempt_refused: bool = False
    pictures: bool = True
    plugins: PluginChoice = INSTALLED
    fail: bool = False

    folder = "episodes"
    result = EpisodeResult

    def __post_init__(self) -> None:
        ProofDoubts(self.twins)  # what is wrong with it is said before any work

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the episodes, in the order in which they are run."""
        return tuple(e.name for e in self.episodes)

    def key(self) -> dict[str, Any]:
        """Return the key that identifies the results: hashes of files and code, and the options that change results.

        These are the number of twins, and whether refused programs are run, too.

        The chosen episodes and the number of workers are no part of it.
        """
        path, chosen = self.experiment.path.resolve(), self.plugins
        files = [path, *sorted(path.parent.glob("*.py")), *sorted(data_folder("experiments").glob("*.py"))]  # the last are shared by all
        asked = {"twins": self.twins, "attempt_refused": self.attempt_refused}
        return run_key(self.experiment.spec.experiment, files, Registry(chosen.files, chosen.blocked, chosen.preferred), **asked)

    def prepare(self) -> None:
        """Check that the benchmark is installed.

        Raises:
            UserError: it is not.
        """
        connect(self.experiment.beside(self.experiment.spec.benchmark), self.environment).close()

    def run(self, name: str, store: Store, processes: int) -> EpisodeResult:
        """Plan, prove and execute one episode of a benchmark; the engine decides how many processes run its twins."""
        del processes
        return play(Trial(
            self.experiment, Episode.named(name), store.folder(name).resolve(), self.environment, self.twins, self.attempt_refused,
            self.pictures, self.plugins,
        ))  # fmt: skip

    def lost(self, name: str, reason: str) -> EpisodeResult:
        """Return the result for an episode that was given up."""
        episode = Episode.named(name)
        return died(episode, self.experiment.suite(episode.suite).budget, reason)

    def line(self, name: str, result: EpisodeResult) -> str:
        """Format a result as one line for people."""
        del name
        return in_a_line(result)

    def report(self, results: dict[str, EpisodeResult], out: Path) -> Report:
        """Return the report of the results, in the order of the experiment's suites, then by task and state."""
        spec, order = self.experiment.spec, list(self.experiment.spec.suites)
        ran = tuple(sorted(results.values(), key=lambda r: (order.index(r.suite), r.task, r.state)))
        found = tables(ran, self.experiment)
        asked = [results[name] for name in self.names]
        lost = [in_a_line(r) for r in asked if not r.rest()] if self.fail else []
        failure = f"{len(lost)} of {len(asked)} episodes failed the benchmark's check at rest within their budget: {'; '.join(lost)}."
        return Report(
            {"run": self.key(), "tables": found, "episodes": ran}, text := markdown(found, self.experiment),
            {"tables.md": text, "report.html": outcomes_page(found, ran, self.experiment, out / self.folder)},
            numbers(found), spec.title, "states " + ", ".join(map(str, sorted({r.state for r in ran}))),
            sum(sum(r.seconds.values()) for r in ran), given=spec.given,
            beside=tuple(Published(who=p.system, said=p.rate, given=p.given, source=p.source) for p in found.published),
            failure=failure if lost else "",
        )  # fmt: skip
