"""Protocols and values that plugins declare: simulators, validators, backends, object models, report sections."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Protocol, runtime_checkable

from msgspec import field

from ..base.value import Value
from ..model.handover import Handover
from ..model.run.judging_limits import JudgingLimits
from .allowance import Allowance

if TYPE_CHECKING:
    from pathlib import Path

    from ..interpretation.goal_literal import GoalLiteral
    from ..interpretation.rules import Rule
    from ..model.belief import Belief
    from ..model.collision import Collision
    from ..model.designators import Action
    from ..model.episode import Episode
    from ..model.geometry import Pose
    from ..model.plan import Plan
    from ..model.program.program import Code, Program
    from ..model.robot import Robot
    from ..model.run.readings import Watch
    from ..model.run.rollout import Rollout, Scene
    from ..model.run.run_record import RunRecord
    from ..model.run.verdict import Cost, Finding
    from ..model.view import View
    from ..model.world.thing import Thing
    from ..model.world.world import Camera, World
    from ..ontology.taxonomy import Taxonomy
    from .demonstration import Shown


class Candidate(Value):
    """Fully grounded plan that is being proven, with its program and run.

    Args:
        plan: what was asked for.
        program, code: the typed program and its text; None before they exist.
        bindings: designator name -> grounding.
        belief: predicted at the end.
        rules, taxonomy: by which demonstrations are interpreted.
        rollout: what happened when the text ran; None before it did.
        episode: the same as events, by the detection that also reads demonstrations.
        actions: the plan's actions with their objects grounded to entities.
        robot: the robot's model.
        world: as it is believed to be at the start.
        goal: what should hold when the text has run: what was asked for, or what the demonstration ended with.
        parts: actions that the plan's actions were decomposed into, grounded; without those that the run decides about.
        allowances: name of each action and part -> what it may touch and move.
        limits: how far the run may disturb what no task is about.
        handovers: what passes into the hand and out of it, in the plan's order; None where nobody knows, as of a text that is
            judged without its run.
        proven: the text that ``code`` was edited from; None where nobody edited it.
    """

    plan: Plan
    program: Program
    code: Code | None
    bindings: Mapping[str, Any]
    belief: Belief
    actions: tuple[Action, ...]
    robot: Robot
    world: World
    rules: tuple[Rule, ...]
    taxonomy: Taxonomy
    rollout: Rollout | None = None
    episode: Episode | None = None
    goal: tuple[GoalLiteral, ...] = ()
    parts: tuple[Action, ...] = ()
    allowances: Mapping[str, Allowance] = field(default_factory=dict)
    limits: JudgingLimits = JudgingLimits()
    handovers: tuple[Handover, ...] | None = None
    proven: Code | None = None

    @property
    def written(self) -> Code:
        """Text of a candidate whose code was generated; an AssertionError before it is."""
        assert self.code is not None
        return self.code

    @property
    def ran(self) -> Rollout:
        """Rollout of a candidate whose text ran; an AssertionError before it did."""
        assert self.rollout is not None
        return self.rollout


class Validator(Protocol):
    """Check of a candidate; validators of cost "rollout" are asked after the program ran, the others before.

    One may be a ``GoalValidator`` or an ``Adviser``, too.
    """

    @property
    def name(self) -> str:
        """Name, unique among validators."""
        ...
    @property
    def cost(self) -> Cost:
        """Stage at which the validator is asked, cheapest first: "facts", "ik", "path" or "rollout"."""
        ...
    def check(self, candidate: Candidate) -> Iterable[Finding]:
        """Check a candidate, and yield the findings."""
        ...


@runtime_checkable
class GoalValidator(Protocol):
    """Validator that can judge a program for which there is a goal but no plan."""

    by_goal: bool
    """Whether the validator judges a program for which there is a goal but no plan."""


@runtime_checkable
class Adviser(Protocol):
    """Validator that a scenario may make advisory: its objections are then reported, but refuse no program
    (``JudgingLimits.advisory``).

    A validator of the purpose of a program is none.
    """

    may_advise: bool
    """Whether a scenario may make the validator advisory."""


class Backend(Protocol):
    """Code generator for one robot language; ``executable`` says whether a simulator runs the generated text.

    One may be ``Remarking``, a ``StandIn`` or a ``Driver``, too.
    """

    @property
    def name(self) -> str:
        """Name, unique among backends."""
        ...
    @property
    def executable(self) -> bool:
        """Whether a simulator can run the text that the backend writes."""
        ...
    def emit(self, program: Program, robot: Robot) -> Code:
        """Generate the text of a program for a robot."""
        ...


@runtime_checkable
class Remarking(Protocol):
    """Backend with a remark that is shown with each of its programs."""

    remark: str
    """Remark that is shown with every result, e.g. on what was not checked."""


@runtime_checkable
class StandIn(Protocol):
    """Backend whose text no simulator runs; the typed program may run on the controller model instead."""

    typed_stands_in: bool
    """Whether the typed program runs in place of the text."""


@runtime_checkable
class Driver(Backend, Protocol):
    """Backend that can also run its text on a robot, through a process that stands for the robot."""

    def drive(self, text: str, robot: Robot, command: Sequence[str]) -> Rollout:
        """Run a program text on a process that stands for a robot; return the measured forces as a rollout without things.

        Raises:
            UserError: the text cannot be driven, or the process does not answer as it must.
        """
        ...


class ProgramRunner(Protocol):
    """Model of robot controllers that runs the text of programs in simulated worlds."""

    def check(self, world: World, robots: Mapping[str, Robot]) -> None:
        """Raise UserError if the world cannot be simulated."""
        ...

    def execute(
        self, text: str, world: World, robots: Mapping[str, Robot], *, mount: str, seed: int, watch: Watch | None = None
    ) -> Rollout:
        """Run a program's text on the controller model, which knows the text and the world but not the plan.

        Args:
            watch: is shown readings; the arm brakes when it notices something, and the outcome is "noticed".
        """
        ...

    def inspect(self, text: str) -> Iterable[tuple[int, str]]:
        """Return the lines of a program's text that may fail, with reasons; raise UserError if the text
        cannot run at all."""
        ...


class VirtualController(Protocol):
    """Model of a robot controller to which other software can connect."""

    def serve(
        self,
        world: World,
        robots: Mapping[str, Robot],
        *,
        mount: str,
        host: str,
        seconds: float,
        idle: float,
        seed: int,
        say: Callable[[str], None],
    ) -> str:
        """Open the ports of the robot controller on a loopback address until a time limit; return why they were closed.

        Args:
            mount: name of the robot whose controller it is.
            host: a loopback address.
            seconds: after which it closes [s]; 0 for no limit.
            idle: without a client, after which it closes [s]; 0 for no limit.
            seed: of the sensors' noise.
            say: called with a line for people.

        Raises:
            UserError: the address is none of loopback, or a port is taken.
        """
        ...


class SimulatedCamera(Protocol):
    """Model of depth cameras."""

    def look(self, world: World, robots: Mapping[str, Robot], camera: Camera, *, seed: int) -> View:
        """Render what a depth camera sees in a world at rest; raise UserError if there is no such camera."""
        ...


class SimulatedPerson(Protocol):
    """Simulation of a person who gives demonstrations."""

    def demonstrate(self, world: World, shown: Sequence[Shown], *, seed: int) -> Rollout:
        """Simulate a person who performs one script after the other."""
        ...


class Illustrator(Protocol):
    """Renderer of pictures for people."""

    def picture(
        self, rollout: Rollout, sample: int, robots: Mapping[str, Robot], size: tuple[int, int], about: Collection[str] = ()
    ) -> Any:
        """Render one sample as (height, width, 3) uint8; ``size`` is (width, height) [pixel], the view is
        fitted to the things in ``about``."""
        ...

    def collision_picture(
        self, world: World, robots: Mapping[str, Robot], collision: Collision, size: tuple[int, int]
    ) -> Any:
        """Render a state that planning refused, with the two colliding bodies marked: (height, width, 3)
        uint8.

        ``world`` is as it is at the start; the collision says what is elsewhere.
        """
        ...

    def scene(self, rollout: Rollout, robots: Mapping[str, Robot], samples: Sequence[int]) -> Scene:
        """Return the shapes of a rollout's world, and their poses at some of its samples."""
        ...


