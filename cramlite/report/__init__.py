"""Report: one self-contained HTML page about a run, assembled from the sections that plugins declare.

The page needs no network and no other file. A section that breaks is replaced by a note that names its plugin.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Sequence
from datetime import date
from importlib.resources import files
from typing import TYPE_CHECKING, Any, Protocol

from ..base.errors import DEFECTS
from ..base.html_template import html_template
from ..base.pulse import Stopped, checkpoint, pulse
from ..base.run_directory import write_whole
from ..base.value import Value, replace
from ..version import VERSION

if TYPE_CHECKING:
    from pathlib import Path

    from ..base.run_directory import RunDirectory
    from ..engine.engine import Engine
    from ..engine.setting import Setting
    from ..engine.solution import Solution
    from ..interpretation.interpretation import Interpretation
    from ..model.collision import Collision
    from ..model.episode import Episode
    from ..model.run.rollout import Scene
    from ..planning.trace import Trace
    from ..plugin.catalogue import Knowledge
    from ..plugin.protocols import ReportSection
    from ..plugin.registry import Registry

__all__ = ["Finished", "Part", "write_one_page", "write_page", "write_report"]


NOT_DRAWN = "This section was not drawn, since the command was interrupted; the same command goes on, and draws it at its end."


class Knowing(Protocol):
    """Protocol of an ``Engine``, with the attributes that a report reads."""

    @property
    def knowledge(self) -> Knowledge:
        """Declarations of all plugins: task types, robots, object models and so on."""

    @property
    def registry(self) -> Registry:
        """Registry of the plugins, with their faults."""


class Alone(Value):
    """Stand-in for an engine, with the declarations of all plugins only, for the page about a single solution."""

    knowledge: Knowledge

    @property
    def registry(self) -> Registry:
        """Registry of the plugins, with their faults."""
        return self.knowledge.registry


class Finished(Value):
    """Finished search with its result: the argument of a ReportSection's ``render``.

    Args:
        engine: that searched; its knowledge draws pictures and names classes.
        run: the directory that the page is written to; None for a page on its own.
        setting: where the plan was to be carried out.
        trace: every decision of the search.
        shown: the proven program, or one that ran and was refused; None where not even one was complete.
        interpretation, episode: of the demonstration; None where there is none.
        drawn: whether there is time to draw; sections that can do without their pictures ask before they draw.
    """

    engine: Knowing
    run: RunDirectory | None
    setting: Setting
    trace: Trace
    shown: Solution | None
    interpretation: Interpretation | None
    episode: Episode | None
    drawn: bool = True

    @property
    def proven(self) -> bool:
        """Whether the program that the report shows passed the validators."""
        return self.shown is not None and self.shown.verdict.passed

    @property
    def outcome(self) -> str:
        """Result in words: that of the search and, if the program was executed, that of the first execution."""
        if self.shown is None or not self.proven:
            return "nothing proven"
        said = "program proven, with advice" if self.shown.advice else "program proven"
        if self.shown.execution is None:
            return said
        return f"{said}, first execution {'succeeded' if self.shown.succeeded else 'failed'}"

    @property
    def solution(self) -> Solution:
        """Solution that the report shows.

        Where there is none, only sections marked ``refused`` are rendered.
        """
        assert self.shown is not None
        return self.shown

    def picture(self, sample: int, size: tuple[int, int], about: Collection[str] = ()) -> Any:
        """Render the run at one sample: (height, width, 3) uint8; ``size`` is (width, height) [pixel].

        Args:
            about: names of things that the picture is fitted to; none for the usual view.
        """
        checkpoint()
        knowledge, rollout = self.engine.knowledge, self.solution.candidate.ran
        return knowledge.simulator.picture(rollout, sample, knowledge.robots_of(rollout.world), size, about)

    def start_picture(self, size: tuple[int, int], about: Collection[str] = ()) -> Any:
        """Render the world at its start, fitted to some things: (height, width, 3) uint8; ``size`` is (width, height) [pixel]."""
        from ..engine.start_record import start_record

        checkpoint()
        knowledge, start = self.engine.knowledge, start_record(self.setting)
        return knowledge.simulator.picture(start, 0, knowledge.robots_of(start.world), size, about)

    def collision_picture(self, collision: Collision, size: tuple[int, int]) -> Any:
        """Render a collision in a state that the search refused: (height, width, 3) uint8; ``size`` is
        (width, height) [pixel]."""
        checkpoint()
        knowledge = self.engine.knowledge
        return knowledge.simulator.collision_picture(self.setting.world, knowledge.robots_of(self.setting.world), collision, size)

    def scene(self, samples: Sequence[int]) -> Scene:
        """Return the shapes of the run, and their poses at some samples."""
        checkpoint()
        knowledge, rollout = self.engine.knowledge, self.solution.candidate.ran
        return knowledge.simulator.scene(rollout, knowledge.robots_of(rollout.world), samples)


class RenderedSection(Value):
    """Rendered section of a report: if its plugin failed, ``html`` is empty and ``fault`` has the error."""

    anchor: str
    title: str
    html: str
    fault: str = ""


def write_report(run: RunDirectory, solution: Solution, engine: Engine, *, drawn: bool = True) -> None:
    """Write ``report.html`` about a proven program into a run directory.

    Args:
        drawn: as ``write_page`` has it.

    Raises:
        UserError: it cannot be written.
    """
    write_page(_finished(engine, run, solution), drawn=drawn)


def write_one_page(solution: Solution, knowledge: Knowledge, path: Path) -> None:
    """Write the report of a solution to a file.

    Raises:
        UserError: it cannot be written.
    """
    write_whole(path, _page(_finished(Alone(knowledge), None, solution), drawn=True))


def _finished(engine: Knowing, run: RunDirectory | None, solution: Solution) -> Finished:
    return Finished(engine, run, solution.setting, solution.trace, solution, solution.interpretation, solution.episode)


def write_page(done: Finished, *, drawn: bool = True) -> None:
    """Write ``report.html`` about a search, whether or not a program was proven; equal runs give equal pages.

    Args:
        drawn: False leaves out sections that draw, which takes seconds.

    Raises:
        UserError: it cannot be written.
    """
    assert done.run is not None
    done.run.write("report.html", _page(replace(done, drawn=drawn), drawn))


def _page(done: Finished, drawn: bool) -> str:
    from markupsafe import Markup

    parts = list(_parts(done, drawn))
    own = files(__package__)
    return html_template((own / "page.html.j2").read_text("utf-8")).render(
        done=done,
        version=VERSION,
        today=date.today().isoformat(),
        parts=[(p, Markup(p.html)) for p in parts],
        style=Markup((own / "page.css").read_text("utf-8")),
        script=Markup((own / "page.js").read_text("utf-8")),
    )


def _parts(done: Finished, drawn: bool) -> Iterator[RenderedSection]:
    sections = sorted(done.engine.registry.collect("report_sections"), key=lambda s: (s[1].order, s[1].title))
    for number, (plugin, section) in enumerate(sections, 1):
        if not (done.proven or section.refused):
            continue
        part = _part(plugin, section, done, f"section-{number}", drawn)
        if part.html or part.fault:
            yield part


def _part(plugin: str, section: ReportSection, done: Finished, anchor: str, drawn: bool) -> RenderedSection:
    """Render a section; one that gives empty HTML has nothing to show about the run, and is left out."""
    render: Callable[[Any], str] = section.render
    try:
        with pulse(lambda: not drawn):
            return RenderedSection(anchor, section.title, str(render(done)))
    except Stopped:
        if drawn:
            raise
        return RenderedSection(anchor, section.title, "", NOT_DRAWN)
    except DEFECTS as error:
        fault = done.engine.registry.fault(plugin, "report_sections", section.title, error)
        return RenderedSection(anchor, section.title, "", str(fault))
