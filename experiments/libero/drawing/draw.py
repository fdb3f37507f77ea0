"""Draw problems for LIBERO: scenes of libero_90 with random states and random goals.

    LIBERO/bin/python experiments/libero/drawing/draw.py 0:10 --out problems

It runs in the benchmark's environment, and asks no planner. ``problems`` is then an environment of the benchmark itself, which knows the
suite ``drawn``: ``cramlite experiment libero --suite drawn --tasks 0:10 --benchmark problems``. More: docs/how-to/drawn_problems.md.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import os
import sys
from collections import Counter
from itertools import count
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

os.environ.setdefault("MUJOCO_GL", "egl")
sys.path.insert(0, str(Path(__file__).resolve().parent))
sys.path.insert(1, str(Path(__file__).resolve().parents[2]))

import numpy as np
from by_hand import Hand
from drawn_goals import (
    PART,
    PLACES,
    TABLE,
    Literal,
    contradiction,
    drawn_goal,
    fits,
    kind_of,
    most_parts,
    offered,
    signature,
    words,
)
from environment import STATE, TEXT, make_environment
from library import known_goals, library, name_of_kind, parsed, predicates_of_sites, region_names, scenes
from robosuite.utils.errors import RandomizationError
from seed_ranges import seeds_of
from variants import CHANCE, Problem, kinds, movables, pinned, replaced, swapped, text, with_sites
from world import World

GOALS = 200
"""Number of goals that are drawn in a state before a new state is drawn."""
FACTS = "problem.json"


def draw(seed: int, folder: Path) -> dict[str, Any]:
    """Generate the random problem of a seed, write it into a folder, and return its record."""
    told: Counter[str] = Counter()
    for attempt in count():
        told["states drawn"] += 1
        rng = np.random.default_rng([seed, attempt])
        scene = str(rng.choice(list(scenes())))
        made, varied = vary(scenes()[scene], rng)
        goal, state = in_state(made, rng, told)
        if goal and written(made, goal, state, folder, told):
            return _facts(seed, scene, made, goal, folder) | varied | {"told": dict(told)}
    raise AssertionError


def vary(problem: Problem, rng: Any) -> tuple[Problem, dict[str, Any]]:
    """Vary a problem at random: which things there are, where they stand, and where its fixtures stand."""
    swap, replace = rng.random() < CHANCE, rng.random() < CHANCE
    made = replaced(problem, rng, library()) if replace else problem
    made = swapped(made, rng) if swap else made
    made = pinned(with_sites(made, {k: region_names(k) for k in kinds(made).values() if not k.endswith("table")}), rng)
    things = movables(made)
    made |= {"goal_state": [["on", *things[:2]]], "obj_of_interest": things[:1]}  # until one is drawn
    return made, {"swapped": bool(swap), "replaced": sorted(set(movables(made)) - set(movables(problem)))}


def in_state(made: Problem, rng: Any, told: Counter[str]) -> tuple[tuple[Literal, ...], Any]:
    """Draw a state of a problem's scene, and a goal in it; an empty goal if things do not fit or stay at rest,
    or if no goal is found after some tries."""
    parts, seed = int(rng.integers(1, 4)), int(rng.integers(2**31))
    with TemporaryDirectory() as folder:
        path = Path(folder) / TEXT
        path.write_text(text(made, "nothing"), encoding="utf-8")
        try:
            world = World(path, parsed(path), seed)
        except RandomizationError:
            told["states left out: things do not fit where they shall stand"] += 1
            return (), None
    state = world.state()
    world.begin(state)
    if world.restless():
        told["states left out: not at rest"] += 1
        return (), None
    world.begin(state)
    goal = _goal(world, rng, parts, told)
    world.close()
    told["states left out: no goal of so many parts was found"] += not goal
    return goal, state


def _goal(world: World, rng: Any, parts: int, told: Counter[str]) -> tuple[Literal, ...]:
    owner = {n: r["target"] for n, r in world.problem["regions"].items() if r["target"] in world.things}
    offers = offered(world.things, targets(world), world.articulated())
    for _ in range(GOALS if parts <= most_parts(offers) else 0):
        goal = drawn_goal(rng, offers, parts)
        told["goals drawn"] += 1
        rule = left_out(goal, world, owner)
        if not rule:
            return goal
        told[f"goals left out: {rule}"] += 1
    return ()


def targets(world: World) -> dict[str, tuple[str, str]]:
    """Return each region that takes things -> its preposition ("on" or "in"), and whether it is on the
    table or part of a thing.

    Regions in which fixtures stand are left out.
    """
    problem = world.problem
    stands = {row[2] for row in problem["initial_state"] if len(row) == 3 and row[1] not in world.things}
    known = (name for name in problem["regions"] if name in world.env.env.object_sites_dict and name not in stands)
    return {name: ("on", TABLE) if problem["regions"][name]["ranges"] else (_put(world, name), PART) for name in known}


def _put(world: World, name: str) -> str:
    """Preposition, "in" or "on", for things at a region: as LIBERO's 130 problem files use it, else by the
    region's joints and name."""
    contains = bool(world.joints(name)) or name.endswith("contain_region")
    return predicates_of_sites().get(name_of_kind(world.problem, name), "in" if contains else "on")