class Simulator(ProgramRunner, VirtualController, SimulatedCamera, SimulatedPerson, Illustrator, Protocol):
    """Physics simulator: runs programs, acts as controller, camera and person, and renders pictures, all with
    one model of the world.

    It may be ``Doubting`` and ``Correcting``, too.
    """

    @property
    def name(self) -> str:
        """Name, unique among simulators."""
        ...


@runtime_checkable
class Doubting(Protocol):
    """Simulator that also reports implausible properties of a world."""

    def doubts(self, world: World, robots: Mapping[str, Robot]) -> Iterable[tuple[str, str]]:
        """Return the things that are implausible at the world's start, each with the reason."""
        ...


@runtime_checkable
class Correcting(Protocol):
    """Simulator that also corrects measured poses that are physically impossible."""

    def put_apart(
        self, world: World, robots: Mapping[str, Robot], most: float, deep: float | None = None, staying: bool = False
    ) -> tuple[World, tuple[str, ...]]:
        """Return the world with loose things that are inside others moved to free places, and a note about each move.

        A thing moves by at most ``most`` [m]. ``deep`` is the penetration that is tolerated [m]; None stands
        for the usual error of readings. ``staying``: two loose things may stay in each other if physics leaves them there.
        """
        ...


class ModelMaker(Value):
    """Parametric object model.

    Args:
        name: what scenarios write under ``model``.
        make: called with ``name``, ``pose`` and the scenario's parameters as keywords, as written: "50 mm" is for the
            model to read (``cramlite.base.quantities``), which knows what kind of number it needs.
        hung: for models that can hang: the pose on a hanger (thing, hanger, depth [m], yaw [rad]).
        files: parameters that name files; they are given as paths, a scenario's from its own folder.
        product: whether it is one thing with a look of its own, which perception can recognise without parameters.
    """

    name: str
    make: Callable[..., Thing]
    hung: Callable[..., Pose] | None = None
    files: tuple[str, ...] = ()
    product: bool = False


