"""Queries about clutter: six products of four types on three hangers, two on each, seen from aside and above.

For each thing that a query can single out (its class and its hanger) and of which at least half is visible, the query is
asked: is the right instance the first answer, and is its pose within 5 degrees and 5 mm? CPU time is of the process.
Seeds were chosen before the first run: development used 0 to 99, the reported figure uses those from 1000.

    python tests/benchmarks/clutter.py --first 1000 --count 50
"""

from __future__ import annotations

import argparse
import math
import time
from collections.abc import Iterator
from typing import Any

import numpy as np
from figure import add_figure, rate, value, write

from cramlite import Engine
from cramlite.base.rate import wilson_interval
from cramlite.model import Pose, Thing, Value, View, World, replace
from cramlite.perception.active_perception import ask
from cramlite.perception.query import parse_query

SPACING, HEIGHT, AWAY = 0.16, 0.45, 0.87  # between hangers, of the pegs, from the origin to the panel [m]
DEPTHS = (0.035, 0.105)  # along the peg: behind and in front [m]
EYE, JITTER = (0.40, -0.36, 0.60), 0.06  # of the camera [m]


class Sample(Value):
    """A view and the truth.

    Args:
        view: what experts get.
        fixtures: things whose poses are known.
        world: as it is.
        ids: name of the thing that each pixel shows, "" for none.
    """

    view: View
    fixtures: tuple[Thing, ...]
    world: World
    ids: Any

    whole: dict[str, int]

    def visible(self, name: str) -> float:
        """Share of the pixels that a thing would have if nothing hid it."""
        return float((self.ids == name).sum()) / max(1, self.whole[name])


def clutter(seed: int, products: tuple[Thing, ...], *, noise: bool = True, rename: bool = False) -> Sample:
    """A scene and its picture.

    Args:
        products: of which four are drawn; six things hang.
        rename: call the things otherwise; no answer may change.
    """
    from cramlite_plugins.locations.viewpoints import looking_at
    from cramlite_plugins.objects.products_and_fixtures import hanger, hung, table

    rng = np.random.default_rng([seed, 411])
    kinds = [products[k] for k in rng.permutation(len(products))[:4]]
    chosen = [kinds[k] for k in rng.permutation([0, 1, 2, 3, *rng.integers(0, 4, 2)])]
    floor = table("floor", Pose((0.4, 0, 0)), size=(1.6, 1.6, 0.02))
    turn = Pose.from_rotvec((0, 0, 0), (0, 0, math.pi))
    hangers = tuple(
        hanger(f"hook_{k}", Pose((AWAY, (k - 1) * SPACING, HEIGHT), turn.quaternion), wall=(SPACING, 0.4, 0.01))
        for k in range(3)
    )
    things = []
    for k, kind in enumerate(chosen):
        thing = replace(kind, name=f"x{(7 * k + 3) % 11}" if rename else f"product_{k}")
        depth = DEPTHS[k // 3] + float(rng.uniform(-0.006, 0.006))
        things.append(replace(thing, pose=hung(thing, hangers[k % 3], depth, float(rng.uniform(-0.15, 0.15)))))
    world = World((floor, *hangers, *things))
    eye = np.array(EYE) + rng.uniform(-JITTER, JITTER, 3)
    target = np.array([AWAY - 0.07, 0.0, HEIGHT - 0.07]) + rng.uniform(-0.02, 0.02, 3)
    camera = looking_at(tuple(eye), tuple(target))
    view, ids = _picture(world, camera, seed, noise=noise)
    whole = {t.name: int((_picture(World((t,)), camera, seed, noise=False)[1] == t.name).sum()) for t in things}
    return Sample(view, (floor, *hangers), world, ids, whole)


def _picture(world: World, camera: Pose, seed: int, *, noise: bool) -> tuple[View, Any]:
    """The view, and the name of the thing that each pixel shows."""
    from cramlite_plugins.simulation.camera.depth_camera import render
    from cramlite_plugins.simulation.camera.noise import Noise
    from cramlite_plugins.simulation.model.compile import compile_world

    compiled = compile_world(world, {})
    view, bodies = render(compiled.model, compiled.data(), camera, noise=Noise() if noise else None, seed=seed)
    names = np.array(["", *(compiled.model.body(b).name for b in range(compiled.model.nbody))])
    return view, names[bodies + 1]


class Row(Value):
    """One query: whether the first answer is the right thing, the error of its pose, and the CPU time [s]."""

    seed: int
    query: str
    right: bool
    metres: float
    radians: float
    seconds: float
    frame: float
    confidence: float

    @property
    def good(self) -> bool:
        return self.right and self.metres < 0.005 and self.radians < math.radians(5)


def rows(seed: int, engine: Engine) -> Iterator[Row]:
    """Every query that singles out one thing of a scene."""
    knowledge = engine.knowledge
    sample = clutter(seed, knowledge.products)
    movable = [t for t in sample.world.things if t.movable]
    places = [(t.type, f"hook_{k % 3}") for k, t in enumerate(movable)]
    for thing, (kind, hook) in zip(movable, places, strict=True):
        if places.count((kind, hook)) > 1 or sample.visible(thing.name) < 0.5:
            continue
        text = f"type={kind} on={hook}"
        begin = time.process_time()
        found = ask(parse_query(text, knowledge.taxonomy, knowledge.experts), sample.view, sample.fixtures, knowledge)
        spent = time.process_time() - begin
        frame = sum(r.ms for r in found.runs if r.expert != "registration") / 1000
        if not found.answers:
            yield Row(seed, text, False, math.inf, math.inf, spent, frame, 0.0)
            continue
        first = found.answers[0]
        names, counts = np.unique(sample.ids[first.value("segment").mask], return_counts=True)
        pose = first.value("pose")
        metres, radians = pose.distance(thing.pose) if pose else (math.inf, math.inf)
        right = names[counts.argmax()] == thing.name
        yield Row(seed, text, bool(right), metres, radians, spent, frame, first.confidence)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--first", type=int, default=1000)
    parser.add_argument("--count", type=int, default=50)
    add_figure(parser)
    arguments = parser.parse_args()
    engine, found, numbers = Engine(), [], []
    seeds = range(arguments.first, arguments.first + arguments.count)
    for seed in seeds:
        for row in rows(seed, engine):
            found.append(row)
            if not row.good:
                off = f"{1000 * row.metres:.1f} mm, {math.degrees(row.radians):.1f} deg"
                print(f"{row.seed} {row.query}: right {row.right}, {off}, confidence {row.confidence:.2f}", flush=True)
    for name, count in (("right instance", sum(r.right for r in found)), ("and pose", sum(r.good for r in found))):
        numbers.append(rate(name, count, len(found)))
        low, high = wilson_interval(count, len(found))
        print(f"{name}: {count} of {len(found)}, {count / len(found):.3f}, 95 % interval {low:.3f} to {high:.3f}")
    for name, values in (("query", [r.seconds for r in found]), ("without registration", [r.frame for r in found])):
        middle, high = np.percentile(values, (50, 95))
        numbers += [value(f"CPU time, {name}", 1000 * middle, "ms", "median"), value(f"CPU time, {name}", 1000 * high, "ms", "95 %")]
        print(f"CPU time, {name}: median {1000 * middle:.0f} ms, 95 % below {1000 * high:.0f} ms")
    write(arguments, numbers, seeds)


if __name__ == "__main__":
    main()
