"""Page that compares a log with a simulated run: curves of joints, speeds and forces over the same time."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ..base.html_template import html_template, write_html

if TYPE_CHECKING:
    from ..engine.real_arm.run_comparison import Compared, RunComparison
    from ..model.geometry import Floats

WIDTH, HEIGHT = 560, 110
"""Width and height of a plot [pixel]."""
POINTS = 600
"""Largest number of points of a curve."""
SPANS = {"rad": 0.1, "rad/s": 0.2, "N": 5.0}
"""Smallest range of a plot's axis, by unit, so that noise does not fill the plot."""

PAGE = """<!doctype html>
<html lang="en"><meta charset="utf-8"><title>{{ title }}</title>
<style>
body { font: 15px/1.5 system-ui, sans-serif; margin: 2em auto; max-width: 78em; padding: 0 1em; color: #222 }
h1 { font-size: 1.3em } p { margin: .2em 0 }
figure { display: inline-block; margin: 0 1em 1em 0 } figcaption { color: #555; font-size: .9em }
svg { background: #fafaf8; border: 1px solid #ddd } polyline { fill: none; stroke-width: 1.5 }
.ran { stroke: #3b6ea5 } .logged { stroke: #c8502d } .parts { stroke: #888; stroke-dasharray: 4 3 }
</style>
<h1>{{ title }}</h1>
{% for line in lines %}<p>{{ line }}</p>
{% endfor %}
<p><span style="color:#3b6ea5">the run</span>, <span style="color:#c8502d">the log</span>{% if parts is not none %}; dashed: where they
part{% endif %}</p>
{% for plot in plots %}<figure><svg width="{{ width }}" height="{{ height }}" viewBox="0 0 {{ width }} {{ height }}">
{% if parts is not none %}<line class="parts" x1="{{ parts }}" x2="{{ parts }}" y1="0" y2="{{ height }}"/>{% endif %}
<polyline class="ran" points="{{ plot.ran }}"/><polyline class="logged" points="{{ plot.logged }}"/></svg>
<figcaption>{{ plot.says }}</figcaption></figure>
{% endfor %}
</html>
"""


def write_comparison_page(file: Path, title: str, lines: Sequence[str], found: RunComparison) -> None:
    """Write the page that compares a log with a run.

    Raises:
        UserError: it cannot be written.
    """
    times = found.times
    parts = None if found.parts is None else round(WIDTH * (found.parts[0] - times[0]) / max(1e-9, times[-1] - times[0]), 1)
    plots = [_plot(c, times) for c in found.compared]
    page = html_template(PAGE).render(title=title, lines=lines, plots=plots, parts=parts, width=WIDTH, height=HEIGHT)
    write_html(file, page, make_folder=True)


def _plot(one: Compared, times: Floats) -> dict[str, str]:
    """Return the curves of one quantity, in the log and in the run, with a common scale."""
    low, high = min(one.logged.min(), one.ran.min()), max(one.logged.max(), one.ran.max())
    spare = max(0.0, SPANS.get(one.unit, 0.0) - (high - low)) / 2
    far, when = one.worst
    says = f"{one.name} [{one.unit}], {low:.3g} to {high:.3g}; differs most at {when:.2f} s, by {far:.3g}"
    edges = low - spare, high + spare
    return {"says": says, "logged": _points(times, one.logged, *edges), "ran": _points(times, one.ran, *edges)}


def _points(times: Floats, values: Floats, low: float, high: float) -> str:
    rows = np.unique(np.linspace(0, len(times) - 1, POINTS).astype(int))
    x = WIDTH * (times[rows] - times[0]) / max(1e-9, times[-1] - times[0])
    y = 4 + (HEIGHT - 8) * (1 - (values[rows] - low) / max(1e-9, high - low))
    return " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(x, y, strict=True))
