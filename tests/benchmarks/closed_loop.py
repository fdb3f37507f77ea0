"""How fast a program's text runs on the controller model, and where the time goes.

    cramlite resolve hang_onto_hanger --twins 0 --no-report --out DIR
    python tests/benchmarks/closed_loop.py DIR
    python tests/benchmarks/closed_loop.py DIR --plugin experiments/libero/panda.py    # whose robots the run has
    python tests/benchmarks/closed_loop.py DIR --errors     # with noise, drift, latency, play and zeros of joints that are off

All times are CPU time of this one process. The raw figure is a bare loop of mj_step over the very commands that the
controller gave, from the same start; the ratio of the two is what the closed loop costs beyond its physics.
"""

from __future__ import annotations

import argparse
import cProfile
import pstats
import time
from pathlib import Path

import mujoco
import numpy as np
from figure import add_figure, value, write
from msgspec import json

from cramlite.model import ErrorModel, Rollout, World, replace
from cramlite.plugin.catalogue import Knowledge
from cramlite.plugin.registry import Registry
from cramlite.scenario.twin import draw_twin
from cramlite_plugins.robots.arms import robots
from cramlite_plugins.simulation.controller import controller
from cramlite_plugins.simulation.model.compile import compile_world
from cramlite_plugins.simulator.execute import execute

ROBOTS = {r.type: r for r in robots()}
CATEGORIES = {
    "mj_step": "physics", "nominal_arm": "kinematics", "controller": "controller", "force_mode": "controller",
    "wrist_sensor": "controller", "ur_": "controller", "gripper_server": "controller", "execute": "recording",
    "recorder": "recording", "index": "recording", "urscript": "interpreter", "<urscript>": "interpreter",
    "geometry": "poses",
}  # fmt: skip


def run(text: str, world: World) -> tuple[Rollout, float]:
    """The rollout and its CPU seconds, compiling of the world included."""
    before = time.process_time()
    rollout = execute(text, world, ROBOTS, mount=world.robots[0].name)
    return rollout, time.process_time() - before


class Commands:
    """In place of ``mujoco`` in the controller's module: keeps every command."""

    def __init__(self) -> None:
        self.kept: list[np.ndarray] = []

    def mj_step(self, model: object, data: mujoco.MjData) -> None:
        self.kept.append(np.array(data.ctrl))
        mujoco.mj_step(model, data)


def commands(text: str, world: World) -> list[np.ndarray]:
    """The actuator commands of each physics step."""
    keeper = Commands()
    controller.mujoco = keeper  # type: ignore[attr-defined]
    try:
        run(text, world)
    finally:
        controller.mujoco = mujoco  # type: ignore[attr-defined]
    return keeper.kept


def raw(world: World, kept: list[np.ndarray]) -> float:
    """CPU seconds of mj_step alone over the same commands."""
    compiled = compile_world(world, ROBOTS)
    data = compiled.data()
    before = time.process_time()
    for ctrl in kept:
        data.ctrl[:] = ctrl
        mujoco.mj_step(compiled.model, data)
    return time.process_time() - before


def shares(text: str, world: World) -> dict[str, float]:
    """Share of the profiled time in each category, by the file that a function is in; the profiler inflates Python."""
    profile = cProfile.Profile()
    profile.runcall(run, text, world)
    spent: dict[str, float] = {}
    for (file, _, name), (_, _, own, *_) in pstats.Stats(profile).stats.items():  # type: ignore[attr-defined]
        place = f"{file} {name}"
        category = next((c for key, c in CATEGORIES.items() if key in place), "numpy and the rest")
        spent[category] = spent.get(category, 0.0) + own
    total = sum(spent.values())
    return {c: s / total for c, s in sorted(spent.items(), key=lambda item: -item[1])}


def main() -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("run", type=Path, help="run directory of 'cramlite resolve'")
    parser.add_argument("--times", type=int, default=5, help="repetitions; the quickest is reported: others use the machine, too")
    parser.add_argument("--errors", action="store_true", help="of sensor, joints and latency, as twins have them")
    parser.add_argument("--plugin", type=Path, action="append", default=[], help="a plugin file with the run's robot")
    add_figure(parser)
    options = parser.parse_args()
    ROBOTS.update(Knowledge(Registry(options.plugin)).robots)
    world = json.decode((options.run / "world.json").read_bytes(), type=World)
    if options.errors:
        off = draw_twin(world, (), ROBOTS[world.robots[0].type], ErrorModel(), 1).world.disturbance
        world = replace(world, disturbance=replace(off, links=()))  # links would change the physics
    text = next(options.run.glob("program.*")).read_text()
    kept = commands(text, world)
    found = [(run(text, world), raw(world, kept)) for _ in range(options.times)]
    simulated = len(kept) * world.physics.timestep
    closed, physics = min(seconds for (_, seconds), _ in found), min(seconds for _, seconds in found)
    print(f"{found[0][0][0].outcome}: {simulated:.1f} s simulated, {len(kept)} physics steps")
    print(f"closed loop {closed:.2f} s, {simulated / closed:.1f} times real time")
    print(f"raw mj_step {physics:.2f} s, {simulated / physics:.1f} times real time, {1e6 * physics / len(kept):.0f} us a step")
    print(f"closed loop / raw {closed / physics:.1f}")
    found_numbers = (
        value("closed loop", simulated / closed, "times real time"), value("mj_step", simulated / physics, "times real time"),
        value("closed loop / mj_step", closed / physics),
    )  # fmt: skip
    write(options, found_numbers)
    print("where the time goes: " + ", ".join(f"{c} {100 * s:.0f} %" for c, s in shares(text, world).items()))


if __name__ == "__main__":
    main()
