"""Page about a calibration: error bars, and the residuals of each picture."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING

from ..base.html_template import html_template, write_html
from ..perception.calibration.result import calibration_text
from ..perception.pictures import COLOURS

if TYPE_CHECKING:
    from ..perception.calibration.hand_eye import Calibration
    from ..perception.calibration.recording import Recording

ENLARGED = 40
"""Factor by which residuals are drawn longer than they are."""


def write_page(folder: Path, found: Calibration, recording: Recording, told: Sequence[str]) -> Path:
    """Write ``calibration.html`` into a folder, which is created if necessary.

    Raises:
        UserError: it cannot be written, or the file holds something else.
    """
    from markupsafe import Markup

    own, path = files(__package__), folder / "calibration.html"
    page = html_template((own / "calibration.html.j2").read_text("utf-8")).render(
        text=calibration_text(found, recording, told), size=found.intrinsics, lines=list(_lines(found, recording)),
        pictures=list(_pictures(found)), enlarged=ENLARGED, style=Markup((own / "page.css").read_text("utf-8")),
    )  # fmt: skip
    write_html(path, page, make_folder=True)
    return path


def _lines(found: Calibration, recording: Recording) -> Iterator[tuple[str, float, float, float, float]]:
    """Yield colour and ends [pixel] of each residual: from the detected corner of the board towards its computed
    position, enlarged."""
    for k, station in enumerate(recording.stations):
        for (u, v), (du, dv) in zip(station.sighting.pixels, found.pixels[station.name], strict=True):
            yield _colour(k), u, v, u + ENLARGED * du, v + ENLARGED * dv


def _pictures(found: Calibration) -> Iterator[tuple[str, str, int, float, float]]:
    """Yield colour, name, number of corners, error [pixel] and largest residual [pixel] of each picture."""
    import numpy as np

    for k, (name, pixels) in enumerate(found.pixels.items()):
        away = np.hypot(*pixels.T)
        yield _colour(k), name, len(pixels), float(np.sqrt((away**2).mean())), float(away.max())


def _colour(number: int) -> str:
    return "#{:02x}{:02x}{:02x}".format(*COLOURS[number % len(COLOURS)])
