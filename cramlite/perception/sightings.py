"""Comparison of a picture with the one that a belief predicts: which things are where they are believed, and which are not."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np
from msgspec.structs import replace

from ..base.value import Value
from ..base.word import Word
from ..model.view import Depth, View
from ..model.world.world import Camera, World

if TYPE_CHECKING:
    from ..plugin.catalogue import Knowledge

STEP = 2
"""Pixels of the picture, along each side, for each ray of a predicted picture."""
TELLS = 0.008
"""Least difference of depth that a thing makes at a pixel which is to tell of it [m]: half of it exceeds the errors of depth and of a
calibrated camera, 2 to 3 mm."""
BEFORE = 0.015
"""Least distance in front of a predicted surface at which a measured point counts as something that hides it [m]: errors of poses, of
the camera and of depth are smaller."""
LEAST = 30
"""Least number of compared pixels from which a thing is judged."""
ENOUGH = 0.5
"""Least share of the pixels not hidden that must show a thing, and least share of all that must not be hidden."""


class Seen(Word):
    """Judgement of a thing by a picture."""

    THERE = "there", "the picture shows it where it is believed"
    GONE = "not there", "the picture shows what is behind its believed place"
    HIDDEN = "not seen", "the picture does not tell"


class Sighting(Value):
    """Comparison of a picture with a thing at its believed pose.

    Args:
        thing: its name.
        pixels: number of pixels compared: the thing changes the predicted depth there, and depth was measured.
        there: share of them that show the thing.
        gone: share of them that show the background behind it.
    """

    thing: str
    pixels: int
    there: float
    gone: float

    @property
    def seen(self) -> Seen:
        """Judgement by the shares of the pixels."""
        told = self.there + self.gone
        if self.pixels < LEAST or told < ENOUGH:
            return Seen.HIDDEN
        return Seen.THERE if self.there >= ENOUGH * told else Seen.GONE

    @property
    def reason(self) -> str:
        """Numbers behind the judgement, as a clause."""
        if self.pixels < LEAST:
            return f"'{self.thing}' would cover {self.pixels} measured pixels, and {LEAST} are needed to tell"
        hidden = max(0.0, 1.0 - self.there - self.gone)
        return (
            f"of {self.pixels} pixels on '{self.thing}' {100 * self.there:.0f} % show it, {100 * self.gone:.0f} % what is behind it, "
            f"{100 * hidden:.0f} % something in front"
        )


def sightings(view: View, camera: Camera, believed: World, things: Iterable[str], knowledge: Knowledge) -> tuple[Sighting, ...]:
    """Compare a picture with the believed world: one sighting for each of the named things.

    Args:
        camera: that took it; on a flange, with the joints of the arm at that time.
        believed: world with the arm as it stood, and things where they should be.
    """
    view, seer = view.thinned(STEP), replace(camera, intrinsics=camera.intrinsics.thinned(STEP), noise=0.0)

    def predicted(world: World) -> Depth:
        return knowledge.simulator.look(world, knowledge.robots_of(world), seer, seed=0).depth

    names = tuple(things)
    whole = predicted(believed) if names else None
    return tuple(_compared(n, view.depth, whole, predicted(_without(believed, n))) for n in names if whole is not None)


def _without(world: World, name: str) -> World:
    """Return a world without a thing, and without what is mounted on it by joints."""
    gone = {name, *(t.name for t in world.mounted_on(name))}
    return replace(world, things=tuple(t for t in world.things if t.name not in gone))


def _compared(name: str, measured: Depth, with_it: Depth, without: Depth) -> Sighting:
    """Count the pixels of a picture that show a thing, or what would be seen without it.

    Args:
        measured, with_it, without: depth images (height, width) [m]; NaN, where nothing was measured, or nothing is.
    """
    behind = np.where(np.isnan(without), np.inf, without)
    with np.errstate(invalid="ignore"):
        tells = (behind - with_it > TELLS) & ~np.isnan(measured)
    depth, near, far = measured[tells], with_it[tells], behind[tells]
    if not len(depth):
        return Sighting(name, 0, 0.0, 0.0)
    border = np.minimum((near + far) / 2, near + BEFORE)
    there = (depth >= near - BEFORE) & (depth <= border)
    return Sighting(name, len(depth), float(there.mean()), float((depth > border).mean()))
