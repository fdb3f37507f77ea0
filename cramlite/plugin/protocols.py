"""The protocols of what plugins declare: simulators, validators, backends, object models, report sections."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Protocol

from msgspec import field

from ..base.value import Value
from ..model.judging_limits import JudgingLimits
from .allowance import Allowance

if TYPE_CHECKING:
    from ..interpretation.rules import Rule
    from ..model.belief import Belief
    from ..model.designators import Action
    from ..model.episode import Episode
    from ..model.geometry import Pose
    from ..model.plan import Plan
    from ..model.program import Code, Program
    from ..model.robot import Robot
    from ..model.rollout import Rollout, Scene
    from ..model.verdict import Cost, Finding
    from ..model.view import View
    from ..model.world import Camera, Thing, World
    from ..ontology.taxonomy import Taxonomy


class Candidate(Value):
    """A fully grounded plan on its way to being proven.

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
        parts: actions that the plan's actions were decomposed into, grounded; without those that the run decides about.
        allowances: name of each action and part -> what it may touch and move.
        limits: how far the run may disturb what no task is about.
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
    parts: tuple[Action, ...] = ()
    allowances: Mapping[str, Allowance] = field(default_factory=dict)
    limits: JudgingLimits = JudgingLimits()


class Validator(Protocol):
    """Judges a candidate. Validators of cost "rollout" are asked after its text ran, the others before."""

    @property
    def name(self) -> str: ...
    @property
    def cost(self) -> Cost: ...
    def check(self, candidate: Candidate) -> Iterable[Finding]: ...


class Backend(Protocol):
    """Writes a program as code. ``executable`` says whether a simulator here runs that text.

    A backend may also have ``remark``, a clause about its text that every result repeats, e.g. what was not checked; and
    ``typed_stands_in``: where its text cannot be run, the typed program runs on the controller model in its place.
    """

    @property
    def name(self) -> str: ...
    @property
    def executable(self) -> bool: ...
    def emit(self, program: Program, robot: Robot) -> Code: ...


class Simulator(Protocol):
    """Runs code and demonstrations in physics."""

    @property
    def name(self) -> str: ...
    def check(self, world: World, robots: Mapping[str, Robot]) -> None:
        """Raise UserError if the world cannot be simulated."""
        ...

    def execute(self, text: str, world: World, robots: Mapping[str, Robot], *, mount: str, seed: int) -> Rollout:
        """Run a program's text on the controller model. It sees the text and the world, nothing else."""
        ...

    def inspect(self, text: str) -> Iterable[tuple[int, str]]:
        """Lines of a program's text that are doubtful, and why; raise UserError if it cannot run at all."""
        ...

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
        """Open the robot controller's ports on loopback until time is up; return why it ended."""
        ...

    def look(self, world: World, robots: Mapping[str, Robot], camera: Camera, *, seed: int) -> View:
        """What a depth camera sees of a world in which nothing moves; raises UserError if there is no such camera."""
        ...

    def demonstrate(self, world: World, script: str, *, seed: int) -> Rollout:
        """Let a simulated person act."""
        ...

    def picture(self, rollout: Rollout, sample: int, robots: Mapping[str, Robot], size: tuple[int, int]) -> Any:
        """A picture of one sample of a rollout: (height, width, 3) uint8."""
        ...

    def scene(self, rollout: Rollout, robots: Mapping[str, Robot], samples: Sequence[int]) -> Scene:
        """The shapes of a rollout's world, and where they are at some of its samples."""
        ...


class ModelMaker(Value):
    """A parametric object model.

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
    """A repair of recorded episodes, applied to what any reader answers.

    Args:
        name: unique, for people.
        order: lower is earlier; the shipped ones have 10 (dropouts), 20 (flicker) and 30 (two hands).
        repair: gives the repaired episode, with a ``Repair`` for each change, or the very episode if nothing is to be
            changed.
    """

    name: str
    order: float
    repair: Callable[[Episode], Episode]


class ReportSection(Value):
    """A part of the report page.

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
