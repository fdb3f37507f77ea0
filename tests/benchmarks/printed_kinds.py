"""Kinds with a print in one noisy depth image: which, where and how turned, among all kinds of a library.

Scenes are drawn: things of a library stand on a table in attitudes that their shapes allow, and a camera some 1.1 m away
sees them, rendered here from the library's own meshes with noise of 1.5 mm at 1 m. LIBERO's library is made before by
``cramlite library add`` of its assets' folders ``stable_hope_objects``, ``stable_scanned_objects`` and ``turbosquid_objects``.

    OMP_NUM_THREADS=1 python tests/benchmarks/printed_kinds.py LIB [LIB ...] --scenes 20 --leave-out 'red_*'
"""

from __future__ import annotations

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")

import argparse
import math
import time
from dataclasses import dataclass
from fnmatch import fnmatchcase
from pathlib import Path

import numpy as np
from figure import add_figure, rate, value, write
from msgspec.structs import replace

from cramlite import Engine
from cramlite.experiment.figure import Number
from cramlite.model import Intrinsics, Pose, Thing, View, World
from cramlite.perception.active_perception import ask
from cramlite.perception.query import parse_query
from cramlite.plugin import UNKNOWN
from cramlite_plugins.objects.products_and_fixtures import make
from cramlite_plugins.perception.kinds.appearance import Appearance, appearance_of
from cramlite_plugins.simulation.camera.depth_camera import render
from cramlite_plugins.simulation.camera.noise import Noise
from cramlite_plugins.simulation.camera.skins import skins_of
from cramlite_plugins.simulation.model.compile import compile_world

FIRST = 1000
THINGS = 7
LARGEST = 0.30
AREA = ((0.30, 0.70), (-0.30, 0.30))
EYE, TARGET = (1.45, 0.0, 0.72), (0.45, 0.0, 0.02)
SIZE, FOCAL = 512, 618.0
NOISE = Noise(disparity=0.029, millimetres=True)
SAME = 0.06
GAP = 0.012


@dataclass(frozen=True)
class Outcome:
    """Outcome for one thing: whether its kind is right, its errors [m], [rad], and whether its print is the right way round."""

    kind: str
    right: bool
    metres: float
    angle: float
    printed: float
    said: str


def drawn(seed: int, known: list[Appearance]) -> list[Thing]:
    """Things of a scene: kinds, attitudes, yaws and places without overlap."""
    rng = np.random.default_rng(seed)
    small = [a for a in known if float(a.surface.extents.max()) < LARGEST]
    placed: list[tuple[np.ndarray, float]] = []
    found = []
    for k in rng.permutation(len(small)):
        a = small[int(k)]
        up = np.array(a.up[int(rng.integers(len(a.up)))])
        turn = Pose.from_axes((0, 0, 0), up, np.eye(3)[int(np.abs(up).argmin())]).inverse()
        pose = Pose.from_rotvec((0, 0, 0), (0, 0, float(rng.uniform(0, 2 * math.pi)))) * turn
        points = pose.apply(a.surface.points)
        middle, radius = (points.min(0) + points.max(0)) / 2, float(np.linalg.norm(np.ptp(points[:, :2], axis=0)) / 2)
        for _ in range(60):
            at = np.array([rng.uniform(*AREA[0]), rng.uniform(*AREA[1])])
            if all(np.linalg.norm(at - p) > radius + r + GAP for p, r in placed):
                placed.append((at, radius))
                place = Pose((float(at[0] - middle[0]), float(at[1] - middle[1]), -float(points[:, 2].min())))
                found.append(replace(a.model, name=f"thing_{len(found)}_{a.model.name}", pose=place * pose))
                break
        if len(found) == THINGS:
            break
    return found


def pictured(seed: int, things: list[Thing]) -> View:
    """The camera's view of a scene."""
    compiled = compile_world(World((make("table", "table", Pose((0.5, 0, 0)), {}), *things)), {})
    forward = np.subtract(TARGET, EYE)
    camera = Pose.from_axes(EYE, forward, np.cross(forward, (0, 0, 1)))
    intrinsics = Intrinsics(FOCAL, FOCAL, (SIZE - 1) / 2, (SIZE - 1) / 2, SIZE, SIZE)
    data = compiled.data()
    import mujoco

    mujoco.mj_forward(compiled.model, data)
    view, _ = render(compiled.model, data, camera, intrinsics, NOISE, seed, skins=skins_of(tuple(things), compiled.things))
    return view


