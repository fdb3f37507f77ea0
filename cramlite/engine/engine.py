"""The engine: goals become proven programs, lazily, one solution after another."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Never

from msgspec.structs import replace

from ..base.errors import UserError
from ..base.memory import give_back
from ..base.pulse import Stop, working
from ..base.seeds import whole_seed
from ..interpretation.no_events import hint_without_events
from ..planning.heartbeat import Heartbeat
from ..planning.search.budget import Budget, budget_of, until_late
from ..planning.trace import Trace
from ..plugin.catalogue import Knowledge
from ..plugin.selection import INSTALLED, PluginChoice
from .reading import Reading, goal_text
from .solution import Solution

if TYPE_CHECKING:
    from ..interpretation.interpretation import Interpretation
    from ..interpretation.ranking import TaskSequence
    from ..model.episode import Episode
    from ..model.plan import Plan
    from ..model.world.world import World
    from ..scenario.scenario import Scenario
    from .candidates import CandidateSequence, Progress
    from .proof.executor import Executor
    from .proof.executor_group import ExecutorGroup
    from .reading import AnyGoal
    from .setting import Setting


KEPT = 4
"""Number of engines that are kept for scenarios with plugins or ontologies of their own."""


class Engine:
    """Engine that turns goals into proven programs; each engine has its own plugins, shared with no other
    engine.

    Args:
        files: plugin modules to load by path.
        blocked, preferred: names of plugins.
        ontologies: further ontology files.
        rules: a folder of rule files that stands for all others.
        models: libraries of known kinds.

    Example:
        >>> from cramlite import Engine, read_scenario          # doctest: +SKIP
        >>> solution = next(Engine().resolve(read_scenario(path)))  # doctest: +SKIP
    """

    def __init__(
        self,
        *,
        files: Sequence[Path | str] = (),
        blocked: Sequence[str] = (),
        preferred: Sequence[str] = (),
        ontologies: Sequence[Path] = (),
        rules: Path | None = None,
        models: Sequence[Path | str] = (),
    ) -> None:
        self.plugins = PluginChoice(tuple(map(Path, files)), tuple(blocked), tuple(preferred), tuple(map(Path, models)))
        self.ontologies, self.rules = tuple(ontologies), rules
        self.registry = self.plugins.registry()
        self.knowledge = Knowledge(self.registry, self.ontologies, rules)
        self._suited: dict[object, Engine] = {}

    @cached_property
    def executors(self) -> ExecutorGroup:
        """Return the processes that run programs in twins, one for each core. They start when first needed,
        stay for later goals, and end with this engine."""
        from .proof.executor_group import group_of

        return group_of(self.knowledge)

    @classmethod
    def with_plugins(cls, plugins: PluginChoice, ontologies: tuple[Path, ...] = (), rules: Path | None = None) -> Engine:
        """Return an engine with chosen plugins; the other arguments are those of `Engine`.

        Raises:
            UserError: as ``PluginChoice.registry``.
        """
        return cls(
            files=plugins.files, blocked=plugins.blocked, preferred=plugins.preferred, ontologies=ontologies, rules=rules,
            models=plugins.models,
        )  # fmt: skip

    def suited(self, scenario: Scenario) -> Engine:
        """Return the engine for a scenario: this one, or one with its plugins and ontologies.

        The other is made where the scenario blocks, prefers or adds some; the last few are kept. ``setting``,
        ``resolve`` and ``plans`` use this by themselves.

        Raises:
            UserError: the scenario blocks or prefers a plugin that there is not; with file and line.
        """
        plugins, ontologies = scenario.with_plugins(self.plugins), scenario.ontologies
        further = tuple(path for path in ontologies if path not in self.ontologies)
        if plugins == self.plugins and not further:
            return self
        key = plugins, further, tuple(p.stat().st_mtime_ns if p.exists() else 0 for p in further)
        found = self._suited.pop(key, None) or Engine.with_plugins(plugins, (*self.ontologies, *further), self.rules)
        self._suited[key] = found
        for old in list(self._suited)[:-KEPT]:
            self._suited.pop(old, None)
        return found

    def read_episode(self, path: Path) -> Episode:
        """Read an episode in any format that a plugin reads, repaired, and its classes aligned with the
        loaded ontologies.

        Raises:
            UserError: no such path, no reader, or a file that cannot be used.
            PluginError: no reader answered, and one failed.
        """
        if not path.exists():
            raise UserError(
                f"There is no episode at '{path}'; give the folder of a NEEM, or record one with 'cramlite record'."
            )
        from ..interpretation.class_alignment import aligned

        return aligned(self.knowledge.episodes.read(path), self.knowledge.taxonomy)

    def interpret(self, episode: Episode) -> Interpretation:
        """Interpret an episode: find every task that each of its actions may have been.

        Raises:
            UserError: the episode has no events.
        """
        from ..interpretation.interpretation import interpret

        if not episode.events:
            raise UserError(
                f"The episode '{episode.name}' has no events, so there is nothing to interpret: it holds "
                f"{len(episode.entities)} entities and {len(episode.tracks)} tracks, and no object was seen to move "
                f"along with a hand. Record it with contacts, or with the poses of hands and objects.{hint_without_events(episode)}"
            )
        return interpret(episode, self.knowledge.rules, self.knowledge.taxonomy)

    def read(self, goal: AnyGoal | Reading) -> Reading:
        """Pair a goal with its demonstration, so that several methods of the engine can share one interpretation.

        A demonstration is then read and interpreted once for all of them, when the first needs it. The reading of a
        reading is that reading.
        """
        if isinstance(goal, Reading):
            return goal
        engine = self._for(goal)

        def episode() -> Episode | None:
            from ..model.episode import Episode
            from ..scenario.scenario import Scenario

            if isinstance(goal, Scenario) and goal.spec.demonstration is not None:
                return engine.read_episode(goal.resolve_path(goal.spec.demonstration))
            return goal if isinstance(goal, Episode) else None

        return Reading(goal, episode, engine.interpret)

    def setting(
        self, goal: Scenario | Reading, *, seed: int = 0, backend: str | None = None, now: World | None = None,
        rest: Plan | None = None, twins: int | None = None,
    ) -> Setting:  # fmt: skip
        """Build the setting of a scenario: world, robot, backend and initial belief.

        Args:
            goal: a scenario, or its reading.
            now: the world as it really is by now, where it is no longer as the scenario has it: its robots, and what they hold; only a
                camera is shown its things.
            rest: the plan that is left by then: what the camera looks for; by default the scenario's.
            twins: in how many a program is tried before it counts as proven, 0 for the nominal run alone; by default what the
                scenario says, or 8.

        Raises:
            UserError: an unknown robot, model, backend, thing, plugin or budget; a seed that is no whole number; the
                reading of something else.
        """
        from ..scenario.scenario import Scenario
        from .setting_from_scenario import setting_of

        reading = self.read(goal)
        scenario, engine = reading.goal, self._for(reading.goal)
        if not isinstance(scenario, Scenario):
            raise UserError(
                f"A setting (world, robot, backend, belief) is that of a scenario, not of {type(scenario).__name__}: pass "
                "read_scenario(path)."
            )
        budget_of(scenario)  # what is wrong with it is said before any work

        def likeliest(before: Setting) -> Plan | None:
            return rest or next((plan for plan, _ in engine.plans(reading, before, Trace())), None)

        return setting_of(scenario, engine.knowledge, likeliest, seed=whole_seed(seed), backend=backend, now=now, twins=twins)

    def resolve(
        self,
        goal: AnyGoal | Reading,
        *,
        setting: Setting | None = None,
        seed: int = 0,
        budget: Budget | None = None,
        trace: Trace | None = None,
        progress: Progress = lambda _: None,
        stop: Stop = lambda: False,
        **unknown: Never,
    ) -> Iterator[Solution]:
        """Generate programs for a goal that were proven in the believed world and in its twins, lazily.

        ``execute`` tells how one of them fares in the real world.

        They are the attempts that passed, of all ``candidates``: that gives those that were refused, too.

        Args:
            goal: a scenario, an episode, a ``Goal``, tasks, or one task; all but a scenario with ``setting``. Or the
                reading of one.
            setting: where, and from which state, the goal is to be achieved; by default a scenario's own.
            seed: the same one gives the same programs.
            budget: counted work; by default the scenario's.
            trace: is filled while the search runs, also when nothing is found.
            progress: called with a line for people: events when they happen, and every 5 s what is done now
                (``NowDone``); from the thread that resolves.
            stop: asked several times a second, also within a run of a text, from the thread that resolves; True ends the
                iterator, and the trace says so.

        Raises:
            UserError: the goal cannot be used.
            TypeError: an argument that there is not, such as ``world``, the old name of ``setting``.
        """
        _refuse(unknown)
        for candidate in self.candidates(
            goal, setting=setting, seed=seed, budget=budget, trace=trace, progress=progress, stop=stop
        ):
            yield from (one for one in candidate.attempts() if one.verdict.passed)

    def execute(self, solution: Solution, executor: Executor | None = None) -> Solution:
        """Execute a proven program once in the real world, and have it judged there.

        The iterator that gave the solution learns nothing of it.

        Args:
            executor: the process that runs the text, which can be killed; None runs it in this one.

        Returns:
            The solution with its ``execution``.

        Raises:
            ExecutorDied: the process that runs the text did, or was killed.
            UserError: its text cannot be run here.
        """
        from .execution import execute

        return replace(solution, execution=execute(solution.candidate, solution.setting, self.knowledge, executor))

    def candidates(
        self,
        goal: AnyGoal | Reading,
        *,
        setting: Setting | None = None,
        seed: int = 0,
        budget: Budget | None = None,
        trace: Trace | None = None,
        progress: Progress = lambda _: None,
        stop: Stop = lambda: False,
    ) -> Iterator[CandidateSequence]:
        """Generate the task sequences that may achieve a goal, best first, as many as the budget has.

        Then, in wider rounds, those again of which alternatives were left out, with twice as many each time, until their budget is
        spent (iterative broadening: Ginsberg and Harvey 1992). Each is tried when its ``attempts`` are asked for, or passed over if
        they are not; the arguments are those of ``resolve``.

        Raises:
            UserError: the goal cannot be used.
        """
        reading, seed, trace = self.read(goal), whole_seed(seed), trace or Trace()
        budget = budget or _budget(reading.goal)
        stop = until_late(budget, trace, stop)
        beat = Heartbeat(trace, progress, stop)
        try:
            yield from beat.over(self._candidates(reading, setting, seed, budget, trace, progress, stop))
        finally:
            give_back()

    def _candidates(
        self, reading: Reading, setting: Setting | None, seed: int, budget: Budget, trace: Trace, progress: Progress,
        stop: Stop,
    ) -> Iterator[CandidateSequence]:  # fmt: skip
        from ..planning.search.answers import Answers
        from ..planning.search.search import Effort, WholeWork
        from .candidates import CandidateSequence, doubted_last, to_try

        engine = self._for(reading.goal)
        with working("building the world, with what the camera sees"):
            setting = engine._setting(reading, setting, seed)
        plans = engine.plans(reading, setting, trace, progress)
        answers, tried, whole = Answers(), list[CandidateSequence](), WholeWork(budget.work)
        planned = trace.watch.over("planning", plans)
        for number, plan, sequence in to_try(doubted_last(planned, tried, trace), budget.sequences, trace, whole):
            tried.append(CandidateSequence(
                number, plan, sequence, reading, setting, engine.knowledge, budget, trace, progress, stop, answers,
                Effort(whole=whole), engine.executors,
            ))  # fmt: skip
            yield tried[-1]
        while tried:
            tried = [wider for one in tried if (wider := one.wider()) is not None]
            yield from tried

    def _for(self, goal: object) -> Engine:
        """Return the engine that resolves a goal: one with the scenario's plugins if the goal is a scenario,
        else this one."""
        from ..scenario.scenario import Scenario

        return self.suited(goal) if isinstance(goal, Scenario) else self

    def _setting(self, reading: Reading, setting: Setting | None, seed: int) -> Setting:
        """Return the setting (world, robot, backend and initial belief) for a goal, with the goal in words
        added to it."""
        from ..scenario.asked_text import asked_text
        from ..scenario.scenario import Scenario

        goal = reading.goal
        if isinstance(goal, Scenario):
            return replace(setting or self.setting(reading, seed=seed), title=goal.spec.title, asked=asked_text(goal.spec))
        if isinstance(goal, str | Path):
            raise UserError(
                f"'{goal}' is text: pass read_scenario(path), or Goal((\"block on shelf\",)) with setting=engine.setting(scenario)."
            )
        if setting is None:
            raise UserError("A goal that is not a scenario needs a setting: pass setting=engine.setting(scenario).")
        return replace(setting, title="", asked=goal_text(goal))

    def plans(
        self, goal: AnyGoal | Reading, setting: Setting, trace: Trace, progress: Progress = lambda _: None, **unknown: Never
    ) -> Iterator[tuple[Plan, TaskSequence | None]]:
        """Generate the plans of a goal, best first.

        A plan from a demonstration comes with the task sequence as which the demonstration was read.
        """
        from ..planning.task_goals import Goal, plan_from_tasks
        from ..planning.task_sequences import plans_for_goal, plans_from_interpretation
        from ..scenario.scenario import Scenario

        _refuse(unknown)
        reading = self.read(goal)
        asked, knowledge = reading.goal, self._for(reading.goal).knowledge
        found, episode = reading.interpretation, reading.episode
        if found is not None and episode is not None:
            progress(f"{len(found.actions)} actions, {found.count()} readings")
            meant = asked.spec.reading if isinstance(asked, Scenario) else None
            yield from plans_from_interpretation(setting.name, found, episode, knowledge.tasks, trace, meant)
        elif isinstance(asked, Goal) or (isinstance(asked, Scenario) and asked.spec.goal is not None):
            scene = setting.symbolic(knowledge.taxonomy)
            yield from ((plan, None) for plan in plans_for_goal(setting.name, asked, scene, knowledge, trace, progress))
        else:
            yield plan_from_tasks(setting.name, asked, knowledge.tasks, setting.world), None  # type: ignore[arg-type]


def _refuse(unknown: Mapping[str, object]) -> None:
    """Raise TypeError if a method of the engine was given an argument that it does not have.

    For 'world' the message names 'setting' as the argument to give.
    """
    for name in unknown:
        instead = "; the setting is given as setting=engine.setting(scenario)" if name == "world" else ""
        raise TypeError(f"this method of the engine has no argument '{name}'{instead}")


def _budget(goal: object) -> Budget:
    from ..scenario.scenario import Scenario

    return budget_of(goal) if isinstance(goal, Scenario) else Budget()


def make_engine(scenario: Scenario, plugins: PluginChoice = INSTALLED) -> Engine:
    """Make an engine with the plugins and ontologies of one scenario.

    Raises:
        UserError: as ``Scenario.with_plugins``.
    """
    chosen = scenario.with_plugins(plugins)
    for file in plugins.files:
        if file.stem in scenario.spec.block:
            where = scenario.where("block", scenario.spec.block.index(file.stem))
            print(f"cramlite: warning: {where}: leaves out the plugin file '{file}'.", file=sys.stderr)
    return Engine.with_plugins(chosen, scenario.ontologies)


