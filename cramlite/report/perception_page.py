"""Page about a perception query: image with overlays, depth, point cloud, pipeline and hypotheses, in one self-contained file."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..base.html_template import html_template, write_html
from ..base.picture import data_uri, encoded
from ..perception.pictures import colour, depth_image, depth_range, overlay

if TYPE_CHECKING:
    from ..model.view import View
    from ..model.world.thing import Thing
    from ..perception.result import Perceived, Percept

CLOUD = 9000  # points of the cloud on the page: what a browser turns without a jerk


def write_page(folder: Path, found: Perceived, view: View, models: Sequence[Thing]) -> Path:
    """Write ``perception.html`` into a folder, which is created if necessary.

    Raises:
        UserError: it cannot be written, or the file holds something else.
    """
    from markupsafe import Markup

    from ..perception.result import in_words, plain

    own = files(__package__)
    seen = sorted((*found.answers, *found.dropped), key=lambda p: p.number)
    page = html_template((own / "perception.html.j2").read_text("utf-8")).render(
        found=found, seen=seen, colours={p.number: _hex(p.number) for p in seen},
        values=lambda percept: _values(percept, plain, in_words),
        overlay=_png(overlay(found, view, models)), picture=_png(view.rgb), depth=_png(depth_image(view)),
        nearest=f"{depth_range(view)[0]:.2f}", farthest=f"{depth_range(view)[1]:.2f}",
        cloud=Markup(json.dumps(cloud(found, view))), style=Markup((own / "page.css").read_text("utf-8")),
    )  # fmt: skip
    path = folder / "perception.html"
    write_html(path, page, make_folder=True)
    return path


def _values(percept: Percept, plain: Any, in_words: Any) -> Iterator[dict[str, Any]]:
    for name, said in percept.values.items():
        if (value := plain(said.value)) is not None:
            lost = [(in_words(plain(o.value)), o.confidence, o.reason) for o in said.judged.others]
            yield {"name": name, "value": in_words(value), "said": said, "lost": lost}


def _hex(number: int) -> str:
    return "#{:02x}{:02x}{:02x}".format(*colour(number))


def _png(image: Any) -> str:
    return data_uri(encoded(image, "PNG", optimize=True), "PNG")


def cloud(found: Perceived, view: View) -> dict[str, Any]:
    """Return the points of a view relative to their mean [mm], each with the colour of its object, else of
    the image."""
    import numpy as np

    points, colours = view.world_cloud, view.rgb.copy()
    keep = view.valid & (view.depth < depth_range(view)[1])
    for percept in (*found.dropped, *found.answers):
        colours[percept.value("segment").mask] = colour(percept.number)
    index = np.flatnonzero(keep)
    index = index[:: max(1, len(index) // CLOUD)]
    chosen = points.reshape(-1, 3)[index]
    middle = np.median(chosen, axis=0) if len(chosen) else np.zeros(3)
    return {
        "points": np.round(1000 * (chosen - middle)).astype(int).reshape(-1).tolist(),
        "colours": colours.reshape(-1, 3)[index].reshape(-1).tolist(),
        "eye": [round(float(v) * 1000) for v in np.asarray(view.camera.position) - middle],
    }