class EpisodeRepair(Value):
    """Repair of recorded episodes, applied to every episode that is read.

    Args:
        name: unique, for people.
        order: lower is earlier; the shipped ones have 10 (dropouts), 20 (flicker) and 30 (two hands).
        repair: gives the repaired episode, with a ``Repair`` for each change, or the very episode if nothing is to be
            changed.
    """

    name: str
    order: float
    repair: Callable[[Episode], Episode]


class Exporter(Value):
    """Writer of recorded runs in a format that other software opens.

    Args:
        name: what ``cramlite export --to`` says.
        suffix: of what it writes, a file or a folder, e.g. ".mcap"; "" for a folder without one.
        about: which software opens it, as part of a sentence.
        write: writes a run to a path that does not exist yet.
        needs: package that must be installed -> what to install it by, e.g. {"rosbags": "cramlite[mcap]"}.
    """

    name: str
    suffix: str
    about: str
    write: Callable[[RunRecord, Path], None]
    needs: Mapping[str, str] = field(default_factory=dict)


class ReportSection(Value):
    """Section of the report page.

    Args:
        title: heading.
        order: lower is further up.
        render: gives HTML from a ``cramlite.report.Finished``; "" leaves the section out.
        refused: it also has something to say where nothing was proven; the others are not asked then.
    """

    title: str
    order: int
    render: Callable[[Any], str]
    refused: bool = False
