"""Animations of a run: GIF for pages and messages, MP4 (H.264) for players and slides. MP4 needs PyAV (``pip install 'cramlite[mp4]'``)."""

from __future__ import annotations

import io
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from cramlite.plugin import Exporter, checkpoint, hookimpl

if TYPE_CHECKING:
    from cramlite.model import RunRecord

GIF_RATE, MP4_RATE = 5, 10
"""Number of pictures per second of the run: one takes 0.1 s of CPU time, and about 25 kB in a GIF."""
COLOURS = 128
"""Number of colours of a GIF: flat shading needs no more."""


@hookimpl
def exporters() -> Iterable[Exporter]:
    """Declare the export formats GIF and MP4."""
    return [
        Exporter("gif", ".gif", "browsers, messages", write_gif),
        Exporter("mp4", ".mp4", "players, slides", write_mp4, {"av": "cramlite[mp4]"}),
    ]


def write_gif(run: RunRecord, out: Path) -> None:
    """Write a run to a new GIF that plays at the run's own speed, in an endless loop."""
    from PIL import Image

    pictures = (Image.fromarray(p).quantize(COLOURS) for p in _pictures(run, GIF_RATE))
    with _Stoppable(out, "w") as file:
        next(pictures).save(file, "GIF", save_all=True, append_images=pictures, duration=1000 // GIF_RATE, loop=0)


class _Stoppable(io.FileIO):
    """File object that checks for cancellation at each write, since Pillow writes a whole animation in one call."""

    def write(self, data: Any) -> int:
        checkpoint()
        return super().write(data)


def write_mp4(run: RunRecord, out: Path) -> None:
    """Write a run to a new MP4, at the speed at which it ran."""
    import av

    with av.open(str(out), "w", format="mp4") as file:
        stream: Any = None
        for picture in _pictures(run, MP4_RATE):
            if stream is None:
                stream = file.add_stream("h264", rate=MP4_RATE)
                stream.height, stream.width = picture.shape[:2]
                stream.pix_fmt = "yuv420p"
            file.mux(stream.encode(av.VideoFrame.from_ndarray(picture, format="rgb24")))
        file.mux(stream.encode(None))


def _pictures(run: RunRecord, rate: int) -> Iterator[Any]:
    """Yield pictures of a run at a constant rate; the last one shows the run's end."""
    times = run.rollout.times
    wanted = np.append(np.arange(times[0], times[-1], 1 / rate), times[-1])
    for k in np.searchsorted(times, wanted):
        checkpoint(float(times[k] - times[0]))
        yield run.picture(int(k))
