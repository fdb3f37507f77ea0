"""Prove kitchens of ``scenarios/kitchen`` for many seeds, nominal proofs without twins: the share that is proven, with its interval.

Each seed varies where things are. With a camera a seed counts only if the first execution in the real world succeeds, too.
"""

from __future__ import annotations

import argparse
import resource
from pathlib import Path

from seeds import wilson

from cramlite import Engine, data_folder, read_scenario
from cramlite.base.errors import CramliteError


def solved(engine: Engine, path: Path, seed: int) -> str:
    """Empty where a program is proven and, with a real world, succeeds there; else why not."""
    scenario = read_scenario(path)
    try:
        setting = engine.setting(scenario, seed=seed, twins=0)
        solution = next(engine.resolve(scenario, setting=setting, seed=seed), None)
    except CramliteError as error:
        return str(error)
    if solution is None:
        return "no solution"
    if setting.real is not None:
        solution = engine.execute(solution)
        assert solution.execution is not None
        return "" if solution.succeeded else solution.execution.verdict.reason
    return ""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("kitchens", nargs="*", help="names; all that must succeed by default")
    parser.add_argument("--first", type=int, default=1)
    parser.add_argument("--count", type=int, default=10)
    arguments = parser.parse_args()
    folder, engine = data_folder("scenarios") / "kitchen", Engine()
    names = arguments.kitchens or sorted(p.stem for p in folder.glob("*.yaml") if not p.stem.endswith("_fails"))
    for name in names:
        reasons = {s: solved(engine, folder / f"{name}.yaml", s) for s in range(arguments.first, arguments.first + arguments.count)}
        good = sum(not why for why in reasons.values())
        low, high = wilson(good, len(reasons))
        print(f"{name}: {good} of {len(reasons)}, interval {low:.2f} to {high:.2f}", flush=True)
        for seed, why in reasons.items():
            if why:
                print(f"  seed {seed}: {why[:300]}", flush=True)
    print(f"{sum(resource.getrusage(resource.RUSAGE_SELF)[:2]):.0f} s of processor time")


if __name__ == "__main__":
    main()
