"""Kitchens of our own that are drawn by a seed, for a UR5e and an arm from a file, proven by nine runs: docs/how-to/drawn_problems.md.

    python tests/benchmarks/drawn_kitchens.py draw 0:10 --out kitchens
    python tests/benchmarks/drawn_kitchens.py play kitchens --out runs/kitchens [--cramlite OLD/.venv/bin/cramlite]

Drawing asks no planner. What is played are scenario files, so that any version can be given them; a kitchen is solved if that version's
``resolve`` proves a program, in the nominal run and in eight twins.
"""

from __future__ import annotations

import argparse
import json
import resource
import shutil
import subprocess
import sys
from collections import Counter
from pathlib import Path
from statistics import median
from typing import Any

import yaml
from figure import add_figure, rate, value, write
from kitchen_drawing import SIX, drawn_kitchen

from cramlite import Engine, data_folder
from cramlite.base.rate import wilson_interval
from cramlite.experiment.figure import Number

sys.path.insert(0, str(data_folder("experiments")))
from drawn_goals import kind_of
from seed_ranges import seeds_of

FACTS, FILE, RESULT = "problem.json", "scenario.yaml", "result.json"
TWINS = 8


def draw(engine: Engine, seed: int, folder: Path) -> dict[str, Any]:
    """Draw the kitchen of a seed into a folder, and return the line to print about it."""
    told: Counter[str] = Counter()
    kitchen, goal = drawn_kitchen(engine, seed, told)
    folder.mkdir(parents=True, exist_ok=True)
    spec = kitchen.spec(goal)
    if "file" in kitchen.robot:
        shutil.copy(SIX, folder)
        spec["robot"] = kitchen.robot | {"file": SIX.name}
    (folder / FILE).write_text(yaml.safe_dump(spec, sort_keys=False, width=140), encoding="utf-8")
    robot = "UR5e" if "type" in kitchen.robot else "arm from a file"
    facts = {"seed": seed, "robot": robot, "kind": kind_of(goal), "goal": spec["goal"], "told": dict(told)}
    (folder / FACTS).write_text(json.dumps(facts, indent=1) + "\n", encoding="utf-8")
    return facts


def play(cramlite: str, folder: Path, out: Path) -> dict[str, Any]:
    """Resolve the kitchen of a folder, once; gives whether it is solved, and the CPU time [s]."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    command = [cramlite, "resolve", str(folder / FILE), "--twins", str(TWINS), "--no-report", "--out", str(out)]
    ran = subprocess.run(command, capture_output=True, text=True, check=False)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    said = (ran.stdout if ran.returncode == 0 else ran.stderr or ran.stdout).strip().splitlines()
    return {"exit": ran.returncode, "solved": ran.returncode == 0, "cpu_s": cpu, "said": said[:4]}


def played(cramlite: str, problems: Path, out: Path) -> list[dict[str, Any]]:
    """Play the kitchens that have no result yet, and return the results of all."""
    found = []
    for path in sorted(problems.glob(f"*/{FACTS}")):
        place = out / path.parent.name
        if not (place / RESULT).exists():
            place.mkdir(parents=True, exist_ok=True)  # what is refused as input makes no run directory
            said = play(cramlite, path.parent, place / "run")
            (place / RESULT).write_text(json.dumps(said, indent=1) + "\n", encoding="utf-8")
        facts = json.loads(path.read_text(encoding="utf-8"))
        found.append(facts | json.loads((place / RESULT).read_text(encoding="utf-8")))
        one = found[-1]
        came = "solved" if one["solved"] else " ".join(one["said"])[:200]
        print(f"{one['seed']} {one['robot']}: {', '.join(one['goal'])}: {came}; {one['cpu_s']:.0f} s", flush=True)
    return found


def numbers(results: list[dict[str, Any]]) -> list[Number]:
    """Print the rates, whole, by robot and by kind of goal, and return them."""
    groups = {"all": results}
    for key in ("robot", "kind"):
        groups |= {one: [r for r in results if r[key] == one] for one in sorted({r[key] for r in results})}
    for name, among in groups.items():
        hits = sum(r["solved"] for r in among)
        low, high = wilson_interval(hits, len(among))
        print(f"| {name} | {hits} of {len(among)} | {low:.3f} to {high:.3f} |")
    found = [rate(name, sum(r["solved"] for r in among), len(among), "proven") for name, among in groups.items()]
    return [*found, value("all", median(r["cpu_s"] for r in results), "s", "CPU, median")]


def told_of(facts: list[dict[str, Any]]) -> str:
    """Return what the rules left out, of all kitchens of a folder, as lines."""
    whole: Counter[str] = Counter()
    for fact in facts:
        whole.update(fact["told"])
    lines = [f"{len(facts)} problems, of {whole['kitchens drawn']} kitchens and {whole['goals drawn']} goals that were drawn."]
    left = [(n, c) for n, c in sorted(whole.items()) if "left out" in n]
    return "\n".join([*lines, *(f"- {name}: {n} ({n / whole[f'{name.split()[0]} drawn']:.1%})" for name, n in left)])


def main() -> None:
    """Draw kitchens, or play them."""
    parser = argparse.ArgumentParser(description=__doc__)
    asked = parser.add_subparsers(dest="asked", required=True)
    drawing = asked.add_parser("draw")
    drawing.add_argument("seeds", help="such as 0:10, which ends with 9")
    drawing.add_argument("--measure", action="store_true", help="the seeds are those of a measurement, and are opened for it")
    drawing.add_argument("--out", type=Path, required=True)
    playing = asked.add_parser("play")
    playing.add_argument("problems", type=Path)
    playing.add_argument("--out", type=Path, required=True)
    playing.add_argument("--cramlite", default=str(Path(sys.executable).parent / "cramlite"), help="of the version that is asked")
    add_figure(playing)
    asked = parser.parse_args()
    if asked.asked == "draw":
        _draw(asked)
        return
    asked.out.mkdir(parents=True, exist_ok=True)
    results = played(asked.cramlite, asked.problems, asked.out)
    seeds = [r["seed"] for r in results]
    write(asked, numbers(results), f"{seeds[0]} to {seeds[-1]}", sum(r["cpu_s"] for r in results))


def _draw(asked: argparse.Namespace) -> None:
    try:
        seeds = seeds_of(asked.seeds, measure=asked.measure)
    except ValueError as error:
        sys.exit(str(error))
    engine = Engine()
    for seed in seeds:
        folder = asked.out / f"{seed:04d}"
        if not (folder / FACTS).exists():
            facts = draw(engine, seed, folder)
            print(f"{seed} {facts['robot']}: {', '.join(facts['goal'])}", flush=True)
    print(told_of([json.loads(p.read_text(encoding="utf-8")) for p in sorted(asked.out.glob(f"*/{FACTS}"))]))


if __name__ == "__main__":
    main()
