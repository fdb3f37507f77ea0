"""Object models of products with a hole, blocks, hangers with a peg, baskets and tables.

All sizes in metres. Peg, tip and tab follow what was measured to work (docs/explanation/simulation.md):
a 6 mm peg with hemispherical ends, a 12 mm tip bent up by 6 mm, a hole of 9 to 12 mm out of 12 boxes.
"""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable, Mapping
from typing import Any, get_args, get_origin, get_type_hints

from cramlite.model import Feature, Filling, Geom, Pose, Thing
from cramlite.plugin import Length, Mass, UserError, nearest, read_value

from .controls import knob, latch, lever, switch
from .furniture import cabinet, door, drawer
from .mesh_thing import mesh_thing
from .rack import rack
from .threads import jar, screw_lid
from .vessels import bottle, bowl, can, jug, lid, mug

Size = tuple[Length, Length, Length]
TAB_RIM, TAB_THICKNESS, TAB_SIDES = 0.008, 0.002, 12
Colour = tuple[float, float, float, float]


def product(
    name: str,
    pose: Pose,
    size: Size = (0.04, 0.025, 0.15),
    mass: Mass = 0.3,
    hole_diameter: Length = 0.010,
    friction: float = 0.6,
    rgba: Colour = (0.85, 0.35, 0.25, 1.0),
) -> Thing:
    """Make a box with a tab on top, which has a hole to hang it by.

    Frame: the centre of the box; x along its width, z up, its front is -y. Feature "hole": at the hole's centre, z
    out of the front (-y), y up. Feature "bottom": the face it stands on, z down.

    Args:
        size: width (x), depth (y), height (z), without the tab.
        hole_diameter: must be larger than the peg.
    """
    width, depth, height = size
    radius = hole_diameter / 2
    centre = height / 2 + radius + TAB_RIM
    through = Pose.from_axes((0, 0, centre), (0, -1, 0), (1, 0, 0))
    hole = Feature("hole", "vrps:Hole", through, {"diameter": hole_diameter})
    bottom = Feature(
        "bottom", "vrps:SurfaceFeature", Pose.from_axes((0, 0, -height / 2), (0, 0, -1), (1, 0, 0)),
        {"width": width, "depth": depth},
    )  # fmt: skip
    box = Geom("box", (width / 2, depth / 2, height / 2), rgba=rgba)
    geoms = (box, *_ring(radius, centre, rgba))
    return Thing(name, "cram:BoxedProduct", pose, geoms, (hole, bottom), mass, friction)


def block(
    name: str,
    pose: Pose,
    size: Size = (0.06, 0.06, 0.06),
    mass: Mass = 0.2,
    friction: float = 0.6,
    rgba: Colour = (0.45, 0.50, 0.62, 1.0),
) -> Thing:
    """Make a plain box that can be moved. Frame: its centre, z up. Feature "bottom": the face it stands on, z down.

    Args:
        size: width (x), depth (y), height (z).
    """
    width, depth, height = size
    face = Pose.from_axes((0, 0, -height / 2), (0, 0, -1), (1, 0, 0))
    bottom = Feature("bottom", "vrps:SurfaceFeature", face, {"width": width, "depth": depth})
    box = Geom("box", (width / 2, depth / 2, height / 2), rgba=rgba)
    return Thing(name, "cram:Product", pose, (box,), (bottom,), mass, friction)


def _ring(radius: float, height: float, rgba: Colour) -> tuple[Geom, ...]:
    """Return the boxes around a hole: tangent to its circle, without a gap between them."""
    half = (TAB_RIM / 2, (radius + TAB_RIM) * math.tan(math.pi / TAB_SIDES), TAB_THICKNESS / 2)
    geoms = []
    for k in range(TAB_SIDES):
        angle = math.tau * k / TAB_SIDES
        out = (math.cos(angle), 0.0, math.sin(angle))
        place = tuple(v * (radius + TAB_RIM / 2) + (height if i == 2 else 0.0) for i, v in enumerate(out))
        geoms.append(Geom("box", half, Pose.from_axes(place, (0, -1, 0), out), "hole", rgba=rgba))
    return tuple(geoms)


