"""Usual upward directions of an object model, derived from its shape: the stable poses of its convex hull."""

from __future__ import annotations

from typing import Any

import numpy as np

from cramlite.model import Vector3

LIKELY = 0.03
"""Share of random drops below which a stable pose is left out: a book on its edge has 0.05."""
SAME = 0.985
"""Cosine of the angle (10 deg) below which two directions count as the same: the facets of a round foot."""
MOST = 6
NAMES = {
    "x": (1.0, 0.0, 0.0), "-x": (-1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0),
    "-y": (0.0, -1.0, 0.0), "z": (0.0, 0.0, 1.0), "-z": (0.0, 0.0, -1.0),
}  # fmt: skip


def upward(mesh: Any) -> tuple[tuple[Vector3, float], ...]:
    """Return the directions in a mesh's frame that point up in its stable poses, each with the share of random
    drops that end so.

    Args:
        mesh: trimesh.Trimesh.

    Returns:
        At most ``MOST``, the likeliest first. Never empty.
    """
    import trimesh

    try:
        turns, shares = trimesh.poses.compute_stable_poses(mesh.convex_hull, n_samples=1, threshold=0.005)
    except Exception:  # of a hull that is flat, qhull and networkx raise what they like
        return (((0.0, 0.0, 1.0), 1.0),)
    found: list[list[Any]] = []
    for turn, share in zip(turns, shares, strict=True):
        up = turn[2, :3]
        same = next((f for f in found if float(f[0] @ up) > SAME), None)
        if same is None:
            found.append([up, float(share)])
        else:
            same[1] += float(share)
    kept = sorted((f for f in found if f[1] >= LIKELY), key=lambda f: -f[1])[:MOST] or [[np.array((0.0, 0.0, 1.0)), 1.0]]
    return tuple(((float(u[0]), float(u[1]), float(u[2])), s) for u, s in kept)


def said(up: Vector3) -> str:
    """Return a direction in words: the axis that it is, else its numbers."""
    for name, axis in NAMES.items():
        if float(np.dot(axis, up)) > SAME:
            return name
    return "({:.2f}, {:.2f}, {:.2f})".format(*up)
