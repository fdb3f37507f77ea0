"""Filmstrip of a run: pictures at the ends of its tasks, also on paper and without scripts."""

from __future__ import annotations

import base64
import io
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from cramlite.model import Value

if TYPE_CHECKING:
    from cramlite import Finished
    from cramlite.model import Floats

    from .shared import Span

MOST = 12
"""Largest number of pictures of the filmstrip."""
SIZE = (320, 240)
"""Width and height of a picture of the filmstrip [pixel]."""
QUALITY = 80
"""WebP quality of the filmstrip: about 4 kB a picture."""

FRAMES = 24
"""Number of pictures of the animation of a run."""
FRAME, LAST = 160, 1600
"""Time for which each picture of an animation is shown, and the last one [ms]: a run passes in some four seconds."""
MOVING = 60
"""WebP quality of an animation: about 3 kB a picture, as little changes between pictures."""


class Frame(Value):
    """Picture as a data URI, its time [s], and the task that ended then; "" at the start."""

    uri: str
    time: float
    task: str


def filmstrip(done: Finished, tasks: Sequence[Span]) -> list[Frame]:
    """Return pictures of the start, and of the end of each task."""
    times = done.solution.candidate.rollout.times  # type: ignore[union-attr]
    moments = [(float(times[0]), ""), *((s.end, s.task) for s in spread(tasks, MOST - 1))]
    return [Frame(_picture(done, times, time), time, task) for time, task in moments]


def as_animation(done: Finished, size: tuple[int, int], about: Sequence[str] = ()) -> tuple[str, str, float]:
    """Return a run as an animated WebP data URI, its first picture, and its speed relative to the run."""
    from PIL import Image

    times = done.solution.candidate.rollout.times  # type: ignore[union-attr]
    samples = np.searchsorted(times, np.linspace(times[0], times[-1], FRAMES)).clip(0, len(times) - 1)
    pictures = [Image.fromarray(done.picture(int(k), size, about)) for k in samples]
    buffer, shown = io.BytesIO(), [*[FRAME] * (FRAMES - 1), LAST]
    pictures[0].save(buffer, "WEBP", save_all=True, append_images=pictures[1:], duration=shown, loop=0, quality=MOVING, method=2)
    faster = float(times[-1] - times[0]) / (FRAME * (FRAMES - 1) / 1000)
    return _uri(buffer), as_uri(np.asarray(pictures[0]), QUALITY), faster


def spread(tasks: Sequence[Span], most: int) -> list[Span]:
    """Return at most ``most`` of the tasks, spread evenly; the last one is always there."""
    if len(tasks) <= most:
        return list(tasks)
    return [tasks[round(k)] for k in np.linspace(0, len(tasks) - 1, most)]


def _picture(done: Finished, times: Floats, time: float) -> str:
    sample = int(np.searchsorted(times, time).clip(0, len(times) - 1))
    return as_uri(done.picture(sample, SIZE), QUALITY)


def as_uri(pixels: object, quality: int) -> str:
    """Encode pixels (height, width, 3) uint8 as a WebP data URI."""
    from PIL import Image

    buffer = io.BytesIO()
    Image.fromarray(pixels).save(buffer, "WEBP", quality=quality, method=4)  # type: ignore[arg-type]
    return _uri(buffer)


def _uri(buffer: io.BytesIO) -> str:
    return "data:image/webp;base64," + base64.b64encode(buffer.getvalue()).decode()
