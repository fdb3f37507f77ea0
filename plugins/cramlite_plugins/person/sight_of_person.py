"""Perception of the demonstrating person: an object with a hole, a peg, and the object's support or container."""

from __future__ import annotations

import math

import numpy as np

from cramlite.model import Feature, Floats, Thing, Value, World
from cramlite.plugin import UserError

from ..shapes.bounds import box_around

#: What stands has its underside within this of the top below it [m].
STANDS = 0.02


class Scene(Value):
    """The scene as the person sees it: an object with a hole, a peg, and the object's container or support.

    Args:
        container, cavity: the container that the object goes into and its opening; for an object that stands at the
            start, the thing below it and that thing's top; where it comes from, or goes to, the hand alone, the hanger and its peg.
    """

    world: World
    product: Thing
    hole: Feature
    hanger: Thing
    peg: Feature
    container: Thing
    cavity: Feature

    @property
    def along(self) -> Floats:
        """Return the unit vector (3,) along the peg, out of the wall, world axes."""
        return self.hanger.pose.rotate(self.peg.pose.rotate((0, 0, 1)))

    @property
    def facing(self) -> Floats:
        """Return the unit vector (3,) that the hand comes from: the object's front if it stands, else the peg's."""
        return self.product.pose.rotate(self.hole.pose.rotate((0, 0, 1))) if self.stands else self.along

    @property
    def stands(self) -> bool:
        """Check whether the object stands on something at the start."""
        return self.cavity.type == "vrps:SurfaceFeature"


def see_hanging(world: World) -> Scene:
    """Find the object, the peg that it hangs on, and the container, by their features.

    Raises:
        UserError: one of them is missing, or nothing hangs on a peg.
    """
    holed, pegs, cavities = (
        featured(world, "vrps:Hole", movable=True),
        featured(world, "vrps:Peg"),
        featured(world, "cram:Cavity"),
    )
    pairs = [(_off_axis(p, h), p, h) for p in holed for h in pegs]
    distance, product, peg = min(pairs, key=lambda c: c[0])
    if distance > 0.02:
        raise UserError(
            f"nothing hangs on a peg: the hole of '{product[0].name}' is {distance * 1000:.0f} mm off the peg of "
            f"'{peg[0].name}'; place the product with its hole around the peg"
        )
    return Scene(world, *product, *peg, *cavities[0])


def _off_axis(product: tuple[Thing, Feature], hanger: tuple[Thing, Feature]) -> float:
    """Distance of a hole's centre from a peg's straight part [m]."""
    hole = product[0].pose.apply(product[1].pose.position)
    x, y, z = (hanger[0].pose * hanger[1].pose).inverse().apply(hole)
    beyond = max(-z, 0.0, z - hanger[1].size.get("length", 0.1))
    return math.hypot(x, y, beyond)


def see_standing(world: World) -> Scene:
    """Find the object with a hole, the peg, and the surface that the object stands on.

    Raises:
        UserError: one of them is missing, or the object stands on nothing.
    """
    product = featured(world, "vrps:Hole", movable=True)[0]
    peg = featured(world, "vrps:Peg")[0]
    tops = [c for c in featured(world, "vrps:SurfaceFeature") if c[0] is not product[0]]
    bottom = product[0].pose.position[2] - float(half_extents(product[0])[2])
    below = [c for c in tops if _under(product[0], bottom, *c)]
    if not below:
        raise UserError(
            f"'{product[0].name}' stands on nothing: its underside is at z = {bottom:.3f} m, and no surface is within "
            f"{1000 * STANDS:.0f} mm below it; put it on a thing with a vrps:SurfaceFeature"
        )
    return Scene(world, *product, *peg, *below[0])


def _under(product: Thing, bottom: float, owner: Thing, surface: Feature) -> bool:
    """Whether an object stands on a surface: the surface is directly at the object's underside."""
    x, y, z = (owner.pose * surface.pose).inverse().apply((*product.pose.position[:2], bottom))
    within = abs(x) <= surface.size.get("width", 0.0) / 2 and abs(y) <= surface.size.get("depth", 0.0) / 2
    return bool(within and abs(z) < STANDS)


def featured(world: World, type_: str, *, movable: bool = False) -> list[tuple[Thing, Feature]]:
    """List each thing that has a feature of the given class, such as a hole, together with that feature.

    Raises:
        UserError: there is nothing of the kind.
    """
    found = [(t, f) for t in world.things for f in t.features if f.type == type_ and (t.movable or not movable)]
    if not found:
        names = ", ".join(f"{t.name} ({t.type})" for t in world.things) or "none"
        what = f"{'movable ' if movable else ''}thing with a {type_}"
        raise UserError(f"the demonstration needs a {what}, and the world has none; its things are: {names}")
    return found


def half_extents(thing: Thing) -> Floats:
    """Compute half the side lengths (3,) of the box that is centred on a thing's origin and holds its body, without its features [m]."""
    low, high = box_around([g for g in thing.geoms if not g.part] or thing.geoms)
    return np.maximum(-low, high)
