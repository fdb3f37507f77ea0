"""Page about an interpretation: a picture of how a demonstration was read, in one self-contained file."""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING

from ..base.html_template import html_template, write_html
from .reading_picture import reading_picture

if TYPE_CHECKING:
    from ..interpretation.interpretation import Interpretation
    from ..model.episode import Episode


def write_interpretation_page(file: Path, episode: Episode, found: Interpretation) -> None:
    """Write the page about an interpretation.

    Raises:
        UserError: it cannot be written, or the file holds something else.
    """
    from markupsafe import Markup

    own = files(__package__)
    page = html_template((own / "interpretation.html.j2").read_text("utf-8")).render(
        episode=episode, zero=found.zero, picture=Markup(reading_picture(episode, found)),
        style=Markup((own / "page.css").read_text("utf-8")),
    )  # fmt: skip
    write_html(file, page)
