"""3D viewer of a scene, with a time slider, on viser (https://viser.studio).

Only ``cramlite view`` imports it: viser is an extra.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from contextlib import redirect_stdout
from io import StringIO
from typing import Any

import numpy as np
import viser

from ..model.run.rollout import Rollout, Scene

EYE = (-0.75, -1.45, 0.85)
"""First position of the camera, from the middle of the moving things [m]: the direction of the report's pictures."""
LONGEST = 90
"""Largest number of characters of a program line that the viewer shows."""


class Viewer:
    """3D viewer of a run in the browser; its time slider, or ``show``, moves all bodies to their poses at a time.

    Args:
        scene: shapes, and where they are at ``samples``.
        rollout: of which these are samples.
        samples: one for each position of the slider.
        program: lines of its text, to say what is done.
        host, port: where to serve.
    """

    def __init__(
        self, scene: Scene, rollout: Rollout, samples: Sequence[int], program: Sequence[str], host: str, port: int
    ) -> None:
        with redirect_stdout(StringIO()):  # viser prints its address in a box; ours is one line
            self.server = viser.ViserServer(host=host, port=port, verbose=False, label="cramlite")
        self._scene, self._rollout, self._samples, self._program = scene, rollout, samples, program
        self._last = len(samples) - 1
        self._step = float(scene.times[1] - scene.times[0]) if self._last else 1.0
        self.bodies = self._add_bodies()
        self._add_path()
        self._aim()
        self._add_controls()
        self.show(0)

    @property
    def url(self) -> str:
        """Address of the viewer."""
        return f"http://{self.server.get_host()}:{self.server.get_port()}"

    def show(self, position: int) -> None:
        """Move all bodies of the scene to their poses at a position of the time slider."""
        with self.server.atomic():
            for body, frame in self.bodies.items():
                track = self._scene.poses[body]
                if len(track) > 1:
                    frame.position, frame.wxyz = track[position, :3], track[position, 3:]
            self._arrow(position)
        self.words.content = self._caption(position)

    def play(self, seconds: float = 0.0) -> None:
        """Serve the viewer, and advance the slider while its play box is ticked; return after ``seconds``, or
        never if 0."""
        end = time.monotonic() + seconds if seconds else float("inf")
        while (now := time.monotonic()) < end:
            if self.playing.value:
                self.slider.value = 0.0 if self.position >= self._last else (self.position + 1) * self._step
            time.sleep(max(self._step / float(self.speed.value) - (time.monotonic() - now), 0.005))

    def close(self) -> None:
        """Stop the viewer's web server."""
        with redirect_stdout(StringIO()):
            self.server.stop()

    @property
    def position(self) -> int:
        """Index of the sample that the viewer's time slider stands at, from 0."""
        return min(round(float(self.slider.value) / self._step), self._last)

    def _add_bodies(self) -> dict[str, Any]:
        """Add a coordinate frame for each body, with the body's shapes as children; return the frames."""
        frames = {}
        for body, track in self._scene.poses.items():
            name = f"/{self._scene.owners[body]}/{body}".replace("//", "/")
            frames[body] = self.server.scene.add_frame(name, show_axes=False, position=track[0, :3], wxyz=track[0, 3:])
        for number, solid in enumerate(self._scene.solids):
            colour = tuple(round(255 * c) for c in solid.colour[:3])
            self.server.scene.add_mesh_simple(
                f"{frames[solid.body].name}/shape {number}",
                solid.vertices.astype(np.float32),
                np.asarray(solid.faces, dtype=np.uint32),
                color=colour,
                opacity=None if solid.colour[3] >= 1 else solid.colour[3],
                flat_shading=True,
            )
        return frames

    def _add_path(self) -> None:
        """Draw the path of the tool as a line in the 3D scene."""
        points = self._rollout.poses["effector"][list(self._samples), :3]
        if len(points) > 1:
            pairs = np.stack([points[:-1], points[1:]], axis=1).astype(np.float32)
            self.server.scene.add_line_segments("/path of the tool", pairs, colors=(60, 110, 165), thickness=0.002)

    def _aim(self) -> None:
        """Point the camera at the middle of all moving things."""
        points = self._rollout.poses["effector"][:, :3]
        middle = (points.min(axis=0) + points.max(axis=0)) / 2
        self.server.scene.set_up_direction("+z")
        self.server.initial_camera.look_at = tuple(middle)
        self.server.initial_camera.position = tuple(middle + EYE)

    def _add_controls(self) -> None:
        gui, whole = self.server.gui, self._last * self._step
        self.slider = gui.add_slider(
            "Time [s]", min=0.0, max=max(whole, self._step), step=self._step, initial_value=0.0
        )
        self.playing = gui.add_checkbox("Play", initial_value=False)
        self.speed = gui.add_dropdown("Speed", ("0.25", "0.5", "1", "2", "4"), initial_value="1")
        self.words = gui.add_markdown("")

        self.slider.on_update(lambda _event: self.show(self.position))

    def _arrow(self, position: int) -> None:
        """Draw the force of the tool as a line, 1 cm for 1 N."""
        sample = self._samples[position]
        begin, force = self._rollout.poses["effector"][sample, :3], self._rollout.wrench[sample, :3]
        line = np.array([[begin, begin + 0.01 * force]], dtype=np.float32)
        self.server.scene.add_line_segments("/force", line, colors=(194, 47, 29), thickness=0.006)

    def _caption(self, position: int) -> str:
        """Format program line, force and gripper opening at a slider position as Markdown."""
        rollout, sample = self._rollout, self._samples[position]
        number = int(rollout.lines[sample])
        text = self._program[number - 1].strip() if 0 < number <= len(self._program) else ""
        force = float(rollout.contact_force()[sample])
        line = f"line {number}: `{text[:LONGEST]}`" if text else f"line {number}" if number else "no line"
        return f"{line}\n\nforce {force:.1f} N, gripper {1000 * float(rollout.opening[sample]):.0f} mm"
