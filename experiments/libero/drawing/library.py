"""Library of LIBERO: the scenes of libero_90, the goals of its 130 tasks, kinds of things and their regions.

It runs in the benchmark's environment.
"""

from __future__ import annotations

import re
from collections import Counter
from functools import lru_cache
from pathlib import Path
from typing import Any

from drawn_goals import Literal, signature
from libero.libero import get_libero_path
from libero.libero.envs import bddl_utils
from libero.libero.envs.objects import OBJECTS_DICT
from variants import Problem, kinds

SUITES = ("libero_spatial", "libero_object", "libero_goal", "libero_10", "libero_90")
"""Suites of the 130 tasks."""
SCENE = re.compile(r"(.*_SCENE\d+)_")


def parsed(path: Path) -> Problem:
    """Read a problem file."""
    found: Problem = bddl_utils.robosuite_parse_problem(str(path))
    return found


def files(suite: str) -> list[Path]:
    """Return the problem files of a suite."""
    return sorted((Path(get_libero_path("bddl_files")) / suite).glob("*.bddl"))


@lru_cache(maxsize=1)
def scenes() -> dict[str, Problem]:
    """Return the scenes of libero_90; the problem files of a scene differ in nothing but the goal."""
    found = dict[str, Problem]()
    for path in files("libero_90"):
        match = SCENE.match(path.name)
        assert match is not None
        found.setdefault(match.group(1), parsed(path))
    return dict(sorted(found.items()))


@lru_cache(maxsize=1)
def tasks() -> tuple[Problem, ...]:
    """Return the problems of the 130 tasks."""
    return tuple(parsed(path) for suite in SUITES for path in files(suite))


def name_of_kind(problem: Problem, name: str) -> str:
    """Return a thing's or a region's name without the numbers of instances."""
    kind, region = kinds(problem), problem["regions"].get(name)
    if region is None:
        return kind.get(name, name)
    target = region["target"]
    return f"{kind.get(target, target)}/{name.removeprefix(f'{target}_')}"


@lru_cache(maxsize=1)
def known_goals() -> frozenset[frozenset[Literal]]:
    """Return the goals of LIBERO's 130 tasks, with things named by their kinds."""
    return frozenset(signature(map(tuple, p["goal_state"]), lambda n, p=p: name_of_kind(p, n)) for p in tasks())  # type: ignore[misc]


@lru_cache(maxsize=1)
def predicates_of_sites() -> dict[str, str]:
    """Return for each region of a thing, such as "basket/contain_region", whether the 130 problem files use
    it with "on" or with "in"."""
    found: dict[str, Counter[str]] = {}
    for problem in tasks():
        for row in (*problem["goal_state"], *problem["initial_state"]):
            if len(row) == 3 and row[2] in problem["regions"] and not problem["regions"][row[2]]["ranges"]:
                found.setdefault(name_of_kind(problem, row[2]), Counter())[row[0].lower()] += 1
    return {name: count.most_common(1)[0][0] for name, count in sorted(found.items())}


@lru_cache(maxsize=1)
def library() -> tuple[str, ...]:
    """Return the kinds of movable things in LIBERO's problem files, as far as LIBERO has models of them."""
    folder = Path(get_libero_path("bddl_files"))
    text = (path.read_text(encoding="utf-8") for path in sorted(folder.glob("*/*.bddl")))
    named = {kind for t in text for part in re.findall(r"\(:objects(.*?)\)", t, re.DOTALL) for kind in re.findall(r"-\s+(\S+)", part)}
    return tuple(sorted(kind for kind in named if kind in OBJECTS_DICT and _loads(kind)))


def _loads(kind: str) -> bool:
    try:
        OBJECTS_DICT[kind](name="x")
    except FileNotFoundError:  # the package names it, and has no model of it
        return False
    return True


def region_names(kind: str) -> list[str]:
    """Return the regions that the model of a kind has, as LIBERO finds them."""
    made: Any = OBJECTS_DICT[kind](name="x_1")
    found = dict[str, None]()
    for part in made.worldbody.find("body").findall(".//body"):
        sites = part.findall(".//site")
        if not sites:
            break
        found |= dict.fromkeys(s.get("name").removeprefix("x_1_") for s in sites)
    return [name for name in found if name.endswith(("_region", "_side"))]
