"""Animation of the run that can be scrubbed, with force, joints and gripper on the same time axis."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numpy as np

from cramlite.plugin import ReportSection, hookimpl

from .filmstrip import filmstrip
from .plots import plot
from .scene_data import scene_data
from .shared import fill, script, spans

if TYPE_CHECKING:
    from cramlite import Finished
    from cramlite.model import Rollout

    from .plots import Plot
    from .shared import Span

TICK = 0.05
"""Time between two positions of the slider [s]; in long runs it is a multiple of this."""
POSES = 150_000
"""Largest number of poses on a page, over all positions of the slider and all bodies: 2.8 MB."""
LEAST = 0.01  # a smaller share of the contacts is not named
BODIES = 40
"""Assumed number of bodies of an arm, a hand and the moving things; each grain is one more."""


@hookimpl
def report_sections() -> Iterable[ReportSection]:
    yield ReportSection("The run", 20, render, refused=True)


def render(done: Finished) -> str:
    """Render the report's animation of the run, with its plots, as HTML."""
    if done.shown is None:
        return ""
    rollout = done.solution.candidate.rollout
    if rollout is None or len(rollout.times) < 2:
        return fill("nothing", text="The text of this backend cannot be run here, so there is nothing to show.")
    code = done.solution.candidate.code
    tasks = spans(done.solution)
    begin, end = float(rollout.times[0]), float(rollout.times[-1])
    tick = _tick(rollout)
    ticks = np.searchsorted(rollout.times, np.arange(begin, end + tick / 2, tick)).clip(0, len(rollout.times) - 1)
    samples = [int(k) for k in ticks]
    lines = [int(rollout.lines[k]) for k in ticks]
    data = {
        "start": begin, "tick": tick, "lines": lines, "where": _where(code, lines), "texts": _texts(code, lines),
        "scene": scene_data(done.scene(samples), rollout, samples, tasks),
    }  # fmt: skip
    plots = _plots(rollout, done.solution.candidate.robot.joints, ticks)
    return fill(
        "the_run", data=data, frames=filmstrip(done, tasks), plots=plots, renderer=script("scene"), bands=_bands(tasks, begin, end),
        values=[list(p.values) for p in plots], count=len(ticks), begin=begin, end=end, marks=_marks(begin, end),
        messages=rollout.messages, proven=done.proven, outcome=rollout.outcome, reason=rollout.reason,
        work=work(rollout),
    )  # fmt: skip


def work(rollout: Rollout) -> str:
    """Say which things had contact points in the simulation, as shares of all, and which MuJoCo left asleep throughout;
    "" if the run does not tell."""
    total = sum(rollout.work.values())
    if not total:
        return ""
    shares = sorted(((points / total, name) for name, points in rollout.work.items() if points), reverse=True)
    told = ", ".join(f"'{name}' {share:.0%}" for share, name in shares if share >= LEAST)
    rest = sum(share for share, _ in shares if share < LEAST)
    others = f", others {rest:.0%}" if rest else ""
    slept = ", ".join(f"'{name}'" for name, points in rollout.work.items() if not points and name in rollout.poses)
    return f"{total:.0f} contact points in an average sample: {told}{others}" + (f"; asleep all the time: {slept}" if slept else "")


def _tick(rollout: Rollout) -> float:
    """Time between two positions of the slider [s]: a multiple of TICK, chosen so that the page stays
    small."""
    bodies = BODIES + sum(int(centres.shape[1]) for centres in rollout.grains.values())
    duration = float(rollout.times[-1] - rollout.times[0])
    return TICK * math.ceil(duration / TICK * bodies / POSES)


def _plots(rollout: Rollout, joints: tuple[str, ...], ticks: Any) -> list[Plot]:
    times = rollout.times
    force = rollout.contact_force()
    angles = {name: rollout.joints[:, k] for k, name in enumerate(joints) if k < rollout.joints.shape[1]}
    found = [plot("Contact force |F|", "N", times, {"|F|": force}, ticks, zero=True)]
    if angles:
        found.append(plot("Joint angles", "rad", times, angles, ticks))
    return [*found, plot("Gripper opening", "mm", times, {"opening": rollout.opening * 1000}, ticks, zero=True)]


def _bands(tasks: list[Span], begin: float, end: float) -> list[tuple[Span, float, float]]:
    """Each task's span with the left edge and width of its bar on the page, in percent of the time axis."""
    scale = 100 / (end - begin)
    return [(s, (s.start - begin) * scale, (s.end - s.start) * scale) for s in tasks]


def _marks(begin: float, end: float) -> list[tuple[str, float]]:
    """Labels of the time axis with their place in percent: at most six."""
    step = next(s for s in (0.5, 1, 2, 5, 10, 20, 60, 300, 1e9) if (end - begin) / s <= 6)
    return [(f"{t:g}", (t - begin) / (end - begin) * 100) for t in np.arange(0, end + 1e-9, step) if t >= begin]


def _where(code: Any, lines: Iterable[int]) -> dict[int, str]:
    """Return a dictionary from line number to the designator of the step that the line belongs to."""
    return {
        n: code.origins[max(k for k in code.origins if k <= n)]
        for n in set(lines)
        if n >= min(code.origins, default=n + 1)
    }


def _texts(code: Any, lines: Iterable[int]) -> dict[int, str]:
    text = code.text.splitlines()
    return {n: text[n - 1].strip() for n in sorted(set(lines)) if 0 < n <= len(text)}
