"""Words for the shape and colours of object models."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import trimesh

from cramlite_plugins.imports.library import look
from cramlite_plugins.imports.library.looks import looks_of

RED, GREEN, WHITE = (0.8, 0.1, 0.1), (0.1, 0.6, 0.2), (0.9, 0.9, 0.88)


def revolved(*profile: tuple[float, float]) -> Any:
    """A body of revolution about z, from (radius, height) pairs [m]."""
    return trimesh.creation.revolve(np.array(profile), sections=48)


def painted(*parts: tuple[Any, tuple[float, float, float]]) -> Any:
    """Meshes of one colour each, as a library has them."""
    return look.whole([look.plain(np.asarray(mesh.triangles, float), rgb) for mesh, rgb in parts])


BOTTLE = revolved((0, 0), (0.03, 0), (0.03, 0.12), (0.012, 0.17), (0.012, 0.2), (0, 0.2))
CAN = revolved((0, 0), (0.033, 0), (0.033, 0.1), (0, 0.1))
BOWL = revolved((0, 0), (0.04, 0), (0.08, 0.05), (0.075, 0.05), (0.035, 0.005), (0, 0.005))
TRAY = trimesh.util.concatenate([
    trimesh.creation.box((0.4, 0.3, 0.01)),
    *(trimesh.creation.box((s, t, 0.06), trimesh.transformations.translation_matrix((x, y, 0.03)))
      for s, t, x, y in ((0.01, 0.3, 0.2, 0), (0.01, 0.3, -0.2, 0), (0.4, 0.01, 0, 0.15), (0.4, 0.01, 0, -0.15))),
])  # fmt: skip


@pytest.mark.parametrize(
    ("mesh", "nouns"),
    [(trimesh.creation.box((0.08, 0.02, 0.12)), ("box",)), (CAN, ("can",)), (BOTTLE, ("bottle",)), (BOWL, ()), (TRAY, ())],
)
def test_a_shape_has_a_noun(mesh: Any, nouns: tuple[str, ...]) -> None:
    assert looks_of(painted((mesh, RED)), "z", loose=True).nouns == nouns
    assert looks_of(painted((mesh, RED)), "z", loose=False).nouns == (), "furniture is not called by its shape"


def test_large_colours_and_small_ones_are_told_apart() -> None:
    cap = trimesh.creation.cylinder(0.012, 0.03, transform=trimesh.transformations.translation_matrix((0, 0, 0.215)))
    found = looks_of(painted((BOTTLE, WHITE), (cap, GREEN)), "z", loose=True)
    assert found.colours[0] == "white" and found.marks == ("green",)


def test_a_lying_bottle_is_one_too() -> None:
    lying = BOTTLE.copy()
    lying.apply_transform(trimesh.transformations.rotation_matrix(np.pi / 2, (1, 0, 0)))
    assert looks_of(painted((lying, RED)), "", loose=True).nouns == ("bottle",)
