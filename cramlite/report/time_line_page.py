"""Page about an execution with resumptions: a picture of each fault, notice, decision and resumption, in one self-contained file."""

from __future__ import annotations

from collections.abc import Sequence
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ..base.html_template import html_template, write_html
from ..base.picture import data_uri, encoded

if TYPE_CHECKING:
    from ..engine.recovery.time_line import Moment
    from ..model.run.rollout import Rollout
    from ..plugin.catalogue import Knowledge

FILE = "time_line.html"
SIZE = (400, 300)
"""Width and height of pictures [pixel]."""


class TimeLinePage:
    """Page about an execution with resumptions, rewritten after the run of each of its programs.

    Args:
        knowledge: whose simulator draws.
    """

    def __init__(self, knowledge: Knowledge) -> None:
        self.knowledge = knowledge
        self.drawn: list[str] = []

    def write(self, moments: Sequence[Moment], last: Rollout, folder: Path) -> None:
        """Write ``time_line.html`` into a folder.

        Args:
            moments: of all rounds so far.
            last: the run of the latest round, which alone is drawn now.

        Raises:
            UserError: it cannot be written, or the file holds something else.
        """
        from markupsafe import Markup

        self.drawn += [self._picture(moment, last) for moment in moments[len(self.drawn) :]]
        own = files(__package__)
        page = html_template((own / "time_line.html.j2").read_text("utf-8")).render(
            moments=list(zip(moments, self.drawn, strict=True)), style=Markup((own / "page.css").read_text("utf-8"))
        )
        write_html(folder / FILE, page)

    def _picture(self, moment: Moment, rollout: Rollout) -> str:
        """Return a picture of the run at the time of an entry of the time line, as a data URI."""
        sample = int(np.searchsorted(rollout.times, moment.since).clip(0, len(rollout.times) - 1))
        robots = self.knowledge.robots_of(rollout.world)
        return data_uri(encoded(self.knowledge.simulator.picture(rollout, sample, robots, SIZE), "WEBP", quality=80), "WEBP")
