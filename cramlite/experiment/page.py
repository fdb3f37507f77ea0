"""The page of an experiment: one self-contained HTML file with the tables, and a picture of how each trial ended."""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path
from typing import Any

from ..base.html_template import html_template
from ..base.picture import data_uri, encoded
from ..model.run.rollout import Rollout
from ..plugin.catalogue import Knowledge


def page(package: str | None, title: str, **values: Any) -> str:
    """Render the HTML page of an experiment, with the template ``tables.html.j2`` of a package as its body.

    Args:
        package: whose ``tables.html.j2`` is the body.
        values: of the body.
    """
    assert package is not None
    parts = (files(__package__) / "page.html.j2", files(package) / "tables.html.j2")
    style = (files("cramlite.report") / "page.css").read_text("utf-8")
    source = "\n".join(p.read_text("utf-8").rstrip("\n") for p in parts)
    return html_template(source).render(title=title, style=style, picture=picture, **values) + "\n</main></body></html>"


def picture(path: Path) -> str:
    """Return a picture file as a data URI; "" if there is no file."""
    if not path.is_file():
        return ""
    return data_uri(path.read_bytes(), "PNG" if path.suffix == ".png" else "JPEG")


def last_picture(rollout: Rollout, knowledge: Knowledge, size: tuple[int, int]) -> bytes:
    """Return a picture of a rollout's last sample as the bytes of a JPEG file."""
    return jpeg(knowledge.simulator.picture(rollout, len(rollout.times) - 1, knowledge.robots_of(rollout.world), size))


def jpeg(pixels: Any) -> bytes:
    """Return a picture (height, width, 3) uint8 as the bytes of a JPEG file."""
    return encoded(pixels, "JPEG", quality=70)
