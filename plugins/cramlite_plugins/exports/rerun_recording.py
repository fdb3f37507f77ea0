"""Recording for rerun (https://rerun.io): shapes that move, curves of joints, forces and gripper, tasks, log and pictures.

Needs rerun-sdk (``pip install 'cramlite[rerun]'``). Everything is on the timeline "time" [s].
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from cramlite.plugin import Exporter, hookimpl

from .ros_bag import jpeg, picture_samples

if TYPE_CHECKING:
    from cramlite.model import Floats, RunRecord

APPLICATION, TIMELINE = "cramlite", "time"
WRENCH = ("fx", "fy", "fz", "tx", "ty", "tz")


@hookimpl
def exporters() -> Iterable[Exporter]:
    """Declare the export format of rerun recordings."""
    return [Exporter("rerun", ".rrd", "rerun", write_recording, {"rerun": "cramlite[rerun]"})]


def write_recording(run: RunRecord, out: Path) -> None:
    """Write a run to a new file as a recording for rerun."""
    import rerun

    with rerun.RecordingStream(APPLICATION, recording_id=run.name) as stream:
        stream.save(out)
        _add_bodies(rerun, run)
        _add_curves(rerun, run)
        _add_words(rerun, run)
        _add_pictures(rerun, run)
        stream.flush()


def _at(rerun: Any, times: Sequence[float] | Floats) -> Any:
    return rerun.TimeColumn(TIMELINE, duration=times)


def _add_bodies(rerun: Any, run: RunRecord) -> None:
    """Log a frame for each body, with the body's shapes below it.

    rerun's quaternions are x, y, z, w.
    """
    rerun.log("world", rerun.ViewCoordinates.RIGHT_HAND_Z_UP, static=True)
    for body, track in run.scene.poses.items():
        path, turns = f"world/{body}", track[:, [4, 5, 6, 3]]
        if len(track) == 1:
            rerun.log(path, rerun.Transform3D(translation=track[0, :3], quaternion=turns[0]), static=True)
        else:
            columns = rerun.Transform3D.columns(translation=track[:, :3], quaternion=turns)
            rerun.send_columns(path, indexes=[_at(rerun, run.scene.times)], columns=columns)
    for number, solid in enumerate(run.scene.solids):
        colour = [round(255 * c) for c in solid.colour]
        mesh = rerun.Mesh3D(vertex_positions=solid.vertices, triangle_indices=np.asarray(solid.faces), albedo_factor=colour)
        rerun.log(f"world/{solid.body}/shape_{number}", mesh, static=True)


def _add_curves(rerun: Any, run: RunRecord) -> None:
    """Add curves over time to the recording: each joint, each component of the wrench, the felt force, and the gripper's opening."""
    rollout = run.rollout
    curves = {f"joints/{name}": rollout.joints[:, k] for k, name in enumerate(run.joints)}
    curves |= {f"wrench/{name}": rollout.wrench[:, k] for k, name in enumerate(WRENCH)}
    curves |= {"force": rollout.contact_force(), "gripper/opening": rollout.opening}
    for path, values in curves.items():
        rerun.send_columns(path, indexes=[_at(rerun, rollout.times)], columns=rerun.Scalars.columns(scalars=values))


def _add_words(rerun: Any, run: RunRecord) -> None:
    """Add texts to the recording: tasks, steps and events when they begin and end, the contacts of each sample,
    and the program's log."""
    said = {
        "tasks": [(s.start, s.name) for s in run.tasks],
        "steps": [(s.start, s.name) for s in run.steps],
        "log": [(m.time, m.text) for m in run.rollout.messages],
        "events": [
            (t, f"{e.type} {word}: {', '.join(e.roles.values())}")
            for e in run.events for t, word in ((e.start, "begins"), (e.end, "ends"))
        ],
        "contacts": [
            (float(t), f"{c.a} - {c.b}: {c.force!r} N, upward {c.lift!r} N")
            for t, all_ in zip(run.rollout.times, run.rollout.touches, strict=True) for c in all_
        ],
    }  # fmt: skip
    for path, rows in said.items():
        if rows:
            times, texts = zip(*sorted(rows), strict=True)
            rerun.send_columns(path, indexes=[_at(rerun, times)], columns=rerun.TextLog.columns(text=texts))


def _add_pictures(rerun: Any, run: RunRecord) -> None:
    for sample in picture_samples(run.rollout.times):
        rerun.set_time(TIMELINE, duration=float(run.rollout.times[sample]))
        rerun.log("camera", rerun.EncodedImage(contents=jpeg(run.picture(sample)), media_type="image/jpeg"))
