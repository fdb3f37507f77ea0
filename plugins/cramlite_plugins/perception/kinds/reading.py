"""Values of the interpretation of a picture: its input, explanations of its parts by known models, and limits of their scores."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property

import numpy as np
from scipy import ndimage

from cramlite.model import Depth, Floats, Mask, Pose, Thing, Value

from ..pose.registration import JointValue
from .agreement import Picture
from .appearance import Appearance


class Reading(Value, eq=False):
    """Explanation of a part of the picture by one known model at one pose.

    Args:
        appearance: of the model.
        pose: of its frame in the world.
        fit: 0 to 1, of its shape; colour: 0 to 1, of its printed texture.
        reasons: clauses with numbers.
        joints: (name, value, standard deviation) of each joint [m, rad]; empty where they were not looked at.
        held: factor of the score, less than 1 where the model would hover and another explanation stands.
    """

    appearance: Appearance
    pose: Pose
    fit: float
    colour: float
    reasons: tuple[str, ...] = ()
    joints: tuple[JointValue, ...] = ()
    held: float = 1.0

    @property
    def score(self) -> float:
        """Return the score of the explanation, fit^2 * colour * held, 0 to 1; the shape has the greater weight, as
        light and blur change colours."""
        return self.fit * self.fit * self.colour * self.held


class Part(Value, eq=False):
    """Part of the picture with its explanations, best first; none where no model explains it."""

    mask: Mask
    readings: tuple[Reading, ...]

    @property
    def score(self) -> float:
        """Return the score of the best explanation of this part of the picture; 0 if nothing explains it."""
        return self.readings[0].score if self.readings else 0.0


class Scene(Value, eq=False, dict=True):
    """Input of interpretation: the picture, its points (height, width, 3) in the world [m], the
    appearances of the known models, limits, the foreground, furniture, and the depth (height, width) at
    which the robot would be seen [m], NaN at pixels without the robot."""

    picture: Picture
    points: Floats
    appearances: tuple[Appearance, ...]
    limits: Mapping[str, float]
    front: Mask
    fixtures: tuple[Thing, ...] = ()
    robot: Depth | None = None

    @cached_property
    def beside_edges(self) -> Mask:
        """Return the mask of the pixels beside a jump in depth, whose points may lie between the two surfaces."""
        view = self.picture.view
        depth = np.where(view.valid, view.depth, np.nan)
        low = ndimage.minimum_filter(np.nan_to_num(depth, nan=np.inf), 3)
        high = ndimage.maximum_filter(np.nan_to_num(depth, nan=-np.inf), 3)
        return np.asarray(high - low > 0.025 * np.where(np.isfinite(low), low, 1.0))


def rarity(mask: Mask, limits: Mapping[str, float]) -> float:
    """Return the factor by which limits of scores are lowered for a large part of the picture; 1 for a small part.

    A wrong model seldom explains many pixels by chance.
    """
    return float(min(1.0, (limits["small"] / max(1, int(mask.sum()))) ** limits["rarer"]))


def bad(mask: Mask, limits: Mapping[str, float]) -> float:
    """Return the score below which a model does not explain a part of the picture."""
    return limits["bad"] * rarity(mask, limits)
