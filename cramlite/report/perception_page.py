"""The page about a query: image with overlays, depth, cloud, pipeline, hypotheses; one file that needs no network."""

from __future__ import annotations

import base64
import io
import json
from collections.abc import Iterator, Sequence
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING, Any

from . import template

if TYPE_CHECKING:
    from ..model.view import View
    from ..model.world import Thing
    from ..perception.result import Perceived, Percept

COLOURS = ((42, 110, 187), (214, 106, 20), (40, 140, 80), (150, 70, 170), (190, 150, 20), (205, 60, 105), (20, 150, 160),
           (120, 120, 60))  # fmt: skip
CLOUD = 9000  # points of the cloud on the page: what a browser turns without a jerk


def write_page(folder: Path, found: Perceived, view: View, models: Sequence[Thing]) -> Path:
    """Write ``perception.html`` into a folder, which is made if need be."""
    from markupsafe import Markup

    from ..perception.result import in_words, plain

    folder.mkdir(parents=True, exist_ok=True)
    own = files(__package__)
    seen = sorted((*found.answers, *found.dropped), key=lambda p: p.number)
    page = template((own / "perception.html.j2").read_text("utf-8")).render(
        found=found, seen=seen, colours={p.number: _hex(p.number) for p in seen},
        values=lambda percept: _values(percept, plain, in_words),
        overlay=_png(overlay(found, view, models)), picture=_png(view.rgb), depth=_png(depth_image(view)),
        nearest=f"{_depth_range(view)[0]:.2f}", farthest=f"{_depth_range(view)[1]:.2f}",
        cloud=Markup(json.dumps(cloud(found, view))), style=Markup((own / "page.css").read_text("utf-8")),
    )  # fmt: skip
    path = folder / "perception.html"
    path.write_text(page, encoding="utf-8")
    return path


def _values(percept: Percept, plain: Any, in_words: Any) -> Iterator[dict[str, Any]]:
    for name, said in percept.values.items():
        if (value := plain(said.value)) is not None:
            lost = [(in_words(plain(o.value)), o.confidence, o.reason) for o in said.judged.others]
            yield {"name": name, "value": in_words(value), "said": said, "lost": lost}


def _colour(number: int) -> tuple[int, int, int]:
    return COLOURS[(number - 1) % len(COLOURS)]


def _hex(number: int) -> str:
    return "#{:02x}{:02x}{:02x}".format(*_colour(number))


def _png(image: Any) -> str:
    from PIL import Image

    stream = io.BytesIO()
    Image.fromarray(image).save(stream, "PNG", optimize=True)
    return "data:image/png;base64," + base64.b64encode(stream.getvalue()).decode()


def overlay(found: Perceived, view: View, models: Sequence[Thing]) -> Any:
    """The picture, faded, with each object's part, number and, where it has a pose, the boxes of its model."""
    import numpy as np
    from PIL import Image, ImageDraw

    grey = view.rgb.mean(axis=2, keepdims=True)
    image = (0.45 * view.rgb + 0.25 * grey + 76).clip(0, 255)
    seen = (*found.dropped, *found.answers)
    answers = {p.number for p in found.answers}
    for percept in seen:
        mask = percept.value("segment").mask
        share = 0.55 if percept.number in answers else 0.25
        image[mask] = (1 - share) * image[mask] + share * np.array(_colour(percept.number))
    drawn = Image.fromarray(image.astype(np.uint8))
    pen = ImageDraw.Draw(drawn)
    for percept in seen:
        rows, columns = np.nonzero(percept.value("segment").mask)
        model = next((m for m in models if m.name == percept.value("model")), None)
        if percept.number in answers and model is not None and percept.value("pose") is not None:
            for line in wires(view, percept.value("pose"), model):
                pen.line(line, fill=(255, 255, 255), width=3)
                pen.line(line, fill=_colour(percept.number), width=1)
        spot = (float(columns.mean()) - 4, float(rows.min()) - 22)
        pen.text(
            spot,
            str(percept.number),
            font_size=18,
            fill=_colour(percept.number),
            stroke_width=2,
            stroke_fill=(255, 255, 255),
        )
    return np.asarray(drawn)


def wires(view: View, pose: Any, model: Thing) -> Iterator[list[tuple[float, float]]]:
    """The edges of the boxes around a model's geoms, in the image [pixel]; those behind the camera are left out."""
    import numpy as np

    signs = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=float)
    pairs = [(i, j) for i in range(8) for j in range(i) if np.abs(signs[i] - signs[j]).sum() == 2]
    to_camera = view.camera.inverse() * pose
    for geom in model.geoms:
        pixels = view.intrinsics.project((to_camera * geom.pose).apply(signs * geom.half_extents))
        for i, j in pairs:
            if np.isfinite(pixels[[i, j]]).all():
                yield [(float(pixels[k][0]), float(pixels[k][1])) for k in (i, j)]


def _depth_range(view: View) -> tuple[float, float]:
    import numpy as np

    if not view.valid.any():
        return 0.0, 1.0
    low, high = np.percentile(view.depth[view.valid], (1, 97))
    return float(low), float(max(high, low + 1e-3))


def depth_image(view: View) -> Any:
    """Near is bright, far is dark, nothing measured is a dull red."""
    import numpy as np

    low, high = _depth_range(view)
    share = 1 - np.clip((np.nan_to_num(view.depth, nan=high) - low) / (high - low), 0, 1)
    stops = np.array([[16, 22, 60], [40, 90, 150], [80, 175, 170], [250, 240, 170]], float)
    grid = np.linspace(0, 1, len(stops))
    image = np.stack([np.interp(share, grid, stops[:, k]) for k in range(3)], axis=-1)
    image[~view.valid] = (92, 60, 60)
    return image.astype(np.uint8)


def cloud(found: Perceived, view: View) -> dict[str, Any]:
    """Points about their middle [mm], and a colour for each: its object's, else the picture's."""
    import numpy as np

    points, colours = view.world_cloud, view.rgb.copy()
    keep = view.valid & (view.depth < _depth_range(view)[1])
    for percept in (*found.dropped, *found.answers):
        colours[percept.value("segment").mask] = _colour(percept.number)
    index = np.flatnonzero(keep)
    index = index[:: max(1, len(index) // CLOUD)]
    chosen = points.reshape(-1, 3)[index]
    middle = np.median(chosen, axis=0) if len(chosen) else np.zeros(3)
    return {
        "points": np.round(1000 * (chosen - middle)).astype(int).reshape(-1).tolist(),
        "colours": colours.reshape(-1, 3)[index].reshape(-1).tolist(),
        "eye": [round(float(v) * 1000) for v in np.asarray(view.camera.position) - middle],
    }
