"""First-execution success against the scale of errors: one program a seed, executed once in a twin at each scale.

    python tests/benchmarks/first_execution.py fetch_from_hanger --seeds 70000:70040 --out curve

Each seed is a world of the scenario. The program is the first that the proof accepts; no program counts as a failure at every scale.
It is executed in twins drawn from the errors under ``twin:`` of the experiment of the same name (or ``--experiment``), times 1 to 4:
the same draw enlarged, from a family of seeds that no proof uses. All validators of runs are asked. With ``poses: camera`` the real world
is the scenario's own, so what the camera got wrong is wrong, and 3 mm and 0.5 deg of hand-eye error are added.

``--camera`` scales the errors of the camera alone, of depth in its pictures and of hand-eye, which are declared: a program is made for each
scale. ``--proof-scale`` says at how many times these errors programs are proven (8 twins); 0 proves in the believed world alone.
"""

from __future__ import annotations

import argparse
import json
import math
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from functools import cache
from pathlib import Path
from typing import Any

from figure import add_figure, rate, write
from msgspec.structs import replace

from cramlite import Engine, find_scenario, read_scenario
from cramlite.base.rate import wilson_interval
from cramlite.base.seeds import derive_seed
from cramlite.engine.setting import Setting
from cramlite.engine.solution import Solution
from cramlite.experiment.demonstrations.spec import read_experiment
from cramlite.experiment.experiment_file import find_experiment
from cramlite.experiment.figure import Number
from cramlite.model import ErrorModel, PoseError, ProofDoubts, World
from cramlite.model.twins.error_model import NO_ERRORS
from cramlite.scenario.twin import draw_twin

SCALES = (1.0, 2.0, 3.0, 4.0)
CAMERA_SCALES = (2.0, 3.0)
HAND_EYE = PoseError(0.003, math.radians(0.5))


@cache
def engine() -> Engine:
    return Engine()


def errors_of(experiment: str, setting: Setting) -> ErrorModel:
    """The experiment's errors for the things of a scene; things that a camera saw have the camera's own errors."""
    spec = read_experiment(find_experiment(experiment)).spec
    found = spec.twin.errors(NO_ERRORS, setting.robot.sensor_errors)
    names = {t.name for t in setting.world.things}
    seen = setting.look is not None
    return replace(
        found, hand_eye=HAND_EYE if seen else PoseError(), things={n: e for n, e in found.things.items() if n in names and not seen}
    )


def one(task: tuple[str, str, int, float]) -> dict[str, Any]:
    """The outcome of one seed: by scale of the errors, the first objection to its execution, or ""."""
    name, experiment, seed, proof_scale = task
    reading = engine().read(read_scenario(find_scenario(name)))
    setting = engine().setting(reading, seed=seed, twins=0)
    errors = errors_of(experiment, setting)
    doubts = ProofDoubts(8 if proof_scale else 0, errors=errors.scaled(proof_scale or 1.0))
    solution = next(engine().resolve(reading, setting=replace(setting, doubts=doubts)), None)
    if engine().registry.faults:  # an environment that lacks a package is no failure of a program
        raise RuntimeError(f"a plugin is broken: {engine().registry.faults[0]}")
    if solution is None:
        return {"seed": seed, "proven": "", **{f"{k:g}": "no program" for k in SCALES}}
    said = solution.verdict.twins.text if solution.verdict.twins else "nominal"
    return {"seed": seed, "proven": said, **{f"{k:g}": executed(solution, errors.scaled(k), seed) for k in SCALES}}


def by_camera(task: tuple[str, str, int, float]) -> dict[str, Any]:
    """The outcome of one seed with a camera whose depth and hand-eye have errors of each scale, which are declared; the others stay."""
    name, experiment, seed, _ = task
    scenario = read_scenario(find_scenario(name))
    found: dict[str, Any] = {"seed": seed, "proven": "nominal"}
    for k in CAMERA_SCALES:
        camera = scenario.spec.camera.model_copy(update={"noise": k})
        reading = engine().read(replace(scenario, spec=scenario.spec.model_copy(update={"camera": camera})))
        setting = engine().setting(reading, seed=seed, twins=0)
        errors = errors_of(experiment, setting)
        errors = replace(errors, hand_eye=PoseError(k * HAND_EYE.position, k * HAND_EYE.angle))
        solution = next(engine().resolve(reading, setting=replace(setting, doubts=ProofDoubts(0, errors=errors))), None)
        found[f"{k:g}"] = "no program" if solution is None else executed(solution, errors, seed)
    return found


def executed(solution: Solution, errors: ErrorModel, seed: int) -> str:
    """The first objection to the execution in a twin; "" where there is none."""
    setting = solution.setting
    base: World = setting.real or setting.world
    unseen = derive_seed(seed, (("execution", "unseen"),), "twin")
    twin = draw_twin(base, setting.relations, setting.robot, errors, unseen, setting.sight)
    execution = engine().execute(replace(solution, setting=replace(setting, real=twin.world))).execution
    assert execution is not None
    return next((f"{f.validator}: {f.reason}" for f in execution.verdict.objections), "")


def rows(found: list[dict[str, Any]], scales: tuple[float, ...]) -> Iterator[str]:
    """The table, and the causes at the scale where most is lost."""
    for k in scales:
        wrong = [r[f"{k:g}"] for r in found if r[f"{k:g}"]]
        good = len(found) - len(wrong)
        low, high = wilson_interval(good, len(found))
        causes = Counter(w.split(":")[0] for w in wrong)
        told = ", ".join(f"{n} x {c}" for c, n in causes.most_common())
        yield f"{k:g} x errors: {good} of {len(found)}, {good / len(found):.3f} ({low:.3f} to {high:.3f}){'; ' + told if told else ''}"


def numbers(scenario: str, found: list[dict[str, Any]], scales: tuple[float, ...]) -> Iterator[Number]:
    """The rates of the figure, over the scale of errors."""
    for k in scales:
        yield rate(scenario, sum(not r[f"{k:g}"] for r in found), len(found), f"{k:g} x", x=k)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenario")
    parser.add_argument("--experiment", help="whose errors are taken; the scenario's name by default")
    parser.add_argument("--seeds", default="70000:70040")
    parser.add_argument("--proof-scale", type=float, default=2.0)
    parser.add_argument("--camera", action="store_true")
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--out", type=Path)
    add_figure(parser)
    options = parser.parse_args()
    first, last = map(int, options.seeds.split(":"))
    experiment = options.experiment or options.scenario
    tasks = [(options.scenario, experiment, seed, options.proof_scale) for seed in range(first, last)]
    found = []
    with ProcessPoolExecutor(options.workers) as pool:
        for result in pool.map(by_camera if options.camera else one, tasks):
            found.append(result)
            print(json.dumps(result), flush=True)
    scales = CAMERA_SCALES if options.camera else SCALES
    print("\n".join(rows(found, scales)))
    write(options, numbers(options.scenario, found, scales), f"{first} to {last - 1}")
    if options.out:
        options.out.with_suffix(".json").write_text(json.dumps(found, indent=1) + "\n")


if __name__ == "__main__":
    main()
