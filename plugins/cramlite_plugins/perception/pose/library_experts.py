"""Pose experts that use the libraries small_gicp and Open3D, asked where the expert
``perception_registration`` is blocked or breaks."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from cramlite.plugin import Expert, Inputs, hookimpl

from .registration import FITTING, NEEDED, registered


def by_small_gicp(inputs: Inputs) -> Mapping[str, Any]:
    """Register known models by 24 point-to-plane ICPs of small_gicp, an extra."""
    from .libraries import small_gicp_pose

    return registered(inputs, small_gicp_pose)


def by_open3d(inputs: Inputs) -> Mapping[str, Any]:
    """Register known models by 24 point-to-plane ICPs of Open3D, an extra."""
    from .libraries import open3d_pose

    return registered(inputs, open3d_pose)


@hookimpl
def experts() -> Iterable[Expert]:
    """Return the experts that estimate poses by small_gicp and by Open3D; their stated costs were measured
    with one model at 640 x 480 pixels (tests/benchmarks/perception_pose.py)."""
    ways = (
        ("small_gicp_registration", "24 ICPs of small_gicp, if it is installed", by_small_gicp, 110.0),
        ("open3d_registration", "24 ICPs of Open3D, if it is installed", by_open3d, 240.0),
    )
    return [
        Expert(name, about, NEEDED, ("hypotheses",), run, "object", cost_ms=cost, parameters=FITTING)
        for name, about, run, cost in ways
    ]