def hanger(
    name: str,
    pose: Pose,
    length: Length = 0.138,
    radius: Length = 0.003,
    tip: Length = 0.012,
    rise: Length = 0.006,
    friction: float = 0.3,
    wall: Size = (0.3, 0.3, 0.01),
    rgba: Colour = (0.75, 0.76, 0.78, 1.0),
) -> Thing:
    """Make a wall panel with a peg that ends in a bent tip.

    Frame: the root of the peg on the wall; x along the peg, z up. Feature "peg": at the root, z along the peg
    towards its tip, x up. Feature "tip": at the end of the bent part, z along it outwards.

    Args:
        length: of the straight part.
        radius: of the peg.
        tip: length of the bent part.
        rise: how much higher its end is; smaller than `tip`.
        wall: width, height and thickness of the panel.
        rgba: of the peg.

    Raises:
        UserError: the tip is too short to rise so far.
    """
    run = math.sqrt(max(tip * tip - rise * rise, 0.0))
    if run <= 0 and tip > 0:
        raise UserError(f"hanger '{name}': a tip of {tip} m cannot rise {rise} m; make rise smaller than tip")
    along = (run / tip, 0.0, rise / tip) if tip > 0 else (1.0, 0.0, 0.0)
    end = (length + run, 0.0, rise)
    root = Pose.from_axes((0, 0, 0), (1, 0, 0), (0, 0, 1))
    middle = Pose.from_axes((length + run / 2, 0.0, rise / 2), along, (0, 1, 0))
    bent = {"radius": radius, "length": tip, "rise": rise}
    geoms = [
        Geom("box", (wall[2] / 2, wall[0] / 2, wall[1] / 2), Pose((-wall[2] / 2, 0, 0)), rgba=(0.88, 0.88, 0.86, 1.0)),
        Geom("capsule", (radius, length / 2), root * Pose((0, 0, length / 2)), "peg", rgba=rgba),
    ]
    if tip > 0:
        geoms.append(Geom("capsule", (radius, tip / 2), middle, "tip", rgba=rgba))
    features = (
        Feature("peg", "vrps:Peg", root, {"radius": radius, "length": length}),
        Feature("tip", "vrps:Tip", Pose.from_axes(end, along, (0, 1, 0)), bent),
    )
    return Thing(name, "cram:Hanger", pose, tuple(geoms), features, None, friction)


def basket(
    name: str,
    pose: Pose,
    size: Size = (0.40, 0.30, 0.15),
    wall: Length = 0.01,
    friction: float = 0.6,
    rgba: Colour = (0.35, 0.55, 0.40, 1.0),
) -> Thing:
    """Make a box that is open at the top, fixed where it stands.

    Frame: the centre of its underside, z up. Feature "cavity": at the centre of the opening, z out of it; its size are
    the inner width (x), depth (y) and height. Feature "floor": the inner floor, z up.

    Args:
        size: outer width (x), depth (y), height (z).
        wall: thickness.
    """
    w, d, h = size
    inner = {"width": w - 2 * wall, "depth": d - 2 * wall, "height": h - wall}
    sides = [(sx * (w - wall) / 2, 0.0, wall / 2, d / 2) for sx in (1, -1)]
    sides += [(0.0, sy * (d - wall) / 2, w / 2 - wall, wall / 2) for sy in (1, -1)]
    geoms = [Geom("box", (w / 2, d / 2, wall / 2), Pose((0, 0, wall / 2)), "floor", rgba=rgba)]
    geoms += [Geom("box", (a, b, (h - wall) / 2), Pose((x, y, (h + wall) / 2)), rgba=rgba) for x, y, a, b in sides]
    features = (
        Feature("cavity", "cram:Cavity", Pose((0, 0, h)), inner),
        Feature("floor", "vrps:SurfaceFeature", Pose((0, 0, wall)), {"width": inner["width"], "depth": inner["depth"]}),
    )
    return Thing(name, "cram:Basket", pose, tuple(geoms), features, None, friction)


def table(
    name: str,
    pose: Pose,
    size: Size = (1.2, 1.2, 0.04),
    friction: float = 0.6,
    grains: int = 0,
    grain_radius: Length = 0.005,
    grain_mass: Mass = 0.0006,
    rgba: Colour = (0.72, 0.62, 0.50, 1.0),
) -> Thing:
    """Make a fixed plate. Frame: the centre of its top face, z up. Feature "top": that face.

    Args:
        size: width (x), depth (y), thickness.
        grains: how many balls lie on it at the start, about its middle.
        grain_radius, grain_mass: of each.
    """
    w, d, h = size
    top = Feature("top", "vrps:SurfaceFeature", Pose(), {"width": w, "depth": d})
    plate = Geom("box", (w / 2, d / 2, h / 2), Pose((0, 0, -h / 2)), rgba=rgba)
    filling = Filling(grains, grain_radius, grain_mass) if grains else None
    return Thing(name, "cram:Table", pose, (plate,), (top,), None, friction, filling=filling)


