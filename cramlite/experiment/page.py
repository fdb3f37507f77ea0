"""The page of an experiment: one self-contained HTML file with the tables and a picture of each execution's end."""

from __future__ import annotations

import base64
from importlib.resources import files
from pathlib import Path

from ..base.html_template import html_template
from .report import HEADINGS, against_nominal, area, plain, share
from .results import DemonstrationResult
from .tables import STAGES, Share, Tables


def page(
    title: str,
    about: list[str],
    tables: Tables,
    results: tuple[DemonstrationResult, ...],
    changes: list[str],
    folder: Path,
) -> str:
    """Render the page as HTML.

    Args:
        about: what was run, in lines for people.
        changes: against the baseline.
        folder: of the run: where the pictures are.
    """
    source = (files(__package__) / "page.html.j2").read_text("utf-8")
    style = (files("cramlite.report") / "page.css").read_text("utf-8")
    return html_template(source).render(
        title=title, about=about, tables=tables, results=results, changes=changes, style=style, stages=STAGES,
        headings=HEADINGS, share=_share, plain=plain, area=area, nominal=against_nominal,
        picture=lambda one, name: _picture(folder / "results" / one / name),
    )  # fmt: skip


def _share(value: Share) -> str:
    """On two lines at most: a number and its unit, and an interval, stay together."""
    counts, _, rest = share(value).partition(" (")
    return counts.replace(" ", "\u00a0") + " (" + rest.replace(" ", "\u00a0")


def _picture(path: Path) -> str:
    """A picture as a data address; empty if there is none."""
    if not path.is_file():
        return ""
    return "data:image/jpeg;base64," + base64.b64encode(path.read_bytes()).decode()
