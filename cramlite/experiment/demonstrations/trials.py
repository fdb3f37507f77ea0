"""Demonstrations of an experiment as trials of a run."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from ...base.json_text import as_json
from ...base.value import Value
from ...plugin.selection import INSTALLED, PluginChoice
from ..order import Report
from ..store import Store, run_key
from .bench import Bench, Trial, bench
from .candidates_table import to_csv
from .report import BASELINE, against_baseline, baseline, html, missed_thresholds, numbers, text, to_json
from .results import DemonstrationResult
from .spec import Demonstration, Experiment, read_experiment
from .tables import ObjectTables, tables
from .trial import run_demonstration


class Demonstrations(Value):
    """Demonstrations of an experiment that a run is to carry out; each demonstration is one trial.

    Args:
        path: of the experiment's file.
        set_name, short, without: which, only the first of each object, what is taken away.
        pictures: draw how each execution ended.
        plugins: of the engine.
        keep_baseline: store the tables to compare later ones with.
    """

    path: Path
    set_name: str = "main"
    short: bool = False
    without: str | None = None
    pictures: bool = True
    plugins: PluginChoice = INSTALLED
    keep_baseline: bool = False

    folder = "results"
    result = DemonstrationResult

    @property
    def experiment(self) -> Experiment:
        """Experiment that the file at ``path`` describes."""
        return read_experiment(self.path)

    @property
    def demonstrations(self) -> dict[str, Demonstration]:
        """Demonstrations by name, in the order in which they are recorded."""
        return {d.name: d for d in self.experiment.demonstrations(self.set_name, short=self.short)}

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the demonstrations, in the order in which they are recorded."""
        return tuple(self.demonstrations)

    @property
    def what(self) -> str:
        """Name of a run of trials, made of the set of demonstrations and the options, such as "main-short-without_search"."""
        return "-".join([self.set_name, *(["short"] if self.short else []), *([f"without_{self.without}"] if self.without else [])])

    def key(self) -> dict[str, Any]:
        """Return the key that identifies the results: set of demonstrations, options, and hashes of files and code.

        Keys are equal on every machine that would give the same results.

        Raises:
            UserError: a file that cannot be used.
        """
        place = self._bench()
        asked = {"set": self.set_name, "short": self.short, "without": self.without}
        return run_key(place.experiment.spec.experiment, place.files, place.engine.registry, **asked)

    def prepare(self) -> None:
        """Do nothing: ``key`` has already read everything that the trials need."""

    def run(self, name: str, store: Store, processes: int) -> DemonstrationResult:
        """Run the trial of a demonstration, or the part of the trial that is not done yet."""
        return run_demonstration(Trial(self.demonstrations[name], store, self._bench(), self.pictures, processes))

    def lost(self, name: str, reason: str) -> DemonstrationResult:
        """Return the result for a demonstration whose trial was given up."""
        one = self.demonstrations[name]
        return DemonstrationResult(name, one.object, one.seed, 0, 0, 0, (), f"worker: {reason}")

    def line(self, name: str, result: DemonstrationResult) -> str:
        """Format a result as one line for people."""
        good = [sum(getattr(r, stage) for r in result.results) for stage in ("planned", "simulated", "succeeded")]
        why = f"; {result.reason}" if result.reason else ""
        return f"{name}: {result.candidates} candidates, {'/'.join(map(str, good))} planned/simulated/executed{why}"

    def report(self, results: dict[str, DemonstrationResult], out: Path) -> Report:
        """Return the report of the results, which are compared with the stored baseline."""
        experiment, ran = self.experiment, tuple(results[name] for name in self.names)
        spec, stored, title = experiment.spec, experiment.beside(BASELINE), f"{experiment.spec.title} ({self.what})"
        found = tables(ran, spec.published if self.set_name == "main" and not self.short else None)
        changes = against_baseline(found, stored, self.what)
        page = html(title, self._about(experiment, len(ran)), found, ran, changes, out / self.folder)
        seeds = [r.seed for r in ran]
        missed = missed_thresholds(found, spec.thresholds) if self.short and self.without is None else []
        return Report(
            to_json(found, ran, self.key()), "\n".join([text(found, title), "baseline:", *changes]),
            {"candidates.csv": to_csv(ran), "report.html": page}, numbers(found), title,
            f"{min(seeds)} to {max(seeds)}, {len(seeds)} demonstrations", sum(found.seconds.values()),
            kept={stored: self._kept(stored, found)} if self.keep_baseline else {},
            failure=f"'{spec.experiment}' --short misses what it must reach: {'; '.join(missed)}. See {out}/report.html." if missed else "",
        )  # fmt: skip

    def _bench(self) -> Bench:
        return bench(self.path.resolve(), self.set_name, self.without, self.plugins)

    def _about(self, experiment: Experiment, count: int) -> list[str]:
        """Description of the run, in lines for people."""
        published = experiment.spec.published
        return [
            f"{count} demonstrations, set '{self.set_name}': {experiment.choose(self.set_name).about}",
            f"Taken away: {experiment.ablation(self.without).about}.", *([f"Published figures: {published.source}"] if published else []),
        ]  # fmt: skip

    def _kept(self, path: Path, found: ObjectTables) -> str:
        """Return the stored baselines as JSON text, with this run's baseline added."""
        known = json.loads(path.read_text(encoding="utf-8")) if path.is_file() else {}
        return as_json(known | {self.what: baseline(found)}) + "\n"
