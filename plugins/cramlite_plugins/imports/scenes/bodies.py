"""Groups of a scene's bodies that move as one: furniture, bodies on joints of furniture, loose bodies;
robots are kept apart."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, Literal

import mujoco
import numpy as np

from cramlite.model import Value

from ...simulation.model.index import joints_of

HINGE, SLIDE, BALL, FREE = (
    int(getattr(mujoco.mjtJoint, f"mjJNT_{kind}")) for kind in ("HINGE", "SLIDE", "BALL", "FREE")
)
CHAIN = 4
"""Number of joints in a row from which a chain is an arm: doors with handles and microwaves have two, no furniture has more than three."""
GAP = 0.01
"""Parts of one piece of furniture are no farther apart than this [m]; they touch or are drawn with a gap of some millimetres."""
DRIVEN = 3
"""Least number of joints in a row that make an arm if a motor drives one of them."""


class Group(Value):
    """Bodies that are fixed to each other.

    Args:
        root: whose frame it has.
        bodies: all of them.
        kind: how it moves.
        parent: root of what it is mounted in; 0 for nothing.
        carrier: all bodies of that.
    """

    root: int
    bodies: tuple[int, ...]
    kind: Literal["fixed", "joint", "free"]
    parent: int = 0
    carrier: tuple[int, ...] = ()


class Grouped(Value):
    """Groups of bodies that are fixed to each other, of a whole scene, with notes on bodies that were not
    understood.

    Args:
        groups: in the file's order.
        notes: for people.
        robots: the lowest body of each robot, which is left out.
    """

    groups: tuple[Group, ...]
    notes: tuple[str, ...]
    robots: tuple[int, ...] = ()


def grouped(model: Any, data: Any) -> Grouped:
    """Group the bodies of a model that move together.

    Fixed bodies are grouped, too, unless it is only a room that joins them.
    """
    robots, bases, notes = _robots(model)
    rooms = _rooms(model, data)
    of: dict[int, int] = {}
    kinds: dict[int, tuple[Literal["fixed", "joint", "free"], int]] = {}
    for body in range(1, model.nbody):
        above = int(model.body_parentid[body])
        if body in robots:
            continue
        carrier = of.get(above, 0)
        kind, note = _kind(model, body, kinds[carrier][0] if carrier else "fixed")
        notes += [note] if note else []
        own = kind != "fixed" or not carrier or above in rooms
        of[body] = body if own else carrier
        if own:
            kinds[body] = (kind, carrier)
    members = {root: tuple(b for b, r in of.items() if r == root) for root in kinds}
    return Grouped(tuple(Group(r, members[r], k, p, members.get(p, ())) for r, (k, p) in kinds.items()), tuple(notes), bases)


def _kind(model: Any, body: int, carrier: str) -> tuple[Literal["fixed", "joint", "free"], str]:
    """Kind of a body's motion ("fixed", "joint" or "free"), and a note on motion that is not supported."""
    types, name = [int(model.jnt_type[j]) for j in joints_of(model, body)], model.body(body).name
    if not types:
        said = f"'{name}' is a mocap body; it is fixed where it starts" if model.body_mocapid[body] >= 0 else ""
        return "fixed", said
    if types == [FREE]:
        return "free", ""
    if len(types) > 1 or types == [BALL]:
        what = "a ball joint" if types == [BALL] else f"{len(types)} joints"
        return "fixed", f"'{name}' has {what}; things have one hinge or slide, so it is held where it starts"
    if carrier == "free":
        return "fixed", f"'{name}' is on a joint of a body that can be carried; its own joint is held where it starts"
    return "joint", ""


def _rooms(model: Any, data: Any) -> frozenset[int]:
    """Find bodies that only group others, such as a room: fixed, without shape and site, with parts that do
    not touch each other.

    A kitchen's cupboards are not one thing; a table's legs, which touch its top, are.
    """
    found = set()
    for body in range(1, model.nbody):
        if int(model.body_geomnum[body]) or int(model.body_weldid[body]) or body in set(map(int, model.site_bodyid)):
            continue
        boxes = [b for c in range(body + 1, model.nbody) if int(model.body_parentid[c]) == body and (b := _box(model, data, c)) is not None]
        if len(boxes) > 1 and not _touching(boxes):
            found.add(body)
    return frozenset(found)


