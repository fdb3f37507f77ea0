"""A picture tells which things are where they are believed, which are not, and of which it cannot tell."""

from __future__ import annotations

from collections.abc import Mapping

import pytest
from msgspec.structs import replace

from cramlite import Engine
from cramlite.model import Camera, Geom, Intrinsics, Pose, Thing, World
from cramlite.perception.sightings import Seen, Sighting, sightings
from cramlite.plugin.catalogue import Knowledge

EYE = Camera(Pose.from_rotvec((0.0, 0.0, 1.0), (3.14159265, 0.0, 0.0)), intrinsics=Intrinsics(300, 300, 159.5, 119.5, 320, 240))
TABLE = Thing("table", "soma:Table", Pose((0.0, 0.0, -0.01)), (Geom("box", (0.6, 0.6, 0.01)),))
SCREEN = Thing("screen", "soma:DesignedTool", Pose((0.0, 0.0, 0.4)), (Geom("box", (0.08, 0.08, 0.005)),))
BLOCK = Thing("block", "soma:DesignedTool", Pose((0.0, 0.0, 0.03)), (Geom("box", (0.03, 0.03, 0.03)),), mass=0.2)
SHEET = replace(BLOCK, pose=Pose((0.0, 0.0, 0.002)), geoms=(Geom("box", (0.05, 0.05, 0.002)),))
CRUMB = replace(BLOCK, pose=Pose((0.0, 0.0, 0.01)), geoms=(Geom("box", (0.008, 0.008, 0.01)),))


@pytest.fixture(scope="module")
def knowledge() -> Knowledge:
    return Engine().knowledge


def judged(knowledge: Knowledge, really: Mapping[str, Thing | None], block: Thing = BLOCK) -> Sighting:
    """The sighting of a block that is believed on the table, in a world where some things are otherwise."""
    things = {t.name: t for t in (TABLE, block)}
    real = World(tuple(t for t in {**things, **really}.values() if t is not None))
    (found,) = sightings(knowledge.simulator.look(real, {}, EYE, seed=1), EYE, World(tuple(things.values())), ["block"], knowledge)
    return found


def at(x: float, z: float = 0.03) -> dict[str, Thing]:
    return {"block": replace(BLOCK, pose=Pose((x, 0.0, z)))}


@pytest.mark.parametrize(
    ("really", "seen"),
    [
        ({}, Seen.THERE),
        (at(0.004), Seen.THERE),  # what poses and cameras err by
        (at(0.06), Seen.GONE),
        (at(0.0, -0.2), Seen.GONE),
        ({"block": None}, Seen.GONE),
        ({"screen": SCREEN}, Seen.HIDDEN),
        ({"screen": SCREEN, "block": None}, Seen.HIDDEN),  # nobody can tell that it is gone
    ],
)
def test_a_picture_tells_where_a_block_is_not(knowledge: Knowledge, really: dict[str, Thing | None], seen: Seen) -> None:
    found = judged(knowledge, really)
    assert found.seen is seen, found.reason


@pytest.mark.parametrize(("thing", "why"), [(SHEET, "0 measured pixels"), (CRUMB, "measured pixels")])
def test_what_is_too_flat_or_too_small_cannot_be_told(knowledge: Knowledge, thing: Thing, why: str) -> None:
    found = judged(knowledge, {}, thing)
    assert found.seen is Seen.HIDDEN and why in found.reason
