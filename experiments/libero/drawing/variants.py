"""Variants of a scene: things swap places, or are replaced by others of the benchmark's library.

A problem is a dictionary as LIBERO's parser returns it (``robosuite_parse_problem``). Nothing of cramlite or LIBERO is imported.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from copy import deepcopy
from typing import Any

Problem = dict[str, Any]
CHANCE = 0.3
"""Probability of each variation of a scene: things swap places, or are replaced."""
WIDTH = 1e-6
"""Half the width of the region that a fixture is pinned to [m]: LIBERO draws its place at each reset, within this."""


def kinds(problem: Problem) -> dict[str, str]:
    """Return a dictionary from each thing and fixture of a problem to its kind, the benchmark's category."""
    return {name: kind for part in ("fixtures", "objects") for kind, names in problem[part].items() for name in names}


def movables(problem: Problem) -> list[str]:
    """Return the names of things that can be carried."""
    return [name for names in problem["objects"].values() for name in names]


def swapped(problem: Problem, rng: Any) -> Problem:
    """Return a problem whose things have swapped their places; at least one now stands where one of another kind stood.

    Args:
        rng: ``numpy.random.Generator``.
    """
    found, things, kind = deepcopy(problem), movables(problem), kinds(problem)
    rows = [row for row in found["initial_state"] if row[0] == "on" and row[1] in things]
    stood = [row[2] for row in rows]
    if len({kind[row[1]] for row in rows}) < 2:
        return found
    order = list(range(len(rows)))
    while all(kind[rows[k][1]] == kind[rows[order[k]][1]] for k in range(len(rows))):
        order = [int(k) for k in rng.permutation(len(rows))]
    for row, k in zip(rows, order, strict=True):
        row[2] = stood[k]
    return found


def replaced(problem: Problem, rng: Any, library: Sequence[str]) -> Problem:
    """Return a problem in which some things, at least one, are replaced by others of a library.

    Args:
        rng: ``numpy.random.Generator``.
        library: kinds of things.
    """
    things, kind = movables(problem), kinds(problem)
    chosen = [t for t in things if rng.random() < 0.5] or [things[rng.integers(len(things))]]
    new = {t: kind[t] for t in things}
    for thing in chosen:
        others = [k for k in library if k != kind[thing]]
        new[thing] = others[rng.integers(len(others))]
    return _renamed(problem, new)


def _renamed(problem: Problem, new: Mapping[str, str]) -> Problem:
    """Variant of LIBERO's planning problem in which things have other kinds, and names made of those kinds."""
    found, count, name = deepcopy(problem), dict[str, int](), dict[str, str]()
    for thing, kind in new.items():
        count[kind] = count.get(kind, 0) + 1
        name[thing] = f"{kind}_{count[kind]}"
    found["objects"] = {k: [name[t] for t, of in new.items() if of == k] for k in dict.fromkeys(new.values())}
    found["initial_state"] = [[row[0], *(name.get(n, n) for n in row[1:])] for row in found["initial_state"]]
    gone = {t for t in new if name[t] != t}
    found["regions"] = {k: r for k, r in found["regions"].items() if r["target"] not in gone or r["ranges"]}
    return found


def pinned(problem: Problem, rng: Any) -> Problem:
    """Return a problem with fixed positions of its fixtures, drawn within the regions from which each
    reset would draw them."""
    found, things = deepcopy(problem), movables(problem)
    for row in found["initial_state"]:
        region = found["regions"].get(row[-1])
        if row[0] == "on" and row[1] not in things and region is not None and region["ranges"]:
            x0, y0, x1, y1 = region["ranges"][0]
            x, y = rng.uniform(x0, x1), rng.uniform(y0, y1)
            region["ranges"] = [[x - WIDTH, y - WIDTH, x + WIDTH, y + WIDTH]]
    return found


def with_sites(problem: Problem, sites: Mapping[str, Sequence[str]]) -> Problem:
    """Return a problem that also declares the regions that the models of its things have.

    Args:
        sites: kind -> names of the regions that its model has.
    """
    found = deepcopy(problem)
    for name, kind in kinds(problem).items():
        for site in sites.get(kind, ()):
            found["regions"].setdefault(f"{name}_{site}", {"target": name, "ranges": [], "yaw_rotation": [0, 0]})
    return found


def text(problem: Problem, language: str) -> str:
    """Write a problem as a problem file (BDDL)."""
    parts = [f"(define (problem {problem['problem_name']})", "  (:domain robosuite)", f"  (:language {language})"]
    parts += ["  (:regions", *(_region(k, r) for k, r in problem["regions"].items()), "  )"]
    for part in ("fixtures", "objects"):
        parts += [f"  (:{part}", *(f"    {' '.join(names)} - {kind}" for kind, names in problem[part].items()), "  )"]
    parts += [f"  (:obj_of_interest {' '.join(problem['obj_of_interest'])})"]
    parts += ["  (:init", *(f"    ({' '.join(row)})" for row in problem["initial_state"]), "  )"]
    parts += [f"  (:goal (And {' '.join(f'({chr(32).join(p)})' for p in problem['goal_state'])}))", ")"]
    return "\n".join(parts) + "\n"


def _region(key: str, region: Mapping[str, Any]) -> str:
    target = region["target"]
    said = f"    ({key.removeprefix(f'{target}_')} (:target {target})"
    if region["ranges"]:
        said += f" (:ranges ({' '.join(f'({_numbers(r)})' for r in region['ranges'])}))"
        said += f" (:yaw_rotation (({_numbers(region['yaw_rotation'])})))"
    return said + ")"


def _numbers(values: Sequence[float]) -> str:
    return " ".join(f"{v:.17g}" for v in values)
