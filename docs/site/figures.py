"""The page of measured numbers: after each link to a file of ``docs/figures`` on a line of its own, that
file's table follows.

``mkdocs`` asks for it when the site is built; ``python docs/site/figures.py`` prints it. How many commits ago a figure was measured is
asked of git at that moment, and unknown where there is no history.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from functools import cache
from html import escape
from pathlib import Path

from cramlite.base.rate import Rate
from cramlite.experiment.figure import Figure, Number, read_figure
from cramlite.experiment.measured import git

ROOT = Path(__file__).parents[2]
FOLDER = ROOT / "docs" / "figures"
PAGE = "explanation/figures.md"
LINK = re.compile(r"^\[([^\]]+)\]\(\.\./figures/(\w+)\.yaml\)$", re.MULTILINE)
"""A line that is a link to a file of measured numbers, and nothing else."""
OLD = 300
"""Number of commits after which measured numbers are marked as old."""
SEEN = {"no": "never run before", "partly": "partly run before", "yes": "run before", None: "whether run before is not recorded"}


def shown(markdown: str) -> str:
    """Replace each link of a page to a file of measured numbers by a table of them, their plot, and how
    they were measured."""
    return LINK.sub(lambda m: block(m[1], m[2], read_figure(FOLDER / f"{m[2]}.yaml")), markdown)


def block(title: str, name: str, figure: Figure) -> str:
    """Return the page's part about one measurement: table, published numbers, plot and circumstances."""
    head = f"**[{title}](../figures/{name}.yaml)**{mark(figure)}"
    parts = [head + (f" {figure.about}" if figure.about else ""), *table(figure.numbers)]
    parts += published(figure)
    parts += [f"![{title}: {figure.plot.y} over {figure.plot.x}](../figures/{name}.svg)"] if figure.plot else []
    return "\n\n".join([*parts, circumstances(figure)])


def table(numbers: Sequence[Number]) -> list[str]:
    """Return a table of measured numbers: a row for each ``what``, a column for each ``part``."""
    rows, columns = list(dict.fromkeys(n.what for n in numbers)), list(dict.fromkeys(n.part for n in numbers))
    found = {(n.what, n.part): cell(n) for n in numbers}
    lines = [["", *(c or "figure" for c in columns)], ["---"] * (len(columns) + 1)]
    lines += [[row, *(found.get((row, c), "") for c in columns)] for row in rows]
    return ["\n".join(f"| {' | '.join(line)} |" for line in lines)]


def cell(number: Number) -> str:
    """Return a number with its interval, for people."""
    note = f"; {number.note}" if number.note else ""
    if number.hits is not None and number.of is not None:
        return Rate(number.hits, number.of).text + note
    bounds = "" if number.low is None else f" ({number.low:g} to {number.high:g})"
    return f"{number.value:,g}".replace(",", " ") + f" {number.unit}".rstrip() + bounds + note


def published(figure: Figure) -> list[str]:
    """Return the table of numbers that others published, with the inputs that each system was given."""
    if not figure.beside:
        return []
    rows = [[p.who, p.said, p.given, p.source] for p in figure.beside]
    lines = [["published", "figure", "given", "source"], ["---"] * 4, *rows, ["ours", "above", figure.given or "not recorded", ""]]
    return ["\n".join(f"| {' | '.join(line)} |" for line in lines)]


def circumstances(figure: Figure) -> str:
    """Return the line under a table of measured numbers: commit, seeds, machine and command."""
    seeds = f"seeds: {figure.seeds}, {SEEN[figure.seen]}" if figure.seeds else "seeds: none, or not recorded"
    cpu = f"{figure.cpu_s:g} s of CPU time" if figure.cpu_s is not None else "CPU time of the whole not recorded"
    return f"{when(figure)}; {seeds}; {figure.machine or 'machine not recorded'}; {cpu}. `{figure.command}`"


def when(figure: Figure) -> str:
    """Return the commit at which numbers were measured, and how many commits ago that was."""
    if figure.commit is None:
        return "commit not recorded"
    ago = age(figure.commit)
    return f"commit {figure.commit}{' with changes' if figure.changed else ''}" + ("" if ago is None else f", {ago} commits ago")


def mark(figure: Figure) -> str:
    """Return the end of a figure's title: the mark "(**old**)" or "(**age unknown**)" for measurements that have it, and a full stop."""
    ago = age(figure.commit) if figure.commit else None
    return " (**age unknown**)." if ago is None else " (**old**)." if ago > OLD else "."


