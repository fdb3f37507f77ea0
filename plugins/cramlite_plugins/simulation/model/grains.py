"""Granular contents: small balls, each a free body, packed into a cavity at the start, or scattered on a surface.

Balls roll hardly at all (condim 6): what is spilled stays where it can be counted, as peas do on a table cloth.
"""

from __future__ import annotations

import math
from typing import Any

import mujoco

from cramlite.model import Feature, Filling, Thing
from cramlite.plugin import UserError

from ...shapes.contents import lain_on, volume

GRAIN = "grain"
MASK = (2, 7)  # as products: they meet robots, products, furniture, and each other
ROLLING = 0.0005  # of rolling friction [m]: a ball of 5 mm stops on a slope of atan(0.0005 / 0.005) = 6 degrees
SOLREF = (0.005, 1.0)  # as things
GAP, SCATTERED = 1.05, 2.0  # between centres at the start, in diameters: in a cavity, and on a surface


def add_grains(spec: Any, thing: Thing) -> None:
    """Add the grains that fill a thing."""
    filling = thing.filling
    if filling is None:
        return
    for k, centre in enumerate(layout(thing)):
        name = f"{thing.name}/{GRAIN}/{k}"
        body = spec.worldbody.add_body(name=name, pos=centre)
        body.add_freejoint(name=name)
        body.add_geom(
            name=name, type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[filling.radius, 0.0, 0.0], mass=filling.mass,
            friction=[filling.friction, 0.005, ROLLING], condim=6, solref=SOLREF, contype=MASK[0], conaffinity=MASK[1],
            rgba=(0.85, 0.65, 0.20, 1.0),
        )  # fmt: skip


def is_grain(name: str) -> bool:
    """Check whether the body or geom of that name is a grain."""
    return f"/{GRAIN}/" in name


def layout(thing: Thing) -> list[tuple[float, float, float]]:
    """Compute the centres of a thing's grains in the world [m]: a grid in its cavity, from the bottom up, or on
    its surface if it has no cavity.

    Raises:
        UserError: there is neither, or it is too small.
    """
    filling = thing.filling
    if filling is None:
        return []
    cavity, surface = thing.feature("cram:Cavity"), lain_on(thing)
    if cavity is not None:
        there, places, room = cavity, _packed(cavity, filling), f"into its cavity of {1e6 * volume(cavity):.0f} ml"
    elif surface is not None:
        width, depth = (1000 * surface.size[k] for k in ("width", "depth"))
        there, places, room = surface, _scattered(surface, filling), f"onto its surface of {width:.0f} x {depth:.0f} mm"
    else:
        raise UserError(f"thing '{thing.name}' is filled, but has no cram:Cavity to be filled, and no surface that balls could lie on")
    if len(places) < filling.count:
        raise UserError(
            f"thing '{thing.name}': {filling.count} balls of {2000 * filling.radius:g} mm do not fit {room}; {len(places)} do"
        )
    frame = thing.pose * there.pose
    return [tuple(map(float, row)) for row in frame.apply(places[: filling.count])]  # type: ignore[misc]


def _packed(cavity: Feature, filling: Filling) -> list[tuple[float, float, float]]:
    """Possible start positions of grains in a cavity: grid points in the cavity's frame [m], from the bottom up."""
    step = GAP * 2 * filling.radius
    layers = int((cavity.size["height"] - 2 * filling.radius) / step) + 1
    heights = [filling.radius + z * step - cavity.size["height"] for z in range(max(layers, 0))]
    return [(x, y, z) for z in heights for x, y in _layer(cavity, filling, step)]


def _scattered(surface: Feature, filling: Filling) -> list[tuple[float, float, float]]:
    """Possible start positions of grains on a surface: grid points in the surface's frame [m]."""
    return [(x, y, filling.radius) for x, y in _layer(surface, filling, SCATTERED * 2 * filling.radius)]


def _layer(cavity: Feature, filling: Filling, step: float) -> list[tuple[float, float]]:
    """Return the horizontal start positions of one layer of grains, on a grid, those nearest to the layer's
    centre first."""
    half = [cavity.size[k] / 2 - GAP * filling.radius for k in ("width", "depth")]
    counts = [int(h / step) for h in half]
    points = [(i * step, k * step) for i in range(-counts[0], counts[0] + 1) for k in range(-counts[1], counts[1] + 1)]
    if "radius" in cavity.size:
        points = [p for p in points if math.hypot(*p) <= half[0]]
    return sorted(points, key=lambda p: (round(math.hypot(*p), 6), p))
