"""Fronts of things: the direction that they face."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from cramlite.model import Feature, Floats

FRONTS = ("cram:Front", "vrps:Hole")
"""Classes of features whose z axis leads out of a thing's front, in order of preference: a product that hangs
by its hole faces whoever takes it."""


def front(features: Iterable[Feature]) -> Floats:
    """Return the direction that a thing's front faces, (3,) in its frame.

    Without a feature that says so it is x: out of a cabinet, to the handle of a mug.
    """
    found = {f.type: f.pose.rotate((0.0, 0.0, 1.0)) for f in features}
    return next((found[kind] for kind in FRONTS if kind in found), np.array([1.0, 0.0, 0.0]))
