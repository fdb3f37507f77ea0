"""The engine: goals become proven programs, lazily, one solution after another."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Any

from msgspec import Struct, field
from msgspec.structs import replace

from .belief import initial_belief
from .errors import UserError, nearest
from .geometry import Pose
from .knowledge import Knowledge, pick
from .registry import Registry
from .state import State
from .trace import Trace

if TYPE_CHECKING:
    from .belief import Belief, Relation
    from .episode import Episode
    from .goals import Goal
    from .interpretation import Interpretation
    from .late_poses import Tolerance
    from .look_queries import Queries
    from .looking import Look
    from .plan import Plan
    from .plugin_types import Backend, Candidate
    from .robots import Robot
    from .scenario import Scenario
    from .scenario_tasks import RuleSpec, TaskSpec
    from .search import Budget
    from .state import Item
    from .verdict import Verdict
    from .world import World

Progress = Callable[[str], None]
Source = tuple["Interpretation | None", "Episode | None"]
LISTED = 1000
"""Task sequences of a demonstration that are looked at, most of them only to see that a task type is missing."""


class Setting(Struct, frozen=True):
    """Where a plan is to be carried out.

    Args:
        name: of the program.
        world: the robot's world.
        relations: what is known to hold in it.
        robot: the robot's model; the first mount of the world acts.
        backend: who writes the code.
        seed: of everything that is drawn.
        real: the world that programs run in, where it differs from what is believed; never shown to plugins.
        look: the picture that the belief comes from, where poses come from a camera.
        late: things whose poses are asked for when the program runs, and how far off they may be then [m, rad].
    """

    name: str
    world: World
    relations: tuple[Relation, ...]
    robot: Robot
    backend: Backend
    seed: int
    real: World | None = None
    look: Look | None = None
    late: Mapping[str, Tolerance] = field(default_factory=dict)

    def belief(self) -> Belief:
        mount = self.world.robots[0]
        at = self.robot.arm_at(mount.base) if self.robot.platform else None
        belief = initial_belief(self.world, mount.name, *self.robot.start(mount), self.relations, at)
        return replace(belief, poses={**belief.poses, **self.look.estimates}) if self.look else belief

    def start(self, plan: Plan) -> State:
        """Where the search begins: at home, or where the robot stands since it looked, with the steps that led there."""
        agenda: tuple[Item, ...] = (*plan.objects, *plan.actions)
        done = self.look.state if self.look else None
        if done is None:
            return State(agenda, self.belief())
        return replace(done, agenda=agenda, belief=self.belief().moved(done.belief.joints), choices=())

    def after(self, solution: Solution) -> Setting:
        """This setting as a solution's run left it: things where they came to rest, the robot at its start again.

        Raises:
            UserError: something is still in the hand; only what was let go has a place of its own.
        """
        rollout, belief = solution.candidate.rollout, solution.candidate.belief
        if belief.held is not None or rollout is None:
            what = f"'{belief.held.thing}' is still in the hand" if belief.held else "the program did not run here"
            raise UserError(
                f"Nothing can go on from where '{solution.plan}' ends: {what}; let it end with the thing put down."
            )
        ends = {n: Pose(tuple(r[-1][:3]), tuple(r[-1][3:])) for n, r in rollout.poses.items() if n in self._movable}
        real = self.real.moved(ends) if self.real else None
        return replace(self, world=self.world.moved(ends), relations=tuple(sorted(belief.relations)), real=real)

    @property
    def _movable(self) -> frozenset[str]:
        return frozenset(t.name for t in self.world.things if t.movable and t.joint is None)


class Solution(Struct, frozen=True):
    """A program whose text ran and was judged, with everything that led to it.

    Args:
        number: which candidate task sequence it came from, from 1.
        candidate: plan, program, code, bindings and rollout.
        verdict: what the validators found.
        trace: every decision of the search so far.
        setting: where it was proven.
        interpretation, episode: what the plan came from; None when it did not come from a demonstration.
        seed: that gives this solution again.
    """

    number: int
    candidate: Candidate
    verdict: Verdict
    trace: Trace
    setting: Setting
    interpretation: Interpretation | None = None
    episode: Episode | None = None

    @property
    def plan(self) -> Plan:
        return self.candidate.plan

    @property
    def program(self) -> Any:
        return self.candidate.program

    @property
    def code(self) -> str:
        """The text that was proven."""
        assert self.candidate.code is not None
        return self.candidate.code.text


class Engine:
    """An engine with its own plugins; two of them share nothing.

    Args:
        files: plugin modules to load by path.
        blocked, preferred: names of plugins.
        ontologies: further ontology files.
        rules: a folder of rule files that stands for all others.

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
    ) -> None:
        self.registry = Registry(tuple(map(Path, files)), tuple(blocked), tuple(preferred))
        self.knowledge = Knowledge(self.registry, ontologies, rules)

    def read_episode(self, path: Path) -> Episode:
        """Read an episode in any format that a plugin reads.

        Raises:
            UserError: no such path, no reader, or a file that cannot be used.
        """
        if not path.exists():
            raise UserError(
                f"There is no episode at '{path}'; give the folder of a NEEM, or record one with 'cramlite record'."
            )
        episode = self.registry.first("read_episode", path=path)
        if episode is None:
            raise UserError(
                f"'{path}' is in no format that a plugin reads (RobCoG event data, KnowRob mongodump, RDF); see 'cramlite plugins'."
            )
        from .alignment import aligned

        return aligned(episode, self.knowledge.taxonomy)

    def interpret(self, episode: Episode) -> Interpretation:
        """Every task that each action of the episode may execute.

        Raises:
            UserError: the episode has no events.
        """
        from .interpretation import interpret

        if not episode.events:
            raise UserError(
                f"The episode '{episode.name}' has no events, so there is nothing to interpret: it holds "
                f"{len(episode.entities)} entities and {len(episode.tracks)} tracks, and no object was seen to move "
                "along with a hand. Record it with contacts, or with the poses of hands and objects."
            )
        return interpret(episode, self.knowledge.rules, self.knowledge.taxonomy)

    def setting(
        self, scenario: Scenario, *, seed: int = 0, backend: str | None = None, now: World | None = None, rest: Plan | None = None
    ) -> Setting:
        """The robot's world of a scenario.

        Args:
            now: the world as it really is by now, where it is no longer as the scenario has it; only a camera is shown it.
            rest: the plan that is left by then: what the camera looks for; by default the scenario's.

        Raises:
            UserError: an unknown robot, model, backend or thing.
        """
        from .scenario_world import build_world, real_world

        robot = pick("robot", self.knowledge.robots, scenario.spec.robot.type, scenario.where("robot", "type"))
        name = backend or scenario.spec.backend or robot.backend
        place = scenario.where("backend") if scenario.spec.backend == name else ""
        writer = pick("backend", self.knowledge.backends, name, place)
        world, relations = build_world(scenario, scenario.spec.things, scenario.spec.vary, self.knowledge.models, seed)
        self._check_world(scenario, world)
        if now is not None:
            world = replace(world, robots=now.robots)
        real = real_world(scenario, world, relations, seed) if scenario.spec.unknown_error else None
        if scenario.spec.poses == "camera":
            from .looking import look

            world, real = replace(world, poses="camera"), replace(now or real or world, poses="camera")
            furniture = replace(world, things=tuple(t for t in world.things if not t.movable))
            wanted = self._wanted(scenario, Setting(scenario.name, furniture, (), robot, writer, seed), rest)
            seen = look(scenario, wanted, world, real, robot, self.knowledge, seed)
            late = _late(scenario, seen.world) if now is None else {}
            return Setting(scenario.name, seen.world, seen.relations, robot, writer, seed, seen.real, seen, late)
        return Setting(scenario.name, world, relations, robot, writer, seed, real, late=_late(scenario, world))

    def _wanted(self, scenario: Scenario, before: Setting, rest: Plan | None) -> Queries:
        """What is to be looked for: what the scenario's camera is told, else what the likeliest plan is about."""
        from .look_queries import queries_of
        from .object_query import parse_query

        camera, taxonomy = scenario.spec.camera, self.knowledge.taxonomy
        if camera is not None and camera.look:
            return tuple((parse_query(text, taxonomy),) for text in camera.look)
        plan = rest or next((p for p, _ in self.plans(scenario, before, Trace())), None)
        return queries_of(plan, before.world, taxonomy) if plan else ()

    def _check_world(self, scenario: Scenario, world: World) -> None:
        """Classes are known and the simulator takes the world; else the user hears it before the search begins."""
        for thing in world.things:
            self.knowledge.taxonomy.known(thing.type, f"{scenario.where_thing(thing.name)}: thing '{thing.name}'")
        try:
            self.knowledge.simulator.check(world, self.knowledge.robots)
        except UserError as error:
            named = [t.name for t in world.things if f"'{t.name}'" in str(error)]
            place = scenario.where_thing(named[0]) if named else scenario.where("things")
            raise UserError(f"{place}: {error}.") from error

    def resolve(
        self,
        goal: Scenario | Episode | Goal | Sequence[TaskSpec | RuleSpec] | TaskSpec | RuleSpec,
        *,
        world: Setting | None = None,
        seed: int = 0,
        budget: Budget | None = None,
        trace: Trace | None = None,
        progress: Progress = lambda _: None,
        skip: Collection[int] = (),
        refused: Callable[[int], None] = lambda _: None,
        failed: Callable[[Solution], None] = lambda _: None,
        stop: Callable[[], bool] = lambda: False,
    ) -> Iterator[Solution]:
        """Proven programs for a goal, one after another; nothing is computed before the first is asked for.

        Args:
            goal: a scenario, an episode, a ``Goal``, tasks, or one task; all but a scenario with ``world``.
            world: the setting, where the goal does not bring one.
            seed: the same one gives the same programs.
            budget: counted work.
            trace: is filled while the search runs, also when nothing is found.
            progress: called with a line for people.
            skip: numbers of candidate sequences, from 1, that an earlier run refused.
            refused: called with the number of each candidate of which nothing could be proven.
            stop: asked before each question to a plugin and before each run of a text, from the thread that resolves;
                True ends the iterator, and the trace says so. What runs is not interrupted: it takes a few seconds.
            failed: called with each complete program that was judged and refused.

        Raises:
            UserError: the goal cannot be used.
        """
        from .scenario import Scenario
        from .search import STOPPED, Budget

        if isinstance(goal, Scenario):
            world = world or self.setting(goal, seed=seed)
        if isinstance(goal, str | Path):
            raise UserError(f"'{goal}' is text: pass read_scenario(path), or Goal((\"block on shelf\",)) with a world.")
        if world is None:
            raise UserError("A goal that is not a scenario needs a world: pass world=engine.setting(scenario).")
        trace, budget = trace if trace is not None else Trace(), budget or Budget()
        for number, (plan, source) in enumerate(self.plans(goal, world, trace, progress), 1):
            if number > budget.sequences:
                left = f"{budget.sequences} task sequences tried, the rest left out"
                trace.add(0, "sequences", "", "capped", "engine", left)
                return
            if stop():
                trace.add(0, "sequences", "", "capped", "engine", STOPPED)
                return
            trace.candidate = number
            if number in skip:
                trace.add(0, "sequence", str(plan), "refused", "engine", "refused before this run was resumed")
                continue
            progress(f"candidate {number}: {plan}")
            proven = False
            for candidate, verdict in self.attempts(plan, world, budget, trace, progress, stop):
                judged = Solution(number, candidate, verdict, trace, world, *source)
                if not verdict.passed:
                    failed(judged)
                    continue
                proven = True
                yield judged
            if not proven:
                refused(number)

    def plans(
        self, goal: Any, world: Setting, trace: Trace, progress: Progress = lambda _: None
    ) -> Iterator[tuple[Plan, Source]]:
        """The task sequences of a goal, best first, each with what it came from."""
        from .episode import Episode
        from .goals import Goal, plan_from_tasks
        from .scenario import Scenario

        if isinstance(goal, Scenario) and goal.spec.demonstration is not None:
            goal = self.read_episode(goal.beside(goal.spec.demonstration))
        if isinstance(goal, Goal) or (isinstance(goal, Scenario) and goal.spec.goal is not None):
            yield from ((plan, (None, None)) for plan in self.plans_for_goal(goal, world, trace))
            return
        if isinstance(goal, Episode):
            yield from self._plans_from_episode(goal, world, trace, progress)
        else:
            yield plan_from_tasks(world.name, goal, self.knowledge.tasks, world.world), (None, None)

    def _plans_from_episode(
        self, episode: Episode, world: Setting, trace: Trace, progress: Progress
    ) -> Iterator[tuple[Plan, Source]]:
        from .plan import TaskCall, plan_from_episode

        found = self.interpret(episode)
        progress(f"{len(found.actions)} actions, {found.count()} candidate task sequences")
        for sequence in islice(found.sequences(), LISTED):
            unknown = [m.task for m in sequence.matches if m.task not in self.knowledge.tasks]
            if unknown:
                names = " -> ".join(m.task.split(":")[-1] for m in sequence.matches)
                trace.add(0, "sequence", names, "refused", "engine", f"no plugin offers the task type {unknown[0]}")
                continue
            calls = [TaskCall(self.knowledge.tasks[m.task], m.roles) for m in sequence.matches]
            yield plan_from_episode(world.name, calls, episode), (found, episode)

    def plans_for_goal(self, goal: Goal | Scenario, world: Setting, trace: Trace) -> Iterator[Plan]:
        """Task sequences whose rules achieve a goal, the shortest first; why each task is there goes to the trace.

        Raises:
            UserError: the goal is none, names what there is not, or holds already.
        """
        from .goal_plans import as_tasks, impossible, meant, task_plans, wanted, with_sides
        from .goals import Goal, plan_from_tasks
        from .operators import Grounder, facts_of
        from .scenario import Scenario

        where, objects = "", {}
        if isinstance(goal, Scenario):
            where, objects, goal = f"{goal.where('goal')}: ", goal.spec.objects, Goal(goal.spec.goal or ())
        knowledge, grounder = self.knowledge, Grounder(world.world, self.knowledge.taxonomy)
        operators = grounder.ground(knowledge.goal_rules, knowledge.tasks)
        facts = facts_of(world.world, world.relations)
        for choice in meant(goal, objects, grounder):
            target, found = wanted(choice.says, grounder, where), False
            if target.met(facts):
                raise UserError(f"{where}the goal '{choice}' holds already in this world, so there is nothing to do.")
            fit = with_sides(target, operators, knowledge.tasks)
            for plan in task_plans(target, facts, fit):
                found = True
                for step, reason in zip(plan.steps, plan.reasons, strict=True):
                    trace.add(0, "goal", str(step), "chosen", "engine", f"for '{choice}': {reason}")
                yield plan_from_tasks(world.name, as_tasks(plan, knowledge.tasks, target), knowledge.tasks, world.world)
            if not found:
                trace.add(0, "goal", str(choice), "refused", "engine", impossible(target, fit))

    def attempts(
        self,
        plan: Plan,
        setting: Setting,
        budget: Budget,
        trace: Trace,
        progress: Progress = lambda _: None,
        stop: Callable[[], bool] = lambda: False,
    ) -> Iterator[tuple[Candidate, Verdict]]:
        """Complete programs for a plan, lazily, each with what the judges found; those that failed are among them."""
        from .answers import Context
        from .late_poses import parametric
        from .proof import assemble, conflict_of, prove
        from .search import STOPPED, Search

        mount = setting.world.robots[0]
        context = Context(setting.robot, mount, {}, self.knowledge.taxonomy, seed=setting.seed, samples=budget.samples)
        took = setting.look.camera if setting.look else None
        context = replace(context, camera=took or next(iter(setting.world.cameras), None))
        search = Search(
            self.registry, self.knowledge.tasks, self.knowledge.task_owners, context, trace, budget, progress, stop
        )
        states = search.solve(setting.start(plan))
        conflict, proofs = None, 0
        while proofs < budget.proofs:
            try:
                state = states.send(conflict) if proofs else next(states)
            except StopIteration:
                return
            if stop():
                trace.add(0, "proof", str(plan), "capped", "engine", STOPPED)
                return
            proofs += 1
            candidate = assemble(
                setting.name, plan, setting.belief(), state, setting.robot, setting.world, self.knowledge
            )
            candidate = parametric(candidate, setting.late)
            for step in candidate.program.steps:
                self.registry.notify("on_step", step=step, candidate=candidate)
            progress(f"candidate program {proofs} of {len(candidate.program.steps)} steps: running its text")
            candidate, verdict = prove(candidate, self.knowledge, setting.backend, setting.seed, setting.real)
            outcome = "proven" if verdict.passed else "failed"
            trace.add(0, "proof", str(plan), outcome, setting.backend.name, verdict.reason)  # type: ignore[arg-type]
            if not verdict.passed:
                progress(f"refused: {verdict.reason}")
            yield candidate, verdict
            conflict = None if verdict.passed else conflict_of(verdict, state)


def _late(scenario: Scenario, world: World) -> dict[str, Tolerance]:
    """The late things of a scenario.

    Raises:
        UserError: a thing that the world does not have, or that cannot be moved.
    """
    movable = [t.name for t in world.things if t.movable]
    for k, late in enumerate(scenario.spec.late):
        if late.thing not in movable:
            place = scenario.where("late", k, "thing")
            raise UserError(f"{place}: no thing '{late.thing}' that can be moved; {nearest(late.thing, movable)}.")
    return {late.thing: (late.position, late.yaw) for late in scenario.spec.late}
