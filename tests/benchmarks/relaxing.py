"""Proposals of ``resolve --relax`` for scenarios without a solution, which are drawn by a seed.

``python tests/benchmarks/relaxing.py [--first N] [--count N]``. A thing is out of reach. Each proposal is checked by a scenario that
is written anew with the change in it, and resolved; and by one with 20 mm less, which must not be solved.
"""

from __future__ import annotations

import argparse
import json
import math
import tempfile
import time
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from figure import add_figure, rate, value, write

from cramlite import Engine, UserError, read_scenario
from cramlite.engine.relaxing import STEP, Relaxation, relaxations
from cramlite.experiment.figure import Number

Spec = dict[str, Any]


def drawn(number: int) -> Spec:
    """A scenario, as data."""
    rng = np.random.default_rng([number, 2340])
    reach, angle, width = rng.uniform(1.0, 1.3), rng.uniform(-0.3, 0.8), rng.uniform(0.04, 0.06)
    x, y = reach * math.cos(angle), reach * math.sin(angle)
    block: Spec = {"name": "block", "model": "block", "at": {"position": [x, y, 0.051]}, "with": {"size": [width, width, 0.1]}}
    things: list[Spec] = [
        {"name": "floor", "model": "table", "at": {"position": [0.6, 0.0, -0.005]}, "with": {"size": [3.0, 3.0, 0.02]}},
        {"name": "shelf", "model": "table", "at": {"position": [0.45, -0.4, 0.15]}, "with": {"size": [0.25, 0.25, 0.02]}}, block,
    ]  # fmt: skip
    return {"scenario": f"unsolved_{number}", "goal": ["block on shelf"], "robot": {"type": "ur5e"}, "things": things}


def changed(spec: Spec, found: Relaxation, steps: int) -> Spec:
    """The scenario with so many steps of a change."""
    off = [STEP * steps * v for v in found.change.way]
    new: Spec = json.loads(json.dumps(spec))
    if not found.change.thing:
        new["robot"]["at"] = {"position": off}
        return new
    thing: Mapping[str, Any] = next(t for t in new["things"] if t["name"] == found.change.thing)
    thing["at"]["position"][:] = [a + b for a, b in zip(thing["at"]["position"], off, strict=True)]
    return new


def solved(spec: Spec, engine: Engine, folder: Path) -> bool:
    """Whether a program is proven for a scenario."""
    path = folder / "scenario.yaml"
    path.write_text(json.dumps(spec))
    scenario = read_scenario(path)
    try:
        return next(engine.resolve(scenario, setting=engine.setting(scenario, twins=0)), None) is not None
    except UserError:
        return False


def episode(number: int, engine: Engine, folder: Path) -> dict[str, Any]:
    """One scenario with its proposals."""
    began, spec = time.process_time(), drawn(number)
    row = {"number": number, "unsolved": not solved(spec, engine, folder)}
    scenario = read_scenario(folder / "scenario.yaml")
    found = relaxations(scenario, engine.setting(scenario, twins=0), engine) if row["unsolved"] else []
    does, less = ([solved(changed(spec, r, r.steps - k), engine, folder) for r in found] for k in (0, 1))
    checked = [(a, not b) for a, b in zip(does, less, strict=True)]
    return {**row, "found": list(map(str, found)), "checked": checked, "cpu": round(time.process_time() - began, 1)}


def numbers(rows: list[dict[str, Any]]) -> Iterator[Number]:
    """The figure's numbers."""
    asked = [r for r in rows if r["unsolved"]]
    yield rate("unsolved scenarios for which a change is proposed", sum(bool(r["found"]) for r in asked), len(asked))
    checked = [c for r in asked for c in r["checked"]]
    yield rate("proposals that solve theirs, written anew", sum(c[0] for c in checked), len(checked))
    yield rate("proposals that do not with 20 mm less", sum(c[1] for c in checked), len(checked))
    yield value("CPU time", float(np.median([r["cpu"] for r in asked])), "s", "median")


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    options.add_argument("--first", type=int, default=0)
    options.add_argument("--count", type=int, default=10)
    add_figure(options)
    asked, engine, folder = options.parse_args(), Engine(), Path(tempfile.mkdtemp())
    chosen, rows = range(asked.first, asked.first + asked.count), []
    for number in chosen:
        rows.append(episode(number, engine, folder))
        print(json.dumps(rows[-1]), flush=True)
    write(asked, numbers(rows), chosen)


if __name__ == "__main__":
    main()
