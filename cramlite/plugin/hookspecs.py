"""Hook specifications: THE contract between the engine and its plugins, every hook typed.

Three chainings: *collect* (all answers together), *first* (one right answer),
*alternatives* (several right answers, asked one plugin at a time and lazily).

Three answers to a resolve hook: ``None`` = not mine; an iterable, possibly empty
= mine, these; ``raise Unresolvable(reason, because)`` = mine, impossible. Any
other exception is that plugin's bug: it is isolated, named and reported.

A plugin is a module (or object) with functions of these names, marked with
``cramlite.plugin.hookimpl`` and declared in the entry-point group "cramlite".
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import pluggy

if TYPE_CHECKING:
    from ..interpretation.fluents import SymbolicWorld
    from ..interpretation.timeline import Predicate
    from ..model.belief import Belief
    from ..model.designators import Action, Late, Location, Motion, Object
    from ..model.episode import Episode
    from ..model.imported_robot import ImportedRobot
    from ..model.program.steps import AnyStep
    from ..model.robot import Robot
    from ..model.robot_file import RobotFile
    from ..model.run.rollout import Rollout
    from ..model.view import View
    from ..model.world.imported_scene import ImportedScene, StatedJoint
    from ..model.world.known_kind import BuiltLibrary
    from .demonstration import RecordScript
    from .expert import Expert
    from .grounding import Answers, Context
    from .location_kind import LocationKind
    from .motion_kind import MotionKind
    from .protocols import Backend, Candidate, EpisodeRepair, Exporter, ModelMaker, ReportSection, Simulator, Validator
    from .task_type import TaskType

hookspec = pluggy.HookspecMarker("cramlite")
hookimpl = pluggy.HookimplMarker("cramlite")
"""Decorator that marks a function of a plugin as the implementation of the hook of its name."""


@hookspec
def task_types() -> Iterable[TaskType]:  # type: ignore[empty-body]
    """Declare task types. Called once at load; all declarations are collected, and two with one name or alias are an error."""


@hookspec
def predicates() -> Iterable[Predicate]:  # type: ignore[empty-body]
    """Declare predicates that rule files may use. Called once, before rules are loaded; all declarations are collected."""


@hookspec
def experts() -> Iterable[Expert]:  # type: ignore[empty-body]
    """Declare perception experts with inputs and outputs. Called once at load; all declarations are collected by ``name``."""


@hookspec
def robots() -> Iterable[Robot]:  # type: ignore[empty-body]
    """Declare robot models. Called once at load; all declarations are collected by ``type``."""


@hookspec
def object_models() -> Iterable[ModelMaker]:  # type: ignore[empty-body]
    """Declare parametric object models that scenarios may name. Called once at load; all declarations are collected by ``name``."""


@hookspec
def simulators() -> Iterable[Simulator]:  # type: ignore[empty-body]
    """Declare simulators, which run programs and simulate people who demonstrate. Called once at load; the
    first one is used, preferred plugins coming first."""


@hookspec
def record_scripts() -> Iterable[RecordScript]:  # type: ignore[empty-body]
    """Declare scripts of the simulated person, for recordings. Called once at load; all declarations are collected by ``name``."""


@hookspec
def episode_repairs() -> Iterable[EpisodeRepair]:  # type: ignore[empty-body]
    """Declare repairs of recorded episodes. Called once at load; all declarations are collected by ``name``.

    Each episode that any plugin reads passes through all of them, in order of their ``order``. Episodes that were
    detected in a rollout do not.
    """


@hookspec
def location_kinds() -> Iterable[LocationKind]:  # type: ignore[empty-body]
    """Declare relations of locations, each with its grounding function. Called once at load; all declarations are collected by ``name``."""


@hookspec
def motion_kinds() -> Iterable[MotionKind]:  # type: ignore[empty-body]
    """Declare kinds of motions that ``resolve_motion`` answers. Called once at load; all declarations are collected by ``name``."""


@hookspec
def validators() -> Iterable[Validator]:  # type: ignore[empty-body]
    """Declare validators of programs and rollouts. Called once at load; every validator may object."""


@hookspec
def backends() -> Iterable[Backend]:  # type: ignore[empty-body]
    """Declare code generators. Called once at load; all declarations are collected by ``name``."""


@hookspec
def ontologies() -> Iterable[Path]:  # type: ignore[empty-body]
    """Declare ontology files (Turtle, RDF/XML) to load beside the shipped ones. Called once at load."""


@hookspec
def report_sections() -> Iterable[ReportSection]:  # type: ignore[empty-body]
    """Declare sections of the report page. Called once at load; the sections are shown in ascending ``order``."""


@hookspec
def exporters() -> Iterable[Exporter]:  # type: ignore[empty-body]
    """Declare formats that recorded runs can be exported to. Called once at load; all declarations are collected by ``name``."""


@hookspec(firstresult=True)
def read_episode(path: Path) -> Episode | None:
    """Read the episode in a file or folder, as it was recorded; None if it is of another format. First answer wins.

    A reader smooths nothing: the engine applies the ``episode_repairs`` to what any reader answers, and then says foreign
    classes in the words of the loaded ontologies.

    Raises:
        UserError: it is of this format and cannot be used.
    """


@hookspec(firstresult=True)
def detect_events(rollout: Rollout, name: str) -> Episode | None:
    """Detect the events of a rollout as an episode called ``name``: entities, states and tracks; None leaves the
    detection to other plugins. First answer wins.

    Asked for demonstrations and for runs of programs alike, so that a run is judged by what demonstrations are read by.
    """


@hookspec(firstresult=True)
def write_episode(episode: Episode, path: Path) -> Path | None:
    """Write an episode to a file or folder that does not exist yet, and return its path. First answer wins.

    None if this writer does not write to such a path.

    Raises:
        UserError: it cannot be written.
    """


@hookspec(firstresult=True)
def read_view(path: Path) -> View | None:
    """Read the recorded view of a depth camera; None if it is of another format. First answer wins.

    Raises:
        UserError: it is of this format and cannot be used.
    """


@hookspec(firstresult=True)
def read_models(path: Path) -> Sequence[ModelMaker] | None:
    """Read a library of object models; None if it is of another format. First answer wins.

    Raises:
        UserError: it is of this format and cannot be used; with file and line.
    """


@hookspec(firstresult=True)
def add_models(folder: Path, library: Path, scale: float, density: float, up: str) -> BuiltLibrary | None:
    """Build a library of object models from the mesh files of a folder, or extend one; None if this plugin
    makes none. First answer wins.

    Args:
        library: folder, which may not exist yet.
        scale: from the unit of mesh files to metres.
        density: of kinds whose files state no mass [kg/m3].
        up: direction of their frames that usually points up, x to -z; "" where their shapes are to say it.

    Raises:
        UserError: the library cannot be used.
    """


@hookspec(firstresult=True)
def read_scene(
    path: Path, packages: Mapping[str, Path], keyframe: str, joints: Mapping[str, StatedJoint]
) -> ImportedScene | None:
    """Read a scene from a file such as an MJCF; None if it is of another format. First answer wins.

    Args:
        packages: name in ``package://`` -> its folder, where the scenario says so.
        keyframe: name of the state that it starts in; empty for the one that its bodies say.
        joints: pattern of names of jointed things -> what the scenario states of their joints; the first that fits.

    Raises:
        UserError: it is of this format and cannot be used; with file and line.
    """


@hookspec(firstresult=True)
def read_robot(file: RobotFile, name: str) -> ImportedRobot | None:
    """Read a robot from a file such as a URDF; None if it is of another format. First answer wins.

    Args:
        name: of the file; the robot's type contains it, and what the file calls its model.

    Raises:
        UserError: it is of this format and cannot be used; says what would be right.
    """


@hookspec(firstresult=True)
def read_sentence(sentence: str, scene: SymbolicWorld, forms: tuple[str, ...]) -> list[str] | None:
    """Translate a sentence that the grammar does not understand to goals such as "tin on tray"; None if this
    plugin cannot. First answer wins.

    A language model may answer here. What it says is shown as a plugin's, and refused unless all of it are goals about things that
    there are; a sentence that is ambiguous or false of the scene is not asked.

    Args:
        scene: its things, with classes and poses.
        forms: of the goals that can be said, e.g. "THING on PLACE".
    """


@hookspec(firstresult=True)
def episode_triples(episode: Episode) -> Iterable[str] | None:
    """Export the episode as lines of N-Triples, for queries; None if this plugin cannot. First answer wins."""


@hookspec
def resolve_action(action: Action, belief: Belief, context: Context) -> Answers:
    """Decompose an action: yield Groundings with a Decomposition as value, best first. The answers of all
    plugins are alternatives.

    A task type's own decomposition is one of the alternatives; plugins' overrides come before it.
    """


@hookspec
def resolve_object(designator: Object | Late, belief: Belief, context: Context) -> Answers:
    """Ground an object designator: yield Groundings with an entity's name as value. The answers of all
    plugins are alternatives."""


@hookspec
def resolve_location(location: Location, belief: Belief, context: Context) -> Answers:
    """Ground a location: yield Groundings with a Place that satisfies it as value. The answers of all plugins
    are alternatives.

    A declared relation (``location_kinds``) is grounded by the function of its kind, too.
    """


@hookspec
def resolve_motion(motion: Motion, belief: Belief, context: Context) -> Answers:
    """Plan a motion: yield Groundings with program steps as value, and with the belief after the motion. The
    answers of all plugins are alternatives."""


@hookspec
def on_step(step: AnyStep, candidate: Candidate) -> None:
    """Observe each step of a candidate that is about to be proven. Notification; the answer is ignored."""
