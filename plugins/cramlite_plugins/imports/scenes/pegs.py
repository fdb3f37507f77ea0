"""Pegs of a scene and their holes: a slender post with a free end is a peg if a movable thing has a hole that goes over it;
other posts are furniture, other openings no holes.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

import numpy as np
from msgspec.structs import replace

from cramlite.model import Feature, Floats, Geom, Pose, Thing

from ...shapes import ray_casting as rays
from ...shapes.openings import holes
from ...shapes.peg_fit import PLAY, play
from ...shapes.solid import geom_mesh
from .things import Made

SLENDER = 2.0
"""Least ratio of length to thickness of the free part of a peg."""
LOOSE = 1.0
"""Largest play of a hole on a peg, as a share of the peg's radius; a thing with a larger hole is put around the peg, not onto it."""
SQUARE = 0.03
"""Relative difference of a post's sides below which it is square."""
LOWEST = -math.sin(math.radians(20.0))
"""Least z component of the unit vector from foot to tip of a peg: from a peg that points further down, things slip off."""
FLIPPED = Pose((0.0, 0.0, 0.0), (0.0, 1.0, 0.0, 0.0))
BESIDE = 0.001
"""Distance from a post's side to the line along which its surroundings are looked for [m]."""


def with_pegs(made: Sequence[Made]) -> list[Made]:
    """Add the feature "peg" to posts that a hole goes over, and the holes to their things."""
    posts = {m.thing.name: peg for m in made if (peg := _post(m.thing, [o.thing for o in made])) is not None}
    if not posts:
        return list(made)
    found = {m.thing.name: _threading(m.thing, posts.values()) for m in made if not m.thing.furniture}
    bored = [h for features in found.values() for h in features]
    pegs = {name: (peg,) for name, peg in posts.items() if any(_fits(h, peg) for h in bored)}
    return [_added(m, pegs.get(m.thing.name, found.get(m.thing.name, ()))) for m in made]


def _added(made: Made, features: Sequence[Feature]) -> Made:
    if not features:
        return made
    said = [f"{f.name} of {' x '.join(f'{1000 * v:.0f}' for v in f.size.values())} mm" for f in features]
    known = [] if made.found == "no surfaces" else [made.found]
    thing = replace(made.thing, features=(*made.thing.features, *features))
    if not thing.movable:
        thing = replace(thing, geoms=tuple(replace(g, part=features[0].name) for g in thing.geoms))
    return replace(made, thing=thing, found=", ".join([*known, *said]))


def _fits(hole: Feature, peg: Feature) -> bool:
    return PLAY < play(hole, peg) <= LOOSE * peg.size["radius"]


def _threading(thing: Thing, posts: Iterable[Feature]) -> tuple[Feature, ...]:
    """Holes that a thing's shapes form together and that go over a post; holes within its meshes are known
    already."""
    import trimesh

    if len(thing.geoms) < 2 or thing.feature("vrps:Hole") is not None:
        return ()
    known = list(posts)
    whole = trimesh.boolean.union([geom_mesh(g) for g in thing.geoms], engine="manifold")
    return tuple(replace(h, type="vrps:Hole") for h in holes(whole) if any(_fits(h, peg) for peg in known))


def _post(thing: Thing, things: Iterable[Thing]) -> Feature | None:
    """Return a fixed thing with only one shape as a peg, from its foot to its free end; None if it is no
    slender post."""
    if thing.movable or thing.joint is not None or len(thing.geoms) != 1:
        return None
    shaft = _shaft(thing.geoms[0])
    if shaft is None:
        return None
    pose, half, size = shaft
    others = rays.body([replace(g, pose=o.pose * g.pose) for o in things if o.name != thing.name and not o.movable for g in o.geoms])
    ways = [p for p in (pose, pose * FLIPPED) if float((thing.pose * p).rotate((0.0, 0.0, 1.0))[2]) >= LOWEST]
    length, turned = max(((_free(others, thing.pose * p, half, size["radius"]), p) for p in ways), key=lambda end: end[0])
    if length < SLENDER * 2 * size["radius"]:
        return None
    return Feature("peg", "vrps:Peg", turned * Pose((0.0, 0.0, half - length)), {**size, "length": length})


def _shaft(geom: Geom) -> tuple[Pose, float, dict[str, float]] | None:
    """Pose of the middle of a round or square post with z along the post, half its length, and its thickness;
    None for geoms of other shapes."""
    if geom.shape in ("cylinder", "capsule"):
        radius, half = geom.size
        return geom.pose, half + (radius if geom.shape == "capsule" else 0.0), {"radius": radius}
    if geom.shape != "box":
        return None
    long = int(np.argmax(geom.size))
    width, depth = (geom.size[k] for k in range(3) if k != long)
    if abs(width - depth) > SQUARE * max(width, depth):
        return None
    axes = geom.pose.rotation
    pose = Pose.from_axes(geom.pose.position, axes[:, long], axes[:, (long + 1) % 3])
    return pose, geom.size[long], {"radius": max(width, depth), "width": 2 * max(width, depth)}


def _free(others: rays.Body, shaft: Pose, half: float, radius: float) -> float:
    """Length [m] of a post that is free of other things, measured from its end at +z; 0 if something is in front
    of that end."""
    end, back = np.asarray(shaft.apply((0.0, 0.0, half))), -np.asarray(shaft.rotate((0.0, 0.0, 1.0)))
    beyond = _met(others, end + back * 1e-6, -back)
    if beyond < 2 * radius:
        return 0.0
    sides = [shaft.rotate((radius + BESIDE) * np.array(v)) for v in ((1.0, 0.0, 0.0), (-1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, -1.0, 0.0))]
    return min(2 * half, *(_met(others, end + side, back) for side in sides))


def _met(others: rays.Body, point: Floats, way: Floats) -> float:
    """Distance along a direction from a point to the next thing [m]; 0 if the point is inside a thing."""
    return min((max(low, 0.0) for low, high, _ in rays.spans(others, point, way) if high > 0.0), default=np.inf)