def judged(things: list[Thing], known: dict[str, Appearance], percepts: list[tuple[str, Pose]]) -> tuple[list[Outcome], int]:
    """Each thing with the nearest percept within ``SAME``; and how many percepts are of nothing."""
    left = list(percepts)
    found = []
    for thing in things:
        kind = thing.name.split("_", 2)[2]
        own = known[kind].surface
        centre = thing.pose.apply(own.centre)
        near = [(float(np.linalg.norm(p.apply(known[m].surface.centre) - centre)), i) for i, (m, p) in enumerate(left)]
        away, i = min(near, default=(math.inf, -1))
        if away > SAME:
            found.append(Outcome(kind, False, math.nan, math.nan, math.nan, "nothing"))
            continue
        model, pose = left.pop(i)
        right = model == kind
        metres, angle = own.difference(pose, thing.pose) if right else (math.nan, math.nan)
        found.append(Outcome(kind, right, metres, angle, pose.distance(thing.pose)[1] if right else math.nan, model))
    return found, len(left)


@dataclass(frozen=True)
class Measured:
    """Outcomes of all scenes, CPU time of each [s], and how many percepts were of nothing."""

    outcomes: list[Outcome]
    seconds: list[float]
    extra: int


def measured(engine: Engine, products: list[Thing], looks: list[Appearance], seeds: range, *, verbose: bool) -> Measured:
    """Draw a scene for each seed, ask what it shows, and compare."""
    known, printed = {a.model.name: a for a in looks}, [a for a in looks if a.printed]
    query = replace(parse_query("", engine.knowledge.taxonomy, engine.knowledge.experts), wanted=("type", "pose", "model"))
    outcomes: list[Outcome] = []
    seconds, extra = list[float](), 0
    for seed in seeds:
        things = drawn(seed, printed)
        view = pictured(seed, things)
        begin = time.process_time()
        found = ask(query, view, (), engine.knowledge, models=tuple(products))
        seconds.append(time.process_time() - begin)
        percepts = [(p.value("model"), p.value("pose")) for p in found.answers
                    if p.value("type") != UNKNOWN and p.value("model") and p.value("pose")]  # fmt: skip
        here, more = judged(things, known, percepts)
        outcomes += here
        extra += more
        if verbose:
            print(f"seed {seed}: {seconds[-1]:.1f} s, {sum(o.right for o in here)} of {len(here)}, {more} false")
            for o in here:
                if not o.right or o.metres > 0.005 or o.angle > 0.1:
                    print(f"  {o.kind}: {o.said} {1000 * o.metres:.1f} mm {math.degrees(o.angle):.1f} deg")
    return Measured(outcomes, seconds, extra)


def numbers_of(found: Measured, known: dict[str, Appearance]) -> tuple[Number, ...]:
    """Return rates of kinds, errors of poses and CPU times."""
    right = [o for o in found.outcomes if o.right]
    millimetres = 1000 * np.array([o.metres for o in right])
    degrees = np.degrees([o.angle for o in right])
    whole = np.degrees([o.printed for o in right if known[o.kind].surface.axis is None])
    return (
        rate("kinds", len(right), len(found.outcomes), f"right kind and place, among {len(known)}"),
        value("kinds", found.extra, "", "seen where nothing is"),
        value("poses", float(np.median(millimetres)), "mm", "position, median"),
        value("poses", float(np.percentile(millimetres, 95)), "mm", "position, 95 %"),
        value("poses", float(np.median(degrees)), "deg", "turned off, median, modulo the shape's symmetries"),
        value("poses", float(np.percentile(degrees, 95)), "deg", "turned off, 95 %, modulo the shape's symmetries"),
        rate("poses", int((whole < 10).sum()), len(whole), "print the right way round, of what is not round (10 deg)"),
        value("CPU", float(np.median(found.seconds)), "s", "a scene, median"),
        value("CPU", float(np.percentile(found.seconds, 95)), "s", "a scene, 95 %"),
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("libraries", nargs="+", type=Path)
    parser.add_argument("--scenes", type=int, default=20)
    parser.add_argument("--first", type=int, default=FIRST)
    parser.add_argument("--leave-out", action="append", default=[])
    parser.add_argument("--verbose", action="store_true")
    add_figure(parser)
    arguments = parser.parse_args()
    engine = Engine(models=arguments.libraries)
    products = [p for p in engine.knowledge.products if not any(fnmatchcase(p.name, o) for o in arguments.leave_out)]
    looks = [appearance_of(p) for p in products]
    for a in looks:
        _ = a.surface.grid, a.surface.opposite_points
    seeds = range(arguments.first, arguments.first + arguments.scenes)
    found = measured(engine, products, looks, seeds, verbose=arguments.verbose)
    numbers = numbers_of(found, {a.model.name: a for a in looks})
    for n in numbers:
        print(n)
    write(arguments, numbers, f"from {arguments.first}: {arguments.scenes} scenes")


if __name__ == "__main__":
    main()
