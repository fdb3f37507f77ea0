"""Region of a picture with what registration of known models needs of it, each worked out once."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from cramlite.model import Mask, Value

from ..dimensions import extents
from ..pose.model import Floats32
from ..pose.outline import Outline
from ..pose.starts import scene_clouds
from ..values import Extents
from .pieces import covered
from .reading import Scene, bad, rarity
from .standing import tops

LOWEST, HIGHEST = 0.05, 0.99
"""Share of a region's points that are its lowest, and share of them that the others are higher than."""


class Region(Value, eq=False, dict=True):
    """Region of a scene's picture that known models are registered with.

    Args:
        mask: (height, width) of its pixels.
    """

    scene: Scene
    mask: Mask

    @cached_property
    def seen(self) -> tuple[Floats32, Outline] | None:
        """Return the region's points in the optical frame, and its outline; None if the points are too few."""
        view = self.scene.picture.view
        clouds = scene_clouds(view, self.mask)
        if not clouds or len(clouds[-1].points) < self.scene.limits["pixels"] / 2:
            return None
        return clouds[-1].points, Outline.of(view, clouds[-1].mask, self.scene.beside_edges)

    @cached_property
    def is_covered(self) -> bool:
        """Check whether something may hide more of the region's thing."""
        return covered(self.scene.picture.view, self.mask, self.scene.front) > self.scene.limits["covered"]

    @cached_property
    def extents(self) -> Extents:
        """Return the size of the box around the region's points."""
        return extents(self.scene.points[self.mask])

    @cached_property
    def floor(self) -> float | None:
        """Return the height of the furniture on which the region's thing stands [m]; None if there is none near its lowest points."""
        points = self.scene.points[self.mask]
        low = points[points[:, 2] <= np.quantile(points[:, 2], LOWEST)].mean(axis=0)
        near = self.scene.limits["floor_m"]
        return max((top for top in tops(self.scene.fixtures, low) if abs(low[2] - top) < near), default=None)

    @cached_property
    def highest(self) -> float:
        """Return the height of the region's highest points [m], but for a few that lie there by noise."""
        return float(np.quantile(self.scene.points[self.mask][:, 2], HIGHEST))

    @property
    def bad(self) -> float:
        """Return the score below which a model does not explain the region."""
        return bad(self.mask, self.scene.limits)

    @property
    def rarity(self) -> float:
        """Return the factor by which limits of scores are lowered for the region, as ``rarity``."""
        return rarity(self.mask, self.scene.limits)
