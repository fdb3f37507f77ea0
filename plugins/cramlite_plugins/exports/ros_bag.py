"""ROS 2 bag of a run, stored as MCAP: Foxglove, ``ros2 bag``, PlotJuggler and rerun open it, with or without ROS.

Topics are of ROS's own types where there is one: tf2_msgs/TFMessage, sensor_msgs/JointState, geometry_msgs/WrenchStamped,
visualization_msgs/MarkerArray, sensor_msgs/CompressedImage, rcl_interfaces/Log. Contacts and events have types of their own, whose
definitions the file carries. Needs rosbags (``pip install 'cramlite[mcap]'``), which writes the container and the messages.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from cramlite.plugin import Exporter, hookimpl

if TYPE_CHECKING:
    from cramlite.model import RunRecord, Solid

WORLD = "world"
PICTURES = 1.0
"""Number of camera pictures per second of the run."""
QUALITY = 80
"""Quality of JPEG pictures, on Pillow's scale."""
INFO = 20
"""Level of a message in rcl_interfaces/Log that is for information."""
OWN_TYPES = {
    "cramlite_msgs/msg/Contact": "string a\nstring b\nfloat64 force\nfloat64 lift\nfloat64 press",
    "cramlite_msgs/msg/Contacts": "std_msgs/Header header\ncramlite_msgs/Contact[] contacts",
    "cramlite_msgs/msg/Event": "std_msgs/Header header\nstring type\nbool begins\nstring[] roles\nstring[] entities",
}
Said = tuple[str, str, float, Any]
"""Recorded message: topic, type, time [s] and content."""


@hookimpl
def exporters() -> Iterable[Exporter]:
    """Declare the export format of ROS 2 bags."""
    about = "Foxglove, ros2 bag, PlotJuggler, rerun"
    return [Exporter("mcap", "", about, write_bag, {"rosbags": "cramlite[mcap]"})]


def write_bag(run: RunRecord, out: Path) -> None:
    """Write a run as a new folder with one MCAP file and ``metadata.yaml``."""
    from rosbags.rosbag2 import StoragePlugin, Writer

    messages = Messages()
    said = sorted(messages.of(run), key=lambda s: s[2])
    with Writer(out, version=Writer.VERSION_LATEST, storage_plugin=StoragePlugin.MCAP) as bag:
        topics = {topic: kind for topic, kind, _, _ in said}
        opened = {topic: bag.add_connection(topic, kind, typestore=messages.store) for topic, kind in topics.items()}
        for topic, kind, time, message in said:
            bag.write(opened[topic], nanoseconds(time), messages.store.serialize_cdr(message, kind))


def nanoseconds(time: float) -> int:
    """Convert a time in seconds to nanoseconds, the unit of times in ROS bags."""
    return round(1e9 * time)


