"""Generated views for perception_pose.py: a product that hangs on a hanger, seen from a random place, with noise.

EASY: nothing in front but its own peg, visibility over .9. HARD: a rod or a board in front, visibility .6 to .85.
The mask is the simulator's, eroded by a pixel, as it is, or dilated by one or two: no segmentation is that good or worse.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Any

import numpy as np
from scipy import ndimage

from cramlite import Engine, data_folder, read_scenario
from cramlite.model import D435, Feature, Geom, Intrinsics, Mask, Pose, Thing, Value, View, World, replace
from cramlite_plugins.locations.viewpoints import looking_at
from cramlite_plugins.objects.products_and_fixtures import hanger, hung, product, table
from cramlite_plugins.perception.pose.model import PoseModel, pose_model
from cramlite_plugins.simulation.camera.depth_camera import render
from cramlite_plugins.simulation.model.compile import Compiled, compile_world

DEVELOPMENT, TEST = 0, 20_000
"""First seeds. Whatever has a number in it was chosen on the development seeds. A first version was tested on seeds from
10,000 on, and then changed; docs/figures/perception_pose.yaml says whether the test seeds from 20,000 on had been run."""
SMALL = Intrinsics(D435.fx / 4, D435.fy / 4, 79.5, 59.5, 160, 120)
EASY, HARD = (0.9, 1.01), (0.6, 0.85)
SIZES = {"slim": (0.04, 0.025, 0.15), "carton": (0.06, 0.05, 0.10), "flat": (0.08, 0.02, 0.12)}


class Sample(Value, eq=False):
    """A view with its truth."""

    seed: int
    product: str
    view: View
    mask: Mask
    truth: Pose
    visibility: float


@lru_cache(maxsize=1)
def products() -> dict[str, Thing]:
    """The three boxes with the tab in the middle and at the back, and what hangs in the shipped scenarios."""
    found = {}
    for name, size in SIZES.items():
        found[name] = product("it", Pose(), size, hole_diameter=0.010)
        found[f"{name}_back"] = _tab_at_the_back(found[name], size[1])
    makers = Engine().knowledge.models
    for scenario in ("fetch_from_hanger", "hang_onto_hanger"):
        spec = read_scenario(data_folder("scenarios") / f"{scenario}.yaml").spec
        for thing in spec.things:
            if thing.model == "boxed_product":
                made = makers[thing.model].make(name="it", pose=Pose(), **thing.parameters)
                found[f"{scenario}/{thing.name}"] = replace(made, type=thing.type or made.type)
    return found


@lru_cache(maxsize=32)
def model_of(name: str) -> PoseModel:
    return pose_model(products()[name])


def sample(seed: int, hard: bool) -> Sample:
    """The view of a seed."""
    rng = np.random.default_rng([seed, int(hard), 99])
    names = list(products())
    name = names[int(rng.integers(len(names)))]
    wanted = HARD if hard else EASY
    while True:
        thing, others, camera = _placed(products()[name], rng)
        alone = _count(_world([thing]), camera)
        if hard:
            others = [*others, _occluder(camera, thing, rng)]
        visibility = _count(_world([thing, *others]), camera) / max(alone, 1)
        if alone > 60 and wanted[0] <= visibility <= wanted[1]:
            break
    compiled = _world([thing, *others])
    view, ids = render(compiled.model, compiled.data(), camera, seed=seed)
    return Sample(seed, name, view, _mask(ids == compiled.things["it"].body, rng), thing.pose, visibility)


def _tab_at_the_back(thing: Thing, depth: float) -> Thing:
    off = Pose((0.0, depth / 2 - 0.001, 0.0))
    geoms = tuple(replace(g, pose=off * g.pose) if g.part == "hole" else g for g in thing.geoms)
    features = tuple(replace(f, pose=off * f.pose) if f.type == "vrps:Hole" else f for f in thing.features)
    return replace(thing, geoms=geoms, features=features)


def _placed(thing: Thing, rng: Any) -> tuple[Thing, list[Thing], Pose]:
    """On a hanger, swung about the peg and turned a little; a camera 0.35 to 0.65 m away, up to 60 degrees aside."""
    hook = hanger("hook", Pose((0.87, 0.0, 0.45), (0, 0, 0, 1)))
    pose = hung(thing, hook, float(rng.uniform(0.04, 0.12)), float(rng.uniform(-0.35, 0.35)))
    if rng.random() < 0.5:
        pose = pose * Pose.from_rotvec((0, 0, 0), (0, 0, math.pi))  # hung the other way round: front to the wall
        hole = thing.feature("vrps:Hole")
        assert isinstance(hole, Feature)
        at = hook.pose * hook.features[0].pose * Pose((0, 0, 0.08))
        pose = Pose(
            tuple(np.add(pose.position, np.subtract(at.position, (pose * hole.pose).position))), pose.quaternion
        )
    swing = Pose.from_rotvec((0, 0, 0), rng.normal(0, np.radians([4, 6, 0])))
    pose = Pose(pose.position, (swing * Pose((0, 0, 0), pose.quaternion)).quaternion)
    azimuth, elevation = rng.uniform(-math.pi / 3, math.pi / 3), rng.uniform(math.radians(-10), math.radians(45))
    way = np.array(
        [-math.cos(azimuth) * math.cos(elevation), math.sin(azimuth) * math.cos(elevation), math.sin(elevation)]
    )
    target = pose.position + rng.normal(0, 0.03, 3)
    camera = looking_at(tuple(target + way * rng.uniform(0.35, 0.65)), tuple(target))
    roll = Pose.from_rotvec((0, 0, 0), (0, 0, float(rng.normal(0, 0.15))))
    return replace(thing, pose=pose), [hook, table("floor", Pose((0.3, 0, -0.005)))], camera * roll


def _occluder(camera: Pose, thing: Thing, rng: Any) -> Thing:
    """A rod or a board, part of the way from the camera to the product."""
    share = rng.uniform(0.45, 0.85)
    middle = np.array(camera.position) * (1 - share) + np.array(thing.pose.position) * share
    middle += camera.rotate((*rng.normal(0, 0.03, 2), 0.0))
    turn = Pose.from_rotvec((0, 0, 0), (0, 0, float(rng.uniform(0, math.pi))))
    pose = Pose(tuple(middle), (camera * turn).quaternion)
    if rng.random() < 0.5:
        return Thing("rod", "cram:Table", pose, (Geom("box", (0.3, float(rng.uniform(0.004, 0.015)), 0.005)),))
    return Thing("board", "cram:Table", pose, (Geom("box", (*map(float, rng.uniform(0.02, 0.06, 2)), 0.005)),))


def _world(things: list[Thing]) -> Compiled:
    return compile_world(World(tuple(things)), {})


def _count(compiled: Compiled, camera: Pose) -> int:
    _, ids = render(compiled.model, compiled.data(), camera, SMALL, noise=None)
    return int((ids == compiled.things["it"].body).sum())


def _mask(mask: Mask, rng: Any) -> Mask:
    change = int(rng.integers(-1, 3))
    if change < 0:
        return np.asarray(ndimage.binary_erosion(mask))
    return np.asarray(ndimage.binary_dilation(mask, iterations=change)) if change else mask
