"""Page about a failed assertion: the finding, a picture of its moment, and the program with the line that was running."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from ..base.html_template import html_template, write_html
from ..base.picture import data_uri, encoded
from ..model.run.rollout import Rollout
from ..plugin.catalogue import Knowledge
from .miss import Miss

SIZE = (560, 420)
"""Width and height of a picture on the page [pixel]."""
BEFORE_S = 0.5
"""Time by which the earlier of the page's two pictures precedes the moment of failure [s]."""

PAGE = """<!doctype html>
<html lang="en"><meta charset="utf-8"><title>{{ lines[0] }}</title>
<style>
body { font: 15px/1.5 system-ui, sans-serif; margin: 2em auto; max-width: 90em; padding: 0 1em; color: #222 }
h1 { font-size: 1.2em } p { margin: .3em 0 } .run { display: flex; gap: 1em; margin: 1em 0 } figure { margin: 0; flex: 0 1 auto }
img { max-width: 100%; border: 1px solid #ccc }
figcaption { color: #666 } pre { background: #f6f6f4; padding: .5em; overflow-x: auto; line-height: 1.35 }
.ran { background: #ffd9d0; display: block } .number { color: #999 }
</style>
<h1>{{ lines[0] }}</h1>
{% for line in lines[1:] %}<p>{{ line }}</p>
{% endfor %}
<div class="run">{% for uri, says in pictures %}<figure><img src="{{ uri }}" alt="{{ says }}"><figcaption>{{ says }}</figcaption></figure>
{% endfor %}</div>
{% if messages %}<h2>What the program logged</h2><pre>{% for m in messages %}{{ "%8.2f s  "|format(m.time) }}{{ m.text }}
{% endfor %}</pre>{% endif %}
<h2>The program</h2><pre>{% for number, line in program %}<span{% if number == ran %} class="ran"{% endif %}><span
 class="number">{{ "%4d "|format(number) }}</span>{{ line }}</span>
{% endfor %}</pre>
</html>
"""


def write_failure_page(
    file: Path, lines: Sequence[str], rollout: Rollout, miss: Miss, text: str, knowledge: Knowledge
) -> None:
    """Write the page about a failed assertion.

    Args:
        lines: the message.

    Raises:
        UserError: it cannot be written.
    """
    sample = miss.sample(rollout)
    times = rollout.times
    earlier = int(times.searchsorted(max(0.0, float(times[sample]) - BEFORE_S)))
    pictures = [_picture(rollout, k, miss, knowledge) for k in dict.fromkeys((earlier, sample))]
    page = html_template(PAGE).render(
        lines=lines, pictures=pictures, messages=rollout.messages, program=list(enumerate(text.splitlines(), 1)),
        ran=miss.line(rollout),
    )  # fmt: skip
    write_html(file, page, make_folder=True)


def _picture(rollout: Rollout, sample: int, miss: Miss, knowledge: Knowledge) -> tuple[str, str]:
    """Return a picture of the run at a sample as a data URI, with the time as caption."""
    things = {t.name for t in rollout.world.things}
    about = [name for name in miss.about if name in things]
    pixels: Any = knowledge.simulator.picture(rollout, sample, knowledge.robots_of(rollout.world), SIZE, about)
    return data_uri(encoded(pixels, "PNG"), "PNG"), f"{float(rollout.times[sample]):.2f} s"
