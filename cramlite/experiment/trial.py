"""Trial of one demonstration: recorded, interpreted, and every candidate planned, proven and executed in a twin.

Runs in a worker process. Whatever is finished is written at once, so that a worker may die at any time.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterable, Iterator
from contextlib import closing
from pathlib import Path

from msgspec.structs import replace

from ..base.errors import UserError
from ..base.seeds import derive_seed
from ..engine.candidates import CandidateSequence
from ..engine.executor_group import ExecutorGroup, RunGroup, processes_here
from ..engine.reading import Reading
from ..engine.recording import record_episode
from ..engine.solution import Solution
from ..planning.budget import Budget
from ..planning.trace import Entry, Trace
from ..plugin.selection import PluginChoice
from .bench import Bench, Trial, bench, goal_missed
from .results import Attempt, CandidateResult, DemonstrationResult, Execution
from .spec import AblationSpec, Demonstration, SetSpec
from .store import Store
from .twins import doubts, execute_in_twin


def run_trial(trial: Trial) -> DemonstrationResult:
    """Run the trial of one demonstration, or what is left of it.

    Raises:
        UserError: a file that cannot be read or written.
    """
    store = Store(trial.directory)
    done = store.demonstration(trial.demonstration.name)
    if done is not None:
        return done
    store.mark(trial.demonstration.name)
    place = bench(trial.experiment, trial.set_name, trial.without, trial.plugins)
    try:
        result = _demonstrated(trial, store, place)
    finally:
        place.executor.close()  # a worker waits for its own processes before it ends
    store.save(trial.demonstration.name, "result", result)
    store.unmark(trial.demonstration.name)
    return result


def _demonstrated(trial: Trial, store: Store, place: Bench) -> DemonstrationResult:
    one, watch, engine = trial.demonstration, place.watch, place.engine
    watch.restart()
    with watch("record"):
        folder, failure = _recorded(one, store, place)
        scenario = place.scenario.demonstrated_by(folder)
    reading = engine.read(scenario)
    with watch("interpret"):
        try:
            found = reading.interpretation
            assert found is not None
            listed = sum(1 for _ in found.sequences())
        except UserError as error:
            return DemonstrationResult(one.name, one.object, one.seed, 0, 0, 0, (), f"interpret: {error}", watch.read(), failure)
    seconds, trace = watch.read(), Trace()
    results = tuple(_until_solved(_results(trial, store, place, reading, trace), place.experiment.choose(trial.set_name)))
    reason = "" if results else "interpret: " + "; ".join(e.reason for e in trace.entries)
    counts = (found.count(), listed, len(results))
    return DemonstrationResult(one.name, one.object, one.seed, *counts, results, reason, seconds, failure)


def _until_solved(results: Iterable[CandidateResult], chosen: SetSpec) -> Iterator[CandidateResult]:
    """All results, or those up to the first that succeeded, as the set has it."""
    for result in results:
        yield result
        if result.succeeded and chosen.until_solved:
            return


def _results(
    trial: Trial, store: Store, place: Bench, reading: Reading, trace: Trace
) -> Iterator[CandidateResult]:
    """What became of each candidate; one that is finished is read."""
    one, spec = trial.demonstration, place.experiment.spec
    most = place.experiment.ablation(trial.without).candidates or spec.most_candidates
    setting = place.engine.setting(reading, twins=0)
    setting = replace(setting, seed=derive_seed(one.seed, (), "resolve"), doubts=doubts(place, setting))
    budget = Budget(**{**spec.budget, "sequences": most})
    for candidate in place.engine.candidates(reading, setting=setting, budget=budget, trace=trace):
        yield store.candidate(one.name, candidate.number) or _candidate(trial, store, place, candidate)


def _recorded(one: Demonstration, store: Store, place: Bench) -> tuple[Path, str]:
    """The folder of the demonstration, recorded once, and what the person did not bring about."""
    name = f"demonstrations/{one.name}"
    if (store.path / name).is_dir():
        return store.path / name, store.failure(one.name)
    recipe = place.scenario.spec.record
    if recipe is None:
        raise UserError(f"{place.scenario.path}: has no 'record' section, so nothing can be demonstrated.")
    product, parameters = place.experiment.spec.product, place.experiment.spec.objects[one.object]
    things = tuple(
        t.model_copy(update={"parameters": {**t.parameters, **parameters}}) if t.name == product else t
        for t in recipe.things
    )
    scenario = replace(
        place.scenario,
        spec=place.scenario.spec.model_copy(update={"record": recipe.model_copy(update={"things": things})}),
    )
    store.path.joinpath("demonstrations").mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=store.path, prefix=".recording-") as folder:
        part = Path(folder) / one.name
        recorded = record_episode(scenario, place.engine, seed=one.seed, out=part)
        store.save_failure(one.name, recorded.failure)
        return store.adopt(part, name), recorded.failure


def _candidate(trial: Trial, store: Store, place: Bench, candidate: CandidateSequence) -> CandidateResult:
    """Plan, prove, execute; written as soon as it is known."""
    sequence, watch = candidate.sequence, place.watch
    assert sequence is not None  # a demonstration was read as it
    watch.restart()
    tasks = tuple(f"{m.task.split(':')[-1]}({', '.join(m.roles.values())})" for m in sequence.matches)
    made: list[tuple[Attempt, bool]] = []
    for attempt, reached in _attempts(trial, store, place, candidate):
        made.append((attempt, reached))
        if attempt.accepted:
            break
    planned = any(a.executions for a, _ in made)
    best = next((a for a, reached in made if a.accepted and reached), None)
    executed = tuple(e.succeeded for e in best.executions) if best else ()
    said = [e for e in candidate.trace.entries if e.candidate == candidate.number]
    result = CandidateResult(
        candidate.number, tasks, sequence.score, planned, best is not None, executed,
        _reason(made, best, said), tuple(a for a, _ in made), watch.read(),
    )  # fmt: skip
    store.save(trial.demonstration.name, str(candidate.number), result)
    return result


def _reason(made: list[tuple[Attempt, bool]], best: Attempt | None, entries: Iterable[Entry]) -> str:
    """Where a candidate failed, and why; empty if it did not."""
    if best is not None:
        return "" if best.execution and best.execution.succeeded else f"execution: {_of(best.execution)}"
    texts = [(a, reached) for a, reached in made if a.executions]
    if texts:
        attempt = texts[-1][0]
        return f"simulation: {attempt.reason or 'accepted, but the goal was not reached'}"
    if made:
        return f"plan: {made[-1][0].reason}"
    said = [e for e in entries if e.outcome in ("refused", "impossible", "failed", "fault", "capped")]
    return "plan: " + ("; ".join(f"{e.designator}: {e.reason}" for e in _telling(said)) or "nothing was refused")


def _telling(said: list[Entry]) -> list[Entry]:
    """The two that came furthest down the plan: what stood in the way last. That all of something failed says less."""
    for outcomes in (("impossible", "fault", "capped"), ("refused",)):
        if found := [e for e in said if e.outcome in outcomes]:
            return found[-2:]
    return said[-2:]


def _of(execution: Execution | None) -> str:
    return execution.reason if execution is not None else "the text did not run"


def _attempts(
    trial: Trial, store: Store, place: Bench, candidate: CandidateSequence
) -> Iterator[tuple[Attempt, bool]]:
    """Each complete program with what became of it in the believed world and in the twin; and whether it reached
    the goal in the believed world."""
    with closing(_twin_runs(trial, place)) as group:
        attempts, spent = candidate.attempts(group), 0.0
        while True:
            with place.watch("plan"):  # what is simulated and detected in it is told apart
                judged = next(attempts, None)
            place.watch.add("twins", group.seconds - spent)
            spent = group.seconds
            if judged is None:
                return
            yield _attempt(trial, store, place, judged)


def _twin_runs(trial: Trial, place: Bench) -> RunGroup:
    """Who runs programs in twins."""
    from .cluster_twins import ClusterRuns, OwnRuns

    registry = place.engine.registry
    plugins = PluginChoice(tuple(registry.files), tuple(registry.blocked), tuple(registry.preferred))
    if trial.twins != "processes":
        return ClusterRuns(plugins) if trial.twins == "tasks" else OwnRuns(plugins)
    return ExecutorGroup(plugins, min(processes_here(), place.experiment.spec.proof.twins or 1))


def _attempt(trial: Trial, store: Store, place: Bench, judged: Solution) -> tuple[Attempt, bool]:
    candidate, verdict = judged.candidate, judged.verdict
    if candidate.code is None or candidate.rollout is None:
        return Attempt(False, verdict.reason), False
    with place.watch("judge"):
        reached = not goal_missed(place, candidate)
    ablation: AblationSpec = place.experiment.ablation(trial.without)
    name = f"{judged.number}{candidate.code.suffix}"
    store.write(f"results/{trial.demonstration.name}/{name}", candidate.code.text)
    scales = place.experiment.spec.scales if ablation.twin else (0.0,)
    executions = tuple(execute_in_twin(trial, store, place, judged, scale=k) for k in scales)
    force = (candidate.rollout.wrench[:, :3] ** 2).sum(axis=1).max() ** 0.5
    share = verdict.twins.succeeded / verdict.twins.ran if verdict.twins else float(verdict.passed)
    return Attempt(verdict.passed, "" if verdict.passed else verdict.reason, executions, float(force), share), reached
