"""Worlds of one's own for recordings of people: a vessel and a bowl on two counters, drawn from a seed; and siblings in which what a
person showed cannot be done."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

SIBLINGS = {
    "empty cup": ("'jug' is empty", "'bowl' is empty"),
    "bowl too small": ("'bowl' would overflow",),
    "bowl out of reach": ("reach of arm 'ur5e'",),
}
"""Kind of a world without a solution -> words of the reasons for which the search may refuse it."""
AWAY = 1.1
"""Distance by which an unreachable bowl and its counter are moved away [m]; a UR5e with its gripper reaches 1.01 m."""


def own_world(demonstration: Path, seed: int, kind: str = "") -> str:
    """Return the text of a scenario with a vessel and a bowl on two counters, drawn from a seed.

    Args:
        demonstration: the recording.
        seed: of heights, places, sizes, the count of grains, on which side what stands, and of two things that nobody means.
        kind: one of ``SIBLINGS``; "" for a world in which it can be done.
    """
    rng = np.random.default_rng(seed)
    side, high = rng.choice([-1.0, 1.0]), rng.uniform(0.05, 0.22, 2)
    away = AWAY if kind == "bowl out of reach" else 0.0
    jug = {"radius": rng.uniform(0.031, 0.038), "height": rng.uniform(0.09, 0.115), "grain_radius": rng.uniform(0.005, 0.006)}
    jug |= {"grains": int(rng.integers(6, 15)), "grain_mass": 0.001}
    bowl = {"radius": rng.uniform(0.06, 0.085), "height": rng.uniform(0.04, 0.06)}
    jug = jug | {"grains": 0} if kind == "empty cup" else jug
    bowl = {"radius": 0.015, "height": 0.015} if kind == "bowl too small" else bowl
    jug_at = [rng.uniform(0.45, 0.58), side * rng.uniform(0.14, 0.3), high[0] + jug["height"] / 2 + 0.001]
    bowl_at = [rng.uniform(0.45, 0.58) + away, -side * rng.uniform(0.14, 0.3), high[1] + bowl["height"] / 2 + 0.001]
    things = [
        _thing("floor", "table", [0.5, 0, -0.005], size=[2.6, 1.8, 0.02]),
        _thing("counter", "table", [0.58, side * 0.24, high[0]], size=[0.42, 0.44, 0.04]),
        _thing("other_counter", "table", [0.58 + away, -side * 0.24, high[1]], size=[0.42, 0.44, 0.04]),
        _thing("jug", "jug", jug_at, 180 + rng.uniform(-25, 25), **jug),
        _thing("bowl", "bowl", bowl_at, **bowl),
        _thing("can", "can", [0.72, side * rng.uniform(0.08, 0.4), high[0] + 0.0585]),
        _thing("block", "block", [0.72 + away, -side * rng.uniform(0.08, 0.4), high[1] + 0.041], size=[0.04, 0.04, 0.08]),
    ]
    head = {"scenario": "own", "title": "As a person showed it", "demonstration": str(demonstration), "robot": {"type": "ur5e"}}
    return json.dumps({**head, "things": things, "budget": {"proofs": 3, "sequences": 2}})


def _thing(name: str, model: str, position: list[float], yaw: float = 0.0, **sizes: Any) -> dict[str, Any]:
    """Return the description of a thing for a scenario; ``yaw`` in degrees, all else in metres and kilogrammes."""
    at = {"position": [float(v) for v in position], **({"yaw": f"{yaw:.3f} deg"} if yaw else {})}
    return {"name": name, "model": model, "at": at, "with": sizes}
