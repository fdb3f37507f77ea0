"""Segments by shape alone: print does not part a thing, a concave edge parts two, and a map leaves it to colour."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Any

import numpy as np
import pytest
from msgspec.structs import replace

from cramlite import Engine
from cramlite.model import Camera, Geom, Intrinsics, Pose, Thing, View, World
from cramlite.perception.active_perception import ask
from cramlite.perception.query import ObjectQuery

EYE = Pose.from_axes((0.55, 0.0, 0.55), z=(-0.707, 0.0, -0.707), x=(0.0, 1.0, 0.0))
KINECT = Intrinsics(525.0, 525.0, 319.5, 239.5, 640, 480)
TABLE = Thing("table", "cram:Table", Pose((0.0, 0.0, -0.02)), (Geom("box", (0.6, 0.6, 0.02)),))


@lru_cache(maxsize=1)
def engine() -> Engine:
    return Engine()


def box(name: str, half: tuple[float, float, float], at: tuple[float, float, float], yaw: float = 0.0) -> Thing:
    return Thing(name, "dul:PhysicalObject", Pose.from_rotvec(at, (0, 0, math.radians(yaw))), (Geom("box", half),))


def seen(*things: Thing, seed: int = 0) -> View:
    """A noisy picture of things on a table, all covered with print of tiles of 12 pixels."""
    knowledge = engine().knowledge
    view = knowledge.simulator.look(World((TABLE, *things)), knowledge.robots, Camera(EYE, intrinsics=KINECT), seed=seed)
    print_ = np.random.default_rng(seed).integers(60, 255, (40, 54, 3)).astype(np.uint8)
    return replace(view, rgb=np.kron(print_, np.ones((12, 12, 1), np.uint8))[:480, :640])


def segments(view: View, fixtures: tuple[Thing, ...] = ()) -> tuple[list[Any], list[str]]:
    """Masks, and the experts that were asked for them."""
    found = ask(ObjectQuery(wanted=("segments",)), view, fixtures, engine().knowledge)
    return [s.mask for s in found.scene["segments"].value], [r.expert for r in found.runs if r.output == "segments"]


ONE = box("one", (0.04, 0.06, 0.05), (0.0, 0.0, 0.05), 30)
BEFORE = box("before", (0.03, 0.03, 0.03), (0.075, 0.0, 0.03), 0)
UPON = box("upon", (0.02, 0.03, 0.02), (0.0, 0.0, 0.12), 30)
APART = box("apart", (0.03, 0.03, 0.03), (0.0, 0.2, 0.03), 10)


@pytest.mark.parametrize(
    ("things", "count"), [((ONE,), 1), ((ONE, APART), 2), ((ONE, BEFORE), 2), ((ONE, UPON), 2), ((ONE, BEFORE, UPON, APART), 4)],
    ids=["alone", "apart", "touching", "stacked", "all"],
)  # fmt: skip
def test_things_are_parted_where_they_meet(things: tuple[Thing, ...], count: int) -> None:
    view = seen(*things)
    found, asked = segments(view)
    assert asked == ["concave_segments"] and len(found) == count
    for thing in things:
        alone = [seen(*(t for t in things if t is not thing), seed=0).depth, view.depth]
        shown = np.abs(alone[0] - alone[1]) > 0.008
        assert max(np.count_nonzero(m & shown) / np.count_nonzero(m | shown) for m in found) > 0.75, thing.name


def test_a_map_leaves_it_to_colour() -> None:
    _, asked = segments(seen(ONE), (TABLE,))
    assert asked == ["concave_segments", "edge_segments"]


def test_nothing_on_a_table_is_nothing() -> None:
    found = ask(ObjectQuery(wanted=("segments",)), seen(), (), engine().knowledge)
    assert not found.answers
