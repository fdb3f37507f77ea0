"""Cases of LIBERO-MAX with their controls, and SafeLIBERO, in a fixed order that a seed draws: docs/how-to/libero.md.

    CRAMLITE_LIBERO_MAX=... CRAMLITE_SAFELIBERO=... python tests/benchmarks/changed_scenes.py --out RUN [--end] [--most 24] [--camera]

Rounds of one case of each family of physical changes, one changed instruction and one scene with an obstacle, each changed case followed by
its control. It may be stopped at any time: the same command plays what is missing, ``--most 0`` plays nothing, and the tables are of what
there is. ``--end`` plays what is kept for the end. ``--camera`` plays by camera and sentence, with changes of light and camera, without
distractors and SafeLIBERO. Only the draw reads the manifests' families; the processes that plan see no manifest.
"""

from __future__ import annotations

import argparse
import itertools
import random
import sys
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from figure import add_figure, rate, value, write
from msgspec import json

from cramlite.experiment.benchmark.results import EpisodeResult
from cramlite.experiment.benchmark.spec import Episode, read_benchmark
from cramlite.experiment.benchmark.trials import Episodes
from cramlite.experiment.figure import Number
from cramlite.experiment.order import Order
from cramlite.experiment.run import run_experiment, speak

LIBERO = Path(__file__).parents[2] / "experiments" / "libero"
SUITES = ("spatial", "object", "goal", "10")
SAFE_SUITES = ("spatial", "object", "goal", "long")
LEVELS, SAFE_TASKS = (1, 2), 2
SAFE_STATES = {False: range(5), True: range(10, 13)}
"""States of SafeLIBERO for development, and for the end."""
CONTROL, CHANGED = 0, 1
"""States of a suite of changes."""
NOT_BY_CAMERA = {"distractor_burst"}
"""Families that are not drawn by camera."""
INTENT = {"instruction_target_update", "instruction_receptacle_update", "task_cancel"}
"""Families in which nothing physical changes."""
KINDS = ("physical", "asked", "safe")
"""Kinds of episodes: something physical changes, another thing or nothing more is asked for, an obstacle may not be moved."""
PERIOD = 0.05
"""Of an action [s]."""
Families = Mapping[str, Sequence[tuple[Episode, str]]]
"""Family -> its changed episodes, each with what its control is the same by: task and things that are away."""


@lru_cache(maxsize=1)
def _changes() -> Any:
    """The benchmark's module of changes."""
    sys.path[:0] = [str(LIBERO.parent), str(LIBERO)]
    import changes

    return changes


def families(*, end: bool, camera: bool = False) -> Families:
    """Return all cases of one part of LIBERO-MAX, by the family of their change."""
    found = defaultdict[str, list[tuple[Episode, str]]](list)
    for kind, name in itertools.product(("seen_" if camera else "", "intent_"), SUITES):
        suite = f"libero_max_{kind}{name}{'_end' if end else ''}"
        for number, case in enumerate(_changes().cases(suite)):
            setup = json.encode(case["scenario"].get("setup", [])).decode()
            same = f"{kind}{case['task_suite_name']} {case['task_index']} {setup}"
            found[case["scenario"]["change_type"]].append((Episode(suite, number, CHANGED), same))
    return {family: cases for family, cases in found.items() if not (camera and family in NOT_BY_CAMERA)}


def kind_of(episode: Episode) -> str:
    """Return an episode's kind, of ``KINDS``."""
    return "safe" if episode.suite.startswith("safe") else "asked" if "intent" in episode.suite else "physical"


def safe(*, end: bool) -> list[Episode]:
    """Return the scenes of SafeLIBERO of one part."""
    where = itertools.product(SAFE_STATES[end], SAFE_SUITES, LEVELS, range(SAFE_TASKS))
    return [Episode(f"safelibero_{s}_{level}", task, state) for state, s, level, task in where]


def order(groups: Families, scenes: Sequence[Episode], seed: int) -> Iterator[Episode]:
    """Yield all episodes, each once: rounds over the families, in each of which suites take turns; controls after their cases."""
    draw, controls = random.Random(seed), set[str]()
    physical = [_shuffled(groups[f], draw) for f in sorted(groups) if f not in INTENT]
    asked = _shuffled([c for f in sorted(groups) if f in INTENT for c in groups[f]], draw)
    drawn = _shuffled([(s, "") for s in scenes], draw)
    for round_ in itertools.zip_longest(*physical, asked, drawn):
        for episode, same in (c for c in round_ if c is not None):
            yield episode
            if same and same not in controls:
                controls.add(same)
                yield Episode(episode.suite, episode.task, CONTROL)


def _shuffled(cases: Sequence[tuple[Episode, str]], draw: random.Random) -> list[tuple[Episode, str]]:
    """Cases in a drawn order in which suites take turns."""
    by_suite = defaultdict[str, list[tuple[Episode, str]]](list)
    for case in cases:
        by_suite[case[0].suite].append(case)
    rows = list(by_suite.values())
    for row in rows:
        draw.shuffle(row)
    draw.shuffle(rows)
    return [case for turn in itertools.zip_longest(*rows) for case in turn if case is not None]


