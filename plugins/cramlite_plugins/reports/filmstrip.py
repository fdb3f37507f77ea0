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
"""Pictures at most."""
SIZE = (320, 240)
"""Width and height [pixel]: 0.03 s of CPU time each."""
QUALITY = 80
"""WebP quality: about 4 kB a picture at this size."""


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
    return "data:image/webp;base64," + base64.b64encode(buffer.getvalue()).decode()