def _box(model: Any, data: Any, top: int) -> tuple[Any, Any] | None:
    """Lowest and highest corner, world axes, of the box around all colliding geoms fixed to a body; None if the
    body moves or has no such geoms."""
    if int(model.body_weldid[top]):
        return None
    low, high = np.full(3, np.inf), np.full(3, -np.inf)
    for g in range(model.ngeom):
        body = int(model.geom_bodyid[g])
        while body > top:
            body = int(model.body_parentid[body])
        if body != top or not int(model.geom_contype[g] | model.geom_conaffinity[g]) or int(model.body_weldid[model.geom_bodyid[g]]):
            continue
        turn = data.geom_xmat[g].reshape(3, 3)
        middle, reach = data.geom_xpos[g] + turn @ model.geom_aabb[g, :3], np.abs(turn) @ model.geom_aabb[g, 3:]
        low, high = np.minimum(low, middle - reach), np.maximum(high, middle + reach)
    return (low, high) if (low < high).all() else None


def _touching(boxes: list[tuple[Any, Any]]) -> bool:
    """Whether boxes form one connected cluster, with gaps of at most ``GAP`` [m] between neighbours."""
    reached, waiting = [boxes[0]], boxes[1:]
    while near := [b for b in waiting if any((b[0] <= r[1] + GAP).all() and (r[0] <= b[1] + GAP).all() for r in reached)]:
        reached += near
        waiting = [b for b in waiting if not any(b is n for n in near)]
    return not waiting


def _robots(model: Any) -> tuple[frozenset[int], tuple[int, ...], list[str]]:
    """Return the bodies of all robot arms in a scene file, the base body of each arm, and a note on each arm for people."""
    driven = {int(model.actuator_trnid[a, 0]) for a in range(model.nu) if int(model.actuator_trntype[a]) in (0, 1)}
    found: set[int] = set()
    bases: list[int] = []
    notes: list[str] = []
    for body in range(1, model.nbody):
        if body in found or not len(joints_of(model, body)):
            continue
        tree = tuple(_below(model, body))
        length = max(_chain(model, b, body) for b in tree)
        motors = any(j in driven for b in tree for j in joints_of(model, b))
        if length >= CHAIN or (length >= DRIVEN and motors):
            base = _base(model, body, frozenset(tree))
            found.update(base)
            bases.append(min(base))
            why = f"{length} joints in a row" + (", driven by motors" if motors else "")
            notes.append(f"'{model.body(min(base)).name}' is a robot ({why}): left out with {len(base)} bodies; 'robot' names who acts")
    return frozenset(found), tuple(bases), notes


def _below(model: Any, body: int) -> Iterator[int]:
    """Yield a body and all bodies below it in the body tree."""
    inside = {body}
    for b in range(body, model.nbody):
        if b in inside or int(model.body_parentid[b]) in inside:
            inside.add(b)
            yield b


def _chain(model: Any, body: int, top: int) -> int:
    """Number of hinge and slide joints from a body up to one of its ancestors in the body tree, both included."""
    count = 0
    while True:
        count += sum(int(model.jnt_type[j]) in (HINGE, SLIDE) for j in joints_of(model, body))
        if body == top:
            return count
        body = int(model.body_parentid[body])


def _base(model: Any, body: int, tree: frozenset[int]) -> frozenset[int]:
    """Return the bodies of an arm and of its base: those above the arm that carry nothing else that moves.

    Of the bodies above the arm, at most one has shapes.
    """
    above, first = int(model.body_parentid[body]), True
    while above and not len(joints_of(model, above)):
        whole = frozenset(_below(model, above))
        shapes = int(model.body_geomnum[above]) > 0
        others = any(len(joints_of(model, b)) for b in whole - tree)
        if others or (shapes and not first):
            break
        tree, above, first = whole, int(model.body_parentid[above]), first and not shapes
    return tree
