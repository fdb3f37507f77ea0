"""One demonstration of an experiment: recorded, interpreted, and every candidate planned, proven and executed in a twin.

Runs in a worker process. Whatever is finished is written at once, so that a worker may die at any time.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from msgspec.structs import replace

from ..base.errors import UserError
from ..base.seeds import derive_seed
from ..engine.candidates import attempts
from ..engine.recording import record_episode
from ..engine.setting import Setting
from ..interpretation.coherence import candidates
from ..interpretation.ranking import TaskSequence
from ..model.episode import Episode
from ..model.verdict import Verdict
from ..planning.budget import Budget
from ..planning.plan import TaskCall, plan_from_episode
from ..planning.trace import Trace
from ..plugin.protocols import Candidate
from .bench import Bench, Trial, bench, goal_missed
from .results import Attempt, CandidateResult, DemonstrationResult, Execution
from .spec import AblationSpec, Demonstration
from .store import Store
from .twins import execute_in_twin


def run_trial(trial: Trial) -> DemonstrationResult:
    """Do one demonstration, or what is left of it.

    Raises:
        UserError: a file that cannot be read or written.
    """
    store = Store(trial.directory)
    done = store.demonstration(trial.demonstration.name)
    if done is not None:
        return done
    store.began(trial.demonstration.name)
    place = bench(trial.experiment, trial.set_name, trial.without, trial.plugins)
    result = _demonstrated(trial, store, place)
    store.save(trial.demonstration.name, "result", result)
    store.ended(trial.demonstration.name)
    return result


def _demonstrated(trial: Trial, store: Store, place: Bench) -> DemonstrationResult:
    one, watch = trial.demonstration, place.watch
    watch.restart()
    with watch("record"):
        folder = _recorded(one, store, place)
    with watch("interpret"):
        try:
            episode = place.engine.read_episode(folder)
            found = place.engine.interpret(episode)
            listed = list(candidates(found, place.engine.knowledge.rules))
        except UserError as error:
            return DemonstrationResult(one.name, one.object, one.seed, 0, 0, 0, (), f"interpret: {error}", watch.read())
    ablation = place.experiment.ablation(trial.without)
    seconds, most = watch.read(), ablation.candidates or place.experiment.spec.most_candidates
    results: tuple[CandidateResult, ...] = ()
    for k, sequence in enumerate(listed[:most], 1):
        results = (*results, store.candidate(one.name, k) or _candidate(trial, store, place, k, sequence, episode))
        if results[-1].executed and place.experiment.choose(trial.set_name).until_solved:
            break
    holes = len(found.holes)
    reason = (
        "" if results else f"interpret: {found.count()} readings, none agrees with itself; {holes} actions unexplained"
    )
    counts = (found.count(), len(listed), len(results))
    return DemonstrationResult(one.name, one.object, one.seed, *counts, results, reason, seconds)


def _recorded(one: Demonstration, store: Store, place: Bench) -> Path:
    """The folder of the demonstration; recorded unless it is there."""
    name = f"demonstrations/{one.name}"
    if (store.path / name).is_dir():
        return store.path / name
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
        record_episode(scenario, place.engine, seed=one.seed, out=part)
        return store.adopt(part, name)


def _candidate(
    trial: Trial, store: Store, place: Bench, number: int, sequence: TaskSequence, episode: Episode
) -> CandidateResult:
    """Plan, prove, execute; written as soon as it is known."""
    one, watch = trial.demonstration, place.watch
    watch.restart()
    tasks = tuple(f"{m.task.split(':')[-1]}({', '.join(m.roles.values())})" for m in sequence.matches)
    seed = derive_seed(one.seed, (), f"candidate {number}")
    made: list[tuple[Attempt, bool]] = []
    trace = Trace()
    for k, (attempt, reached) in enumerate(_attempts(trial, store, place, number, sequence, episode, seed, trace)):
        made.append((attempt, reached))
        if attempt.accepted or k + 1 >= Budget(**place.experiment.spec.budget).proofs:
            break
    planned = any(a.execution is not None for a, _ in made)
    best = next((a for a, reached in made if a.accepted and reached), None)
    executed = best is not None and best.execution is not None and best.execution.succeeded
    result = CandidateResult(
        number, tasks, sequence.score, planned, best is not None, executed,
        _reason(made, best, trace), tuple(a for a, _ in made), watch.read(),
    )  # fmt: skip
    store.save(one.name, str(number), result)
    return result


def _reason(made: list[tuple[Attempt, bool]], best: Attempt | None, trace: Trace) -> str:
    """Where a candidate failed, and why; empty if it did not."""
    if best is not None:
        return "" if best.execution and best.execution.succeeded else f"execution: {_of(best.execution)}"
    texts = [(a, reached) for a, reached in made if a.execution is not None]
    if texts:
        attempt = texts[-1][0]
        return f"simulation: {attempt.reason or 'accepted, but the goal was not reached'}"
    if made:
        return f"plan: {made[-1][0].reason}"
    said = [e for e in trace.entries if e.outcome in ("refused", "impossible", "failed", "fault", "capped")]
    return "plan: " + ("; ".join(f"{e.designator}: {e.reason}" for e in _telling(said)) or "nothing was refused")


def _telling(said: list[Any]) -> list[Any]:
    """The two that came furthest down the plan: what stood in the way last. That all of something failed says less."""
    for outcomes in (("impossible", "fault", "capped"), ("refused",)):
        if found := [e for e in said if e.outcome in outcomes]:
            return found[-2:]
    return said[-2:]


def _of(execution: Execution | None) -> str:
    return execution.reason if execution is not None else "the text did not run"


def _attempts(
    trial: Trial, store: Store, place: Bench, number: int, sequence: TaskSequence, episode: Episode, seed: int,
    trace: Trace,
) -> Iterator[tuple[Attempt, bool]]:  # fmt: skip
    """Each complete program with what became of it in the believed world and in the twin; and whether it reached
    the goal in the believed world."""
    engine, spec = place.engine, place.experiment.spec
    calls = [
        TaskCall(engine.knowledge.tasks[m.task], m.roles) for m in sequence.matches if m.task in engine.knowledge.tasks
    ]
    if len(calls) < len(sequence.matches):
        trace.add(0, "sequence", "", "impossible", "engine", "no plugin offers one of the task types", kind="sequence")
        return
    setting = replace(engine.setting(place.scenario, seed=0), seed=seed)
    plan = plan_from_episode(setting.name, calls, episode)
    found = attempts(plan, setting, engine.knowledge, Budget(**spec.budget), trace)
    while True:
        with place.watch("plan"):  # what is simulated and detected in it is told apart
            candidate, verdict = next(found, (None, None))
        if candidate is None or verdict is None:
            return
        yield _attempt(trial, store, place, number, candidate, verdict, setting)


def _attempt(
    trial: Trial, store: Store, place: Bench, number: int, candidate: Candidate, verdict: Verdict, setting: Setting
) -> tuple[Attempt, bool]:
    if candidate.code is None or candidate.rollout is None:
        return Attempt(False, verdict.reason), False
    with place.watch("judge"):
        reached = not goal_missed(place, candidate)
    ablation: AblationSpec = place.experiment.ablation(trial.without)
    store.write(f"results/{trial.demonstration.name}/{number}{candidate.code.suffix}", candidate.code.text)
    execution = execute_in_twin(trial, store, place, number, candidate, setting, errors=ablation.twin)
    force = (candidate.rollout.wrench[:, :3] ** 2).sum(axis=1).max() ** 0.5
    return Attempt(verdict.passed, "" if verdict.passed else verdict.reason, execution, float(force)), reached
