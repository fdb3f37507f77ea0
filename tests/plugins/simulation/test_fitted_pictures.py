"""A camera that is fitted to things has them in its picture, and little else."""

from __future__ import annotations

import numpy as np

from cramlite.model import Pose, Rollout, World
from cramlite_plugins.objects.products_and_fixtures import block, table
from cramlite_plugins.shapes.bounds import corners
from cramlite_plugins.simulation.camera.ray_tracer import Camera
from cramlite_plugins.simulation.recording.pictures import fitted


def test_all_of_what_a_picture_is_fitted_to_is_in_it_and_fills_it() -> None:
    """Corners of what stands still, and the places where the other things were, in the plane of the picture."""
    shelf, cup = table("shelf", Pose((0.1, -0.5, 0.2)), size=(0.3, 0.3, 0.4)), block("cup", Pose((0.5, 0.2, 0.1)))
    track = np.array([[0.5, 0.2, 0.1, 1, 0, 0, 0], [0.1, -0.5, 0.5, 1, 0, 0, 0]])
    still = np.repeat([[*shelf.pose.position, 1, 0, 0, 0]], 2, axis=0)
    nobody = np.zeros((2, 0))
    run = Rollout(World((shelf, cup), ()), "arm", np.arange(2.0), {"shelf": still, "cup": track}, ((), ()), nobody, nobody, nobody, nobody)
    for width, height in ((480, 360), (200, 400)):
        camera = fitted(Camera(), run, ("shelf", "cup"), (width, height))
        places = np.concatenate([corners(shelf, shelf.pose), track[:, :3]])
        right, down, deep = camera.pose.inverse().apply(places).T
        half = np.tan(camera.vertical_fov / 2)
        across, along = np.abs(right / deep).max() / (half * width / height), np.abs(down / deep).max() / half
        assert max(across, along) < 1.0, "something is outside"
        assert max(across, along) > 0.5, "nothing comes near the rim"