def left_out(goal: tuple[Literal, ...], world: World, owner: dict[str, str]) -> str:
    """Return why a drawn goal is left out, such as that one of the 130 tasks has it; "" if it can be used."""
    if signature(goal, lambda n: name_of_kind(world.problem, n)) in known_goals():
        return "one of the 130 tasks has it"
    if contradiction(goal, owner):
        return "a contradiction"
    if any(world.holds_nearly(p) for p in goal):
        return "a part holds already"
    if any(p[0] in PLACES and not fits(world.extents(p[1]), world.footprint(p)) for p in goal):
        return "a thing is larger than its target in every attitude"
    return "" if Hand(world, owner).can(goal) else "the benchmark cannot hold it"


def written(made: Problem, goal: tuple[Literal, ...], state: Any, folder: Path, told: Counter[str]) -> bool:
    """Write the files of a problem; return whether the benchmark begins an episode of it in the drawn state
    with the drawn goal."""
    folder.mkdir(parents=True, exist_ok=True)
    of_interest = sorted({n for p in goal for n in p[1:]})
    whole = made | {"goal_state": [list(p) for p in goal], "obj_of_interest": of_interest}
    (folder / TEXT).write_text(text(whole, words(goal)), encoding="utf-8")
    np.savetxt(folder / STATE, state, fmt="%.17g")
    begun = _begins(folder, goal, state)
    told["states left out: the benchmark does not begin them so"] += not begun
    return begun


def _begins(folder: Path, goal: tuple[Literal, ...], state: Any) -> bool:
    """Whether the benchmark can begin an episode in the state, and no part of the goal holds then."""
    try:
        world = World(folder / TEXT, parsed(folder / TEXT), 0)
    except RandomizationError:
        return False
    world.reset()
    world.begin(state)
    found = not any(world.holds(p) for p in goal)
    world.close()
    return found


def _facts(seed: int, scene: str, made: Problem, goal: tuple[Literal, ...], folder: Path) -> dict[str, Any]:
    digest = hashlib.blake2b((folder / TEXT).read_bytes() + (folder / STATE).read_bytes(), digest_size=4).hexdigest()
    return {"seed": seed, "digest": digest, "scene": scene, "things": movables(made), "kind": kind_of(goal), "words": words(goal),
            "goal": [list(p) for p in goal]}  # fmt: skip


def told_of(facts: list[dict[str, Any]]) -> str:
    """Format, line by line, what share of the drawn states and goals each exclusion rule left out."""
    whole: Counter[str] = Counter()
    for fact in facts:
        whole.update(fact["told"])
    shares = {"states": whole["states drawn"], "goals": whole["goals drawn"]}
    lines = [f"{len(facts)} problems, of {shares['states']} states and {shares['goals']} goals that were drawn."]
    lines += [f"- {name}: {n} ({n / shares[name.split()[0]]:.1%})" for name, n in sorted(whole.items()) if "left out" in name and n]
    lines += [f"- {kind}: {n}" for kind, n in Counter(f["kind"] for f in facts).most_common()]
    return "\n".join(lines)


def main() -> None:
    """Generate the random problems of those seeds that have no files yet; print statistics of all problems
    in the folder."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("seeds", help="such as 0:10, which ends with 9")
    parser.add_argument("--out", type=Path, default=Path("problems"), help="folder for them (default problems)")
    parser.add_argument("--measure", action="store_true", help="the seeds are those of a measurement, and are opened for it")
    order = parser.parse_args()
    try:
        seeds = seeds_of(order.seeds, measure=order.measure)
    except ValueError as error:
        sys.exit(str(error))
    make_environment(order.out)
    for seed in seeds:
        folder = order.out / f"{seed:04d}"
        if not (folder / FACTS).exists():
            facts = draw(seed, folder)
            (folder / FACTS).write_text(json.dumps(facts, indent=1) + "\n", encoding="utf-8")
            varied = " ".join([*(["swapped"] if facts["swapped"] else []), *facts["replaced"]])
            print(f"{seed}: {facts['scene']} {varied}: {facts['words']}", flush=True)
    print(told_of([json.loads(p.read_text(encoding="utf-8")) for p in sorted(order.out.glob(f"*/{FACTS}"))]))


if __name__ == "__main__":
    main()
