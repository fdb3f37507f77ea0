"""Grips of a thing, wherever it is: contact pairs on a thing's primitives that fit between the fingers,
ranked and explained.

Boxes offer their opposite faces, cylinders and capsules their sides and ends, spheres any diameter, the
convex parts of meshes their faces (``surfaces``); ``antipodal`` checks each against the whole shape.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator, Sequence
from functools import lru_cache
from typing import TypeVar

import numpy as np
from msgspec.structs import replace

from cramlite.model import Floats, Geom, Gripper, Pose, Remedy, Thing, Value

from ...shapes import ray_casting as rays
from ...shapes.bounds import centre_of_mass, corners
from ...shapes.convex import hull_planes
from . import antipodal
from . import pinch_lines as surfaces

HANDLE = "cram:Handle"
NEAR_HANDLE = 0.020  # a pinch point this near to a handle's middle is on it [m]
SLACK = 0.010  # wider than the object when approaching, both sides together [m]
WIDE = 0.03  # and so much wider if it can be: a hand that is 10 mm off does not push it [m]
ENOUGH = 0.015  # with more than this a hand is hardly ever off by half of it [m]
LEAST_SLACK = 0.004  # a thing that leaves less than this does not go between the pads of a known pose [m]
PARALLEL = math.radians(1)
"""Angle between contact normals up to which faces count as parallel, and need no friction to stay between
the pads."""
MARGIN = 0.004  # pads end this far inside a face's edge [m]
AGAIN = 0.008  # [m]
# More than the way round, another turn about the approach, and a further one of one likeness together [m]
CAUGHT = 0.02
MANY = 3  # parts of a thing beyond which equal grasps on them count once
SHIFTS = (0.0, 0.5, 1.0, -0.5, -1.0)  # along a face, as fractions of what the pads leave
LEAN = math.radians(30)
"""Lean of a hand about the line between its pads [rad], for boxes over which a straight hand has no room or
would be too far away for the wrist."""
BARE = 0.05
"""Cost of a poorly covered pad [m], per share of coverage that it lacks: a carton's ridge, 7 mm high, slipped
out of pads that it covered by a ninth, but not out of wholly covered pads 18 mm beside its centre of mass."""
PER_LEAN = 0.06
"""Cost of a radian of lean [m]."""


T = TypeVar("T")


class Grip(Value):
    """Grasp candidate in the thing's frame.

    Args:
        pose: of the TCP.
        width: between the faces [m].
        lever: from the centre of mass to the plane of approach and closing, and what sticks out sideways [m].
        name: for people.
        slant: angle of the contact normals to the closing direction [rad].
        coverage: share of the pad that the shape fills.
        ahead: how far before the TCP the contact pair is [m].
        slack: wider than the contacts that the thing itself lets the fingers approach, both sides together,
            up to ``WIDE`` [m].
        lean: of the hand about the line between its pads [rad].
        caught: whether a pad is below some of the thing that catches on it when it is let go.
        ends: whether no more than the ends of the pads are on it: a palm that is 6 mm higher is over what
            stands as high as the thing.
    """

    pose: Pose
    width: float
    lever: float
    name: str
    slant: float = 0.0
    coverage: float = 1.0
    ahead: float = 0.0
    slack: float = WIDE
    lean: float = 0.0
    caught: bool = False
    ends: bool = False

    @property
    def late(self) -> int:
        """Rank of the kind of grip, in the order of trial: 0 for straight hands, 1 for leaning hands, 2 for
        grips by the ends of the pads."""
        return 2 if self.ends else int(bool(self.lean))

    @property
    def cost(self) -> float:
        """Return the cost [m]: the distance from the centre of mass, and surcharges for a pad that is hardly
        covered, a slanted contact, fingers that pass close to the thing, and a pad that the thing catches on
        at its release."""
        narrow = BARE * max(0.0, 0.6 - self.coverage) + 0.3 * max(0.0, ENOUGH - self.slack)
        hooked = CAUGHT if self.caught else 0.0
        return self.lever + narrow + hooked + 0.02 * self.slant + PER_LEAN * abs(self.lean)

    @property
    def likeness(self) -> tuple[float, ...]:
        """Key that is equal for similar grasps, which hold or fail together: same part of the pads, same
        inclination, width and distance from the centre of mass."""
        down = float(self.pose.rotate((0.0, 0.0, 1.0))[2])
        return (round(self.ahead, 3), round(2 * down), round(self.width / 0.005), round(self.lever / 0.010))


def ranked(thing: Thing, gripper: Gripper, friction: float) -> list[Grip]:
    """Return the grasps that the whole shape allows, best first.

    Args:
        friction: of pads and thing; contacts must lie within its cone.
    """
    handles = tuple(f.pose for f in thing.features if f.type == HANDLE)
    return list(_ranked(thing.geoms, tuple(centre_of_mass(thing)), handles, gripper, friction))


@lru_cache(maxsize=64)
def _ranked(
    geoms: tuple[Geom, ...],
    centre: tuple[float, ...],
    handles: tuple[Pose, ...],
    gripper: Gripper,
    friction: float,
) -> tuple[Grip, ...]:
    shape, middle, cone = rays.body(geoms), np.asarray(centre), max(math.atan(friction), PARALLEL)
    proposed = [*candidates(geoms, gripper), *_across_parts(shape, middle, handles, gripper, cone)]
    found = _checked(shape, middle, proposed, gripper, cone) if proposed else []
    return tuple(grip for _, grip in varied((g.cost, g, g) for g in found))


def varied(grips: Iterable[tuple[float, Grip, T]]) -> list[tuple[float, T]]:
    """Sort values by the costs of the grasps that they come with; a grasp costs ``AGAIN`` more for each
    similar one before it."""
    seen: dict[tuple[float, ...], int] = {}
    keyed = []
    for k, (cost, grip, what) in enumerate(sorted(grips, key=lambda x: (round(x[0], 4), x[1].name))):
        before = seen.get(grip.likeness, 0)
        seen[grip.likeness] = before + 1
        keyed.append((round(cost + AGAIN * before, 4), k, what))
    return [(cost, what) for cost, _, what in sorted(keyed, key=lambda x: x[:2])]


def candidates(geoms: Sequence[Geom], gripper: Gripper) -> Iterator[Grip]:
    """Yield grasps of each primitive of a body by itself; parts such as tabs are not gripped."""
    body = [g for g in geoms if not g.part]
    for i, geom in enumerate(body):
        name = f" of geom {i}" if len(body) > 1 else ""
        grips = [replace(grip, name=grip.name + name) for grip in _of_geom(geom, gripper)]
        if not grips:
            continue
        hands = antipodal.Hands.at([g.pose for g in grips])
        near, far = rays.intervals(rays.body([geom]), hands.positions, hands.approach)
        for grip, one, other in zip(grips, near[:, 0].tolist(), far[:, 0].tolist(), strict=True):
            yield from _drawn_back(grip, one, other, gripper)


def _drawn_back(grip: Grip, near: float, far: float, gripper: Gripper) -> Iterator[Grip]:
    """Yield a grasp of a geom, which reaches from ``near`` to ``far`` along the approach [m], with the hand
    where it is (unless it leans) and drawn back.

    Of a hand that leans a corner of the pads is ahead of their middle.
    """
    if grip.lean:
        corner = gripper.pad[0] / 2 * math.tan(abs(grip.lean))
        if (tips := antipodal.by_tips(grip.pose, near, far, gripper, corner)) is not None:
            yield replace(grip, pose=tips[0], name=f"{grip.name}, by the tips", ahead=tips[1])
        return
    yield grip
    drawn = antipodal.shallow(grip.pose, near, far, gripper)
    if drawn is not None:
        yield replace(grip, pose=drawn, name=f"{grip.name}, shallow")
    tips = antipodal.by_tips(grip.pose, near, far, gripper)
    if tips is not None:
        yield replace(grip, pose=tips[0], name=f"{grip.name}, by the tips", ahead=tips[1])
    ends = antipodal.by_tips(grip.pose, near, far, gripper, most=antipodal.ENDS)
    if ends is not None and (tips is None or ends[1] > tips[1]):
        yield replace(grip, pose=ends[0], name=f"{grip.name}, by their ends", ahead=ends[1], ends=True)


def _across_parts(
    shape: rays.Body, centre: Floats, handles: Sequence[Pose], gripper: Gripper, cone: float
) -> Iterator[Grip]:
    """Yield grasps between faces of convex parts, from all sides, each with the hand as deep as it goes and
    drawn back."""
    parts = [g for g in shape.geoms if g.shape == "convex" and not g.part]
    lines = surfaces.lines(shape, parts, centre, gripper, LEAST_SLACK, cone) if parts else []
    found = [(line, pose, name) for line in lines for pose, name in surfaces.frames(line)]
    deep = antipodal.depths(shape, [pose for _, pose, _ in found], gripper) if found else ()
    for (line, _, name), ways in zip(found, deep, strict=True):
        at = "handle " if any(math.dist(line.middle, h.position) < NEAR_HANDLE for h in handles) else ""
        where = " ".join(f"{1000 * v:+.0f}" for v in line.middle)
        for pose, ahead, how in ways:
            yield Grip(pose, line.width, 0.0, f"{at}{name} at ({where}) mm{how}", ahead=ahead)


def _of_geom(geom: Geom, gripper: Gripper) -> Iterator[Grip]:
    if geom.shape == "box":
        yield from _of_box(geom, gripper)
    elif geom.shape != "convex" and 2 * geom.size[0] + LEAST_SLACK <= gripper.opening[1]:
        for pose, name in antipodal.round_frames(geom, gripper.depth - MARGIN):
            yield Grip(pose, 2 * geom.size[0], 0.0, name)


def too_wide(thing: Thing, gripper: Gripper) -> Remedy | None:
    """Return the remedy if a side of a thing is wider than the hand opens; None if no side is."""
    limit = gripper.opening[1] - LEAST_SLACK
    sides = sorted(np.ptp(corners(thing, Pose()), axis=0).tolist()) if thing.geoms else []
    wide = [side for side in sides if side > limit]
    if not wide:
        return None
    fits = f"turn it so that its {1000 * sides[0]:.0f} mm can be taken, " if sides[0] <= limit else ""
    says = (
        f"'{thing.name}' is {1000 * wide[0]:.0f} mm wide, the hand grasps {1000 * limit:.0f} mm at most: "
        f"{fits}take a smaller thing, one with a handle or rim, or a hand that opens "
        f"{1000 * (wide[0] - limit):.0f} mm wider"
    )
    return Remedy(f"width {thing.name}", says, wide[0] - limit)


def why_none(thing: Thing, gripper: Gripper) -> str:
    """Explain why nothing can be grasped, with the nearest miss."""
    limit = gripper.opening[1] - LEAST_SLACK
    thin = sorted({round(_thinnest(g), 4) for g in thing.geoms if not g.part})
    widths = ", ".join(f"{1000 * w:.0f} mm" for w in thin[:4])
    if not thin or thin[0] > limit:
        return f"no face pair of '{thing.name}' ({widths}) fits the gripper's {1000 * limit:.0f} mm"
    return (
        f"parts of '{thing.name}' ({widths}) would fit the gripper's {1000 * limit:.0f} mm, but the rest of "
        "its shape is in the way of the fingers, makes it too wide, or leaves slanted contacts"
    )


def _thinnest(geom: Geom) -> float:
    if geom.shape == "convex":
        planes, corners = hull_planes(geom.corners), np.asarray(geom.corners)
        return float(np.ptp(corners @ planes[:, :3].T, axis=0).min())
    return 2 * min(geom.size) if geom.shape == "box" else 2 * geom.size[0]


def _checked(
    shape: rays.Body, centre: Floats, grips: Sequence[Grip], gripper: Gripper, cone: float
) -> list[Grip]:
    """Return the grips that fit between the fingers, hold by friction and leave room for the hand, on the
    whole shape.

    On shapes of many parts, only one of several equal grips is kept.
    """
    aheads, most = np.array([g.ahead for g in grips]), gripper.opening[1]
    proposed = antipodal.Hands.at([g.pose for g in grips])
    found = antipodal.pinches(shape, proposed.moved(aheads))
    fits = (found.width > 0) & (found.width + LEAST_SLACK <= most) & (found.slant <= cone)
    rows = np.flatnonzero(fits)
    hands, widths = proposed.of(rows).moved(0.0, found.low[rows] + found.width[rows] / 2), found.width[rows]
    if len(shape.geoms) > MANY:
        kinds = [grips[k].ends for k in rows.tolist()]  # by ends of the pads: less than a cell behind others
        _, first = np.unique(np.column_stack([_cells(hands), kinds]), axis=0, return_index=True)
        first.sort()
        rows, hands, widths = rows[first], hands.of(first), widths[first]
    free = np.flatnonzero(antipodal.clear(shape, hands, np.minimum(widths + SLACK, most), gripper))
    rows, hands, widths = rows[free], hands.of(free), widths[free]
    covered = antipodal.coverage(shape, hands, widths, gripper)
    narrow, wide = np.minimum(widths + SLACK, most), np.minimum(widths + WIDE, most)
    slacks = np.where(antipodal.clear(shape, hands, wide, gripper), wide, narrow) - widths
    off = np.einsum("nij,ni->nj", hands.turns, centre - hands.positions)
    levers = np.abs(off[:, 0]) + 0.3 * np.maximum(0.0, np.abs(off[:, 1]) - widths / 2)
    hung = antipodal.caught(shape, hands, widths, gripper)
    columns = (np.asarray(v).tolist() for v in (rows, widths, levers, covered, slacks, hung))
    return [
        replace(
            grips[k],
            pose=Pose.at(p, grips[k].pose),
            width=width,
            lever=lever,
            slant=float(found.slant[k]),
            coverage=cover,
            slack=slack,
            caught=hangs,
        )
        for p, k, width, lever, cover, slack, hangs in zip(hands.positions, *columns, strict=True)
    ]


def _cells(hands: antipodal.Hands) -> Floats:
    """Rounded positions, approach and closing directions of hands, a row (n, 9) for each.

    Rows are equal for hands that are closer than ``AGAIN`` and turned by less than some 7 deg to each other.
    """
    rows: Floats = np.hstack([hands.positions / AGAIN, 8 * hands.approach, 8 * hands.closing])
    return np.asarray(np.round(rows) + 0.0)  # no minus zero


def _of_box(geom: Geom, gripper: Gripper) -> Iterator[Grip]:
    for closing, approach in itertools.permutations(range(3), 2):
        width = 2 * geom.size[closing]
        if width + LEAST_SLACK > gripper.opening[1]:
            continue
        along = 3 - closing - approach
        room = max(geom.size[along] - gripper.pad[0] / 2 - MARGIN, 0.0)
        for sign, shift in itertools.product((1.0, -1.0), SHIFTS if room > 0.002 else (0.0,)):
            straight = _grip(geom, closing, approach, sign, along, shift * room, width, gripper.depth)
            yield straight
            yield from (_leaning(straight, lean) for lean in (LEAN, -LEAN))


def _leaning(grip: Grip, lean: float) -> Grip:
    turn = Pose.from_rotvec((0.0, 0.0, 0.0), (0.0, lean, 0.0))
    name = f"{grip.name}, leaning {math.degrees(lean):+.0f} deg"
    return replace(grip, pose=grip.pose * turn, name=name, lean=lean)


def _grip(
    geom: Geom,
    closing: int,
    approach: int,
    sign: float,
    along: int,
    offset: float,
    width: float,
    depth: float,
) -> Grip:
    """Grip of a box: TCP z points into the box and TCP y across it; the hand is as deep as it goes, at most
    to the middle."""
    axes = np.eye(3)
    z, y = sign * axes[approach], axes[closing]
    depth_in = min(geom.size[approach], depth - MARGIN)
    centre = -z * (geom.size[approach] - depth_in) + axes[along] * offset
    pose = geom.pose * Pose.from_axes(tuple(centre), z, np.cross(y, z))
    side = "+-"[sign > 0] + "xyz"[approach]
    name = f"from {side} across {'xyz'[closing]} at {1000 * offset:+.0f} mm along {'xyz'[along]}"
    return Grip(pose, width, abs(offset), name)
