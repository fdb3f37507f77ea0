"""Orientation priors for pose estimation: alignments of object axes with world directions."""

from __future__ import annotations

import numpy as np

from cramlite.model import Floats, Pose, Value, Vector3

from .model import Floats32


class Alignment(Value):
    """Constraint that one of some axes of the object is near one of some directions of the world.

    Args:
        axes: unit vectors of the model's frame; directions: of the world's.
        before, after: how far off [rad] a start and a result may be.
    """

    axes: tuple[Vector3, ...]
    directions: tuple[Vector3, ...]
    before: float = float(np.radians(60))
    after: float = float(np.radians(40))


class Prior(Value):
    """Prior on an object's orientation: axes of the object that point roughly in given world directions; none if all are possible."""

    alignments: tuple[Alignment, ...] = ()


UPRIGHT = Prior((Alignment(((0.0, 0.0, 1.0),), ((0.0, 0.0, 1.0),)),))
"""Prior of things that hang or stand: the model's z axis points up, within 60 degrees before and 40 after (docs/explanation)."""


def alignment_error(camera: Pose, turn: Floats32, alignment: Alignment) -> Floats:
    """Return for each of H rotations the smallest angle [rad] between any axis of the model and any direction of the
    world: (H,).

    Args:
        camera: the optical frame in the world.
        turn: (H, 3, 3) rotations from the optical frame to the model's.
    """
    axes, directions = np.array(alignment.axes), np.array(alignment.directions)
    in_model = np.einsum("hij,dj->hdi", turn, camera.inverse().rotate(directions))
    cosine = np.einsum("hdi,ai->hda", in_model, axes).max(axis=(1, 2), initial=-1.0)
    return np.asarray(np.arccos(np.clip(cosine, -1, 1)))