def hung(product: Thing, hanger: Thing, depth: float, yaw: float = 0.0) -> Pose:
    """Compute the pose of a product that hangs on a hanger, its hole resting on the peg from above.

    Args:
        depth: of the tab's middle from the root of the peg [m].
        yaw: turn about the vertical [rad]; at 0 the product's front looks along the peg.

    Raises:
        UserError: the product has no hole, the hanger no peg, or the peg does not fit.
    """
    hole, peg = product.feature("vrps:Hole"), hanger.feature("vrps:Peg")
    if hole is None or peg is None:
        raise UserError(f"'{product.name}' cannot hang on '{hanger.name}': it takes a vrps:Hole and a vrps:Peg")
    drop = hole.size["diameter"] / 2 - peg.size["radius"]
    if drop <= 0 or not 0 <= depth <= peg.size["length"]:
        raise UserError(
            f"'{product.name}' cannot hang on '{hanger.name}' at {depth} m: the hole has {hole.size['diameter']} m,"
            f" the peg {2 * peg.size['radius']} m and a length of {peg.size['length']} m"
        )
    peg_pose = hanger.pose * peg.pose
    place = peg_pose.apply((0, 0, depth)) - (0, 0, drop)
    turn = Pose((0, 0, 0), (math.cos(yaw / 2), 0, 0, math.sin(yaw / 2)))
    axis = turn.rotate(peg_pose.rotate((0, 0, 1)))
    side = (-axis[1], axis[0], 0.0)  # up x axis: the hole's y axis is then up
    return Pose.from_axes(tuple(place), axis, side) * hole.pose.inverse()


MODELS: Mapping[str, Callable[..., Thing]] = {
    "boxed_product": product,
    "block": block,
    "hanger": hanger,
    "basket": basket,
    "table": table,
    "can": can,
    "bottle": bottle,
    "bowl": bowl,
    "mug": mug,
    "jug": jug,
    "lid": lid,
    "jar": jar,
    "screw_lid": screw_lid,
    "mesh": mesh_thing,
    "cabinet": cabinet,
    "drawer": drawer,
    "knob": knob,
    "switch": switch,
    "latch": latch,
    "lever": lever,
    "door": door,
    "rack": rack,
}


def make(model: str, name: str, pose: Pose, parameters: Mapping[str, object] | None = None) -> Thing:
    """Make a thing of an object model.

    Raises:
        UserError: no such model or parameter (names the nearest), or a value of the wrong type.
    """
    if model not in MODELS:
        raise UserError(f"thing '{name}': there is no model '{model}'; {nearest(model, MODELS)}")
    function = MODELS[model]
    valid = [p for p in inspect.signature(function).parameters if p not in ("name", "pose")]
    for key in parameters or {}:
        if key not in valid:
            raise UserError(f"thing '{name}': model '{model}' has no parameter '{key}'; {nearest(key, valid)}")
    hints = get_type_hints(function, include_extras=True)
    needed = [k for k, v in inspect.signature(function).parameters.items() if v.default is v.empty and k in valid]
    if missing := [k for k in needed if k not in (parameters or {})]:
        raise UserError(f"thing '{name}': model '{model}' needs '{missing[0]}'; write it under 'with'")
    checked = {k: _checked(name, k, v, hints[k]) for k, v in (parameters or {}).items()}
    return function(name, pose, **checked)


def _checked(thing: str, key: str, value: object, hint: Any) -> Any:
    from pydantic import ValidationError

    try:
        return read_value(hint, value)
    except ValueError as error:
        said = error.errors()[0]["msg"].removeprefix("Value error, ") if isinstance(error, ValidationError) else str(error)
        if get_origin(hint) is tuple and not (isinstance(value, list | tuple) and len(value) == len(get_args(hint))):
            said = f"{len(get_args(hint))} values are needed, in a list"
        raise UserError(f"thing '{thing}': parameter '{key}' is {value!r}: {said}") from None
