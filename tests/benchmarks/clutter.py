"""Generated views of products on neighbouring hangers, with the truth that only the judge is given.

Six products of four types hang on three hangers, two on each; a camera looks at them from in front, from a little to
the side and above. Development used the seeds 0 to 99, reported figures use those from 1000; both ranges were fixed
before the first figure was taken.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from cramlite.geometry import Pose
from cramlite.view import View
from cramlite.world import Thing, World

SPACING, HEIGHT, AWAY = 0.16, 0.45, 0.87  # between hangers, of the pegs, from the origin to the panel [m]
DEPTHS = (0.035, 0.105)  # along the peg: behind and in front [m]
EYE, JITTER = (0.40, -0.36, 0.60), 0.06  # of the camera [m]


@dataclass(frozen=True)
class Sample:
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

    def visible(self, name: str) -> int:
        """How many pixels show a thing."""
        return int((self.ids == name).sum())


def clutter(seed: int, products: dict[str, Any], *, noise: bool = True, rename: bool = False) -> Sample:
    """A scene and its picture.

    Args:
        products: model name -> a function (name, pose) -> Thing; four of them are drawn, six things hang.
        rename: call the things otherwise; no answer may change.
    """
    from cramlite_plugins.perception.camera import looking_at, render
    from cramlite_plugins.perception.noise import Noise
    from cramlite_plugins.simulation.compile import compile_world
    from cramlite_plugins.simulation.models import hanger, hung, table

    rng = np.random.default_rng([seed, 411])
    kinds = [sorted(products)[k] for k in rng.permutation(len(products))[:4]]
    chosen = [kinds[k] for k in rng.permutation([0, 1, 2, 3, *rng.integers(0, 4, 2)])]
    floor = table("floor", Pose((0.4, 0, 0)), size=(1.6, 1.6, 0.02))
    turn = Pose.from_rotvec((0, 0, 0), (0, 0, math.pi))
    hangers = tuple(
        hanger(f"hook_{k}", Pose((AWAY, (k - 1) * SPACING, HEIGHT), turn.quaternion), wall=(SPACING, 0.4, 0.01))
        for k in range(3)
    )
    things = []
    for k, kind in enumerate(chosen):
        thing = products[kind](f"x{(7 * k + 3) % 11}" if rename else f"product_{k}", Pose())
        depth = DEPTHS[k // 3] + float(rng.uniform(-0.006, 0.006))
        pose = hung(thing, hangers[k % 3], depth, float(rng.uniform(-0.15, 0.15)))
        things.append(Thing(thing.name, thing.type, pose, thing.geoms, thing.features, thing.mass, thing.friction))
    world = World((floor, *hangers, *things))
    compiled = compile_world(world, {})
    data = compiled.data()
    eye = np.array(EYE) + rng.uniform(-JITTER, JITTER, 3)
    target = np.array([AWAY - 0.07, 0.0, HEIGHT - 0.07]) + rng.uniform(-0.02, 0.02, 3)
    camera = looking_at(tuple(eye), tuple(target))
    view, bodies = render(compiled.model, data, camera, noise=Noise() if noise else None, seed=seed)
    names = np.array(["", *(compiled.model.body(b).name for b in range(compiled.model.nbody))])
    return Sample(view, (floor, *hangers), world, names[bodies + 1])