Results = Mapping[Episode, EpisodeResult]


def numbers(groups: Families, scenes: Iterable[Episode], results: Results) -> list[Number]:
    """Print the table, and return the numbers of a figure: rates of played cases by family, changed and control.

    Episodes whose benchmark died count in no rate.
    """
    results = {e: r for e, r in results.items() if not r.apart}
    same_of = {case: same for cases in groups.values() for case, same in cases}
    controls = {same_of[Episode(e.suite, e.task, CHANGED)]: r for e, r in results.items() if e.state == CONTROL and "max" in e.suite}
    found, whole = list[Number](), list[tuple[EpisodeResult, EpisodeResult | None]]()
    for family in sorted(groups):
        pairs = [(results[c], controls.get(same)) for c, same in groups[family] if c in results]
        found += _family(family, pairs)
        whole += [] if family in INTENT else pairs
    found += _family("all physical changes", whole)
    found += _noticing([r for r in results.values() if r.attempt])
    played = [results[s] for s in scenes if s in results]
    if played:
        avoided = [r.attempt is not None and bool(r.attempt.avoided) for r in played]
        found += [rate("SafeLIBERO", sum(r.rest() for r in played), len(played), "changed, true at rest")]
        found += [rate("SafeLIBERO", sum(avoided), len(played), "avoided, and played")]
        found += [rate("SafeLIBERO", sum(r.rest() and a for r, a in zip(played, avoided, strict=True)), len(played), "both")]
    for one in found:
        print(f"| {one.what} | {one.part} | {f'{one.hits} of {one.of}' if one.of else f'{one.value:g} {one.unit}'} |")
    return found


def _family(name: str, pairs: Sequence[tuple[EpisodeResult, EpisodeResult | None]]) -> list[Number]:
    if not pairs:
        return []
    both = [(c, k) for c, k in pairs if k is not None]
    reached = [c for c, _ in pairs if c.attempt is not None and c.attempt.changed is not None]
    columns = {
        "changed, true at rest": (sum(c.rest() for c, _ in pairs), len(pairs)),
        "time passes": (sum(c.rest_while_time_passes() for c, _ in pairs), len(pairs)),
        "control": (sum(k.rest() for _, k in both), len(both)),
        "lost where the control is true": (sum(k.rest() and not c.rest() for c, k in both), len(both)),
        "change came": (len(reached), len(pairs)),
    }
    return [rate(name, hits, of, part) for part, (hits, of) in columns.items() if of]


def _noticing(results: Sequence[EpisodeResult]) -> list[Number]:
    """Return the times that noticing and thinking took, and what was noticed without a cause."""
    still = [r for r in results if "max" in r.suite and r.state == CONTROL and r.attempt]
    alarms = sum(bool(r.attempt.notices) for r in still if r.attempt)
    found = [rate("controls in which something was noticed", alarms, len(still))] if still else []
    came = [r.attempt for r in results if r.attempt and r.attempt.changed is not None and r.attempt.notices]
    first = [a.notices[0].time - PERIOD * (a.changed or 0) for a in came]
    thought = [t for r in results if r.attempt for t in r.attempt.thought]
    for what, times in (("from change to notice, simulated", first), ("from notice to the next program, CPU", thought)):
        if times:
            found += [value(what, float(np.quantile(times, q)), "s", part) for q, part in ((0.5, "median"), (0.95, "95 %"))]
    return found


def main() -> None:
    """Play what is missing, and print the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--end", action="store_true", help="what is kept for the end")
    parser.add_argument("--camera", action="store_true", help="by camera and sentence")
    parser.add_argument("--no-controls", action="store_true", help="changed cases alone")
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument("--seed", type=int, default=0, help="of the order")
    parser.add_argument("--first", type=int, default=0, help="episodes of the order that are left out, as they were played before")
    parser.add_argument("--most", type=int, help="episodes of the order, those left out included; all of them if left out")
    parser.add_argument("--only", nargs="+", choices=KINDS, default=KINDS, help="kinds of episodes, controls with their cases")
    add_figure(parser)
    asked = parser.parse_args()
    groups, scenes = families(end=asked.end, camera=asked.camera), [] if asked.camera else safe(end=asked.end)
    wanted = (e for e in order(groups, scenes, asked.seed) if not (asked.no_controls and e.state == CONTROL and "max" in e.suite))
    drawn = itertools.islice(wanted, asked.first, asked.most)
    chosen = tuple(e for e in drawn if kind_of(e) in asked.only)
    trials = Episodes(read_benchmark(LIBERO / ("camera.yaml" if asked.camera else "experiment.yaml")), chosen, pictures=False)
    results = {Episode.named(n): r for n, r in run_experiment(Order(trials, asked.out, asked.workers), speak).items()}
    said = f"seed {asked.seed} draws the order; {'kept for the end' if asked.end else 'for development'}: {len(results)} episodes"
    write(asked, numbers(groups, scenes, results), said, sum(sum(r.seconds.values()) for r in results.values()))


if __name__ == "__main__":
    main()