class Messages:
    """Messages of a run, of the types that ROS 2 Jazzy and ``OWN_TYPES`` define."""

    def __init__(self) -> None:
        from rosbags.typesys import Stores, get_types_from_msg, get_typestore

        self.store = get_typestore(Stores.ROS2_JAZZY)
        for name, text in OWN_TYPES.items():
            self.store.register(get_types_from_msg(text, name))

    def of(self, run: RunRecord) -> Iterator[Said]:
        """Yield the messages of a run, topic by topic."""
        yield from self._frames(run)
        yield from self._felt(run)
        yield from self._happened(run)
        yield "/markers", "visualization_msgs/msg/MarkerArray", float(run.rollout.times[0]), self._markers(run)
        yield from self._pictures(run)

    def _make(self, kind: str, **values: Any) -> Any:
        return self.store.types[kind](**values)

    def _header(self, time: float, frame: str = WORLD) -> Any:
        whole = nanoseconds(time)
        stamp = self._make("builtin_interfaces/msg/Time", sec=whole // 10**9, nanosec=whole % 10**9)
        return self._make("std_msgs/msg/Header", stamp=stamp, frame_id=frame)

    def _frames(self, run: RunRecord) -> Iterator[Said]:
        """Yield the frames of all bodies in the world: of moving bodies at every sample, of resting bodies once."""
        kind, times = "tf2_msgs/msg/TFMessage", run.scene.times.tolist()
        still = {body: track[0] for body, track in run.scene.poses.items() if len(track) == 1}
        yield "/tf_static", kind, times[0], self._make(kind, transforms=[self._transform(b, r, times[0]) for b, r in still.items()])
        moving = {body: track for body, track in run.scene.poses.items() if len(track) > 1}
        for k, time in enumerate(times):
            yield "/tf", kind, time, self._make(kind, transforms=[self._transform(b, t[k], time) for b, t in moving.items()])

    def _transform(self, body: str, row: Sequence[float], time: float) -> Any:
        x, y, z, qw, qx, qy, qz = map(float, row)
        move = self._make(
            "geometry_msgs/msg/Transform",
            translation=self._make("geometry_msgs/msg/Vector3", x=x, y=y, z=z),
            rotation=self._make("geometry_msgs/msg/Quaternion", x=qx, y=qy, z=qz, w=qw),
        )
        header = self._header(time)
        return self._make("geometry_msgs/msg/TransformStamped", header=header, child_frame_id=body, transform=move)

    def _felt(self, run: RunRecord) -> Iterator[Said]:
        """Yield ROS messages on joints, gripper, wrench and contacts for every sample of a run."""
        rollout, none = run.rollout, np.zeros(0)
        for k, time in enumerate(rollout.times.tolist()):
            header = self._header(time)
            position = np.ascontiguousarray(rollout.joints[k])
            state = self._make(
                "sensor_msgs/msg/JointState", header=header, name=list(run.joints), position=position, velocity=none, effort=none
            )
            yield "/joint_states", "sensor_msgs/msg/JointState", time, state
            opening = self._make("std_msgs/msg/Float64", data=float(rollout.opening[k]))
            yield "/gripper/opening", "std_msgs/msg/Float64", time, opening
            yield "/wrench", "geometry_msgs/msg/WrenchStamped", time, self._wrench(rollout.wrench[k], header)
            kind = "cramlite_msgs/msg/Contact"
            touches = [
                self._make(kind, a=t.a, b=t.b, force=t.force, lift=t.lift, press=math.nan if t.press is None else t.press)
                for t in rollout.touches[k]
            ]
            kind = "cramlite_msgs/msg/Contacts"
            yield "/contacts", kind, time, self._make(kind, header=header, contacts=touches)

    def _wrench(self, row: Any, header: Any) -> Any:
        force, torque = (dict(zip("xyz", map(float, part), strict=True)) for part in (row[:3], row[3:]))
        made = self._make(
            "geometry_msgs/msg/Wrench",
            force=self._make("geometry_msgs/msg/Vector3", **force),
            torque=self._make("geometry_msgs/msg/Vector3", **torque),
        )
        return self._make("geometry_msgs/msg/WrenchStamped", header=header, wrench=made)

    def _happened(self, run: RunRecord) -> Iterator[Said]:
        """Yield messages when a task, a step or an event begins or ends, and for each line of the program's log.

        At the end of the last task or step, the message is "".
        """
        for topic, spans in (("/task", run.tasks), ("/step", run.steps)):
            ends = [("", spans[-1].end)] if spans else []
            for name, time in [(s.name, s.start) for s in spans] + ends:
                yield topic, "std_msgs/msg/String", time, self._make("std_msgs/msg/String", data=name)
        kind = "cramlite_msgs/msg/Event"
        for event in run.events:
            named = {"type": event.type, "roles": list(event.roles), "entities": list(event.roles.values())}
            for time, begins in ((event.start, True), (event.end, False)):
                yield "/events", kind, time, self._make(kind, header=self._header(time), begins=begins, **named)
        for said in run.rollout.messages:
            stamp = self._header(said.time).stamp
            log = self._make(
                "rcl_interfaces/msg/Log", stamp=stamp, level=INFO, name=run.name, msg=said.text, file="", function="", line=said.line
            )
            yield "/rosout", "rcl_interfaces/msg/Log", said.time, log

    def _markers(self, run: RunRecord) -> Any:
        """ROS message with the shapes of a run's bodies, as triangles that move along with the bodies' frames."""
        found = [self._marker(number, solid) for number, solid in enumerate(run.scene.solids)]
        return self._make("visualization_msgs/msg/MarkerArray", markers=found)

    def _marker(self, number: int, solid: Solid) -> Any:
        marker: Any = self.store.types["visualization_msgs/msg/Marker"]
        corners = solid.vertices[np.asarray(solid.faces).ravel()].tolist()
        zero = self._make("builtin_interfaces/msg/Duration", sec=0, nanosec=0)
        image = self._make(
            "sensor_msgs/msg/CompressedImage", header=self._header(0.0, ""), format="", data=np.zeros(0, dtype=np.uint8)
        )
        return marker(
            header=self._header(0.0, solid.body), ns=solid.body, id=number, type=marker.TRIANGLE_LIST, action=marker.ADD,
            pose=self._pose(), scale=self._make("geometry_msgs/msg/Vector3", x=1.0, y=1.0, z=1.0),
            color=self._make("std_msgs/msg/ColorRGBA", **dict(zip("rgba", map(float, solid.colour), strict=True))), lifetime=zero,
            frame_locked=True, points=[self._make("geometry_msgs/msg/Point", x=x, y=y, z=z) for x, y, z in corners], colors=[],
            texture_resource="", texture=image, uv_coordinates=[], text="", mesh_resource="",
            mesh_file=self._make("visualization_msgs/msg/MeshFile", filename="", data=np.zeros(0, dtype=np.uint8)),
            mesh_use_embedded_materials=False,
        )  # fmt: skip

    def _pose(self) -> Any:
        return self._make(
            "geometry_msgs/msg/Pose",
            position=self._make("geometry_msgs/msg/Point", x=0.0, y=0.0, z=0.0),
            orientation=self._make("geometry_msgs/msg/Quaternion", x=0.0, y=0.0, z=0.0, w=1.0),
        )

    def _pictures(self, run: RunRecord) -> Iterator[Said]:
        """Pictures of the onlooking camera, ``PICTURES`` per second of the run."""
        kind = "sensor_msgs/msg/CompressedImage"
        for sample in picture_samples(run.rollout.times):
            time = float(run.rollout.times[sample])
            data = np.frombuffer(jpeg(run.picture(sample)), dtype=np.uint8)
            yield "/camera/compressed", kind, time, self._make(kind, header=self._header(time, "camera"), format="jpeg", data=data)


def picture_samples(times: Any) -> list[int]:
    """Return the indices of the samples of a run that get a camera picture: ``PICTURES`` a second, and the last
    sample."""
    wanted = np.arange(times[0], times[-1], 1 / PICTURES)
    return [*map(int, np.searchsorted(times, wanted)), len(times) - 1]


def jpeg(picture: Any) -> bytes:
    """Compress a (height, width, 3) uint8 picture as JPEG."""
    from io import BytesIO

    from PIL import Image

    file = BytesIO()
    Image.fromarray(picture).save(file, "JPEG", quality=QUALITY)
    return file.getvalue()
