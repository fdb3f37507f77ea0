"""A pot that sleeps in a simulation is judged as any other: it wakes where a program hits it, and the program is refused."""

from __future__ import annotations

import numpy as np
from helpers.edited import objections, proven, run
from msgspec.structs import replace

from cramlite.model import Pose
from cramlite.plugin import Candidate
from cramlite_plugins.objects.vessels import bottle

FLOOR = 0.005  # height of the scenario's floor [m]


def with_pot(x: float, y: float) -> Candidate:
    """A run of a program that was proven without the pot, which stands there."""
    good = proven("placing")
    assert good.code is not None
    pot = bottle("pot", Pose((x, y, FLOOR + 0.095)), height=0.19)
    return run(good, good.code.text, replace(good.world, things=(*good.world.things, pot)))


def test_a_pot_beside_the_way_sleeps_all_the_time_and_nobody_objects() -> None:
    ran = with_pot(0.2, 0.5)
    assert ran.rollout is not None
    assert ran.rollout.work["pot"] == 0.0
    assert float(np.ptp(ran.rollout.poses["pot"], axis=0).max()) == 0.0
    assert objections(ran) == {}


def test_a_pot_in_the_way_wakes_when_it_is_hit_and_the_program_is_refused() -> None:
    ran = with_pot(0.53, -0.05)
    assert ran.rollout is not None
    said, track = objections(ran), ran.rollout.poses["pot"]
    assert "'pot'" in said["collision"] and "limit 2 N by default" in said["collision"]
    assert "'pot', which no task moved then," in said["bystanders"]
    pairs = [{t.a for t in touches} | {t.b for t in touches if t.a != "floor"} for touches in ran.rollout.touches]
    hit = next(k for k, names in enumerate(pairs) if "pot" in names)
    assert float(np.ptp(track[:hit], axis=0).max()) < 1e-4 and ran.rollout.work["pot"] > 0.0
    assert float(np.linalg.norm(track[-1, :3] - track[0, :3])) > 0.03
