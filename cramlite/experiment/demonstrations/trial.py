"""Trial of one demonstration: recorded, interpreted, and every candidate planned, proven and executed in a twin.

Runs in a worker process.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterable, Iterator
from contextlib import closing
from pathlib import Path

from msgspec.structs import replace

from ...base.errors import UserError
from ...base.seeds import derive_seed
from ...engine.candidates import CandidateSequence
from ...engine.proof.executor_group import ExecutorGroup
from ...engine.reading import Reading
from ...engine.recording import record_episode
from ...engine.solution import Solution
from ...planning.trace import Entry, Trace
from ...plugin.selection import PluginChoice
from ..store import RECORDED
from .bench import Trial, goal_missed
from .results import CandidateResult, DemonstrationResult, Execution, Program
from .spec import SetSpec
from .twins import doubts, execute_in_twin, peak_force


def run_demonstration(trial: Trial) -> DemonstrationResult:
    """Run the trial of one demonstration, or the part of the trial that is not done yet.

    Raises:
        UserError: a file that cannot be read or written.
    """
    try:
        return _demonstrated(trial)
    finally:
        trial.place.executor.close()  # a worker waits for its own processes before it ends


def _demonstrated(trial: Trial) -> DemonstrationResult:
    one, place, watch = trial.demonstration, trial.place, trial.place.watch
    watch.restart()
    with watch("record"):
        folder, failure = _recorded(trial)
        scenario = place.scenario.demonstrated_by(folder)
    reading = place.engine.read(scenario)
    with watch("interpret"):
        try:
            found = reading.interpretation
            assert found is not None
            listed = sum(1 for _ in found.sequences())
        except UserError as error:
            return DemonstrationResult(one.name, one.object, one.seed, 0, 0, 0, (), f"interpret: {error}", watch.read(), failure)
    seconds, trace = watch.read(), Trace()
    results = tuple(_until_solved(_results(trial, reading, trace), place.chosen))
    reason = "" if results else "interpret: " + "; ".join(e.reason for e in trace.entries)
    counts = (found.count(), listed, len(results))
    return DemonstrationResult(one.name, one.object, one.seed, *counts, results, reason, seconds, failure)


def _until_solved(results: Iterable[CandidateResult], chosen: SetSpec) -> Iterator[CandidateResult]:
    """Yield the results of a demonstration's candidates; stop after the first success where ``until_solved``
    is set."""
    for result in results:
        yield result
        if result.succeeded and chosen.until_solved:
            return


def _results(trial: Trial, reading: Reading, trace: Trace) -> Iterator[CandidateResult]:
    """Yield the result of each candidate; the result of a finished candidate is read from its file."""
    one, place = trial.demonstration, trial.place
    setting = place.engine.setting(reading, twins=0)
    setting = replace(setting, seed=derive_seed(one.seed, (), "resolve"), doubts=doubts(place, setting))
    for candidate in place.engine.candidates(reading, setting=setting, budget=place.budget, trace=trace):
        yield trial.store.read(one.name, str(candidate.number), CandidateResult) or _candidate(trial, candidate)


def _recorded(trial: Trial) -> tuple[Path, str]:
    """Return the folder of the demonstration, which is recorded once, and why its simulated person failed; "" if the person succeeded."""
    one, store, place = trial.demonstration, trial.store, trial.place
    name = "/".join((RECORDED, one.name))
    if (store.path / name).is_dir():
        return store.path / name, (store.folder(one.name) / "recorded").read_text(encoding="utf-8")
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
    store.path.joinpath(RECORDED).mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=store.path, prefix=".recording-") as folder:
        part = Path(folder) / one.name
        recorded = record_episode(scenario, place.engine, seed=one.seed, out=part)
        trial.write("recorded", recorded.failure)
        return store.adopt(part, name), recorded.failure


def _candidate(trial: Trial, candidate: CandidateSequence) -> CandidateResult:
    """Plan a candidate, prove its programs and execute them; write the result at once."""
    sequence, watch = candidate.sequence, trial.place.watch
    assert sequence is not None  # a demonstration was read as it
    watch.restart()
    tasks = tuple(f"{m.task.split(':')[-1]}({', '.join(m.roles.values())})" for m in sequence.matches)
    made: list[Program] = []
    for attempt in _attempts(trial, candidate):
        made.append(attempt)
        if attempt.accepted:
            break
    planned = any(a.executions for a in made)
    best = next((a for a in made if a.passed), None)
    executed = tuple(e.succeeded for e in best.executions) if best else ()
    said = [e for e in candidate.trace.entries if e.candidate == candidate.number]
    result = CandidateResult(
        candidate.number, tasks, sequence.score, planned, best is not None, executed,
        _reason(made, best, said), tuple(made), watch.read(),
    )  # fmt: skip
    trial.store.save(trial.demonstration.name, result, str(candidate.number))
    return result


def _reason(made: list[Program], best: Program | None, entries: Iterable[Entry]) -> str:
    """Stage (plan, simulation or execution) at which a candidate failed, and why: "plan: no grasp"; empty if
    it did not fail."""
    if best is not None:
        return "" if best.execution and best.execution.succeeded else f"execution: {_of(best.execution)}"
    texts = [a for a in made if a.executions]
    if texts:
        return f"simulation: {texts[-1].reason or 'accepted, but the goal was not reached'}"
    if made:
        return f"plan: {made[-1].reason}"
    said = [e for e in entries if e.outcome in ("refused", "impossible", "failed", "fault", "capped")]
    return "plan: " + ("; ".join(f"{e.designator}: {e.reason}" for e in _telling(said)) or "nothing was refused")


def _telling(said: list[Entry]) -> list[Entry]:
    """Return the last two trace entries that tell why a candidate failed: failures if there are any, else refusals,
    else others."""
    for outcomes in (("impossible", "fault", "capped"), ("refused",)):
        if found := [e for e in said if e.outcome in outcomes]:
            return found[-2:]
    return said[-2:]


def _of(execution: Execution | None) -> str:
    return execution.reason if execution is not None else "the text did not run"


def _attempts(trial: Trial, candidate: CandidateSequence) -> Iterator[Program]:
    """Yield each complete program with its result in the believed world and in the twin."""
    watch = trial.place.watch
    with closing(_twin_runs(trial)) as group:
        attempts, spent = candidate.attempts(group), 0.0
        while True:
            with watch("plan"):  # what is simulated and detected in it is told apart
                judged = next(attempts, None)
            watch.add("twins", group.seconds - spent)
            spent = group.seconds
            if judged is None:
                return
            yield _program(trial, judged)


def _twin_runs(trial: Trial) -> ExecutorGroup:
    """Return the group of processes that run programs in twins."""
    plugins = PluginChoice.of(trial.place.engine.registry)
    return ExecutorGroup(plugins, min(trial.processes, trial.place.experiment.spec.proof.twins or 1))


def _program(trial: Trial, judged: Solution) -> Program:
    candidate, verdict, place = judged.candidate, judged.verdict, trial.place
    if candidate.code is None or candidate.rollout is None:
        return Program(False, verdict.reason, reached=False)
    with place.watch("judge"):
        reached = not goal_missed(place, candidate)
    trial.write(f"{judged.number}{candidate.code.suffix}", candidate.code.text)
    scales = place.experiment.spec.scales if place.ablation.twin else (0.0,)
    executions = tuple(execute_in_twin(trial, judged, scale=k) for k in scales)
    share = verdict.twins.succeeded / verdict.twins.ran if verdict.twins else float(verdict.passed)
    said = "" if verdict.passed else verdict.reason
    return Program(verdict.passed, said, executions, peak_force(candidate.rollout), share if reached else 0.0, reached)
