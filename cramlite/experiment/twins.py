"""Executing a text in a twin: another process is given the text and a world file, and nothing else."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from pydantic import TypeAdapter

from ..engine import Setting
from ..errors import UserError
from ..plugin_types import Candidate
from ..rollout import Rollout
from ..rollout_file import load_rollout
from ..search import derive_seed
from ..twin import twin
from ..world import World
from .results import Execution

if TYPE_CHECKING:
    from .store import Store
    from .trial import Bench, Trial

PICTURE = (320, 240)


def execute_in_twin(
    trial: Trial, store: Store, place: Bench, number: int, candidate: Candidate, setting: Setting, *, errors: bool
) -> Execution:
    """Run a candidate's text where things are not quite as believed, and judge how that ended.

    Args:
        number: of the candidate: names its files, and seeds its twin.
        errors: whether the twin has any; without them it is the believed world.
    """
    from .trial import goal_missed

    assert candidate.code is not None
    seed = derive_seed(trial.demonstration.seed, (), f"twin {number}")
    world = setting.world
    if errors:
        models = place.engine.knowledge.models
        world = twin(place.scenario, world, place.experiment.spec.twin, models, seed, len(setting.robot.joints))
    with place.watch("execute"):
        rollout = run_elsewhere(candidate.code.text, candidate.code.suffix, world, seed)
    with place.watch("judge"):
        episode = replace(place.engine.knowledge.simulator.episode(rollout, setting.name), extras={})
        said = goal_missed(place, replace(candidate, rollout=rollout, episode=episode, world=world))
    picture = ""
    if trial.pictures:
        with place.watch("picture"):
            picture = _picture(trial, store, place, number, rollout)
    force = (rollout.wrench[:, :3] ** 2).sum(axis=1).max() ** 0.5
    return Execution(not said, said, float(force), float(rollout.times[-1]), picture)


def run_elsewhere(text: str, suffix: str, world: World, seed: int) -> Rollout:
    """``cramlite execute`` in a process of its own.

    Raises:
        UserError: it broke, rather than the program.
    """
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        program, place, out = folder / f"program{suffix}", folder / "world.json", folder / "out"
        program.write_text(text, encoding="utf-8")
        place.write_bytes(TypeAdapter(World).dump_json(world))
        words = [
            "execute",
            str(program),
            "--world",
            str(place),
            "--seed",
            str(seed),
            "--out",
            str(out),
            "--no-episode",
            "--json",
        ]
        environment = {**os.environ, "PYTHONPATH": os.pathsep.join(p for p in sys.path if p)}
        done = subprocess.run(
            [sys.executable, "-m", "cramlite.cli", *words], env=environment, capture_output=True, text=True, check=False
        )
        if not (out / "rollout.npz").is_file():
            raise UserError(f"The execution of a program broke: {done.stderr.strip() or done.returncode}")
        return load_rollout(out / "rollout.npz", world)


def _picture(trial: Trial, store: Store, place: Bench, number: int, rollout: Rollout) -> str:
    """The last sample, as a file beside the results."""
    from io import BytesIO

    from PIL import Image

    knowledge = place.engine.knowledge
    pixels = knowledge.simulator.picture(rollout, len(rollout.times) - 1, knowledge.robots, PICTURE)
    buffer = BytesIO()
    Image.fromarray(pixels).save(buffer, "JPEG", quality=70)
    name = f"{number}.jpg"
    store.write(f"results/{trial.demonstration.name}/{name}", buffer.getvalue())
    return name
