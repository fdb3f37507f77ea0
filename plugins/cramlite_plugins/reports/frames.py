"""Which moments of a run are drawn, and their pictures as data URIs."""

from __future__ import annotations

import base64
import io
from collections.abc import Sequence

import numpy as np

from cramlite.geometry import Floats
from cramlite.report import Finished

COUNT = 40
"""Pictures of a run: 40 at 0.05 s each take 2 s."""
SIZE = (400, 300)
QUALITY = 78
"""WebP quality: about 5 kB a picture at this size."""
AROUND = (-0.2, 0.0, 0.2, 0.5)
"""Extra moments around a change of task [s]."""


def moments(times: Floats, changes: Sequence[float], count: int = COUNT) -> list[int]:
    """Samples to draw, ascending and distinct: spread evenly, denser where tasks change.

    Args:
        times: (N,) ascending [s].
        changes: when tasks begin [s].
    """
    last = len(times) - 1
    extra = [t + d for t in changes for d in AROUND][: count // 2]
    even = np.linspace(times[0], times[last], max(count - len(extra), 2))
    wanted = np.searchsorted(times, np.concatenate([even, extra]))
    return sorted({int(np.clip(k, 0, last)) for k in wanted})


def pictures(done: Finished, samples: Sequence[int]) -> list[str]:
    """Data URIs, one a sample."""
    return [_uri(done.picture(k, SIZE)) for k in samples]


def _uri(pixels: object) -> str:
    from PIL import Image

    buffer = io.BytesIO()
    Image.fromarray(pixels).save(buffer, "WEBP", quality=QUALITY, method=2)  # type: ignore[arg-type]
    return "data:image/webp;base64," + base64.b64encode(buffer.getvalue()).decode()