@cache
def age(commit: str, root: Path = ROOT) -> int | None:
    """Return how many commits followed a commit; None if git does not know it."""
    top = git(root, "rev-parse", "--show-toplevel")
    if top is None or Path(top).resolve() != root.resolve():
        return None
    count = git(root, "rev-list", "--count", f"{commit}..HEAD")
    return int(count) if count else None


def plots() -> Iterator[tuple[str, str]]:
    """Give the path in ``docs`` and the SVG text of the plot of each measurement that has one."""
    for path in sorted(FOLDER.glob("*.yaml")):
        figure = read_figure(path)
        if figure.plot:
            yield f"figures/{path.stem}.svg", plot(figure)


ACROSS, HEIGHT, LEFT, TOP, BOTTOM = 386, 320, 64, 16, 48
LETTER = 7.5  # width of a letter of 12 pixels, at most
COLOURS = ("#1f77b4", "#d62728", "#2ca02c", "#9467bd", "#ff7f0e", "#17becf", "#8c564b", "#7f7f7f")


def plot(figure: Figure) -> str:
    """Return the plot of a measurement as SVG: curves through the numbers that have an x value, with their
    intervals."""
    assert figure.plot is not None
    points = [n for n in figure.numbers if n.x is not None]
    xs, top = sorted({n.x for n in points if n.x is not None}), nice(max(n.high if n.high is not None else n.height for n in points))

    def at(x: float, y: float) -> tuple[float, float]:
        across = (x - xs[0]) / ((xs[-1] - xs[0]) or 1.0)
        return LEFT + across * ACROSS, HEIGHT - BOTTOM - y / top * (HEIGHT - TOP - BOTTOM)

    end, low = at(xs[-1], 0.0)
    names = list(dict.fromkeys(n.what for n in points))
    width = round(LEFT + ACROSS + 44 + LETTER * max(map(len, names)))
    parts = [f'<rect width="{width}" height="{HEIGHT}" fill="white"/>']
    for k in range(5):
        _, y = at(xs[0], top * k / 4)
        parts.append(f'<path d="M{LEFT} {y:.1f}H{end:.1f}" stroke="#ddd"/>')
        parts.append(text(LEFT - 8, y + 4, f"{top * k / 4:g}", "end"))
    parts += [text(at(x, 0)[0], low + 18, f"{x:g}", "middle") for x in xs]
    parts.append(text((LEFT + end) / 2, HEIGHT - 8, figure.plot.x, "middle"))
    parts.append(f'<g transform="rotate(-90 16 {HEIGHT / 2:g})">{text(16, HEIGHT / 2, figure.plot.y, "middle")}</g>')
    for k, name in enumerate(names):
        own, colour = [n for n in points if n.what == name], COLOURS[k % len(COLOURS)]
        parts += curve(own, colour, at)
        parts.append(f'<path d="M{end + 14:.1f} {TOP + 12 + 20 * k}h16" stroke="{colour}" stroke-width="2"/>')
        parts.append(text(end + 36, TOP + 16 + 20 * k, name, "start"))
    size = f'viewBox="0 0 {width} {HEIGHT}" width="{width}" height="{HEIGHT}"'
    return f'<svg xmlns="http://www.w3.org/2000/svg" {size} font-family="sans-serif" font-size="12">\n' + "\n".join(parts) + "\n</svg>\n"


def curve(numbers: Sequence[Number], colour: str, at: object) -> Iterator[str]:
    """Give the SVG elements of a curve and its intervals."""
    assert callable(at)
    places = [at(n.x, n.height) for n in numbers]
    yield f'<path d="M{"L".join(f"{x:.1f} {y:.1f}" for x, y in places)}" fill="none" stroke="{colour}" stroke-width="2"/>'
    for number, (x, y) in zip(numbers, places, strict=True):
        yield f'<circle cx="{x:.1f}" cy="{y:.1f}" r="3" fill="{colour}"/>'
        if number.low is not None and number.high is not None:
            (_, low), (_, high) = at(number.x, number.low), at(number.x, number.high)
            yield f'<path d="M{x:.1f} {low:.1f}V{high:.1f}" stroke="{colour}" opacity=".5"/>'


def text(x: float, y: float, said: str, anchor: str) -> str:
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}">{escape(said)}</text>'


def nice(most: float) -> float:
    """Return the least of 1, 2, 4, 6, 8 times a power of ten that is not below a number."""
    power = 10.0 ** len(str(int(most))) if most >= 1 else 1.0
    return next((k * power / 10 for k in (1, 2, 4, 6, 8) if k * power / 10 >= most), power)


if __name__ == "__main__":
    print(shown((ROOT / "docs" / PAGE).read_text(encoding="utf-8")), end="")
