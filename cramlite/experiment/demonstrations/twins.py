"""Execution of a program's text in a twin, and the judgement of how it ended."""

from __future__ import annotations

from msgspec.structs import replace

from ...base.seeds import derive_seed
from ...engine.proof.executor import ExecutorDied
from ...engine.proof.executor_group import DEATHS
from ...engine.setting import Setting
from ...engine.solution import Solution
from ...model.run.rollout import Rollout
from ...model.twins.error_model import NO_ERRORS
from ...model.twins.proof_doubts import ProofDoubts
from ...model.world.world import World
from ...plugin.protocols import Candidate
from ...scenario.twin import draw_twin
from ..page import last_picture
from .bench import Bench, Trial, goal_missed
from .results import Execution

PICTURE = (320, 240)


def doubts(place: Bench, setting: Setting) -> ProofDoubts:
    """Return the errors of the twins in which an experiment proves programs; executions use other twins."""
    spec = place.experiment.spec
    sensor = setting.robot.sensor_errors
    errors = spec.proof.errors.errors(spec.twin.errors(NO_ERRORS, sensor), sensor)
    return ProofDoubts(spec.proof.twins or 0, spec.proof.at_least, errors)


def execute_in_twin(trial: Trial, judged: Solution, *, scale: float) -> Execution:
    """Run a program's text in a twin, whose objects are not quite where they are believed, and judge how the
    run ended.

    Args:
        judged: the program; the number of its candidate names the files, and seeds the twin.
        scale: how many times the errors of the experiment's ``twin`` the world is drawn from; with 0 it is the believed world.
    """
    place, candidate, number, setting = trial.place, judged.candidate, judged.number, judged.setting
    seed = derive_seed(trial.demonstration.seed, (("execution", "unseen"),), f"twin {number}")  # one draw, larger with the scale
    world = setting.world
    if scale:
        twin = place.experiment.spec.twin.errors(NO_ERRORS, setting.robot.sensor_errors).scaled(scale)
        world = draw_twin(world, setting.relations, setting.robot, twin, seed).world
    with place.watch("hand over"):
        rollout = _run(place, candidate, world, seed)
    if rollout is None:
        return Execution(scale, False, f"executor: the process died {DEATHS} times (out of memory, or killed)", 0.0, 0.0)
    with place.watch("judge"):
        episode = replace(place.engine.knowledge.episodes.detect(rollout, setting.name), extras={})
        said = goal_missed(place, replace(candidate, rollout=rollout, episode=episode, world=world))
    picture = ""
    if trial.pictures and scale == place.experiment.spec.scales[0]:
        with place.watch("picture"):
            trial.write(picture := f"{number}.jpg", last_picture(rollout, place.engine.knowledge, PICTURE))
    return Execution(scale, not said, said, peak_force(rollout), float(rollout.times[-1]), picture)


def peak_force(rollout: Rollout) -> float:
    """Return the largest force that the wrist sensor measured in a run [N]."""
    return float((rollout.wrench[:, :3] ** 2).sum(axis=1).max() ** 0.5)


def _run(place: Bench, candidate: Candidate, world: World, seed: int) -> Rollout | None:
    """Return the recording of the execution; None if the executing process died twice."""
    for _ in range(DEATHS):
        try:
            rollout, seconds = place.executor.run(candidate.written.text, world, seed)
        except ExecutorDied:
            continue
        place.watch.add("execute", seconds)
        return rollout
    return None
