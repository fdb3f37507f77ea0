"""Test bench of an experiment: the shared objects of a process for its trials, and the check of the goal."""

from __future__ import annotations

import threading
from functools import lru_cache
from pathlib import Path

from msgspec import field
from msgspec.structs import replace

from ...base.stopwatch import Stopwatch
from ...base.value import Value
from ...engine.engine import Engine
from ...engine.proof.executor import Executor
from ...engine.proof.proof import findings_of
from ...planning.search.budget import Budget
from ...plugin.protocols import Candidate
from ...plugin.selection import INSTALLED, PluginChoice
from ...scenario.scenario import Scenario, read_scenario
from ..store import Store
from .spec import AblationSpec, Demonstration, Experiment, SetSpec, read_experiment


class Bench(Value):
    """Test bench: the shared objects of one thread for all its trials of an experiment."""

    experiment: Experiment
    chosen: SetSpec
    ablation: AblationSpec
    budget: Budget
    scenario: Scenario
    engine: Engine
    executor: Executor
    watch: Stopwatch = field(default_factory=Stopwatch)

    @property
    def files(self) -> list[Path]:
        """Files on which the experiment's results depend."""
        named = [self.experiment.beside(f) for f in (self.ablation.plugin, self.ablation.rules) if f]
        return [self.experiment.path, self.scenario.path, *named]


class Trial(Value):
    """Trial of one demonstration.

    Args:
        store: of the run.
        pictures: whether to draw how each execution ended.
        processes: that run twins.
    """

    demonstration: Demonstration
    store: Store
    place: Bench
    pictures: bool = True
    processes: int = 1

    def write(self, name: str, content: str | bytes) -> None:
        """Write a file into the result folder of this demonstration's trial."""
        self.store.write(self.demonstration.name, name, content)


def bench(
    path: Path,
    set_name: str,
    without: str | None,
    plugins: PluginChoice = INSTALLED,
) -> Bench:
    """Build the test bench of an experiment, once for each thread, since a worker of a cluster may have several
    threads."""
    return _bench(threading.get_ident(), path, set_name, without, plugins)


@lru_cache(maxsize=4)
def _bench(thread: int, path: Path, set_name: str, without: str | None, plugins: PluginChoice) -> Bench:
    experiment = read_experiment(path)
    ablation, chosen = experiment.ablation(without), experiment.choose(set_name)
    scenario = read_scenario(experiment.beside(chosen.scenario or experiment.spec.scenario))
    taken = (experiment.beside(ablation.plugin),) if ablation.plugin else ()
    own = scenario.with_plugins(plugins)
    rules = experiment.beside(ablation.rules) if ablation.rules else None
    engine = Engine.with_plugins(replace(own, files=(*own.files, *taken)), scenario.ontologies, rules)
    watch = Stopwatch()
    engine.knowledge.simulator = watch.around(engine.knowledge.simulator, execute="simulate")
    engine.knowledge.episodes = watch.around(engine.knowledge.episodes, detect="detect")
    return Bench(experiment, chosen, ablation, experiment.budget(set_name, without), scenario, engine, Executor(own), watch)


def goal_missed(place: Bench, candidate: Candidate) -> str:
    """Return the validators' objections to a run, if it missed the experiment's goal; empty if the goal was
    reached.

    The goal is the experiment's, not what the plan predicts: a plan that promises nothing has not reached it.
    """
    spec = place.experiment.spec
    aim = replace(candidate, belief=replace(candidate.belief, relations=frozenset({spec.goal}), held=None))
    findings = findings_of(aim, place.engine.knowledge, rollout=True, only=spec.validators)
    said = "; ".join(f"{f.validator}: {f.reason}" for f in findings if not f.passed)
    return said or (
        "" if any(f.validator == "end_state" for f in findings) else "nothing was moved that the goal is about"
    )
